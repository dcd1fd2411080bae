"""Wind, estimated from how the drone leans: ArduCopter's own WIND message is zero without drag parameters.

A multicopter in level flight at ground velocity v (NED, horizontal) accelerates by dv/dt = a + d(u), u = w - v: a is
the thrust's horizontal part per mass, g tan(lean) towards the lean, w the wind. The drag d(u) = (m + b |u|) u has the
rotors' linear part and the body's quadratic one, as in ArduPilot's EK3_DRAG_MCOEF and EK3_DRAG_BCOEF. Gauss-Newton
finds w, m and b over the last samples, because the drone flies in several directions; until it has, priors hold m
and b.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hawk.ddc.readings.instant import Instant, Reading
from hawk.ddc.stopwatch import Stopwatch
from hawk.model.poses import VehiclePose

FloatArray = NDArray[np.float64]

WIND_S = 1.0
"""Interval of the estimates, seconds."""

GRAVITY = 9.80665
ROTOR_DRAG, ROTOR_DRAG_SPREAD = 0.15, 0.08
"""Prior of m, 1/s: mean and standard deviation."""
BODY_DRAG, BODY_DRAG_SPREAD = 0.015, 0.012
"""Prior of b, 1/m. ArduPilot's simulated quadcopter flies with 0.18 and 0.03, hawk-sim's with 0.15 and 0."""
LEAST_DRAG = 0.05
"""No multicopter has a smaller m, 1/s."""
NOISE = 0.6
"""Standard deviation of one sample's acceleration, m/s²: gusts, and manoeuvres between two samples."""
LARGEST_REST = 1.5
"""Root mean square of what the fit leaves over, m/s², above which it says nothing."""
SAMPLE_S = 0.2
MEMORY_S = 40.0
"""Older samples are forgotten: wind changes over a flight, seconds."""
STEPS = 4
"""Gauss-Newton steps of one estimate; it begins where the last one ended."""
LEAST_S = 8.0
"""Seconds of samples before there is an estimate."""
LARGEST_LEAN = math.radians(25.0)
"""Samples that lean more are manoeuvres."""
LARGEST_CLIMB = 1.0
"""Samples that climb or sink faster than this are no level flight, m/s."""


@dataclass(frozen=True, slots=True)
class Wind:
    """Wind's velocity, m/s in NED (towards, not from), and the airframe's drag: linear, 1/s, and quadratic, 1/m."""

    north: float
    east: float
    rotor_drag: float = ROTOR_DRAG
    body_drag: float = BODY_DRAG

    @property
    def speed(self) -> float:
        """Metres per second."""
        return math.hypot(self.north, self.east)

    @property
    def from_direction(self) -> float:
        """Direction that it comes from, radians clockwise from north, 0 to 2 pi."""
        return math.atan2(-self.east, -self.north) % (2 * math.pi)

    def airspeed(self, lean: float) -> float:
        """Return the speed through the air that a lean (radians) holds in level flight, m/s."""
        thrust = GRAVITY * math.tan(lean)
        if self.body_drag < 1e-6:
            return thrust / self.rotor_drag
        return (math.sqrt(self.rotor_drag**2 + 4 * self.body_drag * thrust) - self.rotor_drag) / (2 * self.body_drag)


@dataclass(frozen=True, slots=True)
class WindFacts:
    """The wind in the air, estimated from how the drone leans."""

    estimate: Wind | None = None
    """None on the ground, and until enough was seen."""
    strong_s: float | None = None
    """Seconds since the wind rose above the limit; None below it."""


class WindReading(Reading):
    """Estimates the wind of a flight once a second, and times a strong one."""

    def __init__(self, limit_m_s: float) -> None:
        """``limit_m_s``: a wind above it is strong."""
        self._limit = limit_m_s
        self._estimator = WindEstimator()
        self._estimated_at = -math.inf
        self._strong = Stopwatch()
        self.estimate: Wind | None = None
        """The last estimate of this flight."""

    def update(self, instant: Instant) -> None:
        """Take the pose."""
        pose, now = instant.fresh_pose, instant.now
        if not instant.is_airborne:
            self._estimator.reset()
            self.estimate = None
        elif pose is not None:
            self._estimator.update(pose)
            if now - self._estimated_at >= WIND_S:
                self.estimate, self._estimated_at = self._estimator.estimate(), now
        self._strong.update(self.estimate is not None and self.estimate.speed > self._limit, now)

    def facts(self, instant: Instant) -> WindFacts:
        """Return what is known."""
        return WindFacts(self.estimate, self._strong.read(instant.now))


_PRIOR = np.array([ROTOR_DRAG, BODY_DRAG])
_WEIGHT = np.array([ROTOR_DRAG_SPREAD, BODY_DRAG_SPREAD]) ** -2.0


class WindEstimator:
    """Estimates the wind from poses in the air."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget everything: another flight."""
        self._samples: deque[tuple[float, float, float, float, float]] = deque()
        self._last: VehiclePose | None = None
        self._found = np.array([0.0, 0.0, *_PRIOR])

    def update(self, pose: VehiclePose) -> None:
        """Take a pose in the air; poses closer than `SAMPLE_S` to the last one are left out."""
        last = self._last
        if last is not None and pose.time - last.time < SAMPLE_S - 1e-6:
            return
        self._last = pose
        if last is None or pose.time - last.time > 5 * SAMPLE_S or not (_is_level(last) and _is_level(pose)):
            return
        span = pose.time - last.time
        if math.dist(last.velocity, pose.velocity) > span * GRAVITY * math.tan(LARGEST_LEAN):
            return  # no lean explains it
        one, other = _thrust(last), _thrust(pose)
        drag = [
            (b - a) / span - (f + g) / 2 for a, b, f, g in zip(last.velocity, pose.velocity, one, other, strict=False)
        ]
        velocity = [(a + b) / 2 for a, b in zip(last.velocity, pose.velocity, strict=True)]
        self._samples.append((pose.time, velocity[0], velocity[1], drag[0], drag[1]))
        while pose.time - self._samples[0][0] > MEMORY_S:
            self._samples.popleft()

    def estimate(self) -> Wind | None:
        """Return the wind; None until enough was seen, and while the drone moves unlike a multicopter in wind.

        Takes half a millisecond.
        """
        if len(self._samples) * SAMPLE_S < LEAST_S:
            return None
        samples = np.array(self._samples)
        velocity, drag = samples[:, 1:3], samples[:, 3:5]
        for _ in range(STEPS):
            self._found = _improved(self._found, velocity, drag)
        if float(np.sqrt(np.mean((drag - _drag(self._found, velocity)) ** 2))) > LARGEST_REST:
            return None
        north, east, rotor, body = (float(value) for value in self._found)
        return Wind(north, east, rotor, body)


def _drag(found: FloatArray, velocity: FloatArray) -> FloatArray:
    """Return the drag per mass (N, 2) of (wind north, wind east, m, b) at velocities (N, 2)."""
    through = found[:2] - velocity
    drag: FloatArray = (found[2] + found[3] * np.linalg.norm(through, axis=1))[:, None] * through
    return drag


def _improved(found: FloatArray, velocity: FloatArray, drag: FloatArray) -> FloatArray:
    """Return the next Gauss-Newton step of (wind north, wind east, m, b) for drags (N, 2) at velocities (N, 2)."""
    through = found[:2] - velocity
    speed = np.maximum(np.linalg.norm(through, axis=1), 0.1)
    factor = found[2] + found[3] * speed
    rest = drag - factor[:, None] * through
    by_wind = (
        factor[:, None, None] * np.eye(2) + found[3] * through[:, :, None] * through[:, None, :] / speed[:, None, None]
    )
    rows = np.concatenate([by_wind, through[:, :, None], (speed[:, None] * through)[:, :, None]], axis=2).reshape(-1, 4)
    information = rows.T @ rows / NOISE**2
    vector = rows.T @ rest.reshape(-1) / NOISE**2
    information[[2, 3], [2, 3]] += _WEIGHT
    information[[0, 1], [0, 1]] += 1e-6
    vector[2:] += _WEIGHT * (_PRIOR - found[2:])
    step: FloatArray = found + np.linalg.solve(information, vector)
    step[2:] = np.maximum(step[2:], (LEAST_DRAG, 0.0))
    return step


def ground_speed(speed: float, track: float, wind: Wind | None) -> float:
    """Return the ground speed that the drone reaches along a track against the wind, m/s.

    Args:
        speed: Travel speed, m/s over ground.
        track: Direction of the flight, radians clockwise from north.
        wind: The wind; None: no wind.
    """
    if wind is None:
        return speed
    air = wind.airspeed(LARGEST_LEAN)
    along = wind.north * math.cos(track) + wind.east * math.sin(track)
    across = wind.east * math.cos(track) - wind.north * math.sin(track)
    if abs(across) >= air:
        return 0.0
    return max(0.0, min(speed, math.sqrt(air**2 - across**2) + along))


def _is_level(pose: VehiclePose) -> bool:
    return abs(pose.velocity[2]) <= LARGEST_CLIMB and math.hypot(pose.roll, pose.pitch) <= LARGEST_LEAN


def _thrust(pose: VehiclePose) -> tuple[float, float]:
    """Return the thrust's horizontal part per mass, north and east, m/s², in level flight (Z-Y-X Euler angles)."""
    roll, pitch, yaw = pose.roll, pose.pitch, pose.yaw
    down = math.cos(roll) * math.cos(pitch)
    forward, right = math.cos(roll) * math.sin(pitch), -math.sin(roll)
    north = forward * math.cos(yaw) - right * math.sin(yaw)
    east = forward * math.sin(yaw) + right * math.cos(yaw)
    return -GRAVITY * north / down, -GRAVITY * east / down
