"""Clearance: the distance to what is below, and since when it is too small; the rangefinder; the slope before Arm.

Without a rangefinder nothing here says anything.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from hawk.comm.autopilot.terrain import Terrain
from hawk.comm.topic import Topic
from hawk.config.sections import OBSTACLE_MARGIN_M
from hawk.ddc.readings.instant import Instant, Parts, Reading
from hawk.ddc.readings.topic_interface import TARGET_POSE_AGE_S
from hawk.ddc.words import direction, metres
from hawk.model.operation import Health, HealthStatus
from hawk.model.plans import Fence
from hawk.model.poses import MapPoint, VehiclePose
from hawk.model.sentences import say
from hawk.model.vehicle import LandedState

REST_S = 1.0
"""Seconds of attitude that are averaged."""
REST_POSES = 5
REST_SPREAD = math.radians(1.0)
"""A drone whose roll or pitch varies by more is carried, not at rest."""
LEAST_TILT = math.radians(3.0)
"""Landing gear and grass tilt a drone by this on level ground."""


@dataclass(frozen=True, slots=True)
class Slope:
    """Rise of the ground for each metre to the north and to the east (metres a metre, upwards)."""

    north: float
    east: float

    @property
    def steepness(self) -> float:
        """Rise for each metre straight up the slope."""
        return math.hypot(self.north, self.east)

    @property
    def is_notable(self) -> bool:
        """True when it is more than what landing gear makes."""
        return self.steepness >= math.tan(LEAST_TILT)

    def rise(self, start: MapPoint, end: MapPoint) -> float:
        """Return how much higher the ground is at ``end``, metres, if it goes on like this."""
        return self.north * (end.north - start.north) + self.east * (end.east - start.east)


def slope_of(roll: float, pitch: float, yaw: float) -> Slope:
    """Return the slope of the ground on which a drone of this attitude (radians, NED) stands."""
    down = math.cos(roll) * math.cos(pitch)
    forward, right = math.cos(roll) * math.sin(pitch), -math.sin(roll)
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return Slope((forward * cosine - right * sine) / down, (forward * sine + right * cosine) / down)


class SlopeReading:
    """Averages the attitude of a drone that stands still, disarmed."""

    def __init__(self) -> None:
        self._poses: deque[VehiclePose] = deque()

    def reset(self) -> None:
        """Forget everything: armed, or in the air."""
        self._poses.clear()

    def update(self, pose: VehiclePose) -> None:
        """Take a pose; the same one again changes nothing."""
        poses = self._poses
        if poses and pose.time <= poses[-1].time:
            return
        poses.append(pose)
        while len(poses) > 1 and poses[-1].time - poses[1].time >= REST_S:
            poses.popleft()

    def slope(self) -> Slope | None:
        """Return the slope; None before a second was seen, and while the drone is moved."""
        poses = self._poses
        if len(poses) < REST_POSES or poses[-1].time - poses[0].time < REST_S:
            return None
        rolls, pitches = [pose.roll for pose in poses], [pose.pitch for pose in poses]
        if max(max(angles) - min(angles) for angles in (rolls, pitches)) > REST_SPREAD:
            return None
        return slope_of(sum(rolls) / len(rolls), sum(pitches) / len(pitches), poses[-1].yaw)


def slope_words(slope: Slope, fence: Fence, home: MapPoint, minimum: float, obstacle: float | None) -> str:
    """Return what the slope means for a flight in the fence.

    Args:
        slope: The slope at the arm place; nothing shows that it goes on, so this is a warning.
        fence: The planned fence.
        home: Place of the drone.
        minimum: Min, metres above the arm place.
        obstacle: Highest obstacle, metres above the ground that it stands on; None when none is declared.
    """
    rise = max(slope.rise(home, MapPoint(*corner)) for corner in fence.polygon)
    where = direction(slope.north, slope.east)
    text = say("stands on a slope of {steepness:.0f} % up to the {where}", steepness=slope.steepness * 100, where=where)
    if rise <= 0:
        return text
    text = say(
        "{slope}: the ground may be {rise} higher {away} away",
        slope=text,
        rise=metres(rise),
        away=metres(rise / slope.steepness),
    )
    return say("{rise}, {clearance}", rise=text, clearance=_clearance(minimum, rise, obstacle))


def _clearance(minimum: float, rise: float, obstacle: float | None) -> str:
    """Return whether Min clears what may stand on the risen ground, and the remedy where it does not well enough."""
    left = minimum - rise - (obstacle or 0.0)
    over = say("it") if obstacle is None else say("an obstacle of {obstacle} there", obstacle=metres(obstacle))
    low = metres(minimum)
    if left > 0:
        clears = say("Min {low} clears {over} by {left}", low=low, over=over, left=metres(left))
    else:
        clears = say("Min {low} does not clear {over}", low=low, over=over)
    if left >= OBSTACLE_MARGIN_M:
        return clears
    enough = metres(math.ceil(rise + (obstacle or 0.0) + OBSTACLE_MARGIN_M))
    return say("{clears}; raise it to {enough}", clears=clears, enough=enough)


LOW_S = 0.5
"""Seconds for which the distance must be too small."""
LOW_READINGS = 4
"""Number of readings that must show it: a single bad one does not count."""
GAP_S = 1.0
"""After this time without a reading that is too small, seconds, those before do not count."""
SILENT_S = 3.0
"""A rangefinder that was heard and is silent for this time is unhealthy, seconds."""
MIN_SHARE = 0.5
"""The least clearance is never more than this share of Min: Min itself must be free to fly."""


@dataclass(frozen=True, slots=True)
class BelowFacts:
    """Readings of what is below the drone. Without a rangefinder there is only ``slope``."""

    terrain: Terrain | None = None
    """The last message of the rangefinder; None when there was none, and when it is silent."""
    low_s: float | None = None
    """Seconds for which the distance has been below the least clearance; None while it is not, and on the ground."""
    low_m: float | None = None
    """The least distance in that time, metres."""
    slope: Slope | None = None
    """The slope that the drone stands on, disarmed; None in flight and before it was seen at rest for a second."""

    @property
    def ground(self) -> float | None:
        """Height of the ground below, metres above the arm place; None where it is not known or not believed."""
        return None if self.terrain is None else self.terrain.believed_ground


def least_clearance(setting_m: float, minimum: float) -> float:
    """Return the least distance to what is below in a task, metres."""
    return min(setting_m, MIN_SHARE * minimum)


class ClearanceReading:
    """Counts the readings that are too small, one after the other."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget the readings: the drone is on the ground."""
        self._seen = self._first = self._last = -math.inf
        self._count = 0
        self._least = math.inf

    def update(self, terrain: Terrain | None, limit: float) -> None:
        """Take the newest message (the same one again changes nothing); ``limit`` in metres."""
        if terrain is None or terrain.time <= self._seen:
            return
        self._seen = terrain.time
        if terrain.doubt or (terrain.distance is not None and terrain.distance >= limit):
            self._count = 0
        elif terrain.distance is not None:
            if terrain.time - self._last > GAP_S:
                self._count = 0
            if not self._count:
                self._first, self._least = terrain.time, math.inf
            self._count += 1
            self._least = min(self._least, terrain.distance)
            self._last = terrain.time

    def low(self, now: float) -> tuple[float | None, float | None]:
        """Return how long the distance has been too small (s) and the least one (m); None while it is not too small."""
        if self._count < LOW_READINGS or now - self._last > GAP_S:
            return None, None
        return self._last - self._first, self._least


def range_health(terrain: Terrain | None, age: float) -> Health | None:
    """Return the health of the rangefinder; None when none was ever heard. ``age`` of its last message, seconds."""
    if terrain is None:
        return None
    if age > SILENT_S:
        return Health.bad(say("silent for {age:.0f} s: heights count above the arm place", age=age))
    if terrain.doubt:
        return Health.bad(say("not believed: {doubt}", doubt=terrain.doubt))
    reason = "" if terrain.distance is not None else say("no reading (it reaches {most:.0f} m)", most=terrain.most)
    return Health(HealthStatus.HEALTHY, reason)


class BelowReading(Reading):
    """Takes the rangefinder's newest message and the attitude once a tick."""

    def __init__(self, terrain: Topic[Terrain], least_clearance_m: float) -> None:
        """``terrain``: the ground below by the rangefinder. ``least_clearance_m``: least distance to it in a task."""
        self._terrain = terrain
        self._least_m = least_clearance_m
        self._clearance = ClearanceReading()
        self._slope = SlopeReading()

    def update(self, instant: Instant) -> None:
        """Take the newest message and pose."""
        vehicle, pose = instant.vehicle, instant.pose
        stands = vehicle.landed is LandedState.ON_GROUND
        if instant.is_airborne:
            self._clearance.update(self._terrain.value, least_clearance(self._least_m, instant.heights.minimum))
        else:
            self._clearance.reset()
        if vehicle.armed or not stands:
            self._slope.reset()
        elif pose is not None and instant.pose_age <= TARGET_POSE_AGE_S:  # before Arm there is no map
            self._slope.update(pose)

    def facts(self, instant: Instant) -> BelowFacts:
        """Return what is known."""
        terrain = self._terrain.fresh(SILENT_S)
        return BelowFacts(terrain, *self._clearance.low(instant.now), self._slope.slope())

    def parts(self, instant: Instant) -> Parts:
        """Return the rangefinder's health; nothing when none was ever heard."""
        health = range_health(self._terrain.value, self._terrain.age)
        return () if health is None else (("rangefinder", health),)
