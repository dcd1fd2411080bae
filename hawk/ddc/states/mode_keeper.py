"""Asking the autopilot for a mode until its heartbeat shows it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hawk.ddc.requests import Request
from hawk.model import CopterMode

if TYPE_CHECKING:
    from hawk.ddc.operations_manager import OperationsManager

RETRY_S = 2.0
"""A mode that was refused, or acknowledged and does not show, is asked for again after so many seconds."""


class ModeKeeper:
    """Asks for one mode, again when it is refused, until it was seen; never afterwards: then somebody else took it."""

    def __init__(self, context: OperationsManager, mode: CopterMode) -> None:
        self._context = context
        self._mode = mode
        self._request: Request | None = None
        self._asked = float("-inf")
        self._reached = False
        self.attempts = 0

    @property
    def reason(self) -> str:
        """The autopilot's words when the last request was refused."""
        return "" if self._request is None else self._request.reason

    def reach(self) -> bool:
        """Ask if it is time to; whether the mode has been seen."""
        if self._reached or self._context.topics.get_state().custom_mode == self._mode:
            self._reached = True
            return True
        waits = self._request is not None and self._request.is_pending
        if not waits and self._context.now - self._asked >= RETRY_S and self._context.has_link:
            self._asked = self._context.now
            self.attempts += 1
            self._request = self._context.ask(f"mode {self._mode.name}", self._context.service.set_mode(self._mode))
        return False
