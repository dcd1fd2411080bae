"""Autonomous Explore, and the leading of the drone that it shares with the Moves."""

from __future__ import annotations

import math

from hawk.ddc.acts import STAY, Acts, Log, SendTarget, ShowUserError, Step
from hawk.ddc.facts import Facts
from hawk.ddc.geofence import path_is_inside, path_words
from hawk.ddc.motion import Carrot, Goal, RoamingWatch
from hawk.ddc.orders import ToHover
from hawk.ddc.outline import OutlineFacts, area_words
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import AirborneState, ModeKeeper
from hawk.ddc.words import direction, metres, sentence
from hawk.model.operation import StateName, UserError
from hawk.model.plans import ExploreStatus, PathPlan
from hawk.model.poses import MapPoint, MapPose
from hawk.model.vehicle import CopterMode

SETTLE_S = 0.5
"""A plan of a frame from before the state began cannot say that nothing is left, seconds."""
NEWS_M = 8.0
NEWS_S = 5.0
"""A new target is reported when it is this far from the last one reported, and not more often than this."""
OUTSIDE_PATH = "The way there leaves the fence."


class Travelling:
    """Leads the drone towards a goal: GUIDED first, height first when it is outside Min and Max, then across."""

    def __init__(self, settings: DdcSettings) -> None:
        self._flight = settings.flight
        self._guided = ModeKeeper(CopterMode.GUIDED)
        self._carrot = Carrot(self._flight.speed_m_s)
        self._has_sent = False
        self.obstacle = ""
        """Reason why the drone is not led on at the moment; empty when it is."""

    def restart(self) -> None:
        """Lead on from where the drone is: the path is another one."""
        self._carrot = Carrot(self._flight.speed_m_s)

    @property
    def refusal(self) -> str:
        """The autopilot's words when it refused GUIDED; empty while it did not."""
        has_failed = self._guided.refusals > 0 and not self._guided.is_reached
        return (self._guided.reason or "no answer") if has_failed else ""

    def process(self, facts: Facts, goal: Goal, speed: float | None = None, lowest: float | None = None) -> Acts:
        """Return this tick's target; ``speed`` (m/s) makes it slower than travel speed, never faster.

        Below ``lowest`` (m, Min without one) the drone climbs before it goes across.
        """
        acts = self._guided.reach(facts)
        if not self._guided.is_reached:
            self.obstacle = self._guided.reason or "Waiting for GUIDED."
            return acts
        place, fence, heights = facts.place, facts.limits.fence, facts.limits.heights
        if place is None:
            self.obstacle = "The position is too old."
            return ()
        if fence is None or not path_is_inside(fence, place.point, goal.point):
            self.obstacle = OUTSIDE_PATH if fence is None else f"The way there {path_words(fence)}."
            return ()
        self.obstacle = facts.target_refusal if self._has_sent else ""
        self._has_sent = True
        floor = heights.minimum if lowest is None else lowest
        return (SendTarget(self._carrot.step(goal, place, facts.now, floor, heights.maximum, speed)),)

    def has_arrived(self, goal: Goal, pose: MapPose) -> bool:
        """Return True within the arrival radius, across and in height."""
        radius = self._flight.arrival_radius_m
        aside = math.hypot(goal.north - pose.north, goal.east - pose.east)
        return aside <= radius and abs(goal.height - pose.height) <= radius


def explored_words(explore: ExploreStatus, lot_m2: float) -> str:
    """Return in words what was explored; ``lot_m2`` is the area of the lot found, square metres."""
    if explore.is_whole and not explore.unreached:
        return f"Explored: the lot found is seen whole, {area_words(lot_m2)}. Other ground was not looked at."
    seen = min(explore.seen_share, 0.99)
    return f"Explored: {seen * 100:.0f} % of the lot found is seen, {area_words(lot_m2)}. The rest was not reached."


def outline_words(explore: ExploreStatus, outline: OutlineFacts | None) -> str:
    """Return in words what was seen of an outline, and the size of what was left out and why."""
    unseen, asked = explore.unseen_m2 or 0.0, explore.asked_m2 or 0.0
    words = "Explored: the outline is seen whole." if unseen <= 0.0 else "Explored: the rest cannot be reached."
    parts = [f"{area_words(asked - unseen)} of {area_words(asked)} seen", f"{area_words(unseen)} not reached"]
    words += f" {', '.join(parts)}." if unseen > 0.0 else ""
    if outline is not None and outline.outside >= 1.0:
        words += f" {area_words(outline.outside)} outside the fence were left out."
    return words


class AutonomousExplore(AirborneState):
    """Follows the planner to the most new information until nothing is left; its height bounded by Min and Max."""

    identity = StateName.AUTONOMOUS_EXPLORE
    is_task = sees = is_guarded = stops_at_fence = needs_operator = may_send_targets = True

    def __init__(self, now: float, settings: DdcSettings) -> None:
        super().__init__(now)
        self._flight = settings.flight
        self._travelling = Travelling(settings)
        self._watch = RoamingWatch()
        self._stuck = False
        self._goal: Goal | None = None
        self._lot_seen = now
        self._reported: tuple[MapPoint, float] | None = None
        self._speed: float | None = None
        self._is_slowed = False

    @property
    def goal(self) -> Goal | None:
        """The planner's target."""
        return self._goal

    def route(self, facts: Facts) -> tuple[MapPoint, ...]:
        """Return the planner's path."""
        return () if facts.sight.plan is None else facts.sight.plan.route

    def detail(self, facts: Facts) -> str:
        """Return the share that was seen of the lot found so far."""
        plan = facts.sight.plan
        if plan is None:
            return "Waiting for a plan."
        if plan.explore.asked_m2 is not None:
            return f"{plan.explore.seen * 100:.0f} % seen of the outline."
        if not plan.explore.lot_known:
            return "Looking for the lot."
        return f"{plan.explore.seen * 100:.0f} % seen of the lot found so far."

    def process(self, facts: Facts) -> Acts:
        """Follow the plan."""
        if facts.sight.lot or facts.limits.outline is not None:  # an outline is seen whole, lot or not
            self._lot_seen = facts.now
        place = facts.place
        if place is None:
            return ()
        acts = self._take_plan(facts, place)
        self._stuck = self._watch.is_stuck(place, facts.now)
        if self._goal is None:
            return acts
        return acts + self._travelling.process(facts, self._goal, self._speed)

    def _decide(self, facts: Facts) -> Step:
        plan = facts.sight.plan
        if facts.now - self._lot_seen > self._flight.explore_lost_lot_s:
            error = ShowUserError(UserError.NO_LOT_DETECTED, "No lot in sight.")
            return Step(ToHover("No lot in sight for too long.", level="warning"), (error,))
        if plan is not None and plan.explore.done and facts.sight.plan_time >= self.entered + SETTLE_S:
            if plan.explore.asked_m2 is not None:
                return Step(ToHover(outline_words(plan.explore, facts.limits.outline), level="ok"))
            if plan.explore.lot_known:
                return Step(ToHover(explored_words(plan.explore, facts.sight.lot_area), level="ok"))
            error = ShowUserError(UserError.NO_LOT_DETECTED, "No lot was found here.")
            return Step(ToHover("No lot was found here.", level="warning"), (error,))
        if self._stuck:
            why = sentence(self._travelling.obstacle) or "The planner gives no way on."
            return Step(ToHover(f"No progress for 10 s. {why}", level="warning"))
        return STAY

    def _take_plan(self, facts: Facts, pose: MapPose) -> Acts:
        plan, heights = facts.sight.plan, facts.limits.heights
        if plan is None or plan.target is None:
            return ()
        height = heights.desired if plan.height is None else plan.height
        yaw = pose.yaw if plan.yaw is None else plan.yaw
        goal = Goal(plan.target.north, plan.target.east, heights.bounded(height), yaw)
        if not (goal.is_finite() and math.isfinite(height)):
            return ()
        self._goal = goal
        return self._report(plan.target, pose, facts.now) + self._slow_down(plan)

    def _slow_down(self, plan: PathPlan) -> Acts:
        """Fly no faster than vision can read; report it once."""
        self._speed = speed = plan.speed
        if speed is None or not 0 < speed < self._flight.speed_m_s or self._is_slowed:
            return ()
        self._is_slowed = True
        return (Log("info", f"Slower, at {speed:.1f} m/s: pictures are read too seldom to fly faster."),)

    def _report(self, target: MapPoint, pose: MapPose, now: float) -> Acts:
        last = self._reported
        if last is not None and (last[0].distance(target) < NEWS_M or now - last[1] < NEWS_S):
            return ()
        self._reported = (target, now)
        away = pose.point.distance(target)
        if away < NEWS_M:
            return ()
        where = direction(target.north - pose.north, target.east - pose.east)
        return (Log("info", f"Next: to the {where}, {metres(away)} away."),)
