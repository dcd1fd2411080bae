"""Configure: stores the travel heights and sets the autopilot's return altitude."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hawk.ddc.requests import Request
from hawk.ddc.states.base import State
from hawk.model import HeightParameters, StateName

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

TIMEOUT_S = 40.0
"""The return altitude takes up to two tries of some real seconds under its two names; simulations run up to 4 times."""


class Configure(State):
    """Writes the parameter file (off the loop), then sets the return altitude to Max and reads it back."""

    identity = StateName.CONFIGURE

    def __init__(self, context: OperationsManager, heights: HeightParameters) -> None:
        super().__init__(context)
        self._heights = heights
        self._storing: Request | None = None
        self._return_altitude: Request | None = None

    @property
    def detail(self) -> str:
        """What is being done."""
        return "Saving the heights."

    def enter(self) -> None:
        """Begin to store."""
        super().enter()
        self._storing = self.context.ask("store heights", self.context.store_heights(self._heights))

    def process(self) -> None:
        """When the heights are stored, take them and set the return altitude."""
        if self._storing is None or not self._storing.is_done or self._return_altitude is not None:
            return
        self.context.use_heights(self._heights)
        if self.context.settings.set_rtl_altitude:
            self._return_altitude = self.context.ask(
                "set return altitude", self.context.service.set_rtl_alt(self._heights.maximum)
            )

    def transition_next_state(self) -> State:
        """Return to Idle when it is done, or failed, or takes too long."""
        if self._storing is not None and self._storing.has_failed:
            return self._fail("The heights were not saved.", self._storing.reason)
        if self._return_altitude is not None and self._return_altitude.has_failed:
            return self._fail("Heights saved, but the return height was not set.", self._return_altitude.reason)
        stored = self._storing is not None and self._storing.is_done
        wanted = self.context.settings.set_rtl_altitude
        if stored and (not wanted or (self._return_altitude is not None and self._return_altitude.is_done)):
            low, travel, high = self._heights.minimum, self._heights.desired, self._heights.maximum
            text = f"Flies at {travel:g} m, never below {low:g} m or above {high:g} m."
            self.context.log.add("ok", text)
            self.context.preflight.reread("RTL_ALT_M", "RTL_ALT")
            return self.context.states.idle(text)
        if self.age > TIMEOUT_S:
            return self._fail("Saving the heights took too long.", "")
        return self

    def _fail(self, text: str, details: str) -> State:
        self.context.log.add("error", text, details)
        return self.context.states.idle(text)
