"""Where the drone flew, how far and how long."""

from __future__ import annotations

import math

from hawk.model import MapPoint, MapPose

STEP_M = 1.0
"""A trail point is kept every so many metres."""
MAXIMUM_POINTS = 10_000


class Trail:
    """Points on the ground below the way flown; bounded by leaving out every second point when it grows too long."""

    def __init__(self) -> None:
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

    def update(self, pose: MapPose | None, airborne: bool, now: float) -> None:
        """Take this tick's pose."""
        if not airborne:
            self._took_off = self._last = None
            return
        if self._took_off is None:
            self._took_off, self.way = now, 0.0
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
