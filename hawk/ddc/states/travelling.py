"""Going to a place behind a carrot: what Explore and the Moves do."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from hawk.ddc.geofence import way_is_inside
from hawk.ddc.motion import Carrot, Goal
from hawk.ddc.states.mode_keeper import ModeKeeper
from hawk.model import CopterMode, MapPose

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

OUTSIDE_WAY = "The way there leaves the fence."


class Travelling:
    """Leads the drone towards a goal: GUIDED first, height first when it is outside Min and Max, then across."""

    def __init__(self, context: OperationsManager) -> None:
        self._context = context
        self._guided = ModeKeeper(context, CopterMode.GUIDED)
        self._carrot = Carrot(context.settings.flight.speed_m_s)
        self.obstacle = ""
        """Why the drone is not led on at the moment."""

    def restart(self) -> None:
        """Lead on from where the drone is: the way is another one."""
        self._carrot = Carrot(self._context.settings.flight.speed_m_s)

    def process(self, goal: Goal, speed: float | None = None) -> None:
        """Send this tick's target; ``speed`` (m/s) makes it slower than travel speed, never faster."""
        if not self._guided.reach():
            self.obstacle = self._guided.reason or "Waiting for GUIDED."
            return
        pose = self._context.topics.get_fresh_pose()
        if pose is None or pose.map is None:
            self.obstacle = "The position is too old."
            return
        fence = self._context.fence
        if fence is None or not way_is_inside(fence, pose.map.point, goal.point):
            self.obstacle = OUTSIDE_WAY
            return
        heights = self._context.heights
        target = self._carrot.step(goal, pose.map, self._context.now, heights.minimum, heights.maximum, speed)
        self.obstacle = self._context.send_target(target)

    def has_arrived(self, goal: Goal, pose: MapPose) -> bool:
        """Whether the drone is within the arrival radius, across and in height."""
        radius = self._context.settings.flight.arrival_radius_m
        aside = math.hypot(goal.north - pose.north, goal.east - pose.east)
        return aside <= radius and abs(goal.height - pose.height) <= radius
