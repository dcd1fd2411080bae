"""Hover: holds its place and waits for the operator."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hawk.ddc.motion import Goal
from hawk.ddc.ranks import Rank
from hawk.ddc.states.airborne import AirborneState
from hawk.ddc.states.base import State
from hawk.ddc.states.holding import Holding
from hawk.ddc.words import metres
from hawk.model import StateName

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager


class Hover(AirborneState):
    """Holds ``goal``, else the stopping point; ``passive``: taken up from an autopilot that holds already."""

    identity = StateName.HOVER

    def __init__(
        self, context: OperationsManager, reason: str = "", goal: Goal | None = None, passive: bool = False
    ) -> None:
        super().__init__(context)
        self._reason = reason
        self.holding = Holding(context, goal, passive)

    @property
    def rank(self) -> Rank:
        """Of the fence while the drone is on its way back inside."""
        return Rank.FENCE if self.holding.is_recovering else Rank.TASK

    @property
    def detail(self) -> str:
        """Why it holds."""
        if self.holding.is_recovering:
            return "Outside the fence: going back inside."
        height = self.context.topics.get_rel_alt()
        place = "" if height is None else f" at {metres(height)}"
        return f"{self._reason} Holding{place}.".strip()

    def process(self) -> None:
        """Hold."""
        self.holding.process()

    def _decide(self) -> State:
        return self
