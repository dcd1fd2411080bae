"""Idle: disarmed, on the ground; the entry state (TRANS_002)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hawk.comm.messages import Arm
from hawk.ddc.states.base import ConfigureOrder, FenceOrder, State
from hawk.model import StateName

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager


class Idle(State):
    """Waits for Configure or Arm."""

    identity = StateName.IDLE

    def __init__(self, context: OperationsManager, reason: str = "") -> None:
        super().__init__(context)
        self._reason = reason

    @property
    def detail(self) -> str:
        """Why it was entered, else that it is ready."""
        return self._reason or "On the ground."

    def transition_next_state(self) -> State:
        """Follow Configure or Arm."""
        order = self._take_order()
        if isinstance(order, ConfigureOrder):
            return self.context.states.configure(order.heights)
        if isinstance(order, FenceOrder):
            return self.context.states.configure_fence(order.plan)
        if isinstance(order, Arm):
            return self.context.states.arm()
        return self
