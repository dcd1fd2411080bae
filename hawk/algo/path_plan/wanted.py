"""What a tour has to show: the field's cells, gathered into fewer and larger ones, without what is not worth a way.

The secret is what counts. Lot that was only seen at a picture's edge counts whole: it is there for sure. Ground that
nobody saw counts the more the likelier it is lot, and not at all when that is unlikely: a tour that went to see every
doubt would never end.
"""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.mapper.window import Window
from hawk.algo.path_plan.field import InformationField
from hawk.algo.path_plan.footprint import Floats, Footprint, Singles

_DOUBT: Final = 0.3  # probability of lot at and below which unseen ground counts nothing
_LEAST_SHARE: Final = 0.1  # of a cell
_GATHERED: Final = 2  # field cells a side
_IS_LOT: Final = 0.5  # share of a cell
_IS_SEEN: Final = 0.5
_OPEN_M: Final = 4.0  # half of a lane

Grid = NDArray[np.float32]


def share_of(
    field: InformationField, footprint: Footprint, least_m2: float, border: float, open_end_m2: float = 0.0
) -> Grid:
    """Return what is to be shown of each cell of a field (0..1). Patches of less than ``least_m2`` are left out.

    ``border`` is the weight of the cells round the lot, whatever they look like. A stretch of unseen ground along known
    lot counts ``open_end_m2`` as a whole, its cells more than 1 each if need be: a lane may lead on there.

    Ground beyond where the drone may be counts as far as a picture taken inside shows it.
    """
    area = field.window.cell_m**2
    likely = np.maximum(field.gain / area - _DOUBT, 0) / (1 - _DOUBT)
    lot = np.maximum(field.lot, border * cv2.dilate(field.lot, np.ones((3, 3), np.uint8)))
    share = np.maximum(likely, lot - np.minimum(lot, field.well)).astype(np.float32)
    share = np.where(_in_sight(field, footprint), share, 0)
    kept = _without_small(share, least_m2 / area)
    return kept if open_end_m2 <= 0 else np.maximum(kept, _open_ends(field, share, open_end_m2 / area))


def gathered(share: Grid, window: Window) -> tuple[Singles, Singles]:
    """Return places (N, 2) of (north, east) and square metres (N,) wanted of the cells of a window, a few of them
    together."""
    rows, columns = (size - size % _GATHERED for size in share.shape)
    whole = share[:rows, :columns].reshape(rows // _GATHERED, _GATHERED, columns // _GATHERED, _GATHERED).sum((1, 3))
    row, column = np.nonzero(whole)
    middle = (_GATHERED - 1) / 2 + 0.5
    north = -(window.row + row * _GATHERED + middle) * window.cell_m
    east = (window.column + column * _GATHERED + middle) * window.cell_m
    return np.column_stack([north, east]).astype(np.float32), (whole[row, column] * window.cell_m**2).astype(np.float32)


def are_allowed(field: InformationField, places: Floats) -> NDArray[np.bool_]:
    """Return for places (T, 2) of (north, east) whether the drone may be there."""
    cells: NDArray[np.intp] = np.round(field.window.cells_of(places[:, 0], places[:, 1])).astype(np.intp)
    within = (cells >= 0) & (cells < (field.window.columns, field.window.rows))
    inside: NDArray[np.bool_] = within[:, 0] & within[:, 1]
    column, row = np.where(inside[:, None], cells, 0).T
    return np.asarray(inside & (field.allowed[row, column] > 0))


def _in_sight(field: InformationField, footprint: Footprint) -> NDArray[np.bool_]:
    """Where a picture taken from an allowed place can show the ground, whatever its heading."""
    if not field.allowed.any():
        return np.zeros(field.allowed.shape, np.bool_)
    away = cv2.distanceTransform(1 - field.allowed, cv2.DIST_L2, 5)
    return np.asarray(away * field.window.cell_m <= min(footprint.width, footprint.depth) / 2)


def _open_ends(field: InformationField, share: Grid, worth: float) -> Grid:
    """Return the cells that nobody saw, along known lot for some metres: ``worth`` whole cells a stretch."""
    known_lot = ((field.lot > _IS_LOT) & (field.seen > _IS_SEEN)).astype(np.uint8)
    beside = cv2.dilate(known_lot, np.ones((3, 3), np.uint8)) > 0
    unseen = np.maximum(field.seen, field.well) <= _IS_SEEN  # what was looked at well may stay unclear for ever
    front = beside & unseen & (share > _LEAST_SHARE)
    _, labels = cv2.connectedComponents(front.astype(np.uint8), connectivity=8)
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    is_open = sizes * field.window.cell_m >= _OPEN_M
    each = np.where(is_open, worth / np.maximum(sizes, 1), 0.0)
    return np.asarray(each[labels], np.float32)


def _without_small(share: Grid, least: float) -> Grid:
    """Leave out patches of less than so many whole cells."""
    _, labels = cv2.connectedComponents((share > _LEAST_SHARE).astype(np.uint8), connectivity=8)
    sums = np.bincount(labels.ravel(), weights=share.ravel())
    sums[0] = 0.0  # what is not wanted
    return np.where(sums[labels] >= least, share, 0).astype(np.float32)
