"""The flying body and the wind."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from hawk.sim.geometry import Slope, Vector, add, clamp, wrap_angle

LEVEL = Slope()
GRAVITY = 9.80665
DRAG = 0.15
"""Horizontal acceleration by air, (m/s²) per (m/s) of airspeed: 4.4 degrees of lean at 5 m/s, as a 450-size quad."""
FALL_DRAG = 0.3
"""The same downwards with dead motors: a terminal speed of about 33 m/s."""
ATTITUDE_TIME_S = 0.12
"""Time constant of roll and pitch (ATC_INPUT_TC is of this size)."""
THRUST_TIME_S = 0.10
"""Time constant of the vertical acceleration."""
YAW_TIME_S = 0.25
LEAN_RATE = math.radians(220.0)
"""Fastest change of lean, rad/s (ATC_RATE_P_MAX of a nimble copter)."""
CRASH_SPEED = 3.5
"""A touch-down faster than this breaks the vehicle, m/s; LOITER without a radio sinks at 2.4 and does not."""


@dataclass(frozen=True, slots=True)
class Body:
    """The true state. ``position`` NED metres in the world, ``velocity`` m/s, angles radians. The start is at down = 0.

    ``climb_force`` is the vertical acceleration (m/s², down positive, gravity balanced) that the motors give.
    """

    position: Vector = (0.0, 0.0, 0.0)
    velocity: Vector = (0.0, 0.0, 0.0)
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0
    yaw_rate: float = 0.0
    climb_force: float = 0.0
    on_ground: bool = True
    crashed: bool = False

    @property
    def height(self) -> float:
        """Metres above the ground at the start."""
        return -self.position[2]


@dataclass(frozen=True, slots=True)
class Demand:
    """Demand of the controllers: NED acceleration (m/s²), yaw rate (rad/s), greatest lean (rad), motors running."""

    acceleration: Vector = (0.0, 0.0, 0.0)
    yaw_rate: float = 0.0
    lean_max: float = math.radians(30.0)
    motors: bool = False
    idle: bool = False
    """Motors turn without lift: throttle at zero."""

    def turned(self, angle: float) -> Demand:
        """Return the demand with its horizontal acceleration turned clockwise by an angle, radians."""
        if angle == 0.0:
            return self
        north, east, down = self.acceleration
        cosine, sine = math.cos(angle), math.sin(angle)
        return replace(self, acceleration=(north * cosine - east * sine, north * sine + east * cosine, down))


def step_body(body: Body, demand: Demand, wind: Vector, dt: float, slope: Slope = LEVEL) -> Body:
    """Return the state ``dt`` seconds later."""
    if body.crashed:
        return body
    lifting = demand.motors and not demand.idle
    if body.on_ground and not (lifting and demand.acceleration[2] < 0.0):
        return _rest(body, slope)
    if not lifting:
        return _land_or_fly(body, _falling(body, wind), replace(body, climb_force=0.0), dt, slope)
    turned = _turn(body, demand, dt)
    return _land_or_fly(body, _flying(turned, wind), turned, dt, slope)


def _rest(body: Body, slope: Slope) -> Body:
    """Stand on the ground, parallel to it, without motion."""
    roll, pitch = slope.tilt(body.yaw)
    if body.velocity == (0.0, 0.0, 0.0) and (body.roll, body.pitch) == (roll, pitch):
        return body
    return replace(body, velocity=(0.0, 0.0, 0.0), roll=roll, pitch=pitch, yaw_rate=0.0, climb_force=0.0)


def _turn(body: Body, demand: Demand, dt: float) -> Body:
    north, east, down = demand.acceleration
    cosine, sine = math.cos(body.yaw), math.sin(body.yaw)
    forward, right = north * cosine + east * sine, east * cosine - north * sine
    lean = min(math.atan(math.hypot(forward, right) / GRAVITY), demand.lean_max)
    direction = math.atan2(right, forward)
    pitch_goal, roll_goal = -lean * math.cos(direction), lean * math.sin(direction)
    most = LEAN_RATE * dt
    blend = dt / ATTITUDE_TIME_S
    yaw_rate = body.yaw_rate + (demand.yaw_rate - body.yaw_rate) * min(1.0, dt / YAW_TIME_S)
    return replace(
        body,
        roll=body.roll + clamp((roll_goal - body.roll) * blend, -most, most),
        pitch=body.pitch + clamp((pitch_goal - body.pitch) * blend, -most, most),
        yaw=wrap_angle(body.yaw + yaw_rate * dt),
        yaw_rate=yaw_rate,
        climb_force=body.climb_force + (down - body.climb_force) * min(1.0, dt / THRUST_TIME_S),
    )


def _flying(body: Body, wind: Vector) -> Vector:
    """Return the acceleration by lean, air and climb force."""
    forward, right = -GRAVITY * math.tan(body.pitch), GRAVITY * math.tan(body.roll)
    cosine, sine = math.cos(body.yaw), math.sin(body.yaw)
    return (
        forward * cosine - right * sine - DRAG * (body.velocity[0] - wind[0]),
        forward * sine + right * cosine - DRAG * (body.velocity[1] - wind[1]),
        body.climb_force - DRAG * (body.velocity[2] - wind[2]),
    )


def _falling(body: Body, wind: Vector) -> Vector:
    return (
        -DRAG * (body.velocity[0] - wind[0]),
        -DRAG * (body.velocity[1] - wind[1]),
        GRAVITY - FALL_DRAG * (body.velocity[2] - wind[2]),
    )


def _land_or_fly(before: Body, acceleration: Vector, turned: Body, dt: float, slope: Slope) -> Body:
    velocity = add(before.velocity, (acceleration[0] * dt, acceleration[1] * dt, acceleration[2] * dt))
    position = add(before.position, (velocity[0] * dt, velocity[1] * dt, velocity[2] * dt))
    ground = 0.0 - slope.height(position[0], position[1])
    if position[2] < ground or (position[2] == ground and velocity[2] < 0.0):
        return replace(turned, position=position, velocity=velocity, on_ground=False)
    fast = math.hypot(*velocity) > CRASH_SPEED
    return replace(
        turned,
        position=(position[0], position[1], ground),
        velocity=(0.0, 0.0, 0.0),
        roll=math.pi if fast else 0.0,
        pitch=0.0,
        yaw_rate=0.0,
        climb_force=0.0,
        on_ground=True,
        crashed=fast,
    )


GUST_SHARE = 0.25
"""Standard deviation of the gusts as a share of the mean wind (turbulence intensity over open ground)."""
GUST_TIME_S = 3.0


class Wind:
    """Horizontal wind. ``speed`` m/s and ``heading`` (radians clockwise from north, where it blows to) may be set."""

    def __init__(self, speed: float, heading: float, rng: np.random.Generator) -> None:
        self.speed = speed
        self.heading = heading
        self._rng = rng
        self._gust = (0.0, 0.0)

    def step(self, dt: float) -> Vector:
        """Return the wind (NED m/s) ``dt`` seconds later."""
        if self.speed == 0.0:
            return 0.0, 0.0, 0.0
        keep = math.exp(-dt / GUST_TIME_S)
        fresh = GUST_SHARE * self.speed * math.sqrt(1.0 - keep * keep)
        noise = self._rng.standard_normal(2)
        self._gust = (self._gust[0] * keep + fresh * float(noise[0]), self._gust[1] * keep + fresh * float(noise[1]))
        north, east = self.speed * math.cos(self.heading), self.speed * math.sin(self.heading)
        return north + self._gust[0], east + self._gust[1], 0.0
