"""Autonomous Explore: follows the planner to the most new information until nothing is left to learn."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from hawk.ddc.motion import Goal, RoamingWatch
from hawk.ddc.states.airborne import AirborneState
from hawk.ddc.states.base import State
from hawk.ddc.states.travelling import Travelling
from hawk.ddc.words import direction, metres, sentence
from hawk.model import MapPoint, MapPose, PathPlan, StateName, UserError

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

SETTLE_S = 0.5
"""A plan of a frame that was taken before the state began says nothing about being done."""
NEWS_M = 8.0
NEWS_S = 5.0
"""A new target is told when it lies so far from the last one told, and not more often than this."""


class AutonomousExplore(AirborneState):
    """Goes where the plan says; its height bounded by Min and Max."""

    identity = StateName.AUTONOMOUS_EXPLORE

    def __init__(self, context: OperationsManager) -> None:
        super().__init__(context)
        self._travelling = Travelling(context)
        self._watch = RoamingWatch()
        self._stuck = False
        self._goal: Goal | None = None
        self._lot_seen = context.now
        self._told: tuple[MapPoint, float] | None = None
        self._speed: float | None = None
        self._is_slowed = False

    @property
    def goal(self) -> Goal | None:
        """Where it goes."""
        return self._goal

    @property
    def detail(self) -> str:
        """How much has been seen of what was found so far."""
        plan = self.context.topics.get_path_plan()
        if plan is None:
            return "Waiting for a plan."
        if not plan.explore.lot_known:
            return "Looking for the lot."
        return f"{plan.explore.seen * 100:.0f} % seen of the lot found so far."

    def enter(self) -> None:
        """Begin; the lot was in sight a moment ago."""
        super().enter()
        self._lot_seen = self.context.now

    def process(self) -> None:
        """Follow the plan."""
        if self.context.topics.get_park_lot_detected():
            self._lot_seen = self.context.now
        pose = self.context.topics.get_fresh_pose()
        if pose is None or pose.map is None:
            return
        self._take_plan(self.context.topics.get_path_plan(), pose.map)
        self._stuck = self._watch.is_stuck(pose.map, self.context.now)
        if self._goal is not None:
            self._travelling.process(self._goal, self._speed)

    def _decide(self) -> State:
        plan = self.context.topics.get_path_plan()
        if self.context.now - self._lot_seen > self.context.settings.flight.explore_lost_lot_s:
            self.context.set_user_error(UserError.NO_LOT_DETECTED, "No lot in sight.")
            return self.context.states.hover("No lot in sight for too long.", level="warning")
        if plan is not None and plan.explore.done and self._is_current():
            if not plan.explore.lot_known:
                self.context.set_user_error(UserError.NO_LOT_DETECTED, "No lot was found here.")
                return self.context.states.hover("No lot was found here.", level="warning")
            return self.context.states.hover("Explored. Nothing left to see.", level="ok")
        if self._stuck:
            why = sentence(self._travelling.obstacle) or "The planner gives no way on."
            return self.context.states.hover(f"No progress for 10 s. {why}", level="warning")
        return self

    def _is_current(self) -> bool:
        return self.context.topics.get_path_plan_time() >= self.entered + SETTLE_S

    def _take_plan(self, plan: PathPlan | None, pose: MapPose) -> None:
        if plan is None or plan.target is None:
            return
        heights = self.context.heights
        height = heights.desired if plan.height is None else plan.height
        goal = Goal(
            plan.target.north,
            plan.target.east,
            heights.bounded(height),
            pose.yaw if plan.yaw is None else plan.yaw,
        )
        if goal.is_finite() and math.isfinite(height):
            self._goal = goal
            self._tell(plan.target, pose)
            self._slow_down(plan.speed)

    def _slow_down(self, speed: float | None) -> None:
        """Fly no faster than vision can read; say so once."""
        self._speed = speed
        is_slower = speed is not None and 0 < speed < self.context.settings.flight.speed_m_s
        if is_slower and not self._is_slowed:
            self._is_slowed = True
            self.context.log.add("info", f"Slower, at {speed:.1f} m/s: pictures are read too seldom to fly faster.")

    def _tell(self, target: MapPoint, pose: MapPose) -> None:
        now = self.context.now
        if self._told is not None and (self._told[0].distance(target) < NEWS_M or now - self._told[1] < NEWS_S):
            return
        self._told = (target, now)
        way = pose.point.distance(target)
        if way >= NEWS_M:
            where = direction(target.north - pose.north, target.east - pose.east)
            self.context.log.add("info", f"Next: to the {where}, {metres(way)} away.")
