"""Lays one frame's ground pictures on the map's axes: each is warped exactly once."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.mapper.evidence import EVIDENCE_M
from hawk.algo.mapper.geometry import compose, transform_points
from hawk.algo.mapper.grid import CellEvidence, log_odds
from hawk.algo.mapper.window import Window
from hawk.algo.vision.seen import GroundImage, Seen


def moved(image: GroundImage, correction: NDArray[np.float64]) -> GroundImage:
    """Return the picture with its place corrected by a (2, 3) map-to-map affine."""
    return replace(image, to_map=compose(correction, image.to_map))


def outline(image: GroundImage) -> NDArray[np.float64]:
    """Return the corners (4, 2) of the whole picture on the ground, (north, east) metres."""
    rows, columns = image.valid.shape
    corners = np.array([[0, 0], [columns - 1, 0], [columns - 1, rows - 1], [0, rows - 1]], np.float64)
    return transform_points(image.to_map, corners)


def quality_mask(valid: NDArray[np.bool_], pixel_m: float, edge_m: float, good_share: float) -> NDArray[np.uint8]:
    """Return 0 outside the usable picture, 1 in it, 2 in its good middle.

    ``edge_m`` of the border are not usable; good is what lies in the middle ``good_share`` of the picture each way.
    """
    usable = _eroded(valid.astype(np.uint8), edge_m / pixel_m, edge_m / pixel_m)
    rows = np.flatnonzero(valid.any(1))
    columns = np.flatnonzero(valid.any(0))
    if len(rows) == 0:
        return usable
    trim = (1 - good_share) / 2
    good = _eroded(valid.astype(np.uint8), trim * (rows[-1] - rows[0] + 1), trim * (columns[-1] - columns[0] + 1))
    return np.asarray(usable + (good & usable), dtype=np.uint8)


def lay(seen: Seen, edge_m: float, good_share: float) -> CellEvidence | None:
    """Return the frame's evidence on map cells, None when nothing of the picture is usable."""
    mask = quality_mask(seen.lot.valid, seen.lot.metres_per_pixel, edge_m, good_share)
    if not mask.any():
        return None
    window = Window.around(outline(seen.lot), EVIDENCE_M)
    return CellEvidence(
        window=window,
        lot=log_odds(warp(seen.lot, seen.lot.values, window, cv2.INTER_LINEAR)),
        core=warp(seen.core, seen.core.values, window, cv2.INTER_LINEAR),
        car=warp(seen.car, seen.car.values, window, cv2.INTER_LINEAR),
        mask=warp(seen.lot, mask, window, cv2.INTER_NEAREST),
    )


def warp(image: GroundImage, values: NDArray[Any], window: Window, interpolation: int) -> NDArray[Any]:
    """Return ``values`` (of the geometry of ``image``) on the window's cells, 0 outside the picture."""
    size = (window.columns, window.rows)
    return cv2.warpAffine(values, window.affine(image.to_map), size, flags=interpolation)


def _eroded(mask: NDArray[np.uint8], rows: float, columns: float) -> NDArray[np.uint8]:
    kernel = np.ones((2 * int(np.ceil(rows)) + 1, 2 * int(np.ceil(columns)) + 1), np.uint8)
    return np.asarray(cv2.erode(mask, kernel, borderType=cv2.BORDER_CONSTANT, borderValue=0), dtype=np.uint8)
