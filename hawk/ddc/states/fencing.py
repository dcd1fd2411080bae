"""Configure, for the fence: keeps the one that the operator drew, or puts it aside."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hawk.ddc.fence_plan import FencePlan
from hawk.ddc.requests import Request
from hawk.ddc.states.base import State
from hawk.model import StateName

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

TIMEOUT_S = 10.0


class ConfigureFence(State):
    """Has the file written off the loop; until then Arm is refused and the old fence counts."""

    identity = StateName.CONFIGURE

    def __init__(self, context: OperationsManager, plan: FencePlan | None) -> None:
        """``plan`` None: the drawn fence is put aside and the configured one counts again."""
        super().__init__(context)
        self._plan = plan
        self._storing: Request | None = None

    @property
    def detail(self) -> str:
        """What is being done."""
        return "Saving the fence."

    def enter(self) -> None:
        """Begin to store."""
        super().enter()
        self._storing = self.context.ask("store fence", self.context.store_fence(self._plan))

    def transition_next_state(self) -> State:
        """Return to Idle when it is stored, or failed, or takes too long."""
        if self._storing is not None and self._storing.has_failed:
            return self._fail("The fence was not saved.", self._storing.reason)
        if self._storing is not None and self._storing.is_done:
            text = "The fence is saved." if self._plan else "The drawn fence was put aside; the standard one counts."
            self.context.log.add("ok", text)
            return self.context.states.idle(text)
        if self.age > TIMEOUT_S:
            return self._fail("Saving the fence took too long.", "")
        return self

    def _fail(self, text: str, details: str) -> State:
        self.context.log.add("error", text, details)
        return self.context.states.idle(text)
