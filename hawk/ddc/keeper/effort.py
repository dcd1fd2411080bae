"""A change that is put back: by whom it was made, how often it is tried, and when it is given up."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from hawk.ddc.acts import Acts, Ask, Request
from hawk.ddc.facts import Facts
from hawk.model.sentences import say

TRIES = 3
"""Times that a thing is put back within `WINDOW_S`. Who changes it once more then changes it for ever."""
WINDOW_S = 60.0
PAUSE_S = 2.0
"""Pause after the autopilot refused, seconds."""


class Fight:
    """Counts how often a thing was put back within `WINDOW_S`."""

    def __init__(self, tries: int = TRIES) -> None:
        self._begun: deque[float] = deque(maxlen=tries)

    def is_over(self, now: float) -> bool:
        """Return True when once more would be too often."""
        return len(self._begun) == self._begun.maxlen and now - self._begun[0] < WINDOW_S

    def note(self, now: float) -> None:
        """Count a thing that is put back now."""
        self._begun.append(now)


class Effort:
    """Puts one thing back by one request. It never fights endlessly: given up, it stays so until the motors are off."""

    def __init__(self, patience_s: float, pause_s: float = PAUSE_S, tries: int | None = TRIES) -> None:
        """Begin with a thing that holds.

        Args:
            patience_s: A thing that is wrong for longer cannot be put back, seconds.
            pause_s: Pause after the autopilot refused, seconds.
            tries: Times that it is put back within `WINDOW_S`; None: as often as it takes.
        """
        self._patience_s = patience_s
        self._pause_s = pause_s
        self._fight = None if tries is None else Fight(tries)
        self._ask: Ask | None = None
        self._wrong_since: float | None = None
        self._not_before = float("-inf")
        self.reason = ""
        """The autopilot's words when the last request failed."""
        self.is_given_up = False

    @property
    def is_wrong(self) -> bool:
        """True while the thing does not hold."""
        return self._wrong_since is not None

    def rest(self, facts: Facts) -> None:
        """The thing holds, or may not be put back now."""
        self._wrong_since = None
        self._take_answer(facts)

    def put_back(self, request: Request, facts: Facts) -> Acts:
        """Return the request when it is time; nothing while one is under way, and once it is given up."""
        now = facts.now
        if self._wrong_since is None:
            self._wrong_since = now
        self._take_answer(facts)
        if self._ask is not None or self.is_given_up or now < self._not_before:
            return ()
        is_over = self._fight is not None and self._fight.is_over(now)
        if is_over or now - self._wrong_since > self._patience_s:
            self.is_given_up = True
            return ()
        if self._fight is not None:
            self._fight.note(now)
        self._ask = Ask(request, now)
        return (self._ask,)

    def _take_answer(self, facts: Facts) -> None:
        if self._ask is None:
            return
        answer = self._ask.answer(facts)
        if answer.is_pending:
            return
        self._ask = None
        self.reason = answer.reason
        if answer.has_failed:
            self._not_before = facts.now + self._pause_s


RECENT_S = 30.0
"""A message of another station explains a change that is seen within this time, seconds."""
UNKNOWN = say("Who changed it is not known: no message of another station reached this link.")
LATER = say("It is put back when the drone is taken from the pilot.")
"""Words on a change that is seen while a pilot flies."""


@dataclass(frozen=True, slots=True)
class Author:
    """Words for who changed something: ``message`` in the message, ``details`` beside it."""

    message: str = ""
    details: str = ""


def changed_by(facts: Facts, subjects: Sequence[str]) -> Author:
    """Return who wrote one of these last: subjects of `hawk.comm.mavlink.foreign_writes`.

    Most links carry only what the autopilot says, so that mostly nobody is known.
    """
    for write in reversed(facts.link.foreign_writes):
        if write.subject in subjects and facts.now - write.time <= RECENT_S:
            return Author(
                say(
                    "Station {system} (component {component}) changed it.",
                    system=write.system,
                    component=write.component,
                )
            )
    return Author(details=UNKNOWN)
