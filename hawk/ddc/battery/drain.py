"""Drain of whole flights: measured from take-off to motors off, and what the last flights say about the next one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from hawk.model.operation import FlightDrain

KEPT_FLIGHTS: Final = 3
"""The worst of the last flights counts: cold, wind and an old battery come back."""
DRAIN_AGE_S: Final = 90 * 86_400.0
"""An older flight says nothing: batteries age, seasons change."""
CLOCK_BACK_S: Final = 86_400.0
"""A computer without a battery-backed clock may start with a time before its last flight, by this at most."""
FASTEST: Final = 100.0 / (4 * 60)
SLOWEST: Final = 100.0 / (60 * 60)
"""A multirotor with a camera empties its battery in 4 to 60 minutes (percent a second); else the gauge is wrong."""
LEAST_S: Final = 60.0
"""A shorter flight is mostly climb and landing, and a gauge counts whole percent; seconds."""
JUMP_PERCENT: Final = 3.0
"""A charge that changes by more between two readings was corrected by the gauge: it is no drain."""
GAP_S: Final = 10.0
"""Two readings farther apart than this are not compared, seconds."""


def known_drain(drains: Sequence[FlightDrain], utc: float) -> float | None:
    """Return the drain to expect, percent a second: the worst of the last flights; None where none can be used."""
    usable = [each.drain for each in drains[-KEPT_FLIGHTS:] if is_usable(each, utc)]
    return max(usable, default=None)


def is_usable(flight: FlightDrain, utc: float) -> bool:
    """Return True for a measurement that is young, long enough and plausible; ``utc`` is now, Unix seconds."""
    is_young = -CLOCK_BACK_S <= utc - flight.at <= DRAIN_AGE_S
    return is_young and flight.seconds >= LEAST_S and SLOWEST <= flight.drain <= FASTEST


class DrainMeter:
    """Measures one flight after the other."""

    def __init__(self) -> None:
        self._last: tuple[float, float] | None = None
        self._seconds = self._percent = 0.0

    def update(
        self, percentage: float | None, now: float, utc: float, *, airborne: bool, armed: bool
    ) -> FlightDrain | None:
        """Take one reading; return the measurement of a flight that has just ended, when it can be used."""
        if airborne and percentage is not None:
            self._take(percentage, now)
        elif not airborne:
            self._last = None
        return None if armed else self._end(utc)

    def _take(self, percentage: float, now: float) -> None:
        if self._last is None:
            self._last = now, percentage
            return
        since, before = self._last
        if now - since < 1.0:
            return
        if now - since <= GAP_S and abs(before - percentage) <= JUMP_PERCENT:
            self._seconds += now - since
            self._percent += before - percentage
        self._last = now, percentage

    def _end(self, utc: float) -> FlightDrain | None:
        seconds, percent = self._seconds, self._percent
        self._seconds = self._percent = 0.0
        self._last = None
        if seconds <= 0.0:
            return None
        found = FlightDrain(percent / seconds, seconds, utc)
        return found if is_usable(found, utc) else None
