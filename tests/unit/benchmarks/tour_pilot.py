"""A pilot that flies a tour of known waypoints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from benchmarks.exploration.surveyed import SurveyedMap
from hawk.algo.frame import FrameInput
from hawk.model.plans import ExploreStatus, PathPlan
from hawk.model.poses import MapPoint, MapPose

Place = tuple[float, float]
ARRIVAL_M: Final = 1.5
_FIRST_TURN_RAD: Final = math.radians(125)  # a picture turned so far has shown all that half a turn shows
_TURN_LEAD_RAD: Final = 0.8
_END_M: Final = 0.3  # a tour's last place is reached when the drone stands


@dataclass
class TourPilot:
    """Flies a tour of known waypoints, picture along the flight; with ``turns`` it turns on the spot at both ends."""

    tour: list[Place]
    turns: bool = False
    _next: int = 0
    _turned: float = 0.0
    _yaw: float | None = None
    _side: float | None = None

    def plan(self, frame: FrameInput, known: SurveyedMap) -> PathPlan:
        """Return the waypoint that is next."""
        pose = _pose(frame)
        place = pose.north, pose.east
        if self.turns and self.tour and not self._next:
            bearing = math.atan2(self.tour[0][1] - pose.east, self.tour[0][0] - pose.north)
            plan = self._turn(pose, math.remainder(bearing - pose.yaw, math.tau), _FIRST_TURN_RAD)
            if plan is not None:
                return plan
        while self._next < len(self.tour):
            is_last = self._next == len(self.tour) - 1
            if math.dist(self.tour[self._next], place) > (_END_M if is_last else ARRIVAL_M):
                break
            self._next += 1
        if self._next < len(self.tour):
            return towards(frame, self.tour[self._next])
        plan = self._turn(pose, 1.0, _FIRST_TURN_RAD + math.pi) if self.turns else None
        return plan or PathPlan(explore=ExploreStatus(done=True))

    def _turn(self, pose: MapPose, side: float, until: float) -> PathPlan | None:
        """Turn on, None when it turned so far (radians, all turns on the spot together)."""
        if self._yaw is not None and self._turned < until:
            self._turned += abs(math.remainder(pose.yaw - self._yaw, math.tau))
        self._yaw = pose.yaw
        if self._turned >= until:
            self._yaw = self._side = None
            return None
        self._side = math.copysign(_TURN_LEAD_RAD, side) if self._side is None else self._side
        place = MapPoint(pose.north, pose.east)
        return PathPlan(place, pose.height, pose.yaw + self._side, (place,))


def _pose(frame: FrameInput) -> MapPose:
    assert frame.pose is not None
    return frame.pose


def towards(frame: FrameInput, place: Place) -> PathPlan:
    """Return the plan to fly to a place, picture along the flight."""
    pose = _pose(frame)
    height = frame.heights.bounded(frame.heights.desired)
    yaw = pose.yaw
    if math.dist(place, (pose.north, pose.east)) > 1.0:
        yaw = math.atan2(place[1] - pose.east, place[0] - pose.north)
    return PathPlan(MapPoint(*place), height, yaw, (MapPoint(*place),))
