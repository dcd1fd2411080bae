"""Errors of GNSS receiver, barometer and compasses that stay through a boot; the rangefinder; the battery.

The estimate follows them as a real ArduCopter's did (EKF3, 4.7): `hawk.sim.autopilot.gps`.
"""

from __future__ import annotations

import math
from typing import Final

from hawk.sim.autopilot.parameters import CELLS, Parameters
from hawk.sim.geometry import Flat, Slope, Vector, wrap_angle
from hawk.sim.vehicle import Body

CAPACITY_MAH: Final = 5000.0
EMPTY_V, FULL_V = 9.9, 12.6
"""Three lithium-polymer cells at rest, as ArduPilot's own simulation."""
RESISTANCE_OHM: Final = 0.012
IDLE_A: Final = 0.6


class Battery:
    """Lasts ``minutes`` in hover from full.

    `charge` (0..1) is true and makes the voltage; `remaining` (0..1) is what the autopilot counts. Setting `remaining`
    sets both, as a battery does whose charge is known.
    """

    def __init__(self, minutes: float, cells: int = CELLS) -> None:
        self.charge = 1.0
        self.cells = cells
        self.current = IDLE_A
        """Amperes, as measured."""
        self.resistance = RESISTANCE_OHM
        """Ohms of the whole battery; a cold or an old one has several times as much."""
        self.rest_v: float | None = None
        """Volts at rest whatever the charge; None: by the charge."""
        self.error_v = 0.0
        """The voltage sensor reads too high by this, volts."""
        self.counts = True
        """False: the counter stands still."""
        self._counted = 1.0
        self._hover_a = CAPACITY_MAH / 1000.0 * 60.0 / minutes

    def step(self, lifting: bool, effort: float, dt: float) -> None:
        """Use charge for ``dt`` seconds. ``effort`` is thrust over weight."""
        self.current = IDLE_A + (self._hover_a * effort**1.5 if lifting else 0.0)
        used = self.current * dt / 3600.0 / (CAPACITY_MAH / 1000.0)
        self.charge = max(0.0, self.charge - used)
        if self.counts:
            self._counted = max(0.0, self._counted - used)

    def restart_counter(self) -> None:
        """Count from full, as ArduPilot does after every boot."""
        self._counted = 1.0

    @property
    def remaining(self) -> float:
        """Charge left by the autopilot's counter, 0..1."""
        return self._counted

    @remaining.setter
    def remaining(self, share: float) -> None:
        self.charge = self._counted = share

    @property
    def voltage(self) -> float:
        """Volts under the present load, as measured."""
        at_rest = self.rest_v
        if at_rest is None:
            at_rest = (EMPTY_V + (FULL_V - EMPTY_V) * self.charge) * (self.cells / CELLS)
        return max(0.0, at_rest - self.resistance * self.current + self.error_v)

    @property
    def used_mah(self) -> float:
        """Charge taken out by the autopilot's counter, milliampere-hours."""
        return (1.0 - self._counted) * CAPACITY_MAH

    @property
    def is_empty(self) -> bool:
        """True when nothing is left: the motors stop."""
        return self.charge <= 0.0


class Receiver:
    """The GNSS receiver is off by `offset`: a constant part, a walk and a glitch (NED, metres)."""

    def __init__(self, bias: Vector = (0.0, 0.0, 0.0)) -> None:
        self._bias = bias
        self._glitch: Vector = (0.0, 0.0, 0.0)
        self._glitch_left_s = math.inf
        self._walked: Flat = (0.0, 0.0)
        self.walk: Flat = (0.0, 0.0)
        """Speed of the walk, north and east, m/s."""

    @property
    def offset(self) -> Vector:
        """Error of the receiver's position, metres."""
        return (
            self._bias[0] + self._walked[0] + self._glitch[0],
            self._bias[1] + self._walked[1] + self._glitch[1],
            self._bias[2] + self._glitch[2],
        )

    def set_bias(self, bias: Vector) -> None:
        """Be off by a constant error; what was walked until now is part of it no more."""
        self._bias, self._walked = bias, (0.0, 0.0)

    def set_glitch(self, glitch: Vector, seconds: float = math.inf) -> None:
        """Be off by a glitch besides, for this time in seconds of the simulation."""
        self._glitch, self._glitch_left_s = glitch, seconds

    def step(self, dt: float) -> None:
        """Let time pass."""
        self._walked = self._walked[0] + self.walk[0] * dt, self._walked[1] + self.walk[1] * dt
        self._glitch_left_s -= dt
        if self._glitch_left_s <= 0.0:
            self.set_glitch((0.0, 0.0, 0.0))


class Barometer:
    """It reads too high by `error` metres, which grows by `drift` (m/s)."""

    def __init__(self) -> None:
        self.error = 0.0
        self.drift = 0.0

    def step(self, dt: float) -> None:
        """Let time pass."""
        self.error += self.drift * dt

    def boot(self) -> None:
        """Take the present pressure as that of the ground, as ArduPilot does."""
        self.error = 0.0


class Compasses:
    """All compasses together: `failed` gives no reading; `error` (radians, clockwise) is common to them."""

    def __init__(self, error: float = 0.0) -> None:
        self.failed = False
        self.error = error


TURN_TIME_S: Final = 2.0
"""Within this time constant the estimate's heading follows compasses that turn together, as measured at 45 degrees."""
LOST_DRIFT: Final = math.radians(0.03)
"""Without a compass the heading drifts by the gyroscopes' bias, rad/s, as measured."""
VARIANCE_ONE: Final = math.radians(50.0)
"""The compasses' test ratio is one at this error."""
SWERVES: Final = math.radians(30.0)
"""With a larger error the vehicle circles, until GNSS contradicts the heading ..."""
RESET_AFTER_S: Final = 8.0
"""... after this time: EKF3 takes the heading from the motion, and no compass from then on, until a boot."""
RESET_ERROR: Final = math.radians(10.0)
"""Error of that heading."""


class Heading:
    """The estimate's heading: `error` is what the compasses made of it, radians."""

    def __init__(self) -> None:
        self.error = 0.0
        self.is_by_motion = False
        self._swerved_s = 0.0
        self._off = 0.0

    @property
    def variance(self) -> float:
        """Test ratio of the compasses in EKF_STATUS_REPORT."""
        return 0.0 if self.is_by_motion else min(1.0, max(abs(self._off), abs(self.error)) / VARIANCE_ONE)

    def step(self, compasses: Compasses, dt: float) -> bool:
        """Follow the compasses for ``dt`` seconds; return True at the moment of an emergency yaw reset."""
        if compasses.failed or self.is_by_motion:
            self.error = wrap_angle(self.error + LOST_DRIFT * dt) if compasses.failed else self.error
            self._off = 0.0
            return False
        self._off = wrap_angle(compasses.error - self.error)
        self.error = wrap_angle(self.error + self._off * min(1.0, dt / TURN_TIME_S))
        self._swerved_s = self._swerved_s + dt if abs(self.error) > SWERVES else 0.0
        if self._swerved_s < RESET_AFTER_S:
            return False
        self.error, self.is_by_motion = math.copysign(RESET_ERROR, self.error), True
        return True


SIMULATED: Final = 100
"""RNGFND1_TYPE of ArduPilot's own simulation."""
DOWN: Final = 25
"""RNGFND1_ORIENT of a sensor that looks down (MAV_SENSOR_ROTATION_PITCH_270)."""
STEEPEST: Final = math.radians(75.0)
"""A drone that leans more measures nothing."""
FARTHEST_CM: Final = 65_535


class Rangefinder:
    """One sensor. ``stuck_cm`` is a fault: it measures this whatever is below; None: none."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.stuck_cm: int | None = None
        self.boot()

    def boot(self) -> None:
        """Take up the sensor that the parameters name."""
        values = self._parameters
        self.is_there = values.flag("RNGFND1_TYPE") == SIMULATED and values.flag("RNGFND1_ORIENT") == DOWN

    @property
    def limits_cm(self) -> tuple[int, int]:
        """Shortest and longest distance."""
        return round(self._parameters["RNGFND1_MIN"] * 100), round(self._parameters["RNGFND1_MAX"] * 100)

    def measure_cm(self, body: Body, slope: Slope) -> int:
        """Return the distance along the sensor's axis."""
        if self.stuck_cm is not None:
            return self.stuck_cm
        north, east, down = body.position
        lean = math.cos(body.roll) * math.cos(body.pitch)
        if lean <= math.cos(STEEPEST):
            return FARTHEST_CM
        height = -down - slope.height(north, east)
        return min(FARTHEST_CM, max(0, round(height / lean * 100)))
