"""Paths over the cells of a mask: the shortest path, lines of sight, and the first corner on the path to a place.

A mask is 1 where the drone may fly. Its cells are joined to their eight neighbours; SciPy's Dijkstra does the search.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from hawk.algo.ground import Bools, Floats, Indices, Mask, Place, Window

_STEPS_ON = 2

CellIndex = tuple[int, int]
"""(row, column)."""


def shortest_path(mask: Mask, start: CellIndex, goal: CellIndex) -> Indices | None:
    """Return the cells (N, 2) of (row, column) from start to goal, None when they are not connected.

    A diagonal step needs all four cells about the corner free: the drone never slips between two that are not.
    """
    labels = _labels(mask)
    if labels[start] == 0 or labels[start] != labels[goal]:
        return None
    connected = labels == labels[start]
    number = _numbered(connected)
    path = _path(_graph(connected, number, cuts_corners=False), int(number[start]), int(number[goal]))
    return None if path is None else np.argwhere(connected)[path]


def is_connected(mask: Mask, start: CellIndex, goal: CellIndex) -> bool:
    """Return True when any path leads from start to goal; far cheaper than the shortest one."""
    labels = _labels(mask)
    return bool(labels[start] != 0 and labels[start] == labels[goal])


def farthest_in_sight(mask: Mask, window: Window, step: int, place: Place, end: Place) -> Place | None:
    """Return the farthest place on the shortest path to ``end`` that a straight line from ``place`` reaches.

    Cells, ends and path are those of `places_on_path`. None when there is no path, or the ends have the same cell.
    """
    cells, path = _cells_on_path(mask, window, step, place, end)
    if path is None:
        return None
    north, east = window.centres(*(cells[_last_in_sight(mask, cells, path)] * step))
    return float(north), float(east)


def places_on_path(mask: Mask, window: Window, step: int, place: Place, end: Place) -> Floats | None:
    """Return the cells' places (N, 2) of (north, east) on the shortest path from ``place`` to ``end``.

    A cell of the mask is ``step`` x ``step`` cells of the window; the nearest ones stand for both places, and a
    diagonal step needs its two cells only. None when there is no path, or the ends have the same cell.
    """
    cells, path = _cells_on_path(mask, window, step, place, end)
    return None if path is None else np.column_stack(window.centres(*(cells[path] * step).T))


def _cells_on_path(mask: Mask, window: Window, step: int, place: Place, end: Place) -> tuple[Indices, list[int] | None]:
    """Return all cells (M, 2) of the mask, and those on the path, from the first on."""
    cells = np.argwhere(mask > 0)
    if len(cells) == 0:
        return cells, None
    start, goal = (_nearest(window, step, cells, p) for p in (place, end))
    free = mask > 0
    path = None if start == goal else _path(_graph(free, _numbered(free), cuts_corners=True), start, goal)
    return cells, path


def cells_touched(window: Window, start: Place, end: Place) -> tuple[Indices, Indices]:
    """Return (rows, columns) of the window's cells on the straight line between two places, also outside the window.

    The line is cut wherever it crosses the border of a row or a column; between two cuts it lies in one cell. Nothing
    is sampled. Through a corner that four cells share it touches two of them only.
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
    """Return True when the straight line touches only cells of the mask."""
    rows, columns = cells_touched(window, start, end)
    inside = (rows >= 0) & (rows < window.rows) & (columns >= 0) & (columns < window.columns)
    return bool(inside.all() and mask[rows, columns].all())


def is_clear_triangle(mask: Mask, window: Window, corners: tuple[Place, Place, Place]) -> bool:
    """Return True when a triangle meets only cells of the mask."""
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


def _labels(mask: Mask) -> NDArray[np.int32]:
    return np.asarray(cv2.connectedComponents(mask, connectivity=4)[1])


def _numbered(free: Bools) -> Indices:
    """Return the numbers of free cells, row by row from 0 on."""
    return np.cumsum(free, dtype=np.intp).reshape(free.shape) - 1


def _graph(free: Bools, number: Indices, *, cuts_corners: bool) -> coo_matrix:
    """Return the lengths of the steps between neighbours as a sparse matrix, each pair once."""
    falling, rising = free[:-1, :-1] & free[1:, 1:], free[:-1, 1:] & free[1:, :-1]
    if not cuts_corners:
        falling = rising = falling & rising
    steps = (
        (free[:, :-1] & free[:, 1:], number[:, :-1], number[:, 1:], 1.0),
        (free[:-1] & free[1:], number[:-1], number[1:], 1.0),
        (falling, number[:-1, :-1], number[1:, 1:], np.sqrt(2)),
        (rising, number[:-1, 1:], number[1:, :-1], np.sqrt(2)),
    )
    sources = np.concatenate([a[there] for there, a, _, _ in steps])
    targets = np.concatenate([b[there] for there, _, b, _ in steps])
    lengths = np.concatenate([np.full(np.count_nonzero(there), length) for there, _, _, length in steps])
    nodes = int(number[-1, -1]) + 1
    return coo_matrix((lengths, (sources, targets)), (nodes, nodes)).tocsr()


def _path(graph: coo_matrix, start: int, goal: int) -> list[int] | None:
    """Return the nodes of the shortest path, None when there is none."""
    lengths, before = dijkstra(graph, directed=False, indices=start, return_predecessors=True)
    if not np.isfinite(lengths[goal]):
        return None
    path = [goal]
    while path[-1] != start:
        path.append(int(before[path[-1]]))
    return path[::-1]


def _nearest(window: Window, step: int, cells: Indices, place: Place) -> int:
    column, row = window.cells_of(np.array(place[0]), np.array(place[1])) / step
    return int(np.argmin(np.hypot(cells[:, 0] - row, cells[:, 1] - column)))


def _last_in_sight(mask: Mask, cells: Indices, path: list[int]) -> int:
    """Return the last cell of the path that a straight line over the mask reaches from its start.

    The drone is not at the middle of its cell: the path always goes on by two cells.
    """
    origin = cells[path[0]]
    for index in reversed(path[_STEPS_ON:]):
        steps = int(np.abs(cells[index] - origin).max())
        line = np.round(np.linspace(origin, cells[index], 2 * steps + 1)).astype(np.intp)
        if mask[line[:, 0], line[:, 1]].all():
            return index
    return path[min(_STEPS_ON, len(path) - 1)]
