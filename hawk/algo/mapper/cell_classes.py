"""Which class each cell shows: the lot's outline from the evidence and the stalls, without flicker.

Asphalt looks alike on roads, roofs and lots. What makes it a lot is stalls: lot evidence is used near grouped stalls,
is closed over trees and islands, and loses what is left over.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from hawk.algo.ground import Window
from hawk.algo.mapper.grid import EvidenceGrid
from hawk.model.lot_map import Cell

_NEAR_M = 9.0  # an aisle's width and a little from a stall
_ANCHOR_M = 8.0
_ANCHORS = 3  # stalls within that, itself counted
CLOSE_M = 8.0
"""Radius over which gaps in the lot are closed: the crowns of trees and the islands between two rows belong to it."""
_OPEN_M = 1.5
_HOLE_M2 = 200.0
_PIECE_M2 = 100.0
_LOOKS = 0.5  # looks from which a cell is seen
_STEP = 2  # evidence cells a working cell

Mask = NDArray[np.uint8]


def classify(grid: EvidenceGrid, window: Window, corners: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return the `Cell` classes (without stalls) of a window of evidence cells.

    ``corners`` (N, 4, 2) are the stalls that count, in the window and around it. The window's rows and columns must be
    even. Pieces that the window's border cuts are judged by what is inside it.
    """
    size = (window.columns // _STEP, window.rows // _STEP)
    seen = grid.layer(window, "looks") >= _LOOKS
    evidence = cv2.resize(grid.layer(window, "lot"), size, interpolation=cv2.INTER_AREA)
    cells = (window.cells_of(corners[..., 0], corners[..., 1]) + 0.5) / _STEP - 0.5
    lot = lot_outline(np.asarray(evidence > 0), cells, window.cell_m * _STEP)
    fine = cv2.resize(lot, (window.columns, window.rows), interpolation=cv2.INTER_NEAREST)
    return np.where(seen, np.where(fine > 0, Cell.LOT, Cell.NON_LOT), Cell.UNKNOWN).astype(np.uint8)


def lot_outline(looks_like_lot: NDArray[np.bool_], corners: NDArray[np.float64], cell_m: float) -> Mask:
    """Return the lot (H, W), 0 or 1, of cells (H, W) that look like one and stalls (N, 4, 2) of (column, row) in them.

    A cell is ``cell_m`` metres a side.
    """
    stalls = np.zeros(looks_like_lot.shape, np.uint8)
    cv2.fillPoly(stalls, list(np.round(corners[_grouped(corners * cell_m)]).astype(np.int32)), [1])
    if not stalls.any():
        return stalls
    near = _distance_to(stalls) * cell_m < _NEAR_M
    lot = (looks_like_lot & near | (stalls > 0)).astype(np.uint8)
    lot = _opened(_closed(lot, CLOSE_M / cell_m), _OPEN_M / cell_m) | stalls
    return _without_pieces(_without_holes(lot, _HOLE_M2 / cell_m**2), stalls, _PIECE_M2 / cell_m**2)


def _grouped(corners: NDArray[np.float64]) -> NDArray[np.bool_]:
    if len(corners) < _ANCHORS:
        return np.zeros(len(corners), np.bool_)
    centre = corners.mean(1)
    distance, _ = cKDTree(centre).query(centre, k=_ANCHORS)
    return np.asarray(distance[:, -1] < _ANCHOR_M)


def _distance_to(mask: Mask) -> NDArray[np.float32]:
    return cv2.distanceTransform(1 - mask, cv2.DIST_L2, 5)  # type: ignore[return-value]


def _closed(mask: Mask, radius: float) -> Mask:
    wide = (_distance_to(mask) <= radius).astype(np.uint8)
    return (cv2.distanceTransform(_padded(wide), cv2.DIST_L2, 5)[1:-1, 1:-1] > radius).astype(np.uint8) | mask


def _opened(mask: Mask, radius: float) -> Mask:
    narrow = (cv2.distanceTransform(_padded(mask), cv2.DIST_L2, 5)[1:-1, 1:-1] > radius).astype(np.uint8)
    if not narrow.any():
        return narrow
    return (_distance_to(narrow) <= radius).astype(np.uint8) & mask


def _padded(mask: Mask) -> Mask:
    return cv2.copyMakeBorder(mask, 1, 1, 1, 1, cv2.BORDER_REPLICATE)  # type: ignore[return-value]


def _without_holes(mask: Mask, most: float) -> Mask:
    _, labels, stats, _ = cv2.connectedComponentsWithStats(1 - mask, connectivity=4)
    small = (stats[:, cv2.CC_STAT_AREA] < most) & ~_at_border(stats, mask.shape)
    small[0] = False
    return np.where(small[labels], 1, mask).astype(np.uint8)


def _without_pieces(mask: Mask, stalls: Mask, least: float) -> Mask:
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=4)
    has_stalls = np.bincount(labels[stalls > 0], minlength=len(stats)) > 0
    keep = has_stalls & ((stats[:, cv2.CC_STAT_AREA] >= least) | _at_border(stats, mask.shape))
    keep[0] = False
    return np.asarray(keep[labels], dtype=np.uint8)


def _at_border(stats: NDArray[Any], shape: tuple[int, ...]) -> NDArray[np.bool_]:
    left, top = stats[:, cv2.CC_STAT_LEFT], stats[:, cv2.CC_STAT_TOP]
    right, bottom = left + stats[:, cv2.CC_STAT_WIDTH], top + stats[:, cv2.CC_STAT_HEIGHT]
    return np.asarray((left == 0) | (top == 0) | (right == shape[1]) | (bottom == shape[0]))
