"""ArduCopter's flight modes: the set-point of each, and what is allowed in it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import ClassVar

from hawk.sim.autopilot.control import CENTI, Limits, Setpoint
from hawk.sim.autopilot.gps import Estimate
from hawk.sim.autopilot.parameters import Parameters
from hawk.sim.autopilot.rally import RallyPlace
from hawk.sim.geometry import Flat, Vector

SINK_M_S = 2.4
"""LOITER, POSHOLD and ALT_HOLD with the throttle stick low, as measured."""
BRAKE_DECELERATION = 7.5
"""BRAKE_MODE_DECEL_RATE, m/s²."""
BRAKE_STOPPED_M_S = 0.1
"""BRAKE holds its place from this speed on."""
HOME_RADIUS_M = 2.0
"""WPNAV_RADIUS: home is reached within it."""
SPOOL_UP_S = 1.0
"""Motors come up to speed before they lift."""
YAW_LOOK_M = 2.0
"""The nose turns to a target without a yaw that is farther than this (WP_YAW_BEHAVIOR 2)."""


class ModeNumber(IntEnum):
    """``custom_mode`` of the modes that are flown here (ArduCopter/mode.h)."""

    STABILIZE = 0
    ALT_HOLD = 2
    GUIDED = 4
    LOITER = 5
    RTL = 6
    LAND = 9
    POSHOLD = 16
    BRAKE = 17
    SMART_RTL = 21


class Phase(Enum):
    """Phase of a flight in EXTENDED_SYS_STATE."""

    FLYING = "flying"
    TAKING_OFF = "taking off"
    LANDING = "landing"


@dataclass(frozen=True, slots=True)
class ModeInputs:
    """Inputs of a mode. ``home`` is NED metres in the world, ``ceiling`` the fence's height above home or None;
    ``stick`` the pilot's throttle, 0..1, None without a radio; ``rally`` where RTL goes in place of home, or None.
    """

    time: float
    estimate: Estimate
    parameters: Parameters
    limits: Limits
    home: Vector
    landed: bool
    position_ok: bool
    stick: float | None
    ceiling: float | None
    rally: RallyPlace | None = None

    @property
    def flat(self) -> Flat:
        """The estimated place, north and east."""
        return self.estimate.position[0], self.estimate.position[1]

    @property
    def height(self) -> float:
        """Metres above home."""
        return self.home[2] - self.estimate.position[2]

    def stopping_point(self) -> Flat:
        """Return the place where the vehicle stands when it brakes now."""
        north, east = self.estimate.velocity[:2]
        speed = math.hypot(north, east)
        ahead = speed / (2.0 * self.limits.acceleration) + 0.3
        return self.estimate.position[0] + north * ahead, self.estimate.position[1] + east * ahead

    def stopping_down(self) -> float:
        """Return the height (down, metres) at which it stops."""
        speed = self.estimate.velocity[2]
        return self.estimate.position[2] + math.copysign(speed * speed / (2.0 * self.limits.acceleration_z), speed)


class Mode:
    """A flight mode. One object for each time that the mode is entered."""

    number: ClassVar[ModeNumber]
    needs_position: ClassVar[bool] = True
    arms: ClassVar[bool] = False
    pilot_flies: ClassVar[bool] = False
    disarms_when_landed: ClassVar[bool] = False

    def __init__(self, view: ModeInputs) -> None:
        self._place = view.stopping_point()
        self._down = view.stopping_down()

    def run(self, view: ModeInputs) -> Setpoint:
        """Return the mode's set-point."""
        raise NotImplementedError

    def reset_position(self, shift: Vector) -> None:
        """Move the place that the mode chose itself with a reset of the estimate (NED, metres)."""
        self._place = self._place[0] + shift[0], self._place[1] + shift[1]
        self._down += shift[2]

    @property
    def phase(self) -> Phase:
        """Phase of the flight in this mode."""
        return Phase.FLYING

    @property
    def name(self) -> str:
        """ArduPilot's name."""
        return self.number.name


class Stabilize(Mode):
    """Flown by the pilot: without throttle the motors idle."""

    number = ModeNumber.STABILIZE
    needs_position = False
    arms = True
    pilot_flies = True

    def run(self, view: ModeInputs) -> Setpoint:
        """Lift by the throttle stick alone; level."""
        stick = view.stick or 0.0
        return Setpoint(climb=(stick - 0.5) * 2.0 * view.limits.speed_up, idle=stick < 0.05)


class AltHold(Mode):
    """Holds height by the throttle stick; drifts with the wind."""

    number = ModeNumber.ALT_HOLD
    needs_position = False
    arms = True
    pilot_flies = True

    def run(self, view: ModeInputs) -> Setpoint:
        """Climb or sink by the stick."""
        return Setpoint(climb=_stick_climb(view), speed_down=SINK_M_S, idle=_rests(view))


class Loiter(Mode):
    """Holds its place; the height follows the throttle stick, which sinks when it is low or absent."""

    number = ModeNumber.LOITER
    arms = True
    pilot_flies = True

    def run(self, view: ModeInputs) -> Setpoint:
        """Stay above the place, climb or sink by the stick."""
        return Setpoint(self._place, climb=_stick_climb(view), speed_down=SINK_M_S, idle=_rests(view))


class PosHold(Loiter):
    """LOITER with another response to the sticks."""

    number = ModeNumber.POSHOLD


class Brake(Mode):
    """Stops at once and stays."""

    number = ModeNumber.BRAKE

    def __init__(self, view: ModeInputs) -> None:
        super().__init__(view)
        self._stopped_at: Flat | None = None

    def reset_position(self, shift: Vector) -> None:
        """Stay above the same ground."""
        super().reset_position(shift)
        if self._stopped_at is not None:
            self._stopped_at = self._stopped_at[0] + shift[0], self._stopped_at[1] + shift[1]

    def run(self, view: ModeInputs) -> Setpoint:
        """Brake, then hold the place where it stood still, and the height."""
        if self._stopped_at is None and math.hypot(*view.estimate.velocity[:2]) < BRAKE_STOPPED_M_S:
            self._stopped_at = view.flat
        if self._stopped_at is None:
            return Setpoint(velocity=(0.0, 0.0), down=self._down, acceleration=BRAKE_DECELERATION, idle=view.landed)
        return Setpoint(self._stopped_at, down=self._down, idle=view.landed)


class Land(Mode):
    """Descends in place, and disarms."""

    number = ModeNumber.LAND
    needs_position = False
    disarms_when_landed = True

    def run(self, view: ModeInputs) -> Setpoint:
        """Sink; hold the place while there is a position."""
        return descend(view, self._place if view.position_ok else None)

    @property
    def phase(self) -> Phase:
        """Always landing."""
        return Phase.LANDING


class Rtl(Mode):
    """Climbs to the return height, flies home, waits, lands and disarms."""

    number = ModeNumber.RTL
    disarms_when_landed = True

    class _Leg(Enum):
        CLIMB = 0
        RETURN = 1
        WAIT = 2
        DESCEND = 3

    def __init__(self, view: ModeInputs) -> None:
        super().__init__(view)
        self._leg = self._Leg.CLIMB
        self._height = _return_height(view)
        self._home = view.home if view.rally is None else (*view.rally.place, view.home[2])
        """Home, or the rally point, when RTL began: ArduCopter plans the return once, and what is moved later changes
        nothing."""
        self._since = view.time

    def run(self, view: ModeInputs) -> Setpoint:
        """Do the present leg and go on to the next when it is done."""
        home = self._home[:2]
        down = self._home[2] - self._height
        if view.landed:
            return descend(view, home)
        self._advance(view)
        if self._leg is self._Leg.DESCEND:
            return descend(view, home)
        place = self._place if self._leg is self._Leg.CLIMB else home
        speed = view.parameters["RTL_SPEED"] * CENTI or None
        return Setpoint(place, down=down, speed=speed)

    def _advance(self, view: ModeInputs) -> None:
        away = math.dist(view.flat, self._home[:2])
        height = self._home[2] - view.estimate.position[2]
        if self._leg is self._Leg.CLIMB and height >= self._height - 0.3:
            self._leg = self._Leg.RETURN
        elif self._leg is self._Leg.RETURN and away < HOME_RADIUS_M:
            self._leg, self._since = self._Leg.WAIT, view.time
        elif self._leg is self._Leg.WAIT and view.time - self._since >= view.parameters["RTL_LOIT_TIME"] / 1000.0:
            self._leg = self._Leg.DESCEND

    @property
    def phase(self) -> Phase:
        """Landing in the last leg."""
        return Phase.LANDING if self._leg is self._Leg.DESCEND else Phase.FLYING


class SmartRtl(Rtl):
    """Returns home along RTL's path: a companion does not need the retraced one."""

    number = ModeNumber.SMART_RTL


def descend(view: ModeInputs, place: Flat | None) -> Setpoint:
    """Return the last leg: WPNAV_SPEED_DN (or LAND_SPEED_HIGH) down to LAND_ALT_LOW, then LAND_SPEED."""
    fast = view.parameters["LAND_SPEED_HIGH"] * CENTI or view.limits.speed_down
    slow = view.parameters["LAND_SPEED"] * CENTI
    speed = fast if view.height > view.parameters["LAND_ALT_LOW"] * CENTI else slow
    return Setpoint(place, climb=-speed, speed_down=speed, idle=view.landed)


def _return_height(view: ModeInputs) -> float:
    """ArduCopter's RTL path: RTL_ALT, lower inside the cone, never lower than here, below the fence's ceiling."""
    goal, lowest = (view.home[:2], 0.0) if view.rally is None else (view.rally.place, view.rally.height)
    wanted = max(view.height, lowest, view.parameters["RTL_ALT"] * CENTI)
    slope = view.parameters["RTL_CONE_SLOPE"]
    if slope > 0.0:
        away = math.dist(view.flat, goal)
        wanted = max(min(wanted, max(away * slope, 2.0)), view.height)
    wanted = max(wanted, view.height + view.parameters["RTL_CLIMB_MIN"] * CENTI)
    return wanted if view.ceiling is None else max(min(wanted, view.ceiling), 0.0)


def _stick_climb(view: ModeInputs) -> float:
    if view.stick is None or view.stick < 0.05:
        return -SINK_M_S
    return (view.stick - 0.5) * 2.0 * view.parameters["PILOT_SPEED_UP"] * CENTI


def _rests(view: ModeInputs) -> bool:
    return view.landed and (view.stick or 0.0) <= 0.5


class Guided(Mode):
    """Flies to targets of the companion computer and holds its place between them."""

    number = ModeNumber.GUIDED
    arms = True

    def __init__(self, view: ModeInputs) -> None:
        super().__init__(view)
        self._yaw: float | None = None
        self._velocity: Vector | None = None
        self._velocity_time = 0.0
        self._climbing_to: float | None = None
        self._is_sent = False
        self._lift_time = 0.0
        self.speed: float | None = None

    def take_off(self, view: ModeInputs, down: float) -> None:
        """Climb straight up to a height (down, metres in the world)."""
        self._is_sent = False
        self._velocity = None
        self._climbing_to = down
        self._lift_time = view.time + SPOOL_UP_S
        self._place, self._down = view.flat, down

    def reset_position(self, shift: Vector) -> None:
        """Stay above the same ground, but fly on to a target that was sent: it is absolute."""
        if not self._is_sent:
            super().reset_position(shift)
        if self._climbing_to is not None:
            self._climbing_to += shift[2]

    def go(self, place: Flat, down: float, yaw: float | None, view: ModeInputs) -> None:
        """Fly to a place. Without a yaw the nose points ahead."""
        self._is_sent = True
        self._velocity = None
        self._climbing_to = None
        if yaw is None and math.dist(place, view.flat) > YAW_LOOK_M:
            yaw = math.atan2(place[1] - view.flat[1], place[0] - view.flat[0])
        self._place, self._down, self._yaw = place, down, yaw

    def move(self, velocity: Vector, yaw: float | None, view: ModeInputs) -> None:
        """Fly with a velocity (NED, m/s); it ends GUID_TIMEOUT after the last one."""
        self._velocity, self._velocity_time = velocity, view.time
        self._climbing_to = None
        self._yaw = yaw

    def turn(self, yaw: float) -> None:
        """Turn to a heading."""
        self._yaw = yaw

    @property
    def target(self) -> Vector:
        """Present target (NED metres in the world)."""
        return *self._place, self._down

    def run(self, view: ModeInputs) -> Setpoint:
        """Return the target; on the ground nothing but a take-off lifts."""
        if view.landed and (self._climbing_to is None or view.time < self._lift_time):
            if self._climbing_to is not None:
                return Setpoint(idle=True)
            self._place, self._down = view.flat, view.estimate.position[2]
            return Setpoint(idle=True)
        self._arrive(view)
        if self._velocity is not None:
            north, east, down = self._velocity
            return Setpoint(velocity=(north, east), climb=-down, yaw=self._yaw, speed=self.speed)
        return Setpoint(self._place, down=self._down, yaw=self._yaw, speed=self.speed)

    def _arrive(self, view: ModeInputs) -> None:
        if self._climbing_to is not None and view.estimate.position[2] <= self._climbing_to + 0.2:
            self._climbing_to = None
        if self._velocity is not None and view.time - self._velocity_time > view.parameters["GUID_TIMEOUT"]:
            self._velocity, self._is_sent = None, False
            self._place, self._down = view.stopping_point(), view.stopping_down()

    @property
    def phase(self) -> Phase:
        """Taking off until the height is reached."""
        return Phase.TAKING_OFF if self._climbing_to is not None else Phase.FLYING


MODES: dict[int, type[Mode]] = {
    mode.number: mode for mode in (Stabilize, AltHold, Guided, Loiter, PosHold, Brake, Land, Rtl, SmartRtl)
}
"""Every mode by number."""
