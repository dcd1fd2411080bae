"""What the states in the air have in common: the operator's Return To Launch, Land and Hold."""

from __future__ import annotations

from hawk.comm.messages import AutonomousExplore, Hold, Land, ReturnToLaunch
from hawk.ddc.states.base import MoveOrder, Order, State


class AirborneState(State):
    """A state in the air that the operator may end by Hold, Return To Launch or Land."""

    def transition_next_state(self) -> State:
        """Follow an accepted command, else decide by what happens."""
        order = self._take_order()
        if order is not None:
            return self._follow(order)
        return self._decide()

    def _follow(self, order: Order) -> State:
        states = self.context.states
        if isinstance(order, Hold):
            return states.hover("Stopped by you.")
        if isinstance(order, ReturnToLaunch):
            return states.return_to_launch()
        if isinstance(order, Land):
            return states.land()
        if isinstance(order, MoveOrder):
            return states.move(order)
        if isinstance(order, AutonomousExplore):
            return states.explore()
        return self

    def _decide(self) -> State:
        """Return the next state when no command came."""
        return self
