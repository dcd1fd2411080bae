"""The way round a corner, over ground where the drone may be."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from hawk.algo.mapper.window import Window
from hawk.algo.path_plan.field import InformationField, Place

_STEP = 2  # field cells a routing cell
_STEPS_ON = 2
_MOST_STEPS = 128  # routing cells a side

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


def way_round(field: InformationField, place: Place, end: Place) -> Place | None:
    """Return the farthest place (north, east) on the shortest way to ``end`` that is reached straight on.

    None when there is no way, or no place nearer to the end than the drone's own.
    """
    return _way_over(field.passable[::_STEP, ::_STEP], field.window, _STEP, place, end)


def way_over(mask: NDArray[np.uint8], window: Window, place: Place, end: Place) -> Place | None:
    """The same over a mask (1: may be flown over) of any size, in coarser steps the larger it is."""
    step = max(_STEP, -(-max(mask.shape) // _MOST_STEPS))
    rows, columns = (size // step for size in mask.shape)
    whole = mask[: rows * step, : columns * step].reshape(rows, step, columns, step).min((1, 3))
    return _way_over(whole, window, step, place, end)


def _way_over(allowed: NDArray[np.uint8], window: Window, step: int, place: Place, end: Place) -> Place | None:
    cells = np.argwhere(allowed > 0)
    if len(cells) == 0:
        return None
    start, goal = (_nearest(window, step, cells, p) for p in (place, end))
    way, before = _distances(allowed, cells, start)
    if start == goal or not np.isfinite(way[goal]):
        return None
    at = cells[_last_in_sight(allowed, cells, _trace(before, start, goal))]
    north = -(window.row + at[0] * step + 0.5) * window.cell_m
    east = (window.column + at[1] * step + 0.5) * window.cell_m
    return float(north), float(east)


def _nearest(window: Window, step: int, cells: Indices, place: Place) -> int:
    column, row = window.cells_of(np.array(place[0]), np.array(place[1])) / step
    return int(np.argmin(np.hypot(cells[:, 0] - row, cells[:, 1] - column)))


def _distances(allowed: NDArray[np.uint8], cells: Indices, start: int) -> tuple[Floats, Indices]:
    number = np.full(allowed.shape, -1, np.intp)
    number[cells[:, 0], cells[:, 1]] = np.arange(len(cells))
    sources, targets, costs = [], [], []
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
        rows, columns = cells[:, 0] + down, cells[:, 1] + right
        inside = (rows < allowed.shape[0]) & (columns >= 0) & (columns < allowed.shape[1])
        there = np.where(inside, number[np.where(inside, rows, 0), np.where(inside, columns, 0)], -1)
        link = np.flatnonzero(there >= 0)
        sources.append(link)
        targets.append(there[link])
        costs.append(np.full(len(link), np.hypot(down, right)))
    shape = (len(cells), len(cells))
    graph = coo_matrix((np.concatenate(costs), (np.concatenate(sources), np.concatenate(targets))), shape).tocsr()
    way, before = dijkstra(graph, directed=False, indices=start, return_predecessors=True)
    return np.asarray(way), np.asarray(before, dtype=np.intp)


def _trace(before: Indices, start: int, end: int) -> list[int]:
    path = [end]
    while path[-1] != start:
        path.append(int(before[path[-1]]))
    return path[::-1]


def _last_in_sight(allowed: NDArray[np.uint8], cells: Indices, path: list[int]) -> int:
    """Return the last cell of the path that a straight way over allowed cells reaches from its start.

    The drone is not at the middle of its cell: the way always goes on by two cells.
    """
    origin = cells[path[0]]
    for index in reversed(path[_STEPS_ON:]):
        steps = int(np.abs(cells[index] - origin).max())
        line = np.round(np.linspace(origin, cells[index], 2 * steps + 1)).astype(np.intp)
        if allowed[line[:, 0], line[:, 1]].all():
            return index
    return path[min(_STEPS_ON, len(path) - 1)]
