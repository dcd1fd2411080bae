"""Manual: someone else flies; nothing is commanded by itself, everything is shown."""

from __future__ import annotations

from hawk.comm.messages import Resume
from hawk.ddc.ranks import Rank
from hawk.ddc.states.airborne import AirborneState
from hawk.ddc.states.base import Order, State
from hawk.model import StateName


class Manual(AirborneState):
    """Waits until the pilot gives back, or the operator takes the drone with a confirmed command."""

    identity = StateName.MANUAL

    @property
    def rank(self) -> Rank:
        """Nothing automatic acts here."""
        return Rank.PILOT

    @property
    def detail(self) -> str:
        """Which mode the pilot flies."""
        return f"Someone else flies, in {self.context.topics.get_state().mode or 'an unknown mode'}."

    def _follow(self, order: Order) -> State:
        if isinstance(order, Resume):
            return self.context.states.hover("Taken back.")
        return super()._follow(order)
