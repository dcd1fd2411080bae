"""The question for control: one session asks, the one in control answers; without an answer the asker may take it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final
from weakref import WeakKeyDictionary

from hawk.model.sentences import say
from hawk.web.session import Session

ANSWER_S: Final = 20.0
"""Seconds without an answer, and without a command of the one in control, after which the asker may take control."""
OPEN_S: Final = 60.0
"""Seconds after which a question lapses that the asker may follow by taking control, and does not."""
AGAIN_S: Final = 60.0
"""Seconds until a session may ask again after "Keep"."""
PAUSE_S: Final = 10.0
"""Seconds between two questions of any sessions: new ones are made by anybody who has the token."""


@dataclass(slots=True)
class _Question:
    asker: Session
    since: float
    """Seconds of the daemon's clock; later when the one in control sends a command, and so is there."""


@dataclass(slots=True)
class Asking:
    """At most one open question. Times are seconds of the daemon's clock."""

    clock: Callable[[], float]
    _question: _Question | None = None
    _kept: WeakKeyDictionary[Session, float] = field(default_factory=WeakKeyDictionary)
    """When a session was refused last."""
    _last: float = float("-inf")
    _told: Session | None = None

    @property
    def asker(self) -> Session | None:
        """The session that asks; None while nobody does. One without a connection has left: nobody asks any more."""
        question = self._question
        if question is None:
            return None
        if question.asker.connections == 0 or self.clock() - question.since > ANSWER_S + OPEN_S:
            self._question = None
            return None
        return question.asker

    def ask(self, session: Session) -> str | None:
        """Put the question: None when it is open, else the reason."""
        asker, now = self.asker, self.clock()
        if asker is session:
            return None
        if asker is not None:
            return say("{name} has asked already.", name=asker.name)
        wait = max(self._kept.get(session, float("-inf")) + AGAIN_S, self._last + PAUSE_S) - now
        if wait > 0.0:
            return say("Control was asked for a moment ago: ask again in {wait:.0f} s.", wait=wait)
        self._question, self._last = _Question(session, now), now
        if self._told is session:
            self._told = None
        return None

    def acted(self) -> None:
        """The one in control sent a command: it is there, and the time for its answer begins again."""
        if self._question is not None:
            self._question.since = self.clock()

    def is_due(self, session: Session) -> bool:
        """Return True when this session asks, and the answer did not come in time."""
        return self.asker is session and self.free_in == 0.0

    @property
    def free_in(self) -> float | None:
        """Seconds until the asker may take control; None while nobody asks."""
        if self.asker is None or self._question is None:
            return None
        return max(0.0, self._question.since + ANSWER_S - self.clock())

    def keep(self) -> None:
        """The one in control keeps it: its asker learns of it, and may ask again later."""
        if (asker := self.asker) is not None:
            self._kept[asker], self._told = self.clock(), asker
        self.end()

    def was_kept_from(self, session: Session | None) -> bool:
        """Return True while this session's last question was answered by "Keep" lately."""
        return session is not None and self._told is session and self.clock() - self._kept[session] <= AGAIN_S

    def end(self) -> None:
        """Forget the question: it was answered, withdrawn, or control went elsewhere."""
        self._question = None
