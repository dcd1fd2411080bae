"""Autonomous Move and Compulsive Move: to a place that the operator chose."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hawk.ddc.motion import Goal, ProgressWatch
from hawk.ddc.states.airborne import AirborneState
from hawk.ddc.states.base import MoveOrder, Order, State
from hawk.ddc.states.travelling import Travelling
from hawk.ddc.topic_interface import VERDICT_AGE_S
from hawk.ddc.words import metres, sentence
from hawk.model import Inbound, StateName, UserError

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager


class Move(AirborneState):
    """Flies straight to the place at the present height, bounded by Min and Max."""

    def __init__(self, context: OperationsManager, order: MoveOrder) -> None:
        super().__init__(context)
        self._travelling = Travelling(context)
        self._watch = ProgressWatch()
        self._stuck = False
        self._arrived = False
        self._order_taken = order
        self._goal = _goal_of(order)

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
        return f"Moving, {metres(pose.map.point.distance(self._goal.point))} to go."

    def process(self) -> None:
        """Lead the drone on."""
        pose = self.context.topics.get_fresh_pose()
        if pose is not None and pose.map is not None:
            self._arrived = self._travelling.has_arrived(self._goal, pose.map)
            self._stuck = self._watch.is_stuck(pose.map, self._goal, self.context.now)
        self._travelling.process(self._goal)

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
    """To any place inside the fence; never depends on vision, map or planner."""

    identity = StateName.COMPULSIVE_MOVE


class AutonomousMove(Move):
    """To a place inside the lot, as long as a verdict no older than a second says that it is."""

    identity = StateName.AUTONOMOUS_MOVE

    def __init__(self, context: OperationsManager, order: MoveOrder) -> None:
        super().__init__(context, order)
        self._number = order.number
        self._confirmed = context.now

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
        verdict = self.context.topics.get_verdict(self._number)
        if verdict is not None and verdict.inbound is Inbound.INSIDE:
            self._confirmed = self.context.now
        super().process()

    def _retarget(self, order: MoveOrder) -> None:
        super()._retarget(order)
        self._number = order.number
        self._confirmed = self.context.now

    def _decide(self) -> State:
        verdict = self.context.topics.get_verdict(self._number)
        if verdict is not None and verdict.inbound is Inbound.OUTSIDE:
            return self._stop("The place turned out to be outside the lot.")
        if self.context.now - self._confirmed > VERDICT_AGE_S:
            return self._stop("The place is not confirmed as inside the lot any longer.")
        return super()._decide()

    def _stop(self, text: str) -> State:
        self.context.set_user_error(UserError.DESIRED_LOCATION_OUT_OF_BOUNDS, text)
        return self.context.states.hover(text, level="warning")


def _goal_of(order: MoveOrder) -> Goal:
    return Goal(order.place.north, order.place.east, order.height, order.yaw)
