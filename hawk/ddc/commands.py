"""Which command is taken in which state, and by whom: one table, and what else must be true."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from hawk.comm.fence_messages import SetFence
from hawk.comm.messages import (
    AutonomousMove,
    Command,
    CommandOption,
    CompulsiveMove,
    Configure,
    Land,
    Resume,
    ReturnToLaunch,
)
from hawk.comm.status import ClientId, OperatorDesk
from hawk.ddc.fence_desk import fence_refusal
from hawk.ddc.geofence import contains, way_is_inside
from hawk.ddc.mapping import is_on_ground
from hawk.ddc.params import ParameterError, check_heights
from hawk.ddc.states.arm import Arm as ArmState
from hawk.ddc.states.homing import Homing
from hawk.ddc.words import seconds, sentence
from hawk.model import HeightParameters, MapPoint, Route, StateName, UserError

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

RESUME_WAIT_S = 3.0
"""Resume is refused so soon after a mode change: the pilot's hand is still at the switch."""

_COLUMNS = (
    StateName.IDLE,
    StateName.CONFIGURE,
    StateName.ARM,
    StateName.TAKEOFF,
    StateName.HOVER,
    StateName.AUTONOMOUS_EXPLORE,
    StateName.AUTONOMOUS_MOVE,
    StateName.COMPULSIVE_MOVE,
    StateName.RETURN_TO_LAUNCH,
    StateName.LAND,
    StateName.COMMUNICATION_LOST,
    StateName.MANUAL,
)

_TABLE = """
Command            | Idle   Configure Arm    Takeoff Hover Explore A.Move C.Move RTL    Land   Lost Manual
Configure          | yes    saving    disarm land    land  land    land   land   land   land   land pilot
Arm                | yes    saving    armed  flying  flying flying flying flying flying flying flying pilot
Takeoff            | arm    saving    yes    flying  flying flying flying flying flying flying flying pilot
Autonomous Explore | off    off       off    climbs  yes   running moving moving homing landing lost pilot
Autonomous Move    | off    off       off    climbs  yes   yes     yes    yes    homing landing lost pilot
Compulsive Move    | off    off       off    climbs  yes   yes     yes    yes    homing landing lost pilot
Hold               | ground ground    ground yes     yes   yes     yes    yes    yes    yes    holds pilot
Return To Launch   | home   home      home   yes     yes   yes     yes    yes    homing! landing yes yes
Land               | ground ground    ground yes     yes   yes     yes    yes    yes    landing! yes yes
Disarm             | off!   off!      yes    air     air   air     air    air    air    yes    air  pilot
Resume             | ours   ours      ours   ours    ours  ours    ours   ours   ours   ours   ours yes
Kill Request       | yes    yes       yes    yes     yes   yes     yes    yes    yes    yes    yes  yes
Kill               | yes    yes       yes    yes     yes   yes     yes    yes    yes    yes    yes  yes
Clear Kill         | yes    saving    disarm air     air   air     air    air    air    air    air  pilot
Set Failsafes      | yes    saving    before before  before before before before before before before pilot
Set Fence          | yes    saving    disarm land    land  land    land   land   land   land   land pilot
Clear Fence        | yes    saving    disarm land    land  land    land   land   land   land   land pilot
"""
"""A word is a reason of `_REASONS`; "yes": taken, if `Judge` finds nothing else against it."""

_REASONS: Mapping[str, str] = {
    "saving": "Saving: wait a moment.",
    "disarm": "Armed: disarm first.",
    "land": "Flying: land first.",
    "flying": "Already flying.",
    "armed": "Already armed, or arming.",
    "arm": "Arm first.",
    "off": "Take off first.",
    "climbs": "Climbing: wait until it holds.",
    "running": "Already exploring.",
    "moving": "Moving: Hold first.",
    "homing": "Returning home: Hold first.",
    "landing": "Landing: Hold first.",
    "homing!": "Already returning home.",
    "landing!": "Already landing.",
    "lost": "The operator was lost: wait until it holds for you.",
    "holds": "Holding already, until the operator is back.",
    "pilot": "Someone else flies: Resume first.",
    "ground": "On the ground.",
    "home": "Is at home.",
    "air": "In the air: land first.",
    "off!": "The motors are off.",
    "ours": "Nobody else flies.",
    "before": "Only before flight, disarmed.",
}


def _read_table() -> dict[str, dict[StateName, str]]:
    rows: dict[str, dict[StateName, str]] = {}
    for line in _TABLE.strip().splitlines()[1:]:
        name, _, cells = line.partition("|")
        rows[name.strip()] = dict(zip(_COLUMNS, cells.split(), strict=True))
    return rows


TABLE: Mapping[str, Mapping[StateName, str]] = _read_table()
"""Type of a command -> state -> "yes" or the word of a reason."""

NEEDS_LINK = frozenset(TABLE) - {"Configure", "Kill Request", "Kill", "Clear Kill"}
"""Commands that need the autopilot to hear."""


def table_reason(command: str, state: StateName) -> str:
    """Return why the table refuses a command (by its type) in a state; empty when it takes it."""
    word = TABLE[command][state]
    return "" if word == "yes" else _REASONS[word]


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why a command is not taken; ``error`` is the User Error that it causes."""

    reason: str
    error: UserError = UserError.NONE


_OUT_OF_BOUNDS = UserError.DESIRED_LOCATION_OUT_OF_BOUNDS
_POSITION_UNKNOWN = Refusal("The position is not known well enough: wait for it.")


class Judge:
    """Decides on commands. It changes nothing."""

    def __init__(self, context: OperationsManager, desk: OperatorDesk) -> None:
        self._context = context
        self._desk = desk
        self._conditions: Mapping[str, Callable[[], Refusal | None]] = {
            "Arm": self._arm,
            "Takeoff": self._takeoff,
            "Autonomous Explore": self._explore,
            "Autonomous Move": self._autonomous_move,
            "Compulsive Move": self._position,
            "Hold": self._hold,
            "Return To Launch": self._in_the_air,
            "Land": self._land,
            "Disarm": self._disarm,
            "Resume": self._resume,
            "Clear Kill": self._clear_kill,
            "Set Failsafes": self._set_failsafes,
            "Clear Fence": self._clear_fence,
        }

    def options(self) -> tuple[CommandOption, ...]:
        """Return for every command whether it would be taken now from the one in control, and why not."""
        found = []
        for command in TABLE:
            refusal = self._possible(command)
            reason = "" if refusal is None else refusal.reason
            found.append(CommandOption(command=command, possible=refusal is None, reason=reason))
        return tuple(found)

    def refusal(self, client: ClientId, command: Command) -> Refusal | None:
        """Return why a command of this client is refused, None when it is taken."""
        kind = command_type(command)
        authority = self._authority(client, kind)
        if authority:
            return Refusal(authority)
        return self._possible(kind) or self._content(command)

    def place_refusal(self, place: MapPoint) -> Refusal | None:
        """Return why the drone may not be at this place of the map."""
        fence = self._context.fence
        if self._context.topics.get_fresh_pose() is None or fence is None:
            return _POSITION_UNKNOWN
        if not contains(fence, place):
            return Refusal("X, Y: the place is outside the fence: choose one inside.", _OUT_OF_BOUNDS)
        return None

    def move_refusal(self, place: MapPoint) -> Refusal | None:
        """Return why the drone may not go straight to this place of the map."""
        refusal = self.place_refusal(place)
        if refusal is None and not self._is_way_inside(place):
            reason = "X, Y: the straight way there leaves the fence: go around it in two moves."
            return Refusal(reason, _OUT_OF_BOUNDS)
        return refusal

    def route_refusal(self, route: Route) -> Refusal | None:
        """Return why the drone may not fly this route: every leg of it, and the way to it, must be inside the fence."""
        fence = self._context.fence
        if fence is None:
            return _POSITION_UNKNOWN
        legs_inside = all(way_is_inside(fence, a, b) for a, b in pairwise(route.points))
        if len(route.points) < 2 or not legs_inside or not self._is_way_inside(route.points[1]):
            return Refusal("X, Y: the way there leaves the fence: choose another place.", _OUT_OF_BOUNDS)
        return None

    def _is_way_inside(self, place: MapPoint) -> bool:
        pose, fence = self._context.topics.get_fresh_pose(), self._context.fence
        return (
            pose is not None
            and pose.map is not None
            and fence is not None
            and way_is_inside(fence, pose.map.point, place)
        )

    def _possible(self, kind: str) -> Refusal | None:
        context = self._context
        if context.kill.is_sending and kind not in ("Kill", "Kill Request"):
            return Refusal("The motors are being cut.")
        reason = table_reason(kind, context.state.identity)
        if reason:
            return Refusal(reason)
        if kind in NEEDS_LINK and not context.has_link:
            return Refusal("No link to the autopilot: wait until it is found.")
        condition = self._conditions.get(kind)
        return None if condition is None else condition()

    def _authority(self, client: ClientId, kind: str) -> str:
        if self._desk.has_control(client):
            return ""
        free = self._desk.controller() is None
        if kind == "Hold":
            anyone = not isinstance(self._context.state, Homing)
            return "" if anyone else _who(free)
        if kind in ("Return To Launch", "Land") and free:
            return ""
        return _who(free)

    def _content(self, command: Command) -> Refusal | None:
        if isinstance(command, Configure):
            return self._heights(command)
        if isinstance(command, SetFence):
            reason = fence_refusal(self._context, command)
            return Refusal(reason) if reason else None
        if isinstance(command, AutonomousMove | CompulsiveMove):
            place = self._context.commands.place_of(command)
            if place is None:
                return Refusal("The position is not known well enough.")
            reachable = self.place_refusal if isinstance(command, AutonomousMove) else self.move_refusal
            return self._travel_height(command) or reachable(place)
        confirmed = not isinstance(command, Resume | ReturnToLaunch | Land) or command.confirmed
        if self._context.state.identity is StateName.MANUAL and not confirmed:
            return Refusal("Confirmed: someone else flies; send it confirmed.")
        return None

    def _travel_height(self, command: Command) -> Refusal | None:
        height, heights = getattr(command, "height", None), self._context.heights
        if height is None or heights.minimum <= height <= heights.maximum:
            return None
        return Refusal(f"Height: must lie between Min {heights.minimum:g} m and Max {heights.maximum:g} m.")

    def _heights(self, command: Configure) -> Refusal | None:
        try:
            check_heights(HeightParameters(command.min, command.des, command.max), self._context.ceiling)
        except ParameterError as error:
            return Refusal(str(error))
        return None

    def _arm(self) -> Refusal | None:
        if self._context.kill.is_killed:
            return Refusal("The motors were cut: clear it first.")
        failed = self._context.preflight.first_failed()
        if failed is None:
            return None
        return Refusal(" ".join(filter(None, (f"{failed.name}: {sentence(failed.value)}", sentence(failed.remedy)))))

    def _takeoff(self) -> Refusal | None:
        state = self._context.state
        if isinstance(state, ArmState) and state.is_armed:
            return None
        return Refusal("Arming: wait until it is armed.")

    def _explore(self) -> Refusal | None:
        refusal = self._position() or self._seeing()
        if refusal is None and not self._context.topics.get_park_lot_detected():
            return Refusal("No lot in sight: move over the lot, or climb.", UserError.NO_LOT_DETECTED)
        return refusal

    def _autonomous_move(self) -> Refusal | None:
        return self._position() or self._seeing()

    def _seeing(self) -> Refusal | None:
        fault = self._context.perception_fault()
        return Refusal(fault) if fault else None

    def _position(self) -> Refusal | None:
        if self._context.topics.get_fresh_pose() is None or self._context.fence is None:
            return Refusal("The position is not known well enough: wait for it.")
        return Refusal("Outside the fence: wait until it is back inside.") if self._context.guard.is_breached else None

    def _hold(self) -> Refusal | None:
        state = self._context.state
        reason = state.hold_refusal() if isinstance(state, Homing) else ""
        return Refusal(reason) if reason else self._in_the_air()

    def _land(self) -> Refusal | None:
        state = self._context.state
        if isinstance(state, Homing) and state.taken_up:
            return Refusal(state.hold_refusal())
        return self._in_the_air()

    def _in_the_air(self) -> Refusal | None:
        if self._context.state.identity is StateName.TAKEOFF:
            return None  # "on the ground" is up to a second old while it takes off
        return Refusal("On the ground.") if is_on_ground(self._context.topics.get_state().landed) else None

    def _disarm(self) -> Refusal | None:
        if self._context.state.identity is not StateName.LAND or self._in_the_air() is not None:
            return None
        return Refusal("In the air: wait until it is on the ground.")

    def _resume(self) -> Refusal | None:
        left = RESUME_WAIT_S - (self._context.now - self._context.mode_changed_at)
        if left > 0:
            return Refusal(f"The mode changed just now: wait {seconds(left)}.")
        return self._in_the_air()

    def _clear_kill(self) -> Refusal | None:
        return None if self._context.kill.is_killed else Refusal("The motors were not cut.")

    def _set_failsafes(self) -> Refusal | None:
        return Refusal("Being set: wait a moment.") if self._context.preflight.is_setting else None

    def _clear_fence(self) -> Refusal | None:
        return None if self._context.fences.is_drawn else Refusal("No fence is drawn: the standard one counts.")


def command_type(command: Command) -> str:
    """Return a command's Type."""
    return str(getattr(command, "type", type(command).__name__))


def _who(free: bool) -> str:
    return "Take control first." if free else "Someone else has control."
