"""Position, velocity and yaw controllers: from a mode's set-point to the demand on the body."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hawk.sim.autopilot.gps import Estimate
from hawk.sim.autopilot.parameters import Parameters
from hawk.sim.geometry import Flat, clamp, limit, sqrt_controller, wrap_angle
from hawk.sim.vehicle import Demand

POSITION_GAIN_Z = 1.0
VELOCITY_GAIN_Z = 4.0
INTEGRAL_GAIN = 1.0
INTEGRAL_MAX = 4.0
"""Holds against 12 m/s of wind with a margin, m/s²."""
BRAKING_SHARE = 0.75
"""Share of the deceleration that is planned: the lag of the attitude leaves some overshoot, as on the real one."""
YAW_GAIN = 2.0
CENTI = 0.01


@dataclass(frozen=True, slots=True)
class Setpoint:
    """Set-point of a mode, in the frame of the estimate (NED metres in the world).

    Horizontally: ``position``, else ``velocity`` (m/s), else (both None) level, moved by the wind. Vertically:
    ``down`` (a height), else ``climb`` (m/s, up positive). ``yaw`` None holds. ``speed``, ``speed_up``, ``speed_down``
    (m/s) replace the WPNAV ones. ``idle`` is zero throttle.
    """

    position: Flat | None = None
    velocity: Flat | None = None
    down: float | None = None
    climb: float = 0.0
    yaw: float | None = None
    speed: float | None = None
    speed_up: float | None = None
    speed_down: float | None = None
    acceleration: float | None = None
    idle: bool = False


@dataclass(frozen=True, slots=True)
class Limits:
    """Speeds (m/s) and accelerations (m/s²) of ArduCopter's WPNAV parameters."""

    speed: float
    speed_up: float
    speed_down: float
    acceleration: float
    acceleration_z: float
    jerk: float
    lean_max: float
    slew_yaw: float
    position_gain: float
    velocity_gain: float

    @classmethod
    def of(cls, parameters: Parameters) -> Limits:
        """Read the limits from parameters in centimetres and centidegrees."""
        return cls(
            speed=parameters["WPNAV_SPEED"] * CENTI,
            speed_up=parameters["WPNAV_SPEED_UP"] * CENTI,
            speed_down=parameters["WPNAV_SPEED_DN"] * CENTI,
            acceleration=parameters["WPNAV_ACCEL"] * CENTI,
            acceleration_z=parameters["WPNAV_ACCEL_Z"] * CENTI,
            jerk=parameters["PSC_JERK_XY"],
            lean_max=math.radians(parameters["ANGLE_MAX"] * CENTI),
            slew_yaw=math.radians(parameters["ATC_SLEW_YAW"] * CENTI),
            position_gain=parameters["PSC_POSXY_P"],
            velocity_gain=parameters["PSC_VELXY_P"],
        )


class Controller:
    """Follows set-points smoothly: wanted velocities change no faster than the acceleration limits."""

    def __init__(self) -> None:
        self._wanted: Flat = (0.0, 0.0)
        self._pull: Flat = (0.0, 0.0)
        self._wanted_down = 0.0
        self._integral: Flat = (0.0, 0.0)
        self._integral_down = 0.0
        self._yaw_hold: float | None = None

    def reset(self, estimate: Estimate | None = None) -> None:
        """Start again from the vehicle's present motion."""
        self._wanted = (0.0, 0.0) if estimate is None else estimate.velocity[:2]
        self._pull = (0.0, 0.0)
        self._wanted_down = 0.0 if estimate is None else estimate.velocity[2]
        self._yaw_hold = None if estimate is None else estimate.yaw
        if estimate is None:
            self._integral, self._integral_down = (0.0, 0.0), 0.0

    def update(self, estimate: Estimate, setpoint: Setpoint, limits: Limits, dt: float) -> Demand:
        """Return the demand on the body for this step."""
        if setpoint.idle:
            self.reset()
            return Demand(lean_max=limits.lean_max, motors=True, idle=True)
        north, east = self._horizontal(estimate, setpoint, limits, dt)
        down = self._vertical(estimate, setpoint, limits, dt)
        return Demand((north, east, down), self._yaw(estimate, setpoint, limits), limits.lean_max, motors=True)

    def _horizontal(self, estimate: Estimate, setpoint: Setpoint, limits: Limits, dt: float) -> Flat:
        speed = limits.speed if setpoint.speed is None else setpoint.speed
        acceleration = limits.acceleration if setpoint.acceleration is None else setpoint.acceleration
        if setpoint.position is not None:
            north = setpoint.position[0] - estimate.position[0]
            east = setpoint.position[1] - estimate.position[1]
            distance = math.hypot(north, east)
            allowed = min(sqrt_controller(distance, limits.position_gain, BRAKING_SHARE * acceleration), speed)
            goal = limit(north, east, allowed) if distance > allowed else (north, east)
        elif setpoint.velocity is not None:
            goal = limit(*setpoint.velocity, speed)
        else:
            self._wanted, self._pull = estimate.velocity[:2], (0.0, 0.0)
            return 0.0, 0.0
        step = self._shape(goal, acceleration, limits.jerk, dt)
        error = (self._wanted[0] - estimate.velocity[0], self._wanted[1] - estimate.velocity[1])
        self._integral = limit(
            self._integral[0] + error[0] * INTEGRAL_GAIN * dt,
            self._integral[1] + error[1] * INTEGRAL_GAIN * dt,
            INTEGRAL_MAX,
        )
        return (
            step[0] / dt + error[0] * limits.velocity_gain + self._integral[0],
            step[1] / dt + error[1] * limits.velocity_gain + self._integral[1],
        )

    def _shape(self, goal: Flat, acceleration: float, jerk: float, dt: float) -> Flat:
        """Move the wanted velocity towards the goal within acceleration and jerk; return its change."""
        north, east = goal[0] - self._wanted[0], goal[1] - self._wanted[1]
        # as fast as the jerk lets the acceleration end on time
        fastest = min(acceleration, math.sqrt(2.0 * jerk * math.hypot(north, east)))
        aim = limit(north / dt, east / dt, fastest)
        change = limit(aim[0] - self._pull[0], aim[1] - self._pull[1], jerk * dt)
        self._pull = (self._pull[0] + change[0], self._pull[1] + change[1])
        step = (self._pull[0] * dt, self._pull[1] * dt)
        self._wanted = (self._wanted[0] + step[0], self._wanted[1] + step[1])
        return step

    def _vertical(self, estimate: Estimate, setpoint: Setpoint, limits: Limits, dt: float) -> float:
        up = limits.speed_up if setpoint.speed_up is None else setpoint.speed_up
        down = limits.speed_down if setpoint.speed_down is None else setpoint.speed_down
        if setpoint.down is not None:
            error = setpoint.down - estimate.position[2]
            goal = clamp(sqrt_controller(error, POSITION_GAIN_Z, limits.acceleration_z), -up, down)
        else:
            goal = clamp(-setpoint.climb, -up, down)
        most = limits.acceleration_z * dt
        step = clamp(goal - self._wanted_down, -most, most)
        self._wanted_down += step
        error = self._wanted_down - estimate.velocity[2]
        self._integral_down = clamp(self._integral_down + error * INTEGRAL_GAIN * dt, -1.0, 1.0)
        return step / dt + error * VELOCITY_GAIN_Z + self._integral_down

    def _yaw(self, estimate: Estimate, setpoint: Setpoint, limits: Limits) -> float:
        if setpoint.yaw is not None:
            self._yaw_hold = setpoint.yaw
        elif self._yaw_hold is None:
            self._yaw_hold = estimate.yaw
        error = wrap_angle(self._yaw_hold - estimate.yaw)
        return clamp(error * YAW_GAIN, -limits.slew_yaw, limits.slew_yaw)
