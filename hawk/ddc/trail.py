"""Where the drone flew, how far and how long."""

from __future__ import annotations

import math
from collections.abc import Callable

from hawk.model import MapPoint, MapPose

STEP_M = 1.0
"""A trail point is kept every so many metres."""
MAXIMUM_POINTS = 10_000
KEEP_S = 0.5
"""Flight time and way are kept every so many seconds: with the journal's own pace less than one is lost."""


class Trail:
    """Points on the ground below the way flown; bounded by leaving out every second point when it grows too long.

    ``keep`` is given flight time (seconds) and way (metres) every KEEP_S in the air, and None after the landing.
    """

    def __init__(self, keep: Callable[[tuple[float, float] | None], None] = lambda _flight: None) -> None:
        self._keep = keep
        self._next_keep = -math.inf
        self._points: list[MapPoint] = []
        self._snapshot: tuple[MapPoint, ...] = ()
        self._took_off: float | None = None
        self._last: MapPose | None = None
        self.identity = 0
        """Changes when the points are not a continuation of the former ones."""
        self.way = 0.0
        """Metres flown since take-off, across the ground."""

    @property
    def points(self) -> tuple[MapPoint, ...]:
        """All points, oldest first."""
        return self._snapshot

    def flight_time(self, now: float) -> float | None:
        """Return seconds since take-off, None on the ground."""
        return None if self._took_off is None else now - self._took_off

    def go_on(self, seconds: float, way: float, now: float) -> None:
        """This flight began ``seconds`` ago, before this program did, and led over ``way`` metres so far."""
        self._took_off, self.way = now - seconds, way

    def update(self, pose: MapPose | None, airborne: bool, now: float) -> None:
        """Take this tick's pose."""
        if not airborne:
            if self._took_off is not None:
                self._keep(None)
            self._took_off = self._last = None
            return
        if self._took_off is None:
            self._took_off, self.way = now, 0.0
            self._next_keep = -math.inf
        self._follow(pose)
        if now >= self._next_keep:
            self._next_keep = now + KEEP_S
            self._keep((now - self._took_off, self.way))

    def _follow(self, pose: MapPose | None) -> None:
        if pose is None or not pose.is_finite():
            return
        if self._last is not None:
            step = math.hypot(pose.north - self._last.north, pose.east - self._last.east)
            if step < STEP_M:
                return
            self.way += step
        self._last = pose
        self._append(pose.point)

    def _append(self, point: MapPoint) -> None:
        self._points.append(point)
        if len(self._points) > MAXIMUM_POINTS:
            self._points = self._points[::2]
            self.identity += 1
        self._snapshot = tuple(self._points)
