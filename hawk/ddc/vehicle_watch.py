"""What changed at the autopilot since the last tick."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum, auto

from hawk.ddc.service_interface import DdcServiceInterface
from hawk.ddc.topic_interface import DdcTopicInterface
from hawk.model import LandedState

LANDED_WAIT_S = 1.5
"""A first heartbeat waits so long for the landed state that goes with it, seconds."""


class VehicleEvent(Enum):
    """Something that the operations manager must answer."""

    FOUND = auto()
    """The autopilot was heard for the first time."""
    LINK_LOST = auto()
    LINK_BACK = auto()
    FOREIGN_MODE = auto()
    """The mode changed and no request of ours asked for it."""


class VehicleWatch:
    """Compares successive states of the autopilot."""

    def __init__(self, topics: DdcTopicInterface, service: DdcServiceInterface, clock: Callable[[], float]) -> None:
        self._topics = topics
        self._service = service
        self._clock = clock
        self._first_heard: float | None = None
        self._found = False
        self._linked = False
        self._mode: int | None = None
        self.mode_changed_at = float("-inf")
        """When the mode last changed, seconds."""

    @property
    def has_link(self) -> bool:
        """Whether the autopilot was found and is heard."""
        return self._found and self._linked

    def observe(self) -> list[VehicleEvent]:
        """Return what happened since the last call, in order."""
        healthy = self._topics.get_link_health().is_healthy
        if not self._found:
            return self._look_for_it(healthy)
        events: list[VehicleEvent] = []
        if healthy != self._linked:
            self._linked = healthy
            events.append(VehicleEvent.LINK_BACK if healthy else VehicleEvent.LINK_LOST)
        if healthy:
            self._watch_mode(events)
        return events

    def _watch_mode(self, events: list[VehicleEvent]) -> None:
        mode = self._topics.get_state().custom_mode
        if mode == self._mode:
            return
        self._mode = mode
        self._service.settle_mode(mode)
        self.mode_changed_at = self._clock()
        if not self._service.asked_for(mode) and VehicleEvent.LINK_BACK not in events:
            events.append(VehicleEvent.FOREIGN_MODE)

    def _look_for_it(self, healthy: bool) -> list[VehicleEvent]:
        if not healthy:
            return []
        now = self._clock()
        if self._first_heard is None:
            self._first_heard = now
        state = self._topics.get_state()
        known = state.landed is not LandedState.UNDEFINED or not state.armed
        if not known and now - self._first_heard < LANDED_WAIT_S:
            return []
        self._found = self._linked = True
        self._mode = state.custom_mode
        return [VehicleEvent.FOUND]
