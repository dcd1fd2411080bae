"""Autonomous Explore, and the leading of the drone that it shares with the Moves."""

from __future__ import annotations

import math
from typing import Final

from hawk.ddc.acts import STAY, Acts, EndLots, Log, SendTarget, ShowUserError, Step
from hawk.ddc.battery.energy import SLOWEST_M_S
from hawk.ddc.facts import Facts
from hawk.ddc.fence.geometry import path_is_inside, path_words
from hawk.ddc.fence.outline import OutlineFacts, area_words
from hawk.ddc.motion import Carrot, Goal, Roaming
from hawk.ddc.orders import Cause, CauseKind, ToHover, ToReturn
from hawk.ddc.readings.wind import ground_speed
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import AirborneState, ModeKeeper
from hawk.ddc.words import direction, metres, sentence
from hawk.model.operation import StateName, UserError
from hawk.model.plans import ExploreStatus, LeftOut, PathPlan
from hawk.model.poses import MapPoint, MapPose
from hawk.model.sentences import joined, say
from hawk.model.vehicle import CopterMode

SETTLE_S = 0.5
"""A plan of a frame from before the state began cannot say that nothing is left, seconds."""
NEWS_M = 8.0
NEWS_S = 5.0
"""A new target is reported when it is this far from the last one reported, and not more often than this."""


class Travelling:
    """Leads the drone towards a goal: GUIDED first, height first when it is outside Min and Max, then across."""

    def __init__(self, settings: DdcSettings) -> None:
        self._flight = settings.flight
        self._guided = ModeKeeper(CopterMode.GUIDED)
        self._carrot = Carrot(self._flight.speed_m_s)
        self._has_sent = False
        self.obstacle = ""
        """Reason why the drone is not led on at the moment; empty when it is."""
        self.is_path_barred = False
        """The reason is the fence, or a zone in it."""

    def restart(self) -> None:
        """Lead on from where the drone is: the path is another one."""
        self._carrot = Carrot(self._flight.speed_m_s)

    @property
    def refusal(self) -> str:
        """The autopilot's words when it refused GUIDED; empty while it did not."""
        has_failed = self._guided.refusals > 0 and not self._guided.is_reached
        return (self._guided.reason or say("no answer")) if has_failed else ""

    def process(self, facts: Facts, goal: Goal, speed: float | None = None, lowest: float | None = None) -> Acts:
        """Return this tick's target; ``speed`` (m/s) makes it slower than travel speed, never faster.

        Below ``lowest`` (m, Min without one) the drone climbs before it goes across.
        """
        acts = self._guided.reach(facts)
        self.is_path_barred = False
        if not self._guided.is_reached:
            self.obstacle = self._guided.reason or say("Waiting for GUIDED.")
            return acts
        place, fence, heights = facts.place, facts.limits.fence, facts.limits.heights
        if place is None:
            self.obstacle = say("The drone's position is too old.")
            return ()
        if fence is None or not path_is_inside(fence, place.point, goal.point):
            self.is_path_barred = True
            what = say("leaves the fence") if fence is None else path_words(fence)
            self.obstacle = say("The path there {what}.", what=what)
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


_STALL_M2: Final = 15.0  # less was left out of every lot: its border is not known to the metre


def explored_words(explore: ExploreStatus, lot_m2: float) -> str:
    """Return in words what was explored: ``lot_m2`` square metres of lot found, the share seen, what was left out."""
    left = left_out_words(explore.left_out or LeftOut())
    share, area = 100 * min(explore.seen_share, 0.99), area_words(lot_m2)
    if explore.is_whole and not explore.unreached:
        share = 100 * explore.seen_share
        whole = say("Explored: the lot found is seen whole, {seen:.0f} % of {area}.", seen=share, area=area)
        return joined(whole, left or say("Ground outside the fence was not looked at."))
    seen = say("Explored: {seen:.0f} % of the lot found is seen, {area}.", seen=share, area=area)
    return joined(seen, left or say("The rest was not reached."))


def left_out_words(left: LeftOut) -> str:
    """Return in words what was left out and why, each from a stall's area on; empty when nothing was."""
    outside, hidden, given_up, beside = map(
        area_words, (left.outside_m2, left.hidden_m2, left.given_up_m2, left.beside_m2)
    )
    words = (
        (left.outside_m2, say("{area} of it outside the fence were left out.", area=outside)),
        (left.hidden_m2, say("No picture from inside the fence shows {area} of it.", area=hidden)),
        (left.given_up_m2, say("{area} were given up: pictures showed nothing new there.", area=given_up)),
        (left.beside_m2, say("{area} beside it were not looked at: the lot may go on there.", area=beside)),
    )
    return joined(*(text for area, text in words if area >= _STALL_M2))


def outline_words(explore: ExploreStatus, outline: OutlineFacts | None) -> str:
    """Return in words what was seen of an outline, and the size of what was left out and why."""
    unseen, asked = explore.unseen_m2 or 0.0, explore.asked_m2 or 0.0
    words: str = say("Explored: the outline is seen whole.")
    if unseen > 0.0:
        seen = say(
            "{seen} of {asked} seen, {unseen} not reached.",
            seen=area_words(asked - unseen),
            asked=area_words(asked),
            unseen=area_words(unseen),
        )
        words = joined(say("Explored: the rest cannot be reached."), seen)
    if outline is None or outline.outside < 1.0:
        return words
    return joined(words, say("{area} outside the fence were left out.", area=area_words(outline.outside)))


def again_words(explore: ExploreStatus, suggested: int) -> str:
    """Return in words which stalls of known lots were looked at once more, and how many are ``suggested`` besides."""
    if not suggested:
        return _looked_at(explore)
    beside = say(
        "{count} suggested stalls are not in the plan: look at its changes after the landing.", count=suggested
    )
    return joined(_looked_at(explore), beside)


def _looked_at(explore: ExploreStatus) -> str:
    if explore.seen >= 1.0 and len(explore.lots) > 1:
        return say("Surveyed again: every stall in the plans of {count} lots was looked at.", count=len(explore.lots))
    if explore.seen >= 1.0:
        return say("Surveyed again: every stall of the plan was looked at.")
    return say("Surveyed again: {seen:.0f} % of the stalls were looked at, the rest was not reached.",
               seen=math.floor(explore.seen * 100))  # fmt: skip


def lots_over(explore: ExploreStatus, round_: OutlineFacts | None) -> Acts:
    """Return the acts that end the lots with which the flight is done; one alone is reported by the end of Explore."""
    seen = {look.lot: look.seen for look in explore.lots if look.is_over}
    lots = () if round_ is None else round_.lots
    ended = [lot for lot in lots if lot.id in seen and not lot.is_over]
    if not ended:
        return ()
    said = tuple(Log("ok", lot_words(lot.name, seen[lot.id])) for lot in ended if len(lots) > 1)
    return EndLots(tuple(lot.id for lot in ended)), *said


def lot_words(name: str, seen: float) -> str:
    """Return in words what was looked at of one lot of several; ``seen`` is the share of its stalls, 0 to 1."""
    if seen >= 1.0:
        return say("{name}: every stall of the plan was looked at.", name=name)
    return say("{name}: {seen:.0f} % of the stalls were looked at, the rest was not reached.",
               name=name, seen=math.floor(seen * 100))  # fmt: skip


class AutonomousExploreState(AirborneState):
    """Follows the planner to the most new information until nothing is left; its height bounded by Min and Max."""

    identity = StateName.AUTONOMOUS_EXPLORE
    is_task = sees = is_guarded = stops_at_fence = needs_operator = may_send_targets = True

    def __init__(self, now: float, settings: DdcSettings) -> None:
        super().__init__(now)
        self._flight = settings.flight
        self._travelling = Travelling(settings)
        self._roaming = Roaming()
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
            return say("Waiting for a plan.")
        if plan.explore.asked_m2 is not None:
            return say("{seen:.0f} % seen of the outline.", seen=plan.explore.seen * 100)
        if facts.limits.outline is not None and facts.limits.outline.lots:
            return say("{seen:.0f} % of the stalls looked at.", seen=plan.explore.seen * 100)
        if not plan.explore.lot_known:
            return say("Looking for the lot.")
        return say("{seen:.0f} % seen of the lot found so far.", seen=plan.explore.seen * 100)

    def process(self, facts: Facts) -> Acts:
        """Follow the plan."""
        if facts.sight.lot or facts.limits.outline is not None:  # an outline is seen whole, lot or not
            self._lot_seen = facts.now
        place = facts.place
        if place is None:
            return ()
        ended = () if facts.sight.plan is None else lots_over(facts.sight.plan.explore, facts.limits.outline)
        acts = (*ended, *self._take_plan(facts, place))
        self._stuck = self._roaming.is_stuck(place, facts.now)
        if self._goal is None:
            return acts
        return acts + self._travelling.process(facts, self._goal, self._speed)

    def _decide(self, facts: Facts) -> Step:
        plan = facts.sight.plan
        if facts.now - self._lot_seen > self._flight.explore_lost_lot_s:
            error = ShowUserError(UserError.NO_LOT_DETECTED, say("No lot in sight."))
            return Step(ToHover(say("No lot in sight for too long."), level="warning"), (error,))
        if plan is not None and plan.explore.done and facts.sight.plan_time >= self.entered + SETTLE_S:
            if plan.explore.asked_m2 is not None:
                return Step(ToHover(outline_words(plan.explore, facts.limits.outline), level="ok"))
            if facts.limits.outline is not None and facts.limits.outline.lots:
                return Step(ToHover(again_words(plan.explore, facts.sight.counts.suggested), level="ok"))
            if plan.explore.lot_known:
                return Step(ToHover(explored_words(plan.explore, facts.sight.lot_area), level="ok"))
            error = ShowUserError(UserError.NO_LOT_DETECTED, say("No lot was found here."))
            return Step(ToHover(say("No lot was found here."), level="warning"), (error,))
        if plan is not None and self._is_next_lot_too_far(plan, facts):
            words = say(
                "The battery does not last for the {path} to the next lot and back.", path=metres(plan.explore.path_m)
            )
            return Step(ToReturn(Cause(words, CauseKind.RESERVE)))
        if self._stuck:
            why = sentence(self._travelling.obstacle) or say("The planner gives no further path.")
            return Step(ToHover(joined(say("No progress for 10 s."), why), level="warning"))
        return STAY

    def _is_next_lot_too_far(self, plan: PathPlan, facts: Facts) -> bool:
        """Return True when the charge does not last for the path to the next lot, back here, and home."""
        reserve, place = facts.battery.reserve, facts.place
        if not plan.explore.path_m or plan.target is None or reserve is None or place is None:
            return False
        track = math.atan2(plan.target.east - place.east, plan.target.north - place.north)
        out, back = (
            plan.explore.path_m / max(ground_speed(self._flight.speed_m_s, each, facts.wind.estimate), SLOWEST_M_S)
            for each in (track, track + math.pi)
        )
        return not reserve.lasts_beyond(out, back)

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
        words = say("Slower, at {speed:.1f} m/s: pictures are read too seldom to fly faster.", speed=speed)
        return (Log("info", words),)

    def _report(self, target: MapPoint, pose: MapPose, now: float) -> Acts:
        last = self._reported
        if last is not None and (last[0].distance(target) < NEWS_M or now - last[1] < NEWS_S):
            return ()
        self._reported = (target, now)
        away = pose.point.distance(target)
        if away < NEWS_M:
            return ()
        where = direction(target.north - pose.north, target.east - pose.east)
        return (Log("info", say("Next: to the {where}, {away} away.", where=where, away=metres(away))),)
