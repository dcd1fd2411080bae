"""Staying at one place: what Hover and CommunicationLost do."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from hawk.ddc.geofence import RECOVERY_DEPTH_M, WAY_BACK_M, contains, inside_point, last_inside, way_is_inside
from hawk.ddc.motion import Carrot, Goal, distance, maximum_target_distance, stopping_point
from hawk.ddc.states.mode_keeper import ModeKeeper
from hawk.model import CopterMode, Fence, MapPoint, VehiclePose

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

LOW_SHARE = 0.9
"""From this share of Min upwards a drone just below Min holds at Min; lower it brakes where it is."""
GUIDED_ATTEMPTS = 3
"""GUIDED refused so often: no target can be formed, so BRAKE."""


class Holding:
    """Holds a GUIDED target at the stopping point; BRAKE where no target can be formed; never LOITER.

    ``passive``: the state was taken up from the autopilot, which holds already: nothing is sent until the fence must
    be kept.
    """

    def __init__(self, context: OperationsManager, goal: Goal | None = None, passive: bool = False) -> None:
        self._context = context
        self._goal = goal
        self._passive = passive
        self._guided = ModeKeeper(context, CopterMode.GUIDED)
        self._brake: ModeKeeper | None = None
        self._carrot = Carrot(context.settings.flight.speed_m_s)
        self._recovering = False

    @property
    def is_recovering(self) -> bool:
        """Whether the drone is on its way back inside the fence."""
        return self._recovering

    def restart(self) -> None:
        """The position jumped: hold where the drone is by the new one."""
        self._goal = None

    def process(self) -> None:
        """Form the goal if need be and send this tick's target."""
        self._keep_inside()
        if self._passive:
            return
        if self._brake is not None:
            self._brake.reach()
            return
        if self._goal is None and not self._can_form_goal():
            self._brake = ModeKeeper(self._context, CopterMode.BRAKE)
            self._brake.reach()
            return
        if not self._guided.reach():
            if self._guided.attempts > GUIDED_ATTEMPTS:
                self._brake = ModeKeeper(self._context, CopterMode.BRAKE)
            return
        self._send()

    def _keep_inside(self) -> None:
        if not self._context.guard.is_breached:
            self._recovering = False
            return
        pose = self._context.topics.get_fresh_pose()
        fence = self._context.fence
        if self._recovering or pose is None or pose.map is None or fence is None:
            return
        place = inside_point(fence, pose.map.point)
        height = min(pose.map.height, fence.ceiling - RECOVERY_DEPTH_M)
        self._goal = Goal(place.north, place.east, height, pose.map.yaw)
        self._passive = False
        self._brake = None
        self._guided = ModeKeeper(self._context, CopterMode.GUIDED)
        self._recovering = True

    def _can_form_goal(self) -> bool:
        pose = self._context.topics.get_fresh_pose()
        if pose is None or pose.map is None or self._context.fence is None:
            return False
        return pose.map.height >= LOW_SHARE * self._context.heights.minimum

    def _send(self) -> None:
        pose = self._context.topics.get_fresh_pose()
        if pose is None or pose.map is None:
            return
        if self._goal is None:
            self._goal = self._form_goal(pose)
        if self._goal is None:
            return
        near = distance(pose.map, self._goal) <= maximum_target_distance(self._context.settings.flight.speed_m_s)
        if near and pose.map.height >= LOW_SHARE * self._context.heights.minimum:
            target = self._goal
        else:
            target = self._carrot.step(
                self._goal, pose.map, self._context.now, self._context.heights.minimum, self._context.ceiling
            )
        self._context.send_target(target)

    def _form_goal(self, pose: VehiclePose) -> Goal | None:
        goal = stopping_point(pose)
        fence = self._context.fence
        if goal is None or fence is None or pose.map is None:
            return None
        place = _reachable(fence, pose.map.point, goal.point)
        goal = replace(goal, north=place.north, east=place.east)
        highest = max(self._context.heights.maximum, math.floor(pose.map.height))
        height = min(max(goal.height, self._context.heights.minimum), highest, fence.ceiling)
        return replace(goal, height=height)


def _reachable(fence: Fence, start: MapPoint, stop: MapPoint) -> MapPoint:
    """Return the stopping point, or what is nearest to it inside the fence on this side of its edge."""
    inside = stop if contains(fence, stop) else inside_point(fence, stop, WAY_BACK_M)
    if not contains(fence, start) or way_is_inside(fence, start, inside):
        return inside
    return last_inside(fence, start, stop)
