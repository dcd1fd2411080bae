"""Watches of the senses: which events the link has, which jumps came between two ticks, who else writes."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from enum import StrEnum

from hawk.ddc.readings.topic_interface import DdcTopicInterface
from hawk.ddc.requests.service_interface import DdcServiceInterface
from hawk.model.vehicle import ForeignWrite, LandedState, VehicleState


class VehicleEvent(StrEnum):
    """A change at the autopilot since the last tick."""

    FOUND = "found"
    """The autopilot is heard for the first time."""
    LINK_LOST = "link lost"
    LINK_BACK = "link back"
    FOREIGN_MODE = "foreign mode"
    """The mode changed and no request of ours asked for it."""
    DOUBTED = "doubted"
    """Its words on armed and landed contradict each other or its motion: `GroundFacts.doubt`."""


@dataclass(frozen=True, slots=True)
class LinkFacts:
    """The link to the autopilot. ``is_up``: found, and heard within the limit."""

    is_up: bool = False
    age: float = math.inf
    """Seconds since the last HEARTBEAT."""
    mode_changed_at: float = -math.inf
    events: tuple[VehicleEvent, ...] = ()
    words: str = ""
    """The autopilot's last warning, while it is recent enough to explain what the autopilot does."""
    second_sender: str = ""
    """Words for a sender beside the autopilot, which is not heard; empty while there is none."""
    foreign_writes: tuple[ForeignWrite, ...] = ()
    """Messages by which other stations wrote to the autopilot lately, as far as our link brings them; newest last."""


KEPT_WRITES = 16
WRITES_S = 30.0
LANDED_WAIT_S = 1.5
"""A first heartbeat waits for the landed state that belongs to it, seconds."""


class LinkWatch:
    """Compares successive states of the autopilot: found, lost, heard again, mode changed by someone else."""

    def __init__(self, topics: DdcTopicInterface, service: DdcServiceInterface) -> None:
        self._topics = topics
        self._service = service
        self._first_heard: float | None = None
        self._linked: bool | None = None  # None: not found yet
        self._mode: int | None = None
        self.mode_changed_at = float("-inf")
        """Time of the last change of the mode, seconds."""

    @property
    def is_up(self) -> bool:
        """True when the autopilot was found and is heard."""
        return self._linked is True

    def observe(self, vehicle: VehicleState, now: float) -> tuple[VehicleEvent, ...]:
        """Return the events since the last call, in order. ``vehicle``: the state that is believed."""
        healthy = self._topics.get_link_health().is_healthy
        if self._linked is None:
            return self._look_for_it(healthy, vehicle, now)
        events: list[VehicleEvent] = []
        if healthy != self._linked:
            self._linked = healthy
            events.append(VehicleEvent.LINK_BACK if healthy else VehicleEvent.LINK_LOST)
        if healthy and self._mode_is_foreign(vehicle.custom_mode, now) and VehicleEvent.LINK_BACK not in events:
            events.append(VehicleEvent.FOREIGN_MODE)
        return tuple(events)

    def _mode_is_foreign(self, mode: int | None, now: float) -> bool:
        if mode == self._mode:
            return False
        self._mode = mode
        self._service.settle_mode(mode)
        self.mode_changed_at = now
        return not self._service.asked_for(mode)

    def _look_for_it(self, healthy: bool, vehicle: VehicleState, now: float) -> tuple[VehicleEvent, ...]:
        if not healthy:
            return ()
        if self._first_heard is None:
            self._first_heard = now
        known = vehicle.landed is not LandedState.UNDEFINED or not vehicle.armed
        if not known and now - self._first_heard < LANDED_WAIT_S:
            return ()
        self._linked = True
        self._mode = vehicle.custom_mode
        return (VehicleEvent.FOUND,)


class ForeignWrites:
    """Keeps what other stations wrote to the autopilot lately."""

    def __init__(self) -> None:
        self._writes: deque[ForeignWrite] = deque(maxlen=KEPT_WRITES)

    def note(self, write: ForeignWrite) -> None:
        """Keep one."""
        self._writes.append(write)

    def recent(self, now: float) -> tuple[ForeignWrite, ...]:
        """Return those of the last `WRITES_S` seconds, the newest last."""
        return tuple(write for write in self._writes if now - write.time <= WRITES_S)


class Jumps:
    """Collects the jumps of one kind between two ticks."""

    def __init__(self) -> None:
        self._metres = 0.0

    def note(self, metres: float) -> None:
        """Keep the largest jump."""
        self._metres = max(self._metres, abs(metres))

    def take(self) -> float:
        """Return the largest jump since the last call, metres."""
        taken, self._metres = self._metres, 0.0
        return taken
