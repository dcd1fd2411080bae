"""Corridors between parts of a lot, so that the drone can cross the road that parts them.

The secret is where it crosses: on the shortest straight line from one part to the next that stays inside the fence.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Cells = NDArray[np.uint8]

_WIDE = 3  # cells of a corridor's width: routing looks at every other cell
_CLOSER = 8  # tries at another place when the shortest line leaves the fence


def with_bridges(ground: Cells, fenced: Cells, longest: float) -> Cells:
    """Return the ground (1 where the drone may be) with corridors between its parts.

    ``fenced`` is 1 inside the fence; a gap of more than ``longest`` cells is not bridged.
    """
    count, labels = cv2.connectedComponents(ground, connectivity=8)
    if count <= 2:  # the background counts
        return ground
    bridged = ground.copy()
    reached = labels == 1
    waiting = set(range(2, count))
    while waiting:
        line = _shortest(reached, (labels > 0) & ~reached, fenced, longest)
        if line is None:  # go on from a part that cannot be reached: others may be, from there
            part = waiting.pop()
            reached = labels == part
            continue
        begin, end = line
        cv2.line(bridged, begin, end, (1,), _WIDE)
        part = int(labels[end[1], end[0]])
        waiting.discard(part)
        reached |= labels == part
    return np.asarray(bridged & fenced, np.uint8)


def _shortest(
    reached: NDArray[np.bool_], other: NDArray[np.bool_], fenced: Cells, longest: float
) -> tuple[tuple[int, int], tuple[int, int]] | None:
    """Return the ends (column, row) of the shortest line inside the fence from what is reached to what is not."""
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
    for pick in order[:: max(1, len(order) // _CLOSER)]:
        end = (int(columns[pick]), int(rows[pick]))
        row, column = divmod(int(place_of[nearest[end[1], end[0]]]), reached.shape[1])
        line = np.zeros(fenced.shape, np.uint8)
        cv2.line(line, (column, row), end, (1,), 1)
        if fenced[line > 0].all():
            return (column, row), end
    return None
