"""CommunicationLost: no operator; holds, then returns home."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hawk.ddc.ranks import Rank
from hawk.ddc.states.airborne import AirborneState
from hawk.ddc.states.base import Cause, State
from hawk.ddc.states.holding import Holding
from hawk.ddc.words import seconds
from hawk.model import StateName

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager


class CommunicationLost(AirborneState):
    """Holds for ``operator_hold_s``; nothing resumes by itself when the operator is back."""

    identity = StateName.COMMUNICATION_LOST

    def __init__(self, context: OperationsManager, passive: bool = False) -> None:
        super().__init__(context)
        self._passive = passive
        self.holding = Holding(context, passive=passive)

    @property
    def rank(self) -> Rank:
        """Above fence and task."""
        return Rank.COMMUNICATION_LOST

    @property
    def return_in(self) -> float:
        """Seconds until it returns home."""
        return max(0.0, self.context.settings.operator.operator_hold_s - self.age)

    @property
    def detail(self) -> str:
        """When it returns home."""
        return f"No word from the operator. Returns home in {seconds(self.return_in)}."

    def process(self) -> None:
        """Hold."""
        self.holding.process()

    def _decide(self) -> State:
        if self.context.operator_present:
            return self.context.states.hover("The operator is back.", passive=self._passive)
        if self.return_in <= 0:
            cause = Cause("The operator is lost.", lambda: not self.context.operator_present)
            return self.context.states.return_to_launch(cause)
        return self
