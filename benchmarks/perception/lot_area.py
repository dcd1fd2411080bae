"""The lot's area: where the network says lot and stalls in company are near, closed over trees and islands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision import quads
from hawk.algo.vision.seen import FloatArray


@dataclass(frozen=True, slots=True)
class LotOptions:
    """Lengths in metres, areas in square metres.

    A cell belongs to the lot above ``probability`` within ``reach`` of an anchor: a stall with ``company`` stalls
    (itself included) within ``company_reach``. ``close`` and ``open`` are radii of the smoothing; holes smaller than
    ``hole`` are filled, parts smaller than ``part`` or without an anchor dropped.
    """

    probability: float = 0.5
    reach: float = 9.0
    company: int = 3
    company_reach: float = 8.0
    close: float = 5.0
    open: float = 2.0
    hole: float = 150.0
    part: float = 120.0


def lot_area(
    probability: NDArray[np.float32], stalls: FloatArray, cell_m: float, options: LotOptions | None = None
) -> NDArray[np.bool_]:
    """Return the lot's cells (H, W).

    ``probability`` (H, W) of lot, 0..1; ``stalls`` (N, 4, 2) of (column, row) in its cells, ``cell_m`` metres a side
    (0.4 m and more keep it quick).
    """
    options = options or LotOptions()
    anchors = _anchors(probability.shape, stalls, cell_m, options)
    if not anchors.any():
        return np.zeros(probability.shape, np.bool_)
    away = cv2.distanceTransform(1 - anchors, cv2.DIST_L2, 5) * cell_m
    near = ((probability > options.probability) & (away < options.reach)) | (anchors > 0)
    area = _smooth(near.astype(np.uint8), cell_m, options)
    area = _fill_holes(area, options.hole / cell_m**2)
    return _drop_parts(area, anchors, options.part / cell_m**2)


def _anchors(shape: tuple[int, ...], stalls: FloatArray, cell_m: float, options: LotOptions) -> NDArray[np.uint8]:
    drawn = np.zeros(shape, np.uint8)
    if len(stalls):
        centres = stalls.mean(axis=1)
        first, _ = quads.near_pairs(centres, centres, options.company_reach / cell_m)
        in_company = np.bincount(first, minlength=len(stalls)) >= options.company
        cv2.fillPoly(drawn, list(np.rint(stalls[in_company]).astype(np.int32)), (1,))
    return drawn


def _smooth(area: NDArray[np.uint8], cell_m: float, options: LotOptions) -> NDArray[np.uint8]:
    """Close over trees and islands, then open away thin bridges; the raster's edge counts as more of the same."""
    pad = int(1.6 * options.close / cell_m) + 1
    padded = cv2.copyMakeBorder(area, pad, pad, pad, pad, cv2.BORDER_REPLICATE)
    padded = cv2.morphologyEx(padded, cv2.MORPH_CLOSE, _disc(options.close / cell_m))
    padded = cv2.morphologyEx(padded, cv2.MORPH_OPEN, _disc(options.open / cell_m))
    return np.asarray(padded[pad:-pad, pad:-pad], np.uint8)


def _disc(radius: float) -> NDArray[Any]:
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * int(radius) + 1,) * 2))


def _fill_holes(area: NDArray[np.uint8], largest: float) -> NDArray[np.uint8]:
    _, label, stats, _ = cv2.connectedComponentsWithStats(1 - area, connectivity=4)
    left, top, width, height, size = stats.T
    inner = (left > 0) & (top > 0) & (left + width < area.shape[1]) & (top + height < area.shape[0])
    fill = inner & (size < largest)
    fill[0] = False
    return np.asarray(area | fill[label], np.uint8)


def _drop_parts(area: NDArray[np.uint8], anchors: NDArray[np.uint8], smallest: float) -> NDArray[np.bool_]:
    count, label, stats, _ = cv2.connectedComponentsWithStats(area, connectivity=4)
    anchored = np.bincount(label[anchors > 0], minlength=count) > 0
    keep = anchored & (stats[:, cv2.CC_STAT_AREA] >= smallest)
    keep[0] = False
    return np.asarray(keep[label])
