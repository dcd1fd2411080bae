"""The systems on the autopilot's link: which one is the copter, and what else gives signs of life there.

A link is shared: antenna trackers, gimbals, companion computers, other vehicles and ground stations send HEARTBEATs on
it. The vehicle is an ArduPilot that flies a copter, by the type in its HEARTBEAT, and nothing else that comes first.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Final

from hawk.comm.mavlink.frames import AUTOPILOT_COMPONENT, Heartbeat
from hawk.comm.mavlink.vehicle_kinds import GROUND_STATION, kind_words
from hawk.model.sentences import say, semicolons

SHOWN_S: Final = 10.0
"""Real seconds after its last HEARTBEAT for which a system is shown."""


@dataclass(frozen=True, slots=True)
class _Member:
    """The last HEARTBEAT of a component, when it came, and when the first one did."""

    beat: Heartbeat
    heard: float
    first: float


class Roster:
    """The systems on one link by their HEARTBEATs. Callable on every thread; ``now`` is monotonic real seconds."""

    def __init__(self, own_id: int) -> None:
        """``own_id``: our MAVLink system id."""
        self._own_id = own_id
        self._lock = threading.Lock()
        self._members: dict[tuple[int, int], _Member] = {}

    def take(self, beat: Heartbeat, now: float) -> None:
        """Note a HEARTBEAT."""
        with self._lock:
            key = (beat.system, beat.component)
            before = self._members.get(key)
            self._members[key] = _Member(beat, now, now if before is None else before.first)  # keeps its place

    def vehicle(self, wanted: int | None, now: float, wait_s: float = 0.0) -> int | None:
        """Return the system id of the copter: ``wanted``, else the only one that was heard for ``wait_s``; else None.

        Without a time to wait the first one is taken.
        """
        copters = self._copters(now)
        if wanted is not None or not wait_s:
            return next((each.beat.system for each in copters if wanted in (None, each.beat.system)), None)
        is_sure = len(copters) == 1 and now - copters[0].first >= wait_s
        return copters[0].beat.system if is_sure else None

    def several(self, now: float) -> str:
        """Return the copters in words when there are several; else empty."""
        copters = self._copters(now)
        return semicolons(*(_named(each.beat) for each in copters)) if len(copters) > 1 else ""

    def names(self, now: float) -> str:
        """Return what is heard, in words; empty when nothing is."""
        return semicolons(*(_named(each) for each in self._heard(now)))

    def other_vehicles(self, vehicle: int, now: float) -> str:
        """Return the copters that are heard besides the vehicle, in words; empty when there is none."""
        others = (each for each in self._heard(now) if each.is_of_a_copter and each.system != vehicle)
        return semicolons(*(_named(each) for each in others))

    def twin(self, now: float) -> str:
        """Return words for a ground station with our own id; empty when there is none."""
        found = (each for each in self._heard(now) if each.system == self._own_id and each.kind == GROUND_STATION)
        each = next(found, None)
        return (
            "" if each is None else say("{named}, component {component}", named=_named(each), component=each.component)
        )

    def _copters(self, now: float) -> list[_Member]:
        with self._lock:
            members = list(self._members.values())
        return [each for each in members if now - each.heard <= SHOWN_S and each.beat.is_of_a_copter]

    def _heard(self, now: float) -> list[Heartbeat]:
        with self._lock:
            return [each.beat for each in self._members.values() if now - each.heard <= SHOWN_S]


def _named(beat: Heartbeat) -> str:
    kind = kind_words(beat.kind, beat.autopilot)
    if beat.component == AUTOPILOT_COMPONENT or beat.kind == GROUND_STATION:
        return say("{kind}, system {system}", kind=kind, system=beat.system)
    return say("{kind}, system {system}.{component}", kind=kind, system=beat.system, component=beat.component)
