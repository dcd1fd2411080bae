"""Autonomous Move and Compulsive Move: to a place that the operator chose."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

from hawk.ddc.motion import Goal, ProgressWatch
from hawk.ddc.route_follower import RouteFollower
from hawk.ddc.states.airborne import AirborneState
from hawk.ddc.states.base import MoveOrder, Order, State
from hawk.ddc.states.travelling import Travelling
from hawk.ddc.topic_interface import VERDICT_AGE_S
from hawk.ddc.words import metres, sentence
from hawk.model import Inbound, MapPoint, MapPose, Route, StateName, UserError

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager


class Move(AirborneState):
    """Flies to the place at the present height, bounded by Min and Max."""

    def __init__(self, context: OperationsManager, order: MoveOrder) -> None:
        super().__init__(context)
        self._travelling = Travelling(context)
        self._watch = ProgressWatch()
        self._stuck = False
        self._arrived = False
        self._order_taken = order
        self._goal = self._aim = self._watched = _goal_of(order)

    @property
    def goal(self) -> Goal:
        """Where it goes."""
        return self._goal

    @property
    def detail(self) -> str:
        """How far it still is."""
        pose = self.context.topics.get_pose()
        if pose is None or pose.map is None:
            return "Moving."
        return f"Moving, {metres(self._way_left(pose.map.point))} to go."

    def process(self) -> None:
        """Lead the drone on."""
        pose = self.context.topics.get_fresh_pose()
        if pose is not None and pose.map is not None:
            self._lead(pose.map)
            self._arrived = self._travelling.has_arrived(self._goal, pose.map)
            self._stuck = self._watch.is_stuck(pose.map, self._watched, self.context.now)
        self._travelling.process(self._aim)

    def _lead(self, _: MapPose) -> None:
        """Set where to lead the drone straight (`_aim`), and the goal towards which progress is expected."""
        self._aim = self._watched = self._goal

    def _way_left(self, place: MapPoint) -> float:
        return place.distance(self._goal.point)

    def _follow(self, order: Order) -> State:
        same_kind = isinstance(order, MoveOrder) and order.autonomous == self._order_taken.autonomous
        if isinstance(order, MoveOrder) and same_kind:
            self._retarget(order)
            return self
        return super()._follow(order)

    def _retarget(self, order: MoveOrder) -> None:
        self._order_taken = order
        self._goal = _goal_of(order)
        self._arrived = self._stuck = False

    def _decide(self) -> State:
        if self._arrived:
            return self.context.states.hover("There.", self._goal, level="ok")
        if self._stuck:
            why = sentence(self._travelling.obstacle)
            return self.context.states.hover(f"No progress for 10 s. {why}".strip(), level="warning")
        return self


class CompulsiveMove(Move):
    """Straight to any place inside the fence; never depends on vision, map or planner."""

    identity = StateName.COMPULSIVE_MOVE


class AutonomousMove(Move):
    """To a place inside the lot over known lot, as long as a verdict no older than a second gives a route there."""

    identity = StateName.AUTONOMOUS_MOVE

    def __init__(self, context: OperationsManager, order: MoveOrder) -> None:
        super().__init__(context, order)
        self._number = order.number
        self._confirmed = context.now
        self._follower = RouteFollower(order.route, context.settings.flight.arrival_radius_m)
        self._asked_again = False

    @property
    def route(self) -> tuple[MapPoint, ...]:
        """The way that is left, from the drone to the place; empty while the position is not known."""
        pose = self.context.topics.get_pose()
        return () if pose is None or pose.map is None else self._follower.left(pose.map.point)

    def enter(self) -> None:
        """Begin: the verdict that let it begin counts."""
        super().enter()
        self._confirmed = self.context.now

    def leave(self) -> None:
        """Nothing is desired any longer, unless a newer place was asked for."""
        self.context.forget_desired(self._number)

    def process(self) -> None:
        """Lead the drone on; note when the place was last confirmed."""
        if self.context.is_judging_move:
            self._confirmed = self.context.now  # the planner judges the next place; ours is asked for again after it
        elif self.context.desired_number != self._number:
            self._number = self.context.desire(self._goal.point)
            self._confirmed = self.context.now
            self._asked_again = True
        verdict = self.context.topics.get_verdict(self._number)
        if verdict is not None and verdict.inbound is Inbound.INSIDE and not verdict.route.refused:
            self._confirmed = self.context.now
            self._take_route(verdict.route)
        super().process()

    def _lead(self, pose: MapPose) -> None:
        aim, corner = self._follower.aim(pose.point), self._follower.heading_for
        self._aim = replace(self._goal, north=aim.north, east=aim.east)
        self._watched = replace(self._goal, north=corner.north, east=corner.east)

    def _way_left(self, place: MapPoint) -> float:
        return sum(a.distance(b) for a, b in pairwise(self._follower.left(place)))

    def _take_route(self, route: Route) -> None:
        """Fly the planner's new route from here on; the very one of before changes nothing."""
        if route.points and route != self._follower.route:
            if not self._asked_again:
                self.context.log.add("info", "The map changed on the way. Another way there was found.")
            self._follow_from_here(route)

    def _follow_from_here(self, route: Route) -> None:
        self._follower = RouteFollower(route, self.context.settings.flight.arrival_radius_m)
        self._travelling.restart()
        self._asked_again = False

    def _retarget(self, order: MoveOrder) -> None:
        super()._retarget(order)
        self._number = order.number
        self._confirmed = self.context.now
        self._follow_from_here(order.route)

    def _decide(self) -> State:
        verdict = self.context.topics.get_verdict(self._number)
        if verdict is not None and verdict.inbound is Inbound.OUTSIDE:
            return self._stop("The place turned out to be outside the lot.")
        if verdict is not None and verdict.route.refused:
            return self._stop(sentence(f"Held: {verdict.route.refused}"))
        if self.context.now - self._confirmed > VERDICT_AGE_S:
            return self._stop("The place is not confirmed as inside the lot any longer.")
        return super()._decide()

    def _stop(self, text: str) -> State:
        self.context.set_user_error(UserError.DESIRED_LOCATION_OUT_OF_BOUNDS, text)
        return self.context.states.hover(text, level="warning")


def _goal_of(order: MoveOrder) -> Goal:
    return Goal(order.place.north, order.place.east, order.height, order.yaw)
