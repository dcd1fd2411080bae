"""Values that pass between judge, guard and states: ranks, causes, orders and transitions."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum, StrEnum

from hawk.comm.protocol.commands import Command, Hold, Land, ReturnToLaunch
from hawk.ddc.facts import Facts
from hawk.ddc.fence.plan import FencePlan
from hawk.ddc.motion import Goal
from hawk.model.operation import Level
from hawk.model.plans import HeightParameters, Route
from hawk.model.poses import MapPoint


class Rank(IntEnum):
    """The one order of rank: an automatic reaction never moves down in it."""

    TASK = 0
    """The operator's task."""
    PERCEPTION = 1
    """A failure of vision, mapper, planner, camera or position."""
    FENCE = 2
    """Fence and ceiling."""
    COMMUNICATION_LOST = 3
    RETURN_TO_LAUNCH = 4
    LAND = 5
    AUTOPILOT = 6
    """The autopilot's own failsafe."""
    PILOT = 7
    """Someone else flies."""
    KILL = 8


class CauseKind(StrEnum):
    """Condition under which a cause lasts."""

    RESERVE = "battery reserve"
    BATTERY_UNKNOWN = "battery unknown"
    VOLTAGE = "voltage"
    FENCE = "outside the fence"
    WIND = "wind"
    KEPT = "not kept"
    """Something that we set in the autopilot cannot be put back."""
    OPERATOR = "operator lost"
    ALWAYS = "always"
    """The autopilot's own decision, and the end of the program."""
    NEVER = "never"
    """Something that happened once."""


@dataclass(frozen=True, slots=True)
class Cause:
    """Reason why the drone returns or lands by itself. While it lasts, Hold is refused with it."""

    text: str
    kind: CauseKind
    details: str = ""

    def lasts(self, facts: Facts) -> bool:
        """Return True while the condition holds."""
        match self.kind:
            case CauseKind.RESERVE:
                return facts.battery.reserve is not None and facts.battery.reserve.is_reached
            case CauseKind.BATTERY_UNKNOWN:
                return facts.battery.info is None
            case CauseKind.VOLTAGE:
                return facts.battery.charge.is_low
            case CauseKind.FENCE:
                return facts.is_breached
            case CauseKind.WIND:
                return facts.wind.strong_s is not None
            case CauseKind.KEPT:
                return bool(facts.kept.lost)
            case CauseKind.OPERATOR:
                return not facts.operator.is_present
        return self.kind is CauseKind.ALWAYS


@dataclass(frozen=True, slots=True)
class MoveOrder:
    """An accepted Move: place (map frame), height (m above the arm place), yaw (rad).

    ``number`` is that of its desired pose and ``route`` the planner's path there, for an autonomous one.
    """

    place: MapPoint
    height: float
    yaw: float
    autonomous: bool
    number: int
    route: Route = field(default_factory=Route)

    @property
    def goal(self) -> Goal:
        """The place as a goal."""
        return Goal(self.place.north, self.place.east, self.height, self.yaw)


@dataclass(frozen=True, slots=True)
class ConfigureOrder:
    """Accepted travel heights."""

    heights: HeightParameters


@dataclass(frozen=True, slots=True)
class FenceOrder:
    """An accepted fence; None drops the drawn one."""

    plan: FencePlan | None


@dataclass(frozen=True, slots=True)
class ArmOrder:
    """An accepted Arm: ``checks`` is the number of preflight checks that passed."""

    checks: int
    by: str = ""
    """Name of the one who asked; empty when it is not known."""


@dataclass(frozen=True, slots=True)
class SafetyOrder:
    """An accepted Hold, Return To Launch or Land, and the name of the one who asked; empty when it is not known."""

    command: Hold | Land | ReturnToLaunch
    by: str = ""


Order = Command | ArmOrder | SafetyOrder | MoveOrder | ConfigureOrder | FenceOrder


@dataclass(frozen=True, slots=True)
class ToIdle:
    """Disarmed, on the ground. ``gave_up_arming``: an "armed" that comes late is answered by a disarm."""

    reason: str = ""
    gave_up_arming: bool = False


@dataclass(frozen=True, slots=True)
class ToConfigure:
    """Store the heights, or the fence, of an order."""

    order: ConfigureOrder | FenceOrder


@dataclass(frozen=True, slots=True)
class ToArm:
    """Arm; with ``armed`` wait for take-off with a drone that is armed already."""

    armed: bool = False
    reason: str = ""
    checks: int = 0
    """Preflight checks that passed."""
    by: str = ""
    """Name of the one who asked; empty when nobody did."""


@dataclass(frozen=True, slots=True)
class ToTakeoff:
    """Climb to the desired height."""


@dataclass(frozen=True, slots=True)
class ToHover:
    """Hold a goal, else the stopping point. ``passive``: the autopilot holds already and nothing is sent."""

    reason: str = ""
    goal: Goal | None = None
    passive: bool = False
    level: Level = "info"
    by: str = ""
    """Name of the one who asked; empty when nobody did."""


@dataclass(frozen=True, slots=True)
class ToExplore:
    """See the whole lot."""


@dataclass(frozen=True, slots=True)
class ToMove:
    """Go to a place."""

    order: MoveOrder


@dataclass(frozen=True, slots=True)
class ToReturn:
    """Fly home. ``by_autopilot``: the autopilot began it by itself and nothing is sent.

    ``straight``: why no path inside the fence is flown, even where the straight line leaves it; empty: it may be.
    """

    cause: Cause | None = None
    by_autopilot: bool = False
    straight: str = ""
    by: str = ""
    """Name of the one who asked; empty when nobody did."""


@dataclass(frozen=True, slots=True)
class ToLand:
    """Descend here. ``by_autopilot`` and ``by`` as for `ToReturn`."""

    cause: Cause | None = None
    by_autopilot: bool = False
    by: str = ""


@dataclass(frozen=True, slots=True)
class ToCommunicationLost:
    """Hold, then return home. ``passive`` as for `ToHover`.

    ``given_back_by``: name of the one who gave control back; empty when the operator was lost. ``is_hidden``: the
    operator's page was hidden for too long.
    """

    passive: bool = False
    given_back_by: str = ""
    is_hidden: bool = False


@dataclass(frozen=True, slots=True)
class ToManual:
    """Someone else flies."""


Transition = (
    ToIdle
    | ToConfigure
    | ToArm
    | ToTakeoff
    | ToHover
    | ToExplore
    | ToMove
    | ToReturn
    | ToLand
    | ToCommunicationLost
    | ToManual
)
