"""The operation state (specification section 17) and what the states share.

A state decides from facts and its own small data and returns values; it never sends, logs or makes another state.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from hawk.comm.protocol.commands import AutonomousExplore, Hold, Land, ReturnToLaunch
from hawk.ddc.acts import STAY, Acts, Ask, Request, SetMode, Step
from hawk.ddc.facts import Answer, Facts
from hawk.ddc.motion import Goal
from hawk.ddc.orders import Cause, MoveOrder, Order, Rank, SafetyOrder, ToExplore, ToHover, ToLand, ToMove, ToReturn
from hawk.ddc.readings.home import home_words
from hawk.ddc.readings.operator import SOME_OPERATOR
from hawk.model.operation import StateName
from hawk.model.poses import MapPoint
from hawk.model.sentences import joined, say
from hawk.model.vehicle import CopterMode

MODE_RETRY_S = 2.0
"""A mode that was refused, or acknowledged and does not show, is asked for again after this time, seconds."""


class State(ABC):
    """One operation state. `process` says what to do, `transition_next_state` what follows; both run once a tick.

    The class attributes are its traits: guard, judge and gate ask for them and never for a name.
    """

    identity: ClassVar[StateName]
    on_ground: ClassVar[bool] = False
    """The drone is not in the air."""
    is_task: ClassVar[bool] = False
    """Flies somewhere for the operator."""
    sees: ClassVar[bool] = False
    """Flies by sight: a fault of perception ends it."""
    is_guarded: ClassVar[bool] = False
    """Fence, ceiling and battery reserve act."""
    stops_at_fence: ClassVar[bool] = False
    """A breach of the fence ends it."""
    needs_operator: ClassVar[bool] = False
    """A lost operator ends it (Takeoff looks itself, after its climb)."""
    holds: ClassVar[bool] = False
    """Holds where the drone is, above Max as well: a pilot may have flown it there."""
    is_homing: ClassVar[bool] = False
    """The autopilot brings the drone down: Hold needs control."""

    def __init__(self, now: float) -> None:
        """Begin at ``now``, seconds; nothing is done before `enter`."""
        self.entered = now
        self.asked_by = ""
        """Name of the one who asked for it; empty when nobody did, or the name is not known."""

    def get_identity(self) -> str:
        """Return the identity string."""
        return self.identity.value

    @property
    def rank(self) -> Rank:
        """Rank of the present activity: automatic reactions of this rank and below leave the state alone."""
        return Rank.TASK

    @property
    def may_send_targets(self) -> bool:
        """True while it may send targets; it may change while the state lasts."""
        return False

    @property
    def is_left_alone(self) -> bool:
        """True while neither a restart nor the end of the program changes it."""
        return False

    @property
    def goal(self) -> Goal | None:
        """The place that the drone is sent to; None when there is none."""
        return None

    @property
    def autopilot_mode(self) -> CopterMode | None:
        """The autopilot's mode that alone brings the drone down; None where the state sends targets, or nothing."""
        return None

    @property
    def may_take_off(self) -> bool:
        """True while Takeoff may follow."""
        return False

    def route(self, facts: Facts) -> tuple[MapPoint, ...]:
        """Return the rest of the path to the goal, from the drone; empty when there is none."""
        return ()

    @abstractmethod
    def detail(self, facts: Facts) -> str:
        """Return one sentence for the operator: the present activity, or the reason for the state."""

    def age(self, facts: Facts) -> float:
        """Return the seconds since the state began."""
        return facts.now - self.entered

    def hold_refusal(self, facts: Facts) -> str:
        """Return the reason why Hold is refused now; empty when it is not."""
        return ""

    def return_in(self, facts: Facts) -> float | None:
        """Return the seconds until the drone returns home by itself; None when it does not."""
        return None

    def restart(self) -> None:  # noqa: B027 - most states have nothing to begin again
        """Begin again from where the drone is: the link was lost, or the position jumped."""

    def enter(self, facts: Facts) -> Acts:
        """Return the acts of the moment in which the state becomes the active one."""
        return ()

    def leave(self, facts: Facts) -> Acts:
        """Return the acts of the moment in which another state becomes the active one."""
        return ()

    def process(self, facts: Facts) -> Acts:
        """Return the acts of this tick."""
        return ()

    @abstractmethod
    def transition_next_state(self, facts: Facts, order: Order | None = None) -> Step:
        """Return the transition that the facts, or an accepted order, cause; none when the state stays."""


class AirborneState(State):
    """A state in the air that the operator may end by Hold, Return To Launch, Land, Explore or a Move."""

    def transition_next_state(self, facts: Facts, order: Order | None = None) -> Step:
        """Follow the order; without one decide by the facts."""
        return self._decide(facts) if order is None else self._follow(facts, order)

    def _follow(self, facts: Facts, order: Order) -> Step:
        asked, by = (order.command, order.by) if isinstance(order, SafetyOrder) else (order, "")
        match asked:
            case Hold():
                return Step(ToHover(say("Stopped by {by}.", by=by or SOME_OPERATOR), by=by))
            case ReturnToLaunch():
                return Step(ToReturn(by=by))
            case Land():
                return Step(ToLand(by=by))
            case MoveOrder():
                return Step(ToMove(asked))
            case AutonomousExplore():
                return Step(ToExplore())
            case _:
                return STAY

    def _decide(self, facts: Facts) -> Step:
        return STAY


class PendingRequest:
    """One request of a state, if it has asked: its outcome by the facts."""

    def __init__(self) -> None:
        self._ask: Ask | None = None
        self._outcome: Answer | None = None

    @property
    def is_open(self) -> bool:
        """True once a request was made."""
        return self._ask is not None

    def ask(self, request: Request, facts: Facts) -> Ask:
        """Return the act that starts a request; its outcome is this one's from now on."""
        self._ask, self._outcome = Ask(request, facts.now), None
        return self._ask

    def clear(self) -> None:
        """Forget the request."""
        self._ask = self._outcome = None

    def answer(self, facts: Facts) -> Answer | None:
        """Return the outcome so far; None when nothing was asked."""
        if self._outcome is None and self._ask is not None:
            answer = self._ask.answer(facts)
            if answer.is_pending:
                return answer
            self._outcome = answer  # facts forget it after a while
        return self._outcome

    def is_done(self, facts: Facts) -> bool:
        """Return True after a positive answer."""
        answer = self.answer(facts)
        return answer is not None and answer.is_done

    def failure(self, facts: Facts) -> Answer | None:
        """Return the answer when the request failed."""
        answer = self.answer(facts)
        return answer if answer is not None and answer.has_failed else None


class ModeKeeper:
    """Asks for one mode until the HEARTBEAT shows it; never afterwards: then somebody else changed it."""

    def __init__(self, mode: CopterMode) -> None:
        self._mode = mode
        self._pending = PendingRequest()
        self._asked = float("-inf")
        self.is_reached = False
        """True once the mode was seen."""
        self.reason = ""
        """The autopilot's words when it refused the last request."""
        self.attempts = 0
        self.refusals = 0

    def reach(self, facts: Facts) -> Acts:
        """Look for the mode; return the request when it is time to ask."""
        if self.is_reached or facts.vehicle.custom_mode == self._mode:
            self.is_reached, self.reason = True, ""
            return ()
        answer = self._pending.answer(facts)
        if answer is not None and answer.has_failed:
            self._pending.clear()
            self.refusals += 1
            self.reason = answer.reason
        waits = answer is not None and answer.is_pending
        if waits or facts.now - self._asked < MODE_RETRY_S or not facts.link.is_up:
            return ()
        self._asked = facts.now
        self.attempts += 1
        return (self._pending.ask(SetMode(self._mode), facts),)


def returning(facts: Facts, cause: Cause) -> ToReturn | ToLand:
    """Return the transition of a return that cannot wait, nor fly a path.

    Land where RTL would not end at home, and where the drone's own place is doubted.
    """
    if facts.witness.misleads_home:
        return ToLand(cause_here(facts, cause))
    return (
        ToLand(astray(facts, cause)) if leaves(facts) else ToReturn(cause, straight=say("the program cannot lead it"))
    )


def cause_here(facts: Facts, cause: Cause) -> Cause:
    """Return the cause of a landing in place of a return that would fly to a place that is doubted."""
    return Cause(joined(cause.text, facts.witness.doubt), cause.kind, cause.details)


def leaves(facts: Facts) -> bool:
    """Return True while RTL would not end at home, nor at a home that somebody moved inside the fence."""
    home = facts.position.autopilot_home
    return home.misleads or (bool(facts.kept.astray) and not home.is_moved)


def astray(facts: Facts, cause: Cause | None) -> Cause | None:
    """Return the cause of a landing in place of a return; None keeps a landing that nobody caused."""
    if cause is None:
        return None
    return Cause(joined(cause.text, astray_words(facts)), cause.kind, cause.details)


def astray_words(facts: Facts) -> str:
    """Return in words why RTL would not end at home."""
    home = facts.position.autopilot_home
    return home_words(home) if home.is_moved else facts.kept.astray
