"""The autopilot's state estimate: the true state with errors of GNSS, barometer, inertial sensors and compass.

Only the estimate ever reaches the controllers and the telemetry: EKF-local and global positions come from the same one
and agree with each other. The true position is for the camera and the truth alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hawk.sim.autopilot.sensors import Barometer, Compasses, Heading, Receiver
from hawk.sim.geometry import Vector, add, subtract, wrap_angle
from hawk.sim.vehicle import Body

DRIFT_TIME_S = 120.0
"""Correlation time of GNSS position errors (ionosphere, multipath)."""
DRIFT_SMOOTH_S = 10.0
"""The filter lets errors in slowly: no jerk in the estimate."""
HEIGHT_SHARE = 0.4
"""The barometer drifts less than GNSS."""
ATTITUDE_SIGMA = math.radians(0.2)
YAW_SIGMA = math.radians(0.3)
VELOCITY_SIGMA = 0.02
LOST_DRIFT = 0.05
"""Growth of the velocity error without GNSS, (m/s)/s."""
FIX_TIMEOUT_S = 4.0
"""GPS_TIMEOUT_MS of AP_GPS: the receiver is absent after it."""
HEALTH_TIMEOUT_S = 7.5
"""Health turns False 7-8 s after the loss."""
RECOVERY_S = 3.0
AIDED_S = 15.0
"""Without GNSS for this time EKF3 stops aiding: it gives a constant position."""
VARIANCE_PER_M = 0.2665
"""Test ratio of the position by metre of GNSS innovation, as measured over 6 to 100 m."""
VARIANCE_TIME_S = 42.0
"""Its decay while the estimate's own uncertainty grows, as measured."""
GLITCH_SAID_S = 1.2
"""Until GPS_GLITCHING shows, and EKF3 refuses GNSS for RESET_S; it shows for as long again after the reset."""
RESET_S = 10.0
SMALL_TIME_S = 1.6
"""An innovation that passes the test is taken within this time constant: 1.1 m of lag at 0.7 m/s, as measured."""
WALK_SHARE = 0.38
"""Share of a walk of GNSS that shows in the estimate's velocity: the receiver measures its true speed. As measured."""
BAROMETER_TIME_S = 4.8
BAROMETER_SHARE = 0.48
"""The same of the barometer: 2.4 m of lag and 0.24 m/s at a drift of 0.5 m/s, as measured."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """Estimated position (NED metres in the world), velocity (m/s), attitude (rad) and yaw rate (rad/s)."""

    position: Vector
    velocity: Vector
    roll: float
    pitch: float
    yaw: float
    yaw_rate: float = 0.0


class _SlowError:
    """A smooth random walk that stays about zero with a given standard deviation, and starts at zero."""

    def __init__(self, sigma: float, rng: np.random.Generator) -> None:
        self.sigma = sigma
        self.value = 0.0
        self.rate = 0.0
        self._raw = 0.0
        self._rng = rng

    def step(self, dt: float) -> None:
        if self.sigma == 0.0:
            self.rate = -self.value / DRIFT_SMOOTH_S
        else:
            keep = math.exp(-dt / DRIFT_TIME_S)
            raw_sigma = self.sigma * math.sqrt((DRIFT_TIME_S + DRIFT_SMOOTH_S) / DRIFT_TIME_S)
            fresh = raw_sigma * math.sqrt(1.0 - keep * keep)
            self._raw = self._raw * keep + fresh * float(self._rng.standard_normal())
            self.rate = (self._raw - self.value) / DRIFT_SMOOTH_S
        self.value += self.rate * dt


class Glitch:
    """GNSS that is off by ``offset`` (NED, metres), and the part of it that the estimate has ``taken``.

    EKF3 refuses what fails its test, and resets its position to GNSS when that has lasted for `RESET_S`.
    """

    def __init__(self, offset: Vector = (0.0, 0.0, 0.0)) -> None:
        """``offset``: of the GNSS that the estimate begins with."""
        self.offset = offset
        self.taken = offset
        self.rate: Vector = (0.0, 0.0, 0.0)
        self._refused_s = 0.0
        self._settling_s = 0.0

    @property
    def variance(self) -> float:
        """Test ratio of the horizontal position."""
        north, east, _ = subtract(self.offset, self.taken)
        return VARIANCE_PER_M * math.hypot(north, east) * math.exp(-self._refused_s / VARIANCE_TIME_S)

    @property
    def is_reported(self) -> bool:
        """True while EKF_STATUS_REPORT has GPS_GLITCHING."""
        return self._refused_s >= GLITCH_SAID_S or self._settling_s > 0.0

    def settle(self) -> None:
        """Show a glitch for `RESET_S`: the filter was reset."""
        self._settling_s = RESET_S

    def step(self, dt: float) -> Vector:
        """Let time pass; return the movement of a reset, zero without one."""
        self.rate = (0.0, 0.0, 0.0)
        self._settling_s = max(0.0, self._settling_s - dt)
        left = subtract(self.offset, self.taken)
        if VARIANCE_PER_M * math.hypot(left[0], left[1]) < 1.0:
            self._refused_s = 0.0
            self.rate = (left[0] / SMALL_TIME_S, left[1] / SMALL_TIME_S, left[2] / SMALL_TIME_S)
            self.taken = add(self.taken, (self.rate[0] * dt, self.rate[1] * dt, self.rate[2] * dt))
            return 0.0, 0.0, 0.0
        self._refused_s += dt
        if self._refused_s < RESET_S:
            return 0.0, 0.0, 0.0
        self._refused_s, self._settling_s, self.taken = 0.0, RESET_S, self.offset
        return left


class Estimator:
    """Turns the true state into the autopilot's.

    ``gnss_sigma`` is the slow horizontal error, metres (1 sigma), ``wait_s`` the time from boot to a good position;
    ``gnss``, ``barometer`` and ``compasses`` have their own errors besides, and outlive this object.
    """

    def __init__(
        self,
        gnss_sigma: float,
        wait_s: float,
        rng: np.random.Generator,
        gnss: Receiver | None = None,
        barometer: Barometer | None = None,
        compasses: Compasses | None = None,
    ) -> None:
        self._rng = rng
        self.gnss = gnss or Receiver()
        self.barometer = barometer or Barometer()
        self.compasses = compasses or Compasses()
        self._raised = self.barometer.error
        self._raised_rate = 0.0
        self.heading = Heading()
        self.yaw_resets = 0
        """Emergency yaw resets since the boot."""
        self._north = _SlowError(gnss_sigma, rng)
        self._east = _SlowError(gnss_sigma, rng)
        self._down = _SlowError(gnss_sigma * HEIGHT_SHARE, rng)
        self._angles = tuple(_SlowError(sigma, rng) for sigma in (ATTITUDE_SIGMA, ATTITUDE_SIGMA, YAW_SIGMA))
        self._jump: Vector = (0.0, 0.0, 0.0)
        self._reset: Vector = (0.0, 0.0, 0.0)
        self.glitch = Glitch(self.gnss.offset)
        self._has_aided = False
        self._dead_reckoning: tuple[float, float] = (0.0, 0.0)
        self._dead_velocity: tuple[float, float] = (0.0, 0.0)
        self._lost_s = HEALTH_TIMEOUT_S
        self._good_s = RECOVERY_S - wait_s
        self.receiving = True
        self.exact = False

    def step(self, body: Body, dt: float) -> Estimate:
        """Return the estimate for the true state, ``dt`` seconds after the last one."""
        self._track_fix(dt)
        self._sense(dt)
        if self.exact:
            return Estimate(body.position, body.velocity, body.roll, body.pitch, body.yaw, yaw_rate=body.yaw_rate)
        for error in (self._north, self._east, self._down, *self._angles):
            error.step(dt)
        self._reckon(dt)
        self._reset = add(self._reset, self.glitch.step(dt))
        noise = self._rng.standard_normal(3) * VELOCITY_SIGMA
        error_position = (
            self._north.value + self._dead_reckoning[0],
            self._east.value + self._dead_reckoning[1],
            self._down.value - self._raised,
        )
        north, east, _ = self.glitch.rate
        error_velocity = (
            self._north.rate + self._dead_velocity[0] + north * WALK_SHARE + float(noise[0]),
            self._east.rate + self._dead_velocity[1] + east * WALK_SHARE + float(noise[1]),
            self._down.rate - self._raised_rate * BAROMETER_SHARE + float(noise[2]),
        )
        roll, pitch, yaw = (error.value for error in self._angles)
        return Estimate(
            add(add(add(body.position, error_position), self._jump), (*self.glitch.taken[:2], 0.0)),
            add(body.velocity, error_velocity),
            body.roll + roll,
            body.pitch + pitch,
            wrap_angle(body.yaw + yaw + self.heading.error),
            yaw_rate=body.yaw_rate,
        )

    def jump(self, north: float, east: float, down: float) -> None:
        """Shift the estimate at once, metres: a reset of the EKF."""
        self._jump = add(self._jump, (north, east, down))
        self._reset = add(self._reset, (north, east, down))

    def take_reset(self) -> Vector:
        """Return how far the estimate was reset since the last call, metres."""
        reset, self._reset = self._reset, (0.0, 0.0, 0.0)
        return reset

    @property
    def aids(self) -> bool:
        """True while the EKF gives a position that moves: it had GNSS less than `AIDED_S` ago."""
        return self._has_aided and self._lost_s < AIDED_S

    @property
    def healthy(self) -> bool:
        """True while SYS_STATUS reports the position as valid."""
        return self._lost_s < HEALTH_TIMEOUT_S

    @property
    def fix_type(self) -> int:
        """GPS_FIX_TYPE: 3 with a fix, 1 while searching, 0 without a receiver."""
        if self._lost_s < FIX_TIMEOUT_S:
            return 3
        return 1 if self.receiving else 0

    @property
    def satellites(self) -> int:
        """Satellites in use."""
        return 14 if self.fix_type == 3 else 0

    @property
    def horizontal_accuracy(self) -> float:
        """The receiver's own estimate of its error, metres."""
        return max(0.4, self._north.sigma) if self.fix_type == 3 else 99.0

    def measured(self, body: Body) -> Vector:
        """Return the receiver's own position (NED metres in the world): the barometer has no part in it."""
        slow = (self._north.value, self._east.value, self._down.value)
        return add(add(body.position, slow), self.gnss.offset)

    def _sense(self, dt: float) -> None:
        """Let the sensors' errors grow and the heading follow."""
        self.gnss.step(dt)
        self.barometer.step(dt)
        self._raised_rate = (self.barometer.error - self._raised) / BAROMETER_TIME_S
        self._raised += self._raised_rate * dt
        if self.heading.step(self.compasses, dt):
            self.yaw_resets += 1
            self.glitch.settle()
        self.glitch.offset = self.gnss.offset
        if not self._has_aided:
            self.glitch.taken = self.glitch.offset

    def _track_fix(self, dt: float) -> None:
        if self.receiving:
            self._good_s += dt
            if self._good_s >= RECOVERY_S:
                self._lost_s, self._has_aided = 0.0, True
        else:
            self._good_s = 0.0
            self._lost_s += dt

    def _reckon(self, dt: float) -> None:
        """Let the estimate drift without GNSS, and return within seconds with it."""
        if self._lost_s > 1.0:
            noise = self._rng.standard_normal(2) * LOST_DRIFT * math.sqrt(dt)
            self._dead_velocity = (self._dead_velocity[0] + float(noise[0]), self._dead_velocity[1] + float(noise[1]))
        else:
            self._dead_velocity = (-self._dead_reckoning[0] / 2.0, -self._dead_reckoning[1] / 2.0)
        self._dead_reckoning = (
            self._dead_reckoning[0] + self._dead_velocity[0] * dt,
            self._dead_reckoning[1] + self._dead_velocity[1] * dt,
        )
