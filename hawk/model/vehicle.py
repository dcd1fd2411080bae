"""State of the autopilot: its mode, battery, sensors and messages."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum


class CopterMode(IntEnum):
    """ArduCopter's ``custom_mode`` numbers (ArduPilot, ArduCopter/mode.h)."""

    STABILIZE = 0
    ACRO = 1
    ALT_HOLD = 2
    AUTO = 3
    GUIDED = 4
    LOITER = 5
    RTL = 6
    CIRCLE = 7
    LAND = 9
    DRIFT = 11
    SPORT = 13
    FLIP = 14
    AUTOTUNE = 15
    POSHOLD = 16
    BRAKE = 17
    THROW = 18
    AVOID_ADSB = 19
    GUIDED_NOGPS = 20
    SMART_RTL = 21
    FLOWHOLD = 22
    FOLLOW = 23
    ZIGZAG = 24
    SYSTEMID = 25
    AUTOROTATE = 26
    AUTO_RTL = 27


def mode_name(custom_mode: int | None) -> str | None:
    """Return ArduPilot's own name of a mode ("GUIDED"); "MODE(n)" for one that is not known; None for None."""
    if custom_mode is None:
        return None
    try:
        return CopterMode(custom_mode).name
    except ValueError:
        return f"MODE({custom_mode})"


LANDED_TIMEOUT_S = 2.0
"""An older EXTENDED_SYS_STATE (5 Hz) says nothing about the ground, seconds."""


class LandedState(IntEnum):
    """MAV_LANDED_STATE."""

    UNDEFINED = 0
    ON_GROUND = 1
    IN_AIR = 2
    TAKING_OFF = 3
    LANDING = 4


@dataclass(frozen=True, slots=True)
class VehicleState:
    """Autopilot state (mavros_msgs/State of the specification).

    ``armed`` and ``custom_mode`` came with the last HEARTBEAT, at ``time``; ``landed`` with the last
    EXTENDED_SYS_STATE, at ``landed_time``; a boot makes it UNDEFINED.
    """

    connected: bool = False
    armed: bool = False
    custom_mode: int | None = None
    landed: LandedState = LandedState.UNDEFINED
    time: float = -math.inf
    landed_time: float = -math.inf

    def landed_at(self, now: float) -> LandedState:
        """Return the landed state; UNDEFINED when it is older than LANDED_TIMEOUT_S."""
        return self.landed if now - self.landed_time <= LANDED_TIMEOUT_S else LandedState.UNDEFINED

    @property
    def mode(self) -> str | None:
        """ArduPilot's own name of the mode."""
        return mode_name(self.custom_mode)


@dataclass(frozen=True, slots=True)
class BatteryInfo:
    """Battery: percentage 0-100, volts, amperes; None where the autopilot does not know."""

    percentage: float | None = None
    voltage: float | None = None
    current: float | None = None
    time: float = -math.inf


@dataclass(frozen=True, slots=True)
class GnssHeight:
    """Altitude by GNSS beside the reported one of that moment, metres above sea level, at ``time`` (seconds).

    ``accuracy`` is the receiver's own, metres; None where it gives none.
    """

    time: float
    altitude: float
    accuracy: float | None
    reported: float


@dataclass(frozen=True, slots=True)
class Diagnostics:
    """Summary of the autopilot's sensors, as it reports them."""

    all_ok: bool = False
    armable: bool = False
    global_position_ok: bool = False
    home_position_ok: bool = False
    gps_fix: int | None = None
    satellites: int | None = None
    horizontal_accuracy: float | None = None
    time: float = -math.inf
    estimator_fault: str = ""
    """Why the position estimator is not to be trusted; empty when it is. Then ``global_position_ok`` is False too."""
    fence_on: bool | None = None
    """The autopilot says that a fence is enabled, whatever enabled it; None while it was not heard."""
    compass_ok: bool | None = None
    """The autopilot has a compass that works; None where it has none in use, and while it was not heard."""
    is_mavlink_1: bool = False
    """The link speaks MAVLink 1, which has no accuracy."""


@dataclass(frozen=True, slots=True)
class ForeignWrite:
    """Another station wrote to the autopilot: its MAVLink ids, and what it wrote (a parameter's name, "fence" ...)."""

    time: float
    system: int
    component: int
    subject: str


@dataclass(frozen=True, slots=True)
class StatusText:
    """A message of the autopilot in its own words. ``severity`` is MAV_SEVERITY, 0 (emergency) to 7 (debug)."""

    time: float
    severity: int
    text: str
