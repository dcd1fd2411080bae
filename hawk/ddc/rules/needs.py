"""The situation that commands are judged on, and one function for each `Need` of the table of commands."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from hawk.comm.protocol.command_table import DISARM_FIRST, ON_GROUND, Need
from hawk.comm.protocol.heartbeat import CheckItem, KillState
from hawk.ddc.facts import Facts
from hawk.ddc.orders import Rank
from hawk.ddc.parameters.values import FailsafeCheck, Values
from hawk.ddc.readings.home import home_words
from hawk.ddc.readings.sight import FAULT_CONFIRM_S
from hawk.ddc.rules.preflight import failsafe_checks, preflight_items
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import State
from hawk.ddc.words import named, seconds, sentence
from hawk.model.operation import Fall, StateName, UserError
from hawk.model.sentences import joined, say

RESUME_WAIT_S = 3.0
"""Resume is refused so soon after a mode change: the pilot's hand is still at the switch."""

LOT_IS_SEEN = say(
    "Explored already: the lot found is seen whole. Move to other ground first, or land for a new survey."
)
OUTLINE_IS_SEEN = say("Explored already: the outline is seen whole. Set another one, or land for a new survey.")
NOTHING_INSIDE = say("Nothing of the outline lies inside the fence: set another outline, or clear it.")
_PUT_BACK = say("It is being put back: wait.")


@dataclass(frozen=True, slots=True)
class Refusal:
    """Reason why a command is refused; ``error`` is the User Error that it causes."""

    reason: str
    error: UserError = UserError.NONE


POSITION_UNKNOWN: Final = Refusal(say("The position is not known well enough: wait for it."))


@dataclass(frozen=True, slots=True)
class Interlocks:
    """Work and memory of the program that lock commands.

    ``fence_problem``: the reason why the autopilot does not hold our fence. ``fall``: motors that went off in the air;
    None once it is cleared.
    """

    kill_state: KillState = "none"
    is_killed: bool = False
    is_setting: bool = False
    """Failsafes are being set."""
    fence_problem: str = ""
    fall: Fall | None = None


class Situation:
    """Everything that a command is judged on."""

    def __init__(
        self, facts: Facts, state: State, settings: DdcSettings, values: Values, interlocks: Interlocks = Interlocks()
    ) -> None:
        """``values``: the autopilot's parameters that were read lately."""
        self.facts = facts
        self.state = state
        self.settings = settings
        self.values = values
        self.interlocks = interlocks

    @cached_property
    def checks(self) -> tuple[CheckItem, ...]:
        """The preflight checks, made when first asked for."""
        locks = self.interlocks
        return preflight_items(self.facts, self.values, self.settings, is_killed=locks.is_killed, fall=locks.fall)

    @cached_property
    def failsafes(self) -> tuple[FailsafeCheck, ...]:
        """The checks of the autopilot's failsafes, made when first asked for."""
        return failsafe_checks(self.facts, self.values, self.settings)


def unmet(need: Need, situation: Situation) -> Refusal | None:
    """Return the refusal of a command whose need is not met; None when it is."""
    return _NEEDS[need](situation)


# -- link, motors, ground and air --------------------------------------------------------------------------------------


def _link(situation: Situation) -> Refusal | None:
    return None if situation.facts.link.is_up else Refusal(say("No link to the autopilot: wait until it is found."))


def _no_fall(situation: Situation) -> Refusal | None:
    if situation.interlocks.fall is None:
        return None
    return Refusal(say("The motors went off in the air: look at the drone, then clear it."))


def _not_cut(situation: Situation) -> Refusal | None:
    return Refusal(say("The motors were cut: clear it first.")) if situation.interlocks.is_killed else None


def _cut(situation: Situation) -> Refusal | None:
    return None if situation.interlocks.is_killed else Refusal(say("The motors were not cut."))


def _checks(situation: Situation) -> Refusal | None:
    failed = next((item for item in situation.checks if not item.passed), None)
    if failed is None:
        return None
    return Refusal(joined(named(failed.name, failed.value), sentence(failed.remedy)))


def _armed(situation: Situation) -> Refusal | None:
    return None if situation.state.may_take_off else Refusal(say("Arming: wait until it is armed."))


def _disarmed(situation: Situation) -> Refusal | None:
    return Refusal(DISARM_FIRST) if situation.facts.vehicle.armed else None


def _air(situation: Situation) -> Refusal | None:
    if situation.state.identity is StateName.TAKEOFF:
        return None  # "on the ground" is up to a second old while it takes off
    return Refusal(ON_GROUND) if situation.facts.is_on_ground else None


def _ground(situation: Situation) -> Refusal | None:
    """Refuse Disarm off the ground. While the motors are off yet, in Arm, it only stops the arming."""
    facts = situation.facts
    if facts.is_on_ground or (not facts.vehicle.armed and situation.state.on_ground):
        return None
    return Refusal(facts.ground.doubt or say("In the air: wait until it is on the ground."))


# -- before any task, whichever station armed --------------------------------------------------------------------------


def _kept(situation: Situation) -> Refusal | None:
    kept = situation.facts.kept
    return Refusal(kept.lost_words) if kept.lost else None


def _home(situation: Situation) -> Refusal | None:
    home = situation.facts.position.autopilot_home
    return Refusal(joined(home_words(home), say("It is being set back: wait."))) if home.is_moved else None


def _failsafes(situation: Situation, but: Collection[str] = ()) -> Refusal | None:
    """Refuse what flies on until the autopilot would bring the drone home without us; ``but``: checks left out."""
    failed = next((check for check in situation.failsafes if not check.passed and check.name not in but), None)
    if failed is None:
        return None
    if not failed.is_read:
        remedy: str = say("Wait a moment.")
    elif failed.name in situation.facts.kept.restored:
        remedy = _PUT_BACK
    elif failed.can_be_set:
        in_air, on_ground = say("Return or land, then Set failsafes."), say("Disarm, then Set failsafes.")
        remedy = in_air if situation.facts.is_airborne else on_ground
    else:
        remedy = failed.remedy
    return Refusal(joined(named(failed.name, failed.value), remedy))


def _other_failsafes(situation: Situation) -> Refusal | None:
    """Hover brings our fence to the autopilot, and what was right back into it, before any task."""
    return _failsafes(situation, but=situation.facts.kept.known)


def _fence(situation: Situation) -> Refusal | None:
    problem = situation.interlocks.fence_problem
    return Refusal(problem) if problem else None


# -- the place, and what is seen ---------------------------------------------------------------------------------------


def _position(situation: Situation) -> Refusal | None:
    facts = situation.facts
    return POSITION_UNKNOWN if facts.pose is None or facts.limits.fence is None else None


def _no_doubt(situation: Situation) -> Refusal | None:
    doubt = situation.facts.witness.doubt
    return Refusal(doubt) if doubt else None


def _inside(situation: Situation) -> Refusal | None:
    return Refusal(say("Outside the fence: wait until it is back inside.")) if situation.facts.is_breached else None


def _holdable(situation: Situation) -> Refusal | None:
    """Refuse to take a drone from the pilot that Hover could not hold, and would land."""
    place = situation.facts.witness.place
    if not place.is_doubted or place.is_followed:
        return None
    return Refusal(joined(place.words, say("It could not be held: land it, or fly by hand.")))


def _perception(situation: Situation) -> Refusal | None:
    sight = situation.facts.sight
    lasts = sight.fault_s >= FAULT_CONFIRM_S  # one bad picture refuses no task, as it ends none
    return Refusal(sight.fault) if sight.fault and lasts else None


def _unseen(situation: Situation) -> Refusal | None:
    plan = situation.facts.sight.plan
    if plan is None or not plan.explore.is_spent:
        return None
    return Refusal(OUTLINE_IS_SEEN if situation.facts.limits.outline is not None else LOT_IS_SEEN)


def _lot(situation: Situation) -> Refusal | None:
    outline = situation.facts.limits.outline
    if outline is not None:
        return Refusal(NOTHING_INSIDE) if outline.area <= 0.0 else None
    if situation.facts.sight.lot:
        return None
    return Refusal(say("No lot in sight: move over the lot first."), UserError.NO_LOT_DETECTED)


# -- who flies ---------------------------------------------------------------------------------------------------------


def _no_cause(situation: Situation) -> Refusal | None:
    reason = situation.state.hold_refusal(situation.facts)
    return Refusal(reason) if reason else None


def _not_autopilots(situation: Situation) -> Refusal | None:
    state = situation.state
    return Refusal(state.hold_refusal(situation.facts)) if state.rank is Rank.AUTOPILOT else None


def _switch_rests(situation: Situation) -> Refusal | None:
    left = RESUME_WAIT_S - (situation.facts.now - situation.facts.link.mode_changed_at)
    return Refusal(say("The mode changed just now: wait {left}.", left=seconds(left))) if left > 0 else None


# -- what is set, drawn and stored -------------------------------------------------------------------------------------


def _not_setting(situation: Situation) -> Refusal | None:
    return Refusal(say("Being set: wait a moment.")) if situation.interlocks.is_setting else None


def _drawn_fence(situation: Situation) -> Refusal | None:
    limits = situation.facts.limits
    is_drawn = limits.plan.source == "drawn" or limits.plan_problem != ""
    return None if is_drawn else Refusal(say("No fence is drawn: the standard one is used."))


def _outline(situation: Situation) -> Refusal | None:
    return None if situation.facts.limits.outline is not None else Refusal(say("No outline is set."))


def _map(situation: Situation) -> Refusal | None:
    sight = situation.facts.sight
    is_empty = sight.lot_area <= 0.0 and sight.counts.total == 0
    return Refusal(say("The map is empty: the next flight begins it.")) if is_empty else None


_NEEDS: Final[Mapping[Need, Callable[[Situation], Refusal | None]]] = {
    Need.LINK: _link,
    Need.NO_FALL: _no_fall,
    Need.NOT_CUT: _not_cut,
    Need.CHECKS: _checks,
    Need.ARMED: _armed,
    Need.KEPT: _kept,
    Need.HOME: _home,
    Need.FAILSAFES: _failsafes,
    Need.FENCE: _fence,
    Need.POSITION: _position,
    Need.NO_DOUBT: _no_doubt,
    Need.INSIDE: _inside,
    Need.PERCEPTION: _perception,
    Need.UNSEEN: _unseen,
    Need.LOT: _lot,
    Need.AIR: _air,
    Need.GROUND: _ground,
    Need.NO_CAUSE: _no_cause,
    Need.NOT_AUTOPILOTS: _not_autopilots,
    Need.SWITCH_RESTS: _switch_rests,
    Need.HOLDABLE: _holdable,
    Need.OTHER_FAILSAFES: _other_failsafes,
    Need.CUT: _cut,
    Need.NOT_SETTING: _not_setting,
    Need.DRAWN_FENCE: _drawn_fence,
    Need.OUTLINE: _outline,
    Need.DISARMED: _disarmed,
    Need.MAP: _map,
}
