"""Where the drone may be: the fence as polygon and as cells."""

from __future__ import annotations

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from hawk.algo.mapper.window import Window
from hawk.model import Fence


class FenceGuard:
    """Answers for one fence; None means that there is none yet, and everything is inside."""

    def __init__(self, fence: Fence | None) -> None:
        self.fence = fence
        self._polygon = None
        if fence is not None and len(fence.polygon) >= 3:
            self._polygon = shapely.Polygon(fence.polygon)
            shapely.prepare(self._polygon)

    def contains(self, north: float, east: float) -> bool:
        """Return whether a place is inside."""
        return self._polygon is None or bool(self._polygon.covers(shapely.Point(north, east)))

    def contains_way(self, start: tuple[float, float], end: tuple[float, float]) -> bool:
        """Return whether the whole straight way is inside."""
        return self._polygon is None or bool(self._polygon.covers(shapely.LineString([start, end])))

    def mask(self, window: Window) -> NDArray[np.uint8]:
        """Return 1 where whole cells lie inside, 0 elsewhere; a cell has the same answer in every window."""
        if self.fence is None or self._polygon is None:
            return np.ones(window.shape, np.uint8)
        corners = np.array(self.fence.polygon)
        wider = window.grown(1)  # what lies beyond the window counts too when the cells at the fence are taken away
        cells = np.round(wider.cells_of(corners[:, 0], corners[:, 1]) * 16).astype(np.int32)
        mask = np.zeros(wider.shape, np.uint8)
        cv2.fillPoly(mask, [cells], [1], shift=4)
        return np.asarray(cv2.erode(mask, np.ones((3, 3), np.uint8))[1:-1, 1:-1], dtype=np.uint8)
