"""Operation: the states, User Error, health, and what a flight and a survey left behind."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum, StrEnum
from typing import Annotated, Final, Literal

from pydantic import AliasChoices, Field

from hawk.model.moment import UNKNOWN_MOMENT, Moment

Level = Literal["info", "ok", "warning", "error"]
"""Level of an entry in the flight log."""


class UserError(IntEnum):
    """User Error of the specification, section 4."""

    NONE = 0
    DESIRED_LOCATION_OUT_OF_BOUNDS = 1
    NO_LOT_DETECTED = 2


class HealthStatus(IntEnum):
    """Health Status of the specification, section 4."""

    HEALTHY = 0
    UNHEALTHY = 1


@dataclass(frozen=True, slots=True)
class Health:
    """Health of one part, with the reason in words when it is unhealthy."""

    status: HealthStatus = HealthStatus.HEALTHY
    reason: str = ""

    @classmethod
    def bad(cls, reason: str) -> Health:
        """Return an unhealthy verdict with its reason."""
        return cls(HealthStatus.UNHEALTHY, reason)

    @property
    def is_healthy(self) -> bool:
        """True when the part works."""
        return self.status is HealthStatus.HEALTHY


class StateName(StrEnum):
    """Identity strings of the operation states, exactly as in the design."""

    IDLE = "Idle"
    CONFIGURE = "Configure"
    ARM = "Arm"
    TAKEOFF = "Takeoff"
    HOVER = "Hover"
    AUTONOMOUS_EXPLORE = "Autonomous Explore"
    AUTONOMOUS_MOVE = "Autonomous Move"
    COMPULSIVE_MOVE = "Compulsive Move"
    RETURN_TO_LAUNCH = "Return To Launch"
    LAND = "Land"
    COMMUNICATION_LOST = "CommunicationLost"
    MANUAL = "Manual"


GROUND_STATES = frozenset({StateName.IDLE, StateName.CONFIGURE, StateName.ARM})
"""States in which the drone is not in the air."""


_DISTANCE_BEFORE_0_3: Final = "way"
"""The key of `FlightSoFar.distance_m` in journals and notes of versions before 0.3."""


@dataclass(frozen=True, slots=True)
class FlightSoFar:
    """A flight in progress: seconds since take-off and metres flown, as of ``moment``.

    ``parameters``: those of the autopilot that were right in this flight; they are put back when somebody changes them.
    """

    seconds: float
    distance_m: Annotated[float, Field(validation_alias=AliasChoices("distance_m", _DISTANCE_BEFORE_0_3))]
    moment: Moment = UNKNOWN_MOMENT
    parameters: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Fall:
    """A flight whose motors went off in the air.

    ``at``: when it was last seen to fly (UTC seconds); ``height``: metres above the arm place then. ``latitude`` and
    ``longitude``: the last place that is known, degrees (WGS-84). None where it is not known.
    """

    at: float
    latitude: float | None = None
    longitude: float | None = None
    height: float | None = None


@dataclass(frozen=True, slots=True)
class FlightDrain:
    """Drain that a flight measured: percent a second, over ``seconds`` in the air, until ``at`` (UTC seconds)."""

    drain: float
    seconds: float
    at: float


@dataclass(frozen=True, slots=True)
class SurveyLeft:
    """Rest of a survey when its last exploration ended.

    ``seen`` is the share (0..1) of ``lot_area`` (square metres) that was seen well; ``remaining_m`` the metres that the
    planner still meant to fly; ``done``: nothing was left to learn; ``flown_s`` the seconds that it explored so far.
    """

    seen: float
    lot_area: float
    remaining_m: float
    done: bool = False
    flown_s: float = 0.0
