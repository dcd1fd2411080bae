"""Ground beyond the border of known lot that has to be looked at before the border counts as closed.

A lot goes on across a drive, a planted strip, a footpath: ground that was seen, and is none. Its border is closed where
everything out to the next row was looked at: seen at all, and seen well where it looks like lot.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from hawk.algo.ground import Bools, CoarseLayers, Grid, Mask

_IS_SEEN: Final = 0.5  # share of a cell
_LOOKS_ALIKE: Final = 0.5
_ROW_CELLS: Final = 3
"""Least width of ground that may hold a row, cells: a stall is 5 m long."""


@dataclass(frozen=True, slots=True)
class Border:
    """Limits to where a lot may go on: ``ours`` is 1 for ground that belongs to the survey, inside the drawn fence.

    ``reach_m`` is the distance from known lot across other ground, ``alike_reach_m`` from ground that looks like lot.
    ``width_m`` is the least width of ground that holds a row. ``is_flown_to``: the drone may be near ground that looks
    like lot.
    """

    ours: Mask
    reach_m: float
    alike_reach_m: float
    width_m: float
    is_flown_to: bool = True


@dataclass(frozen=True, slots=True)
class Unlooked:
    """Ground of the survey beyond known lot that was not looked at and is wide enough for a row, 1 a cell.

    ``all`` is all of it, ``near`` what lies so near that the lot may go on there. ``ours`` is 1 for ground that belongs
    to the survey, looked at or not.
    """

    all: Mask
    near: Mask
    ours: Mask


def unlooked_at(layers: CoarseLayers, to_lot_m: Grid, to_alike_m: Grid, border: Border) -> Unlooked:
    """Return the ground beyond known lot that was not looked at.

    Args:
        layers: The map's coarse layers.
        to_lot_m: Distance of each cell to known lot, metres; 0 in it.
        to_alike_m: Distance of each cell to ground of `alike_near`, metres.
        border: How far the lot may go on.
    """
    looked_at = np.where(looks_alike(layers), layers.well, np.maximum(layers.seen, layers.well)) >= _IS_SEEN
    unlooked = (to_lot_m > 0) & (border.ours > 0) & ~looked_at
    wide = _wide(unlooked, round(border.width_m / layers.window.cell_m))
    near = (to_lot_m <= border.reach_m) | (to_alike_m <= border.alike_reach_m)
    return Unlooked(wide.astype(np.uint8), (wide & near).astype(np.uint8), border.ours)


def alike_near(layers: CoarseLayers, to_lot_m: Grid, border: Border) -> Bools:
    """Return ground that looks like lot and lies so near to known lot that it may be a part of it: no stalls yet."""
    near = looks_alike(layers) & (to_lot_m <= border.reach_m) & (border.ours > 0)
    return _wide(near, _ROW_CELLS)


def without_patches(ground: Bools, least_cells: float) -> Bools:
    """Return the ground without patches of fewer cells than that."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(ground.astype(np.uint8), connectivity=8)
    is_large = stats[:, cv2.CC_STAT_AREA] >= least_cells
    is_large[0] = False  # no patch
    return np.asarray(is_large[labels])


def _wide(ground: Bools, cells: int) -> Bools:
    """Return the ground without parts that are narrower."""
    kernel = np.ones((cells, cells), np.uint8)
    return np.asarray(cv2.morphologyEx(ground.astype(np.uint8), cv2.MORPH_OPEN, kernel) > 0)


def looks_alike(layers: CoarseLayers) -> Bools:
    """Return ground that looks like lot, with stalls near it or without."""
    return np.asarray(layers.likely > _LOOKS_ALIKE * np.maximum(layers.seen, 0.3))
