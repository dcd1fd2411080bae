"""Cost of the flight home: its path, battery drain as measured, and the moment at which the drone must return."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from hawk.ddc.fence.geometry import path_is_inside
from hawk.ddc.fence.path import length, path_inside
from hawk.ddc.readings.wind import Wind, ground_speed
from hawk.model.operation import FlightDrain
from hawk.model.plans import Fence
from hawk.model.poses import MapPoint

DRAIN_WINDOW_S = 60.0
"""The drain is measured over this time in flight, seconds."""
DRAIN_MINIMUM_S = 20.0
"""With less flight than this the assumed drain is used, seconds."""
ASSUMED_DRAIN = 100.0 / (15 * 60)
"""Drain until it was measured, percent a second: an empty battery after 15 minutes."""
SAFETY_FACTOR = 1.3
"""The flight home against the wind costs more than the flight out."""
LANDING_PERCENT = 5.0
"""A path home that is longer than the straight line is flown only if this is left at its end, percent."""
SLOWEST_M_S = 0.5
"""A drone that the wind holds back counts as this fast: the reserve is then reached at once, away from home."""
CLIMB_M_S = 2.0
DESCENT_M_S = 1.5
FINAL_DESCENT_M_S = 0.5
FINAL_HEIGHT_M = 10.0
"""ArduCopter's landing: WPNAV_SPEED_DN down to LAND_ALT_LOW, LAND_SPEED from there."""


@dataclass(frozen=True, slots=True)
class Reserve:
    """Battery in percent: the charge, the charge needed to come home with the reserve, and seconds until then."""

    percentage: float
    needed: float
    time_left: float
    flight: float = 0.0
    """Charge that the flight home costs, without the reserve; by the path inside the fence where it is longer."""
    seconds_home: float = 0.0
    """Seconds from here until it has landed at home."""
    drain: float = 0.0
    """Percent a second, as the other figures count it."""

    def lasts_beyond(self, out_s: float, back_s: float) -> bool:
        """Return True when the charge lasts for ``out_s`` seconds away, ``back_s`` back here, and the flight home."""
        return self.percentage - self.drain * (out_s + SAFETY_FACTOR * back_s) > self.needed

    @property
    def lasts(self) -> bool:
        """True when the charge lasts for the flight home by the path inside the fence."""
        return self.percentage - self.flight >= LANDING_PERCENT

    @property
    def is_reached(self) -> bool:
        """True when the drone must return."""
        return self.percentage <= self.needed


def seconds_home(distance: float, height: float, return_height: float, speed: float) -> float:
    """Return the seconds to climb to the return height, fly home over ``distance`` metres at ``speed`` and land."""
    top = max(height, return_height)
    final = min(top, FINAL_HEIGHT_M)
    climb = max(0.0, return_height - height) / CLIMB_M_S
    return climb + distance / speed + (top - final) / DESCENT_M_S + final / FINAL_DESCENT_M_S


class DrainReading:
    """Measures the drain in flight: least squares over a window."""

    def __init__(self, reserve_percent: float) -> None:
        self._reserve = reserve_percent
        self._samples: deque[tuple[float, float]] = deque()
        self.measured: float | None = None
        """Percent a second as measured, never below a third of the assumed drain; None until enough was measured."""

    def reset(self) -> None:
        """Forget the samples (another flight, another battery)."""
        self._samples.clear()
        self.measured = None

    def update(self, percentage: float, now: float) -> None:
        """Take one reading in flight, at most one a second is kept."""
        if self._samples and now - self._samples[-1][0] < 1.0:
            return
        self._samples.append((now, percentage))
        while now - self._samples[0][0] > DRAIN_WINDOW_S:
            self._samples.popleft()
        self.measured = self._measure()

    @property
    def drain(self) -> float:
        """Percent a second: as measured, the assumed one until enough was measured, and never below a third of it."""
        return ASSUMED_DRAIN if self.measured is None else self.measured

    def _measure(self) -> float | None:
        if len(self._samples) < 3 or self._samples[-1][0] - self._samples[0][0] < DRAIN_MINIMUM_S:
            return None
        count = len(self._samples)
        mean_t = sum(t for t, _ in self._samples) / count
        spread = sum((t - mean_t) ** 2 for t, _ in self._samples)
        slope = sum((t - mean_t) * p for t, p in self._samples) / spread
        return max(-slope, ASSUMED_DRAIN / 3)

    def reserve(self, percentage: float, distance: float, height: float, return_height: float, speed: float) -> Reserve:
        """Return the charge against the cost of the flight home.

        ``distance`` and heights in metres; ``speed`` over ground on the flight home, m/s.
        """
        home = seconds_home(distance, height, return_height, max(speed, SLOWEST_M_S))
        drain = self.drain
        flight = SAFETY_FACTOR * home * drain
        needed = self._reserve + flight
        return Reserve(percentage, needed, max(0.0, (percentage - needed) / drain), flight, home, drain)


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


LOOK_S = 1.0
"""A path is looked for once in this time, seconds: it costs milliseconds. Its first leg follows the drone."""


class HomePath:
    """Keeps the path home, and looks for it again once a second."""

    def __init__(self) -> None:
        self._of: tuple[Fence, MapPoint] | None = None
        self._path: tuple[MapPoint, ...] | None = None
        self._looked = -math.inf

    def look(self, fence: Fence | None, place: MapPoint, home: MapPoint, now: float) -> tuple[MapPoint, ...]:
        """Return the path from a place home, both ends included; the straight line where none inside is needed.

        A place or home outside the fence has no path inside: the line is straight as well.
        """
        if fence is None or path_is_inside(fence, place, home):
            return (place, home)
        if self._of != (fence, home) or now - self._looked >= LOOK_S:
            self._of, self._looked = (fence, home), now
            self._path = path_inside(fence, place, home)
        return (place, home) if self._path is None else (place, *self._path[1:])


def mean_speed(path: tuple[MapPoint, ...], speed: float, wind: Wind | None) -> float:
    """Return the mean speed over ground along a path, m/s, each leg against its wind.

    A leg that the wind forbids counts as flown at `SLOWEST_M_S`.
    """
    whole = length(path)
    if whole == 0.0:
        return speed
    legs = [(a.distance(b), math.atan2(b.east - a.east, b.north - a.north)) for a, b in pairwise(path)]
    return whole / sum(metres / max(ground_speed(speed, track, wind), SLOWEST_M_S) for metres, track in legs)
