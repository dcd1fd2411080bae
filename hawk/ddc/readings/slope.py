"""The slope that the drone stands on: its own tilt at rest, before Arm."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from hawk.config.sections import OBSTACLE_MARGIN_M
from hawk.ddc.words import direction, metres
from hawk.model.limits import Fence
from hawk.model.poses import MapPoint, VehiclePose
from hawk.model.sentences import say

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


class SlopeWatch:
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
