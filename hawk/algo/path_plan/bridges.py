"""Corridors between parts of a lot, so that the drone can cross the road that parts them, inside the fence."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np

from hawk.algo.ground import Bools, Mask
from hawk.algo.path_plan.lot_ground import without_border

_BRIDGE_CELLS: Final = 3  # width of a corridor: routing looks at every other cell
_BRIDGE_TRIES: Final = 8  # at other places when the shortest line leaves the fence
_NEIGHBOURS: Final = np.ones((3, 3), np.uint8)

Cell = tuple[int, int]
"""Column and row."""


def with_bridges(ground: Mask, fenced: Mask, longest: float) -> Mask:
    """Return the ground with corridors between its parts, so that the drone can cross the road that parts them.

    A corridor is the shortest straight line from one part to the next inside the fence (1 in ``fenced``), or else the
    shortest path around what lies outside, of ``longest`` cells at most. ``ground`` is 1 where the drone may be.
    """
    count, labels = cv2.connectedComponents(ground, connectivity=8)
    if count <= 2:  # the background is one of them
        return ground
    bridged = ground.copy()
    reached = labels == 1
    waiting = set(range(2, count))
    while waiting:
        other = (labels > 0) & ~reached
        line = _shortest(reached, other, fenced, longest) or _around(reached, other, fenced, longest)
        if line is None:  # go on from a part that cannot be reached: others may be, from there
            part = waiting.pop()
            reached = labels == part
            continue
        cv2.polylines(bridged, [np.array(line, np.int32)], False, (1,), _BRIDGE_CELLS)
        end = line[-1]
        part = int(labels[end[1], end[0]])
        waiting.discard(part)
        reached |= labels == part
    return np.asarray(bridged & fenced, np.uint8)


def _shortest(reached: Bools, other: Bools, fenced: Mask, longest: float) -> list[Cell] | None:
    """Return the ends of the shortest line inside the fence from reached cells to others."""
    away, nearest = cv2.distanceTransformWithLabels(
        (~reached).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    rows, columns = np.nonzero(other)
    if len(rows) == 0:
        return None
    place_of = np.zeros(int(nearest.max()) + 1, np.intp)
    place_of[nearest[reached]] = np.flatnonzero(reached)
    order = np.argsort(away[rows, columns], kind="stable")
    order = order[away[rows, columns][order] <= longest]
    for pick in order[:: max(1, len(order) // _BRIDGE_TRIES)]:
        end = (int(columns[pick]), int(rows[pick]))
        row, column = divmod(int(place_of[nearest[end[1], end[0]]]), reached.shape[1])
        line = np.zeros(fenced.shape, np.uint8)
        cv2.line(line, (column, row), end, (1,), 1)
        if fenced[line > 0].all():
            return [(column, row), end]
    return None


def _around(reached: Bools, other: Bools, fenced: Mask, longest: float) -> list[Cell] | None:
    """Return the cells of the shortest path inside the fence from reached cells to others.

    The path keeps a cell from what lies outside, so that the whole width of the corridor is inside.
    """
    free = (without_border(fenced) > 0) | reached | other
    waves = [reached]
    while len(waves) <= longest and not (waves[-1] & other).any():
        wave = np.asarray(cv2.dilate(waves[-1].astype(np.uint8), _NEIGHBOURS) > 0) & free
        if (wave == waves[-1]).all():
            return None
        waves.append(wave)
    met = np.argwhere(waves[-1] & other)
    if len(met) == 0:
        return None
    row, column = (int(value) for value in met[0])
    path = [(column, row)]
    for wave in reversed(waves[:-1]):  # a cell of a wave has a neighbour in the one before
        row, column = _neighbour(wave, row, column)
        path.append((column, row))
    return path[::-1]


def _neighbour(wave: Bools, row: int, column: int) -> tuple[int, int]:
    """Return the cell itself, or a neighbour of it, that is in the wave."""
    top, left = max(row - 1, 0), max(column - 1, 0)
    near = np.argwhere(wave[top : row + 2, left : column + 2]) + np.array([top, left])
    nearest = near[int(np.argmin(np.abs(near - (row, column)).sum(1)))]
    return int(nearest[0]), int(nearest[1])
