"""Which cells a straight way or a cut corner touches: exactly, nothing is sampled, no corner of a cell is missed."""

from __future__ import annotations

import math

import numpy as np
import shapely
from numpy.typing import NDArray

from hawk.algo.mapper.window import Window
from hawk.algo.path_plan.turned import Place

Mask = NDArray[np.uint8]
Indices = NDArray[np.intp]


def cells_touched(window: Window, start: Place, end: Place) -> tuple[Indices, Indices]:
    """Return (rows, columns) of the window's cells on the straight way between two places, also outside the window.

    The way is cut wherever it crosses the border of a row or a column; between two cuts it lies in one cell. Through a
    corner that four cells share it touches two of them only.
    """
    a, b = (np.array([-p[0] / window.cell_m - window.row, p[1] / window.cell_m - window.column]) for p in (start, end))
    cuts = [np.array([0.0, 1.0])]
    for one, other in zip(a.tolist(), b.tolist(), strict=True):
        low, high = min(one, other), max(one, other)
        borders = np.arange(math.ceil(low), math.floor(high) + 1)
        if high > low:
            cuts.append((borders - one) / (other - one))
    share = np.sort(np.clip(np.concatenate(cuts), 0.0, 1.0))
    middles = (share[1:] + share[:-1]) / 2
    rows, columns = np.floor(a[:, None] + middles * (b - a)[:, None]).astype(np.intp)
    return rows, columns


def is_clear(mask: Mask, window: Window, start: Place, end: Place) -> bool:
    """Return whether the straight way touches only cells of the mask (1: may be flown over)."""
    rows, columns = cells_touched(window, start, end)
    inside = (rows >= 0) & (rows < window.rows) & (columns >= 0) & (columns < window.columns)
    return bool(inside.all() and mask[rows, columns].all())


def is_clear_triangle(mask: Mask, window: Window, corners: tuple[Place, Place, Place]) -> bool:
    """Return whether a triangle meets only cells of the mask."""
    points = np.array(corners)
    triangle = np.column_stack(
        [-points[:, 0] / window.cell_m - window.row, points[:, 1] / window.cell_m - window.column]
    )
    top, left = np.floor(triangle.min(0)).astype(np.intp)
    bottom, right = np.floor(triangle.max(0)).astype(np.intp)
    if top < 0 or left < 0 or bottom >= window.rows or right >= window.columns:
        return False
    rows, columns = np.mgrid[top : bottom + 1, left : right + 1]
    cells = shapely.box(rows, columns, rows + 1, columns + 1)
    return bool(mask[rows, columns][shapely.intersects(shapely.Polygon(triangle), cells)].all())
