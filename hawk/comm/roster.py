"""The systems on the autopilot's link: which one is the copter, and what else gives signs of life there.

A link is shared: antenna trackers, gimbals, companion computers, other vehicles and ground stations send HEARTBEATs on
it. The vehicle is an ArduPilot that flies a copter, by the type in its HEARTBEAT, and nothing else that comes first.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Final

from hawk.comm.mavlink_frames import AUTOPILOT_COMPONENT, Heartbeat
from hawk.comm.vehicle_kinds import GROUND_STATION, kind_words

SHOWN_S: Final = 10.0
"""Real seconds after its last HEARTBEAT for which a system is shown."""


@dataclass(frozen=True, slots=True)
class _Member:
    beat: Heartbeat
    heard: float


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
            self._members[(beat.system, beat.component)] = _Member(beat, now)  # keeps the place of its first one

    def vehicle(self, wanted: int | None, now: float) -> int | None:
        """Return the system id of the copter: ``wanted``, else the first one; None while none is heard."""
        copters = [each.system for each in self._heard(now) if each.is_of_a_copter]
        return next((system for system in copters if wanted in (None, system)), None)

    def names(self, now: float) -> str:
        """Return what is heard, in words; empty when nothing is."""
        return "; ".join(_named(each) for each in self._heard(now))

    def other_vehicles(self, vehicle: int, now: float) -> str:
        """Return the copters that are heard besides the vehicle, in words; empty when there is none."""
        others = (each for each in self._heard(now) if each.is_of_a_copter and each.system != vehicle)
        return "; ".join(_named(each) for each in others)

    def twin(self, now: float) -> str:
        """Return words for a ground station with our own id; empty when there is none."""
        found = (each for each in self._heard(now) if each.system == self._own_id and each.kind == GROUND_STATION)
        return next((f"{_named(each)}, component {each.component}" for each in found), "")

    def _heard(self, now: float) -> list[Heartbeat]:
        with self._lock:
            return [each.beat for each in self._members.values() if now - each.heard <= SHOWN_S]


def _named(beat: Heartbeat) -> str:
    part = "" if beat.component == AUTOPILOT_COMPONENT or beat.kind == GROUND_STATION else f".{beat.component}"
    return f"{kind_words(beat.kind, beat.autopilot)}, system {beat.system}{part}"
