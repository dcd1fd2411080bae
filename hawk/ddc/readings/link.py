"""The link: whether the autopilot is heard, what changed at it, who else writes to it."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum

from hawk.ddc.readings.belief import Belief
from hawk.ddc.readings.instant import Instant, Reading
from hawk.ddc.readings.topic_interface import DdcTopicInterface
from hawk.ddc.stopwatch import Stopwatch
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
    new_mode: int | None = None
    """The mode that this tick saw first; None while the mode stays."""


KEPT_WRITES = 16
WRITES_S = 30.0
LANDED_WAIT_S = 1.5
"""A first heartbeat waits for the landed state that belongs to it, seconds."""


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


class LinkReading(Reading):
    """Compares successive states of the autopilot: found, lost, heard again, mode changed by someone else, doubted.

    Its events wait until a tick takes them: one that fails loses none. It is asked by `observe` before the instant is
    known, which depends on it.
    """

    def __init__(self, topics: DdcTopicInterface, asked_for: Callable[[int | None], bool]) -> None:
        """``asked_for`` returns True for a mode that a request of ours asked for a moment ago."""
        self._topics = topics
        self._asked_for = asked_for
        self._heard = Stopwatch()
        self._linked: bool | None = None  # None: not found yet
        self._mode: int | None = None
        self._is_doubted = False
        self._events: tuple[VehicleEvent, ...] = ()
        self._new_mode: int | None = None
        self.mode_changed_at = float("-inf")
        """Time of the last change of the mode, seconds."""
        self._writes = ForeignWrites()
        self._stop = topics.vehicle.foreign_write.listen(self._writes.note)

    def close(self) -> None:
        """Stop listening."""
        self._stop()

    @property
    def is_up(self) -> bool:
        """True when the autopilot was found and is heard."""
        return self._linked is True

    @property
    def is_unbroken(self) -> bool:
        """True when it is up, and was not lost since the last tick that took the events."""
        return self.is_up and VehicleEvent.LINK_LOST not in self._events

    def observe(self, belief: Belief, now: float) -> None:
        """Take the state of a tick as it is believed."""
        self._events += self._changes(belief.vehicle, now)
        was_doubted, self._is_doubted = self._is_doubted, self.is_up and bool(belief.ground.lasting_doubt)
        if self._is_doubted and not was_doubted:
            self._events += (VehicleEvent.DOUBTED,)

    def facts(self, instant: Instant, words: str) -> LinkFacts:
        """Return what is known, without events. ``words``: the autopilot's last warning."""
        return LinkFacts(
            is_up=self.is_up,
            age=self._topics.get_link_age(),
            mode_changed_at=self.mode_changed_at,
            words=words,
            second_sender=self._topics.get_second_sender(),
            foreign_writes=self._writes.recent(instant.now),
        )

    def take_events(self, facts: LinkFacts) -> LinkFacts:
        """Return the facts with the events since the last call, in their order, and the mode that was first seen."""
        taken = replace(facts, events=self._events, new_mode=self._new_mode)
        self._events, self._new_mode = (), None
        return taken

    def _changes(self, vehicle: VehicleState, now: float) -> tuple[VehicleEvent, ...]:
        is_heard = self._topics.get_link_health().is_healthy
        if self._linked is None:
            return self._look_for_it(is_heard, vehicle, now)
        events: list[VehicleEvent] = []
        if is_heard != self._linked:
            self._linked = is_heard
            events.append(VehicleEvent.LINK_BACK if is_heard else VehicleEvent.LINK_LOST)
        if is_heard and self._mode_is_foreign(vehicle.custom_mode, now) and VehicleEvent.LINK_BACK not in events:
            events.append(VehicleEvent.FOREIGN_MODE)
        return tuple(events)

    def _mode_is_foreign(self, mode: int | None, now: float) -> bool:
        if mode == self._mode:
            return False
        self._mode = self._new_mode = mode
        self.mode_changed_at = now
        return not self._asked_for(mode)

    def _look_for_it(self, is_heard: bool, vehicle: VehicleState, now: float) -> tuple[VehicleEvent, ...]:
        if not is_heard:
            return ()
        heard_s = self._heard.update(True, now) or 0.0
        known = vehicle.landed is not LandedState.UNDEFINED or not vehicle.armed
        if not known and heard_s < LANDED_WAIT_S:
            return ()
        self._linked = True
        self._mode = vehicle.custom_mode
        return (VehicleEvent.FOUND,)
