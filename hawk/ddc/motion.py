"""Leading the drone: stopping point, the carrot target ahead of it, the route it follows, and its progress."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from hawk.model.plans import Route
from hawk.model.poses import MapPoint, MapPose, VehiclePose

BRAKING_M_S2 = 2.0
"""Least braking of the drone, m/s²; ArduCopter's WPNAV_ACCEL is 2.5."""
REACTION_S = 0.3
"""Until braking begins, seconds."""
TARGET_HORIZON_S = 3.0
"""No target lies farther than this many seconds of flight plus the stopping distance."""
CARROT_LEAD_S = 1.5
"""The carrot waits for the drone when it is this many seconds of flight, plus the stopping distance, ahead."""
CLIMB_M_S = 2.0
"""Vertical speed of the carrot, m/s; ArduCopter's WPNAV_SPEED_DN is 1.5, WPNAV_SPEED_UP 2.5."""
PROGRESS_M = 1.0
PROGRESS_S = 10.0
"""Less than PROGRESS_M of progress in PROGRESS_S is none."""
_STEP_LIMIT_S = 0.5  # after a hiccup of the loop the carrot does not leap


@dataclass(frozen=True, slots=True)
class Goal:
    """A place to be: map frame, metres; height above the arm place; yaw in radians clockwise from north."""

    north: float
    east: float
    height: float
    yaw: float

    @property
    def point(self) -> MapPoint:
        """The place on the ground below."""
        return MapPoint(self.north, self.east)

    def is_finite(self) -> bool:
        """Return True when every number is finite."""
        return all(math.isfinite(v) for v in (self.north, self.east, self.height, self.yaw))


def stopping_distance(speed: float) -> float:
    """Return the metres from now to standstill at this speed (m/s): reaction, then braking."""
    return speed * REACTION_S + speed * speed / (2 * BRAKING_M_S2)


def maximum_target_distance(speed: float) -> float:
    """Return how far a target may lie ahead, metres, for a travel speed in m/s."""
    return TARGET_HORIZON_S * speed + stopping_distance(speed)


def stopping_point(pose: VehiclePose) -> Goal | None:
    """Return where the drone comes to rest, at its yaw; None when the map pose is not known or not finite."""
    if pose.map is None or not pose.map.is_finite():
        return None
    north, east, down = (v if math.isfinite(v) else 0.0 for v in pose.velocity)
    speed = math.hypot(north, east)
    ahead = stopping_distance(speed) / speed if speed > 0.1 else 0.0
    rise = -math.copysign(stopping_distance(abs(down)), down)
    return Goal(pose.map.north + north * ahead, pose.map.east + east * ahead, pose.map.height + rise, pose.map.yaw)


def distance(pose: MapPose, goal: Goal) -> float:
    """Return the distance to the goal in space, metres."""
    return math.dist((pose.north, pose.east, pose.height), (goal.north, goal.east, goal.height))


class Carrot:
    """A target that goes ahead of the drone at travel speed and waits for it.

    A drone whose computer died stops at the last carrot, a few metres on.
    """

    def __init__(self, speed: float) -> None:
        self._speed = speed
        self._lead = CARROT_LEAD_S * speed + stopping_distance(speed)
        self._place: Goal | None = None
        self._time = 0.0

    @property
    def place(self) -> Goal | None:
        """The carrot's place; None before the first step."""
        return self._place

    def step(
        self, goal: Goal, pose: MapPose, now: float, lowest: float, highest: float, speed: float | None = None
    ) -> Goal:
        """Move on towards the goal and return the target for this tick.

        Outside ``lowest``..``highest`` (metres) only the height changes; the path across begins inside. ``speed``
        (m/s) makes this tick slower than travel speed, never faster; an invalid speed is ignored.
        """
        if self._place is None or _aside(self._place, pose) > self._lead + 2.0:
            self._place = Goal(pose.north, pose.east, pose.height, goal.yaw)
            self._time = now
        step = min(max(now - self._time, 0.0), _STEP_LIMIT_S)
        self._time = now
        place = replace(self._place, height=self._next_height(goal, pose, step), yaw=goal.yaw)
        if lowest - 0.5 <= pose.height <= highest + 0.5:
            pace = min(speed, self._speed) if speed is not None and speed > 0 else self._speed
            place = self._across(place, goal, pose, pace * step)
        self._place = place
        return place

    def _across(self, place: Goal, goal: Goal, pose: MapPose, step: float) -> Goal:
        north, east = goal.north - place.north, goal.east - place.east
        left = math.hypot(north, east)
        if left <= step:
            moved = replace(place, north=goal.north, east=goal.east)
        else:
            moved = replace(place, north=place.north + north / left * step, east=place.east + east / left * step)
        waits = _aside(moved, pose) > self._lead and _aside(moved, pose) > _aside(place, pose)
        return place if waits else moved

    def _next_height(self, goal: Goal, pose: MapPose, step: float) -> float:
        assert self._place is not None  # noqa: S101 - set by step()
        change = goal.height - self._place.height
        height = self._place.height + math.copysign(min(abs(change), CLIMB_M_S * step), change)
        return min(max(height, pose.height - self._lead), pose.height + self._lead)


def _aside(place: Goal, pose: MapPose) -> float:
    return math.hypot(place.north - pose.north, place.east - pose.east)


class Progress:
    """Detects a drone that gets nowhere: less than a metre nearer to its goal in ten seconds."""

    def __init__(self) -> None:
        self._goal: Goal | None = None
        self._best = math.inf
        self._since = 0.0

    def is_stuck(self, pose: MapPose, goal: Goal, now: float) -> bool:
        """Take the pose of this tick; return True without progress for too long (``now`` in seconds)."""
        left = distance(pose, goal)
        if self._goal is None or goal.point != self._goal.point or abs(goal.height - self._goal.height) > PROGRESS_M:
            self._goal, self._best, self._since = goal, left, now
        elif left <= self._best - PROGRESS_M:
            self._best, self._since = left, now
        return now - self._since >= PROGRESS_S


class Roaming:
    """The same for a goal that changes in flight: less than a metre from one place in ten seconds."""

    def __init__(self) -> None:
        self._anchor: MapPose | None = None
        self._since = 0.0

    def is_stuck(self, pose: MapPose, now: float) -> bool:
        """Take the pose of this tick; return True after too long within a metre (``now`` in seconds)."""
        if self._anchor is None or self._anchor.distance(pose) >= PROGRESS_M:
            self._anchor, self._since = pose, now
        return now - self._since >= PROGRESS_S


_ON_LEG_M = 1.0
"""Within this distance of a leg the drone is on it, metres."""


class RouteFollower:
    """Follows one route."""

    def __init__(self, route: Route, arrival_m: float) -> None:
        """``arrival_m``: within this distance of a corner the drone has stopped there, metres.

        Raises:
            ValueError: The route has less than two points.
        """
        if len(route.points) < 2:
            raise ValueError("a route has at least two points")
        self.route = route
        self._arrival_m = arrival_m
        self._leg = 1

    def aim(self, place: MapPoint) -> MapPoint:
        """Return the point to lead a drone at this place to, straight."""
        points, turns = self.route.points, self.route.turns
        while self._leg < len(points) - 1:
            if place.distance(points[self._leg]) > max(turns[self._leg], self._arrival_m):
                break
            self._leg += 1
        start, end = points[self._leg - 1], points[self._leg]
        cut = turns[self._leg - 1]
        if cut == 0 or _off_leg(place, start, end) <= _ON_LEG_M:
            return end
        return start.towards(end, min(1.0, cut / start.distance(end)))

    @property
    def heading_for(self) -> MapPoint:
        """The point of the route that is next."""
        return self.route.points[self._leg]

    def left(self, place: MapPoint) -> tuple[MapPoint, ...]:
        """Return the rest of the route: from the drone's place through the points that are still to come."""
        return (place, *self.route.points[self._leg :])


def _off_leg(place: MapPoint, start: MapPoint, end: MapPoint) -> float:
    """Return the distance to the straight line through a leg, metres; 0 for a leg of no length."""
    north, east = end.north - start.north, end.east - start.east
    length = math.hypot(north, east)
    if length == 0:
        return 0.0
    return abs((place.north - start.north) * east - (place.east - start.east) * north) / length
