"""Sessions, and the lease of control: requested, granted, given back, or expired.

A session is a browser (its cookie) or a tool. It may have several connections, and survives a lost link.
"""

from __future__ import annotations

import hmac
import logging
import math
import re
import secrets
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final
from weakref import WeakKeyDictionary

from hawk.comm.protocol.authority import SOMEONE_ELSE, Role, Tenure, distinct
from hawk.comm.protocol.heartbeat import ClientId
from hawk.config.sections import OperatorSettings
from hawk.model.sentences import say


@dataclass(slots=True, eq=False, weakref_slot=True)
class Session:
    """``name`` is shown to everyone; ``secret`` is the cookie and known to its owner only."""

    name: str
    secret: str = field(repr=False)
    role: Role = Role.OPERATOR
    number: str = ""
    """The name of those who give none."""
    given: str = ""
    """The name that was given; ``name`` may have a number behind it."""
    renamed: float = -math.inf
    last_sign: float = -math.inf
    connections: int = 0
    hidden_since: float | None = None
    """Since when each of its pages that show life is hidden, seconds; None while one is shown."""
    looks: dict[ClientId, tuple[float, bool]] = field(default_factory=dict, repr=False)
    """When each of its connections showed life last, and whether its page was hidden then."""
    successor: Session | None = field(default=None, repr=False)
    """The session that took control while this one was lost."""


@dataclass(frozen=True, slots=True)
class ControlView:
    """Control as one client sees it.

    ``controller`` is the name of the session that has control, ``taken_by`` of the one that took it from this client's
    session while that was lost and has it still.
    """

    controller: str | None = None
    in_control: bool = False
    controller_lost: bool = False
    taken_by: str | None = None
    name: str = ""
    """Of this client's session."""
    asked_by: str | None = None
    free_in: float | None = None
    """Seconds until the session that asks may take control."""
    kept: bool = False
    """This client's session asked, and control was kept."""


LOG = logging.getLogger(__name__)

SESSION_LIMIT: Final = 1000
"""Sessions kept; beyond it the longest absent one without control is removed."""
RENAME_S: Final = 2.0
"""Seconds between two names of a session."""
LONGEST_FLIGHT_S: Final = 3600.0
"""Seconds after its last sign of life for which a lost session keeps its login whatever its age: a flight is over by
then."""
_SECRET: Final = re.compile(r"[A-Za-z0-9_-]{43}")


class ControlDesk:
    """A `hawk.comm.protocol.heartbeat.OperatorDesk`. Times are seconds of the daemon's clock."""

    def __init__(self, clock: Callable[[], float], settings: OperatorSettings) -> None:
        self._clock = clock
        self._settings = settings
        self._sessions: dict[str, Session] = {}
        self._clients: dict[ClientId, Session] = {}
        self._holder: Session | None = None
        self._lapsed: Session | None = None
        """The session whose lease ran out last, while nobody has taken control since."""
        self._count = 0
        self._asking = Asking(clock)
        self._given_back_by = ""

    # -- sessions -----------------------------------------------------------------------------------------------------

    def connect(self, client: ClientId, secret: str | None, role: Role = Role.OPERATOR) -> Session:
        """Add a connection; without a cookie of ours, or with that of another role, it gets a new session."""
        found = self._sessions.get(secret or "")
        if secret is None or not _SECRET.fullmatch(secret) or (found is not None and found.role is not role):
            secret = secrets.token_urlsafe(32)  # 256 random bits
        session = self._sessions.get(secret) or self._create(secret, role)
        if session.connections == 0:
            session.name = self._distinct(session)  # somebody may have taken the name in the meantime
        session.connections += 1
        self._clients[client] = session
        return session

    def disconnect(self, client: ClientId) -> None:
        """Remove a connection; the session and its lease stay until they expire."""
        session = self._clients.pop(client, None)
        if session is not None:
            session.connections -= 1
            session.looks.pop(client, None)

    def keeps_place(self, secret: str | None) -> bool:
        """Return True for the cookie of the session in control: it gets in when the server is full.

        A session whose lease ran out counts as long as nobody has taken control since.
        """
        session = self._lease() or self._lapsed
        given = secret if secret is not None and _SECRET.fullmatch(secret) else ""
        return session is not None and hmac.compare_digest(given, session.secret)

    def keeps_login(self, secret: str) -> bool:
        """Return True for the session in control, and for a lost one long enough for it to come back in flight."""
        if not self.keeps_place(secret):
            return False
        return self._lease() is not None or self._clock() - self._sessions[secret].last_sign <= LONGEST_FLIGHT_S

    def role(self, client: ClientId) -> Role:
        """Return the role of a connection; one that is not known commands nothing."""
        session = self._clients.get(client)
        return Role.VIEWER if session is None else session.role

    def sign_of_life(self, client: ClientId, *, is_hidden: bool | None = False) -> None:
        """Note that the client sent something. ``is_hidden``: nobody sees its page; None: it says nothing of that."""
        session, now = self._clients.get(client), self._clock()
        if session is None:
            return
        if session is self._holder and not self.operator_present(now):
            self._asking.acted()  # it was lost and could not answer
        session.last_sign = now
        if is_hidden is not None:
            session.looks[client] = (now, is_hidden)
        self._note_hidden(session, now)

    def _note_hidden(self, session: Session, now: float) -> None:
        """Note since when nobody sees a page of a session. A page that shows no life any more shows nothing."""
        alive = [hidden for at, hidden in session.looks.values() if now - at <= self._settings.operator_timeout_s]
        if not all(alive):
            session.hidden_since = None
        elif alive and session.hidden_since is None:
            session.hidden_since = now

    def acted(self, client: ClientId) -> None:
        """Note a command of this client beyond a sign of life."""
        if self.has_control(client):
            self._asking.acted()

    # -- names --------------------------------------------------------------------------------------------------------

    def call(self, client: ClientId, name: str | None) -> str | None:
        """Call a connection's session by a name, None for its number: None when done, else the reason."""
        session, now = self._clients[client], self._clock()
        if (name or "") == session.given:
            return None
        if now - session.renamed < RENAME_S:
            return f"Name: was changed a moment ago; wait {RENAME_S:g} s."
        before, session.given, session.renamed = session.name, name or "", now
        session.name = self._distinct(session)
        LOG.info("%s (%s) is called %s from now on", before, session.number, session.name)
        return None

    def names(self) -> dict[ClientId, str]:
        """Return the name of each connection's session."""
        return {client: session.name for client, session in self._clients.items()}

    def _distinct(self, session: Session) -> str:
        present = {*self._clients.values()} | ({self._holder} if self._holder is not None else set())
        return distinct(session.given or session.number, (other.name for other in present - {session}))

    # -- control ------------------------------------------------------------------------------------------------------

    def request(self, client: ClientId) -> str | None:
        """Ask for control: None when granted, else the reason. That of a lost operator is granted at once."""
        holder = self._lease()
        session = self._clients[client]
        if holder is not None and holder is not session and self._is_held():
            if not self._asking.is_due(session):
                silence = min(self._settings.operator_timeout_s, self._settings.control_lease_s)
                return f"{SOMEONE_ELSE} It is free once given back, or after {silence:g} s of silence."
            LOG.info("%s takes control from %s, which did not answer", session.name, holder.name)
        former = holder or self._lapsed
        if former is not None and former is not session:
            former.successor = session
            LOG.info("%s takes control from %s", session.name, former.name)
        self._hand(session)
        return None

    def ask(self, client: ClientId) -> str | None:
        """Ask the one in control for it: None when asked, or granted because nobody else is there; else the reason."""
        session = self._clients[client]
        if self._holder is session or not self._is_held():
            return self.request(client)
        session.last_sign = self._clock()
        return self._asking.ask(session)

    def withdraw(self, client: ClientId) -> str | None:
        """Take this session's question back: None when done, else the reason."""
        if self._asking.asker is not self._clients[client]:
            return "You have not asked for control."
        self._asking.end()
        return None

    def answer(self, client: ClientId, *, gives: bool) -> str | None:
        """Answer the question for control: None when done, else the reason."""
        if not self.has_control(client):
            return "You do not have control."
        asker = self._asking.asker
        if asker is None:
            return "Nobody asks for control any more."
        if gives:
            LOG.info("%s gives control to %s", self._clients[client].name, asker.name)
            self._hand(asker)
        else:
            self._asking.keep()
        return None

    def release(self, client: ClientId) -> str | None:
        """Give control back: None when done, else the reason."""
        if not self.has_control(client):
            return "You do not have control."
        self._given_back_by = self._clients[client].name
        self._holder = None
        self._asking.end()
        return None

    # -- OperatorDesk -------------------------------------------------------------------------------------------------

    def operator_present(self, now: float) -> bool:
        """Return True when the session with control showed a sign of life within ``operator_timeout_s``."""
        holder = self._lease()
        return holder is not None and now - holder.last_sign <= self._settings.operator_timeout_s

    def hidden_since(self) -> float | None:
        """Since when each page of the session with control is hidden, seconds; None while one is shown."""
        holder = self._lease()
        return None if holder is None else holder.hidden_since

    def controller(self) -> str | None:
        """Name of the session that has control."""
        holder = self._lease()
        return None if holder is None else holder.name

    def controller_is_lost(self) -> bool:
        """Return True when a session has control but shows no life: control is free for the asking."""
        return self.tenure() is Tenure.LOST

    def tenure(self) -> Tenure:
        """Return whether any session has control, and shows life."""
        if self._lease() is None:
            return Tenure.FREE
        return Tenure.HELD if self.operator_present(self._clock()) else Tenure.LOST

    def controlling_clients(self) -> frozenset[ClientId]:
        """Return the connections of the session that has control."""
        holder = self._lease()
        return frozenset(client for client, session in self._clients.items() if session is holder)

    def has_control(self, client: ClientId) -> bool:
        """Return True when this connection's session has control."""
        holder = self._lease()
        return holder is not None and self._clients.get(client) is holder

    def given_back_by(self) -> str:
        """Name of the session that gave control back, while nobody has taken it since; else empty."""
        return self._given_back_by if self._lease() is None else ""

    def taken_by(self, client: ClientId) -> str | None:
        """Name of the session that took control from this connection's while that was lost, and has it still."""
        holder, session = self._lease(), self._clients.get(client)
        taken = holder is not None and session is not None and session.successor is holder
        return holder.name if taken and holder is not None else None

    def seen_by(self, client: ClientId) -> ControlView:
        """Return what this connection's heartbeat says of control."""
        session = self._clients.get(client)
        asker = self._asking.asker if self._is_held() else None
        return ControlView(
            self.controller(),
            self.has_control(client),
            self.controller_is_lost(),
            self.taken_by(client),
            "" if session is None else session.name,
            None if asker is None else asker.name,
            self._asking.free_in if asker is not None else None,
            self._asking.was_kept_from(session),
        )

    def is_lost(self, client: ClientId) -> bool:
        """Return True when this connection's session has control but shows no life: it receives no heartbeat."""
        return self.has_control(client) and not self.operator_present(self._clock())

    # -----------------------------------------------------------------------------------------------------------------

    def _is_held(self) -> bool:
        return self.tenure() is Tenure.HELD

    def _hand(self, session: Session) -> None:
        """Give control to a session: it counts as present from now on."""
        session.last_sign = self._clock()
        session.successor = None
        self._holder, self._lapsed, self._given_back_by = session, None, ""
        self._asking.end()

    def _lease(self) -> Session | None:
        if self._holder is not None and self._clock() - self._holder.last_sign > self._settings.control_lease_s:
            self._holder, self._lapsed = None, self._holder
        return self._holder

    def _create(self, secret: str, role: Role) -> Session:
        absent = [s for s in self._sessions.values() if s.connections == 0 and s is not self._holder]
        if len(self._sessions) >= SESSION_LIMIT and absent:
            del self._sessions[min(absent, key=lambda s: s.last_sign).secret]
        self._count += 1
        number = f"{role.capitalize()} {self._count}"
        session = self._sessions[secret] = Session(number, secret, role, number)
        return session


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
    _notified: Session | None = None

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
        if self._notified is session:
            self._notified = None
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
            self._kept[asker], self._notified = self.clock(), asker
        self.end()

    def was_kept_from(self, session: Session | None) -> bool:
        """Return True while this session's last question was answered by "Keep" lately."""
        return session is not None and self._notified is session and self.clock() - self._kept[session] <= AGAIN_S

    def end(self) -> None:
        """Forget the question: it was answered, withdrawn, or control went elsewhere."""
        self._question = None
