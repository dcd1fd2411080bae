"""The situation that commands are judged on, and what each `Need` of the table of commands asks of it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from hawk.comm.protocol.command_table import DISARM_FIRST, ON_GROUND, Need
from hawk.comm.protocol.heartbeat import CheckItem, ClientId, KillState
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
NO_SUCH_PLAN = say("No such changed plan waits: look at the newest one.")
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
    None once it is cleared. ``killer``: who began the Kill that is being sent.
    """

    kill_state: KillState = "none"
    is_killed: bool = False
    is_setting: bool = False
    """Failsafes are being set."""
    fence_problem: str = ""
    fall: Fall | None = None
    killer: ClientId = ""


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


def _checks(situation: Situation) -> Refusal | None:
    failed = next((item for item in situation.checks if not item.passed), None)
    if failed is None:
        return None
    return Refusal(joined(named(failed.name, failed.value), sentence(failed.remedy)))


def _ground(situation: Situation) -> Refusal | None:
    """Refuse Disarm off the ground. While the motors are off yet, in Arm, it only stops the arming."""
    facts = situation.facts
    if facts.is_on_ground or (not facts.vehicle.armed and situation.state.on_ground):
        return None
    return Refusal(facts.ground.doubt or say("In the air: wait until it is on the ground."))


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


def _holdable(situation: Situation) -> Refusal | None:
    """Refuse to take a drone from the pilot that Hover could not hold, and would land."""
    place = situation.facts.witness.place
    if not place.is_doubted or place.is_followed:
        return None
    return Refusal(joined(place.words, say("It could not be held: land it, or fly by hand.")))


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


def _switch_rests(situation: Situation) -> Refusal | None:
    left = RESUME_WAIT_S - (situation.facts.now - situation.facts.link.mode_changed_at)
    return Refusal(say("The mode changed just now: wait {left}.", left=seconds(left))) if left > 0 else None


def _holds(is_met: Callable[[Situation], bool], reason: str) -> Callable[[Situation], Refusal | None]:
    """Return the function of a need that is met, or refused for always the same reason."""
    refused = Refusal(reason)
    return lambda now: None if is_met(now) else refused


def _unless(reason: Callable[[Situation], str]) -> Callable[[Situation], Refusal | None]:
    """Return the function of a need that is met while there is no reason against it."""
    return lambda now: Refusal(words) if (words := reason(now)) else None


_NEEDS: Final[Mapping[Need, Callable[[Situation], Refusal | None]]] = {
    # -- link, motors, ground and air
    Need.LINK: _holds(lambda now: now.facts.link.is_up, say("No link to the autopilot: wait until it is found.")),
    Need.NO_FALL: _holds(
        lambda now: now.interlocks.fall is None,
        say("The motors went off in the air: look at the drone, then clear it."),
    ),
    Need.NOT_CUT: _holds(lambda now: not now.interlocks.is_killed, say("The motors were cut: clear it first.")),
    Need.CUT: _holds(lambda now: now.interlocks.is_killed, say("The motors were not cut.")),
    Need.CHECKS: _checks,
    Need.ARMED: _holds(lambda now: now.state.may_take_off, say("Arming: wait until it is armed.")),
    Need.DISARMED: _holds(lambda now: not now.facts.vehicle.armed, DISARM_FIRST),
    # "on the ground" is up to a second old while it takes off
    Need.AIR: _holds(lambda now: now.state.identity is StateName.TAKEOFF or not now.facts.is_on_ground, ON_GROUND),
    Need.GROUND: _ground,
    # -- before any task, whichever station armed
    Need.KEPT: _unless(lambda now: now.facts.kept.lost_words),
    Need.HOME: _home,
    Need.FAILSAFES: _failsafes,
    # Hover brings our fence to the autopilot, and what was right back into it, before any task
    Need.OTHER_FAILSAFES: lambda now: _failsafes(now, but=now.facts.kept.known),
    Need.FENCE: _unless(lambda now: now.interlocks.fence_problem),
    # -- the place, and what is seen
    Need.POSITION: _holds(
        lambda now: now.facts.pose is not None and now.facts.limits.fence is not None, POSITION_UNKNOWN.reason
    ),
    Need.NO_DOUBT: _unless(lambda now: now.facts.witness.doubt),
    Need.INSIDE: _holds(lambda now: not now.facts.is_breached, say("Outside the fence: wait until it is back inside.")),
    Need.HOLDABLE: _holdable,
    # one bad picture refuses no task, as it ends none
    Need.PERCEPTION: _unless(lambda now: now.facts.sight.fault if now.facts.sight.fault_s >= FAULT_CONFIRM_S else ""),
    Need.UNSEEN: _unseen,
    Need.LOT: _lot,
    # -- who flies
    Need.NO_CAUSE: _unless(lambda now: now.state.hold_refusal(now.facts)),
    Need.NOT_AUTOPILOTS: _unless(
        lambda now: now.state.hold_refusal(now.facts) if now.state.rank is Rank.AUTOPILOT else ""
    ),
    Need.SWITCH_RESTS: _switch_rests,
    # -- what is set, drawn and stored
    Need.NOT_SETTING: _holds(lambda now: not now.interlocks.is_setting, say("Being set: wait a moment.")),
    Need.DRAWN_FENCE: _holds(
        lambda now: now.facts.limits.plan.source == "drawn" or now.facts.limits.plan_problem != "",
        say("No fence is drawn: the standard one is used."),
    ),
    Need.OUTLINE: _holds(lambda now: now.facts.limits.outline is not None, say("No outline is set.")),
    Need.OFFER: _holds(lambda now: now.facts.lots.offer is not None, NO_SUCH_PLAN),
    Need.MAP: _holds(
        lambda now: not (now.facts.sight.lot_area <= 0.0 and now.facts.sight.counts.total == 0),
        say("The map is empty: the next flight begins it."),
    ),
}
