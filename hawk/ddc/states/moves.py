"""Autonomous Move and Compulsive Move: to a place that the operator chose."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from hawk.ddc.acts import STAY, Acts, Desire, Log, ShowUserError, Step
from hawk.ddc.facts import Facts
from hawk.ddc.motion import Goal, Progress, RouteFollower
from hawk.ddc.orders import MoveOrder, Order, ToHover
from hawk.ddc.readings.topic_interface import VERDICT_AGE_S
from hawk.ddc.settings import DdcSettings
from hawk.ddc.states.base import AirborneState
from hawk.ddc.states.explore import Travelling
from hawk.ddc.words import metres, sentence
from hawk.model.operation import StateName, UserError
from hawk.model.plans import DesiredPose, Inbound, Route
from hawk.model.poses import MapPoint, MapPose
from hawk.model.sentences import joined, say


class MoveState(AirborneState):
    """Flies to the place at the present height, bounded by Min and Max."""

    is_task = is_guarded = stops_at_fence = needs_operator = may_send_targets = True

    def __init__(self, now: float, order: MoveOrder, settings: DdcSettings) -> None:
        super().__init__(now)
        self._travelling = Travelling(settings)
        self._progress = Progress()
        self._stuck = False
        self._arrived = False
        self._order = order
        self._goal = self._aim = self._watched = order.goal

    @property
    def goal(self) -> Goal:
        """The place."""
        return self._goal

    def detail(self, facts: Facts) -> str:
        """Return the distance that is left."""
        place = facts.last_place
        if place is None:
            return say("Moving.")
        return say("Moving, {distance} to go.", distance=metres(self._distance_left(place.point)))

    def process(self, facts: Facts) -> Acts:
        """Lead the drone on."""
        place = facts.place
        if place is not None:
            self._lead(place)
            self._arrived = self._travelling.has_arrived(self._goal, place)
            self._stuck = self._progress.is_stuck(place, self._watched, facts.now)
        return self._travelling.process(facts, self._aim)

    def _lead(self, _: MapPose) -> None:
        """Set the place to lead the drone to (`_aim`), and the goal towards which progress is expected."""
        self._aim = self._watched = self._goal

    def _distance_left(self, place: MapPoint) -> float:
        return place.distance(self._goal.point)

    def _follow(self, facts: Facts, order: Order) -> Step:
        if isinstance(order, MoveOrder) and order.autonomous == self._order.autonomous:
            self._retarget(facts, order)
            return STAY
        return super()._follow(facts, order)

    def _retarget(self, facts: Facts, order: MoveOrder) -> None:
        self._order = order
        self._goal = order.goal
        self._arrived = self._stuck = False

    def _decide(self, facts: Facts) -> Step:
        if self._arrived:
            return Step(ToHover(say("There."), self._goal, level="ok"))
        if self._stuck:
            why = sentence(self._travelling.obstacle)
            return Step(ToHover(joined(say("No progress for 10 s."), why), level="warning"))
        return STAY


class CompulsiveMoveState(MoveState):
    """Straight to any place inside the fence; never depends on vision, map or planner."""

    identity = StateName.COMPULSIVE_MOVE


class AutonomousMoveState(MoveState):
    """To a place inside the lot over known lot, as long as a verdict no older than a second gives a route there."""

    identity = StateName.AUTONOMOUS_MOVE
    sees = True

    def __init__(self, now: float, order: MoveOrder, settings: DdcSettings) -> None:
        super().__init__(now, order, settings)
        self._number = order.number
        self._confirmed = now  # by the verdict that let the move begin
        self._arrival_m = settings.flight.arrival_radius_m
        self._follower = RouteFollower(order.route, self._arrival_m)
        self._asked_again = False

    def route(self, facts: Facts) -> tuple[MapPoint, ...]:
        """Return the rest of the route, from the drone to the place; empty while the position is unknown."""
        place = facts.last_place
        return () if place is None else self._follower.left(place.point)

    def leave(self, facts: Facts) -> Acts:
        """Stop the judging of the place, unless a newer place is judged."""
        desired = facts.sight.desired
        return (Desire(None),) if desired is not None and desired.number == self._number else ()

    def process(self, facts: Facts) -> Acts:
        """Lead the drone on; note when the place was last confirmed."""
        acts = self._keep_desired(facts)
        verdict = facts.verdict(self._number)
        if verdict is not None and facts.is_confirmed_inside(self._number):
            self._confirmed = facts.now
            acts += self._take_route(verdict.route)
        return acts + super().process(facts)

    def _keep_desired(self, facts: Facts) -> Acts:
        """Have the place judged again after another one was judged."""
        desired = facts.sight.desired
        if desired is not None and desired.number != self._number:
            self._confirmed = facts.now  # the planner judges the next place, for a second at most
            return ()
        if desired is not None:
            return ()
        self._number = facts.sight.desired_count + 1
        self._confirmed = facts.now
        self._asked_again = True
        return (Desire(DesiredPose(self._number, self._goal.north, self._goal.east)),)

    def _lead(self, pose: MapPose) -> None:
        aim, corner = self._follower.aim(pose.point), self._follower.heading_for
        self._aim = replace(self._goal, north=aim.north, east=aim.east)
        self._watched = replace(self._goal, north=corner.north, east=corner.east)

    def _distance_left(self, place: MapPoint) -> float:
        return sum(a.distance(b) for a, b in pairwise(self._follower.left(place)))

    def _take_route(self, route: Route) -> Acts:
        """Fly the planner's new route from here on; the same route changes nothing."""
        if not route.points or route == self._follower.route:
            return ()
        was_asked = self._asked_again
        self._follow_from_here(route)
        return () if was_asked else (Log("info", say("The map changed in flight. Another route there was found.")),)

    def _follow_from_here(self, route: Route) -> None:
        self._follower = RouteFollower(route, self._arrival_m)
        self._travelling.restart()
        self._asked_again = False

    def _retarget(self, facts: Facts, order: MoveOrder) -> None:
        super()._retarget(facts, order)
        self._number = order.number
        self._confirmed = facts.now
        self._follow_from_here(order.route)

    def _decide(self, facts: Facts) -> Step:
        verdict = facts.verdict(self._number)
        if verdict is not None and verdict.inbound is Inbound.OUTSIDE:
            return _stop(say("The place turned out to be outside the lot."))
        if verdict is not None and verdict.route.refused:
            return _stop(sentence(say("Held: {refused}", refused=verdict.route.refused)))
        if facts.now - self._confirmed > VERDICT_AGE_S:
            return _stop(say("The place is not confirmed as inside the lot any longer."))
        return super()._decide(facts)


def _stop(text: str) -> Step:
    error = ShowUserError(UserError.DESIRED_LOCATION_OUT_OF_BOUNDS, text)
    return Step(ToHover(text, level="warning"), (error,))
