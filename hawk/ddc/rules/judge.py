"""Decides on commands: by the table of commands and states, and by what else must be true. Nothing is changed here."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

from hawk.comm.protocol.authority import authority_refusal
from hawk.comm.protocol.commands import (
    AutonomousMove,
    Command,
    CompulsiveMove,
    Configure,
    Land,
    Resume,
    ReturnToLaunch,
    RouteRequest,
    SetFence,
    SetOutline,
)
from hawk.comm.protocol.heartbeat import CheckItem, ClientId, CommandOption, KillState
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import contains, path_is_inside, path_words, place_words
from hawk.ddc.fence.plan import fence_refusal
from hawk.ddc.orders import Rank
from hawk.ddc.parameters.heights import ParameterError, check_heights
from hawk.ddc.parameters.values import FailsafeCheck, Values
from hawk.ddc.readings.home import home_words
from hawk.ddc.readings.sight import FAULT_CONFIRM_S
from hawk.ddc.rules.command_table import NEEDS_LINK, TABLE, table_reason
from hawk.ddc.rules.outline_rules import NOTHING_INSIDE, outline_refusal
from hawk.ddc.rules.preflight import failsafe_checks, preflight_items
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import State
from hawk.ddc.words import named, seconds, sentence
from hawk.model.limits import HeightParameters
from hawk.model.operation import Fall, StateName, UserError
from hawk.model.plans import Route
from hawk.model.poses import MapPoint
from hawk.model.sentences import joined, say, words_of

RESUME_WAIT_S = 3.0
"""Resume is refused so soon after a mode change: the pilot's hand is still at the switch."""


LOT_IS_SEEN = say(
    "Explored already: the lot found is seen whole. Move to other ground first, or land for a new survey."
)
OUTLINE_IS_SEEN = say("Explored already: the outline is seen whole. Set another one, or land for a new survey.")

ALWAYS_SENT = frozenset({"Return To Launch", "Land"})
"""Commands that are sent without an answer when the armed drone is not heard, whatever the state (as is Kill)."""
UNHEARD = say("Sent without an answer: no word from the autopilot.")


@dataclass(frozen=True, slots=True)
class Bench:
    """Work of the operations manager that bears on commands.

    It cuts the motors, sets failsafes, and sees to it that the autopilot holds our fence (``fence_problem``: the reason
    why it does not).
    """

    kill_state: KillState = "none"
    is_killed: bool = False
    is_setting: bool = False
    fence_problem: str = ""
    fall: Fall | None = None
    """Motors that went off in the air; None once it is cleared."""


@dataclass(frozen=True, slots=True)
class Refusal:
    """Reason why a command is refused; ``error`` is the User Error that it causes."""

    reason: str
    error: UserError = UserError.NONE


_PUT_BACK = say("It is being put back: wait.")
_OUT_OF_BOUNDS = UserError.DESIRED_LOCATION_OUT_OF_BOUNDS
_POSITION_UNKNOWN = Refusal(say("The position is not known well enough: wait for it."))


class Case:
    """Everything that a command is decided on."""

    def __init__(
        self, facts: Facts, state: State, settings: DdcSettings, values: Values, bench: Bench = Bench()
    ) -> None:
        """``values``: the autopilot's parameters that were read lately."""
        self.facts = facts
        self.state = state
        self.settings = settings
        self.values = values
        self.bench = bench

    @cached_property
    def checks(self) -> tuple[CheckItem, ...]:
        """The preflight checks, made when first asked for."""
        return preflight_items(
            self.facts, self.values, self.settings, is_killed=self.bench.is_killed, fall=self.bench.fall
        )

    @cached_property
    def failsafes(self) -> tuple[FailsafeCheck, ...]:
        """The checks of the autopilot's failsafes, made when first asked for."""
        return failsafe_checks(self.facts, self.values, self.settings)


def options(case: Case) -> tuple[CommandOption, ...]:
    """Return for every command whether the one in control could give it now, and the reason if not."""
    found = []
    for command in TABLE:
        refusal = _impossible(case, command)
        reason = "" if refusal is None else refusal.reason
        found.append(CommandOption(command=command, possible=refusal is None, reason=reason))
    return tuple(found)


def refusal(case: Case, client: ClientId, command: Command) -> Refusal | None:
    """Return the reason why a command of this client is refused; None when it is accepted."""
    kind = command_type(command)
    operator = case.facts.operator
    unauthorised = authority_refusal(
        kind,
        has_control=client in operator.clients,
        control=operator.tenure,
        homing=case.state.is_homing,
    )
    if unauthorised:
        return Refusal(unauthorised)
    return _impossible(case, kind) or _content(case, command)


def place_of(command: AutonomousMove | CompulsiveMove | RouteRequest, facts: Facts) -> MapPoint | None:
    """Return the place (map frame) of a Move or Route Request; None while the position is unknown."""
    if command.frame == "Map":
        return MapPoint(command.x, command.y)
    here = facts.place
    return None if here is None else MapPoint(here.north + command.x, here.east + command.y)


def place_refusal(facts: Facts, place: MapPoint) -> Refusal | None:
    """Return the reason why the drone may not be at this place of the map."""
    fence = facts.limits.fence
    if facts.pose is None or fence is None:
        return _POSITION_UNKNOWN
    if not contains(fence, place):
        where = place_words(fence, place)
        return Refusal(say("X, Y: the place is {where}: choose one inside.", where=where), _OUT_OF_BOUNDS)
    return None


def move_refusal(facts: Facts, place: MapPoint) -> Refusal | None:
    """Return the reason why the drone may not go straight to this place of the map."""
    refused, fence = place_refusal(facts, place), facts.limits.fence
    if refused is None and fence is not None and not _is_path_inside(facts, place):
        what = path_words(fence)
        words = say("X, Y: the straight way there {what}: go around it in two moves.", what=what)
        return Refusal(words, _OUT_OF_BOUNDS)
    return refused


def route_refusal(facts: Facts, route: Route) -> Refusal | None:
    """Return the reason why the drone may not fly this route: a leg, or the path to it, leaves the fence."""
    fence = facts.limits.fence
    if fence is None:
        return _POSITION_UNKNOWN
    legs_inside = all(path_is_inside(fence, a, b) for a, b in pairwise(route.points))
    if len(route.points) < 2 or not legs_inside or not _is_path_inside(facts, route.points[1]):
        return Refusal(say("X, Y: the way there {what}: choose another place.", what=path_words(fence)), _OUT_OF_BOUNDS)
    return None


def is_sent_unheard(facts: Facts, kind: str) -> bool:
    """Return True for a command that goes to an autopilot that is not heard."""
    return facts.is_unheard and kind in ALWAYS_SENT


def command_type(command: Command) -> str:
    """Return a command's Type."""
    return str(getattr(command, "type", type(command).__name__))


# -- steps of the decision --------------------------------------------------------------------------------------------


def _impossible(case: Case, kind: str) -> Refusal | None:
    if case.bench.kill_state == "sending" and kind not in ("Kill", "Kill Request"):
        return Refusal(say("The motors are being cut."))
    if is_sent_unheard(case.facts, kind):
        return None
    reason = table_reason(kind, case.state.identity)
    if reason:
        return Refusal(reason)
    if kind in NEEDS_LINK and not case.facts.link.is_up:
        return Refusal(say("No link to the autopilot: wait until it is found."))
    condition = _CONDITIONS.get(kind)
    return None if condition is None else condition(case)


def _content(case: Case, command: Command) -> Refusal | None:
    facts, heights = case.facts, case.facts.limits.heights
    match command:
        case Configure():
            return _heights(command, facts.ceiling(case.state.on_ground), case.settings.floor)
        case SetFence():
            reason = fence_refusal(command, case.settings, heights)
            return Refusal(reason) if reason else None
        case SetOutline():
            reason = outline_refusal(command, facts, case.settings)
            return Refusal(reason) if reason else None
        case AutonomousMove() | CompulsiveMove():
            place = place_of(command, facts)
            reachable = place_refusal if isinstance(command, AutonomousMove) else move_refusal
            refused = _POSITION_UNKNOWN if place is None else reachable(facts, place)
            return _travel_height(command, heights) or refused
        case Resume() | ReturnToLaunch() | Land() if not command.confirmed:
            if case.state.identity is StateName.MANUAL:
                return Refusal(say("Confirmed: someone else flies; send it confirmed."))
    return None


def _travel_height(command: AutonomousMove | CompulsiveMove, heights: HeightParameters) -> Refusal | None:
    height = command.height if isinstance(command, CompulsiveMove) else None
    low, high = heights.minimum, heights.maximum
    if height is None or low <= height <= high:
        return None
    return Refusal(say("Height: must lie between Min {low:g} m and Max {high:g} m.", low=low, high=high))


def _heights(command: Configure, ceiling: float, floor: float) -> Refusal | None:
    try:
        check_heights(HeightParameters(command.min, command.des, command.max), ceiling, floor)
    except ParameterError as error:
        return Refusal(words_of(error))
    return None


def _is_path_inside(facts: Facts, place: MapPoint) -> bool:
    here, fence = facts.place, facts.limits.fence
    return here is not None and fence is not None and path_is_inside(fence, here.point, place)


# -- conditions of single commands ------------------------------------------------------------------------------------


def _arm(case: Case) -> Refusal | None:
    if case.bench.fall is not None:
        return Refusal(say("The motors went off in the air: look at the drone, then clear it."))
    if case.bench.is_killed:
        return Refusal(say("The motors were cut: clear it first."))
    failed = next((item for item in case.checks if not item.passed), None)
    if failed is None:
        return None
    return Refusal(joined(named(failed.name, failed.value), sentence(failed.remedy)))


def _failsafes(case: Case, but: Collection[str] = ()) -> Refusal | None:
    """Refuse what flies on until the autopilot would bring the drone home without us; ``but``: checks left out."""
    failed = next((check for check in case.failsafes if not check.passed and check.name not in but), None)
    if failed is None:
        return None
    if not failed.is_read:
        remedy: str = say("Wait a moment.")
    elif failed.name in case.facts.kept.restored:
        remedy = _PUT_BACK
    elif failed.can_be_set:
        in_air, on_ground = say("Return or land, then Set failsafes."), say("Disarm, then Set failsafes.")
        remedy = in_air if case.facts.is_airborne else on_ground
    else:
        remedy = failed.remedy
    return Refusal(joined(named(failed.name, failed.value), remedy))


def _flight_gate(case: Case) -> Refusal | None:
    """Refuse every task, whichever station armed, unless failsafes, home and the autopilot's fence are right."""
    problem, home = case.bench.fence_problem, case.facts.position.autopilot_home
    if case.facts.kept.lost:
        return Refusal(case.facts.kept.lost_words)
    if home.is_moved:
        return Refusal(joined(home_words(home), say("It is being set back: wait.")))
    return _failsafes(case) or (Refusal(problem) if problem else None)


def _takeoff(case: Case) -> Refusal | None:
    if not case.state.may_take_off:
        return Refusal(say("Arming: wait until it is armed."))
    return _flight_gate(case)


def _explore(case: Case) -> Refusal | None:
    refused, outline, plan = _autonomous_move(case), case.facts.limits.outline, case.facts.sight.plan
    if refused is None and plan is not None and plan.explore.is_spent:
        return Refusal(OUTLINE_IS_SEEN if outline is not None else LOT_IS_SEEN)
    if refused is None and outline is not None:
        return Refusal(NOTHING_INSIDE) if outline.area <= 0.0 else None
    if refused is None and not case.facts.sight.lot:
        return Refusal(say("No lot in sight: move over the lot first."), UserError.NO_LOT_DETECTED)
    return refused


def _autonomous_move(case: Case) -> Refusal | None:
    sight = case.facts.sight
    lasts = sight.fault_s >= FAULT_CONFIRM_S  # one bad picture refuses no task, as it ends none
    return _compulsive_move(case) or (Refusal(sight.fault) if sight.fault and lasts else None)


def _compulsive_move(case: Case) -> Refusal | None:
    return _position(case) or _flight_gate(case)


def _position(case: Case) -> Refusal | None:
    if case.facts.pose is None or case.facts.limits.fence is None:
        return _POSITION_UNKNOWN
    if case.facts.witness.doubt:
        return Refusal(case.facts.witness.doubt)
    return Refusal(say("Outside the fence: wait until it is back inside.")) if case.facts.is_breached else None


def _hold(case: Case) -> Refusal | None:
    reason = case.state.hold_refusal(case.facts)
    return Refusal(reason) if reason else _in_the_air(case)


def _land(case: Case) -> Refusal | None:
    if case.state.rank is Rank.AUTOPILOT:
        return Refusal(case.state.hold_refusal(case.facts))
    return _in_the_air(case)


def _in_the_air(case: Case) -> Refusal | None:
    if case.state.identity is StateName.TAKEOFF:
        return None  # "on the ground" is up to a second old while it takes off
    return Refusal(say("On the ground.")) if case.facts.is_on_ground else None


def _disarm(case: Case) -> Refusal | None:
    """Disarm needs the ground. While the motors are off yet, in Arm, it only stops the arming."""
    facts = case.facts
    if facts.is_on_ground or (not facts.vehicle.armed and case.state.on_ground):
        return None
    return Refusal(facts.ground.doubt or say("In the air: wait until it is on the ground."))


def _resume(case: Case) -> Refusal | None:
    left = RESUME_WAIT_S - (case.facts.now - case.facts.link.mode_changed_at)
    if left > 0:
        return Refusal(say("The mode changed just now: wait {left}.", left=seconds(left)))
    place = case.facts.witness.place
    if place.is_doubted and not place.is_followed:  # Hover could not hold it, and would land
        return _in_the_air(case) or Refusal(joined(place.words, say("It could not be held: land it, or fly by hand.")))
    # Hover brings our fence to the autopilot, and what was right back into it, before any task
    return _in_the_air(case) or _failsafes(case, but=case.facts.kept.known)


def _clear_kill(case: Case) -> Refusal | None:
    return None if case.bench.is_killed else Refusal(say("The motors were not cut."))


def _set_failsafes(case: Case) -> Refusal | None:
    return Refusal(say("Being set: wait a moment.")) if case.bench.is_setting else None


def _clear_outline(case: Case) -> Refusal | None:
    return None if case.facts.limits.outline is not None else Refusal(say("No outline is set."))


def _clear_fence(case: Case) -> Refusal | None:
    is_drawn = case.facts.limits.plan.source == "drawn" or case.facts.limits.plan_problem != ""
    return None if is_drawn else Refusal(say("No fence is drawn: the standard one is used."))


def _new_survey(case: Case) -> Refusal | None:
    sight = case.facts.sight
    if case.facts.vehicle.armed:
        return Refusal(say("Armed: disarm first."))
    is_empty = sight.lot_area <= 0.0 and sight.counts.total == 0
    return Refusal(say("The map is empty: the next flight begins it.")) if is_empty else None


_CONDITIONS: Mapping[str, Callable[[Case], Refusal | None]] = {
    "Arm": _arm,
    "Takeoff": _takeoff,
    "Autonomous Explore": _explore,
    "Autonomous Move": _autonomous_move,
    "Compulsive Move": _compulsive_move,
    "Hold": _hold,
    "Return To Launch": _in_the_air,
    "Land": _land,
    "Disarm": _disarm,
    "Resume": _resume,
    "Clear Kill": _clear_kill,
    "Set Failsafes": _set_failsafes,
    "Clear Fence": _clear_fence,
    "Clear Outline": _clear_outline,
    "New Survey": _new_survey,
}
