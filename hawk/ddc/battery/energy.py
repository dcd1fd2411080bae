"""Cost of the flight home: battery drain as measured, and the moment at which the drone must return."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

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


class BatteryWatch:
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
        return Reserve(percentage, needed, max(0.0, (percentage - needed) / drain), flight)
