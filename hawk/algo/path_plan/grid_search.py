"""The shortest way over the cells of a mask.

Cells are joined to their eight neighbours, diagonally only where the four cells about the corner are all free, so that
the drone never slips between two that are not. SciPy's Dijkstra does the search; cells that are not connected with the
start never become part of its graph.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

Mask = NDArray[np.uint8]
Indices = NDArray[np.intp]
CellIndex = tuple[int, int]


def shortest_path(mask: Mask, start: CellIndex, goal: CellIndex) -> Indices | None:
    """Return the cells (N, 2) of (row, column) from start to goal, None when they are not connected."""
    labels = _labels(mask)
    if labels[start] == 0 or labels[start] != labels[goal]:
        return None
    connected = labels == labels[start]
    number = np.cumsum(connected, dtype=np.intp).reshape(connected.shape) - 1
    _, before = dijkstra(_graph(connected, number), directed=False, indices=number[start], return_predecessors=True)
    path = [int(number[goal])]
    while path[-1] != number[start]:
        path.append(int(before[path[-1]]))
    return np.argwhere(connected)[path[::-1]]


def is_connected(mask: Mask, start: CellIndex, goal: CellIndex) -> bool:
    """Return whether any way leads from start to goal: far cheaper than the shortest one."""
    labels = _labels(mask)
    return bool(labels[start] != 0 and labels[start] == labels[goal])


def _labels(mask: Mask) -> NDArray[np.int32]:
    return np.asarray(cv2.connectedComponents(mask, connectivity=4)[1])


def _graph(free: NDArray[np.bool_], number: Indices) -> coo_matrix:
    """Return the lengths of the steps between neighbours as a sparse matrix, each pair once."""
    around = free[:-1, :-1] & free[:-1, 1:] & free[1:, :-1] & free[1:, 1:]
    steps = (
        (free[:, :-1] & free[:, 1:], number[:, :-1], number[:, 1:], 1.0),
        (free[:-1] & free[1:], number[:-1], number[1:], 1.0),
        (around, number[:-1, :-1], number[1:, 1:], np.sqrt(2)),
        (around, number[:-1, 1:], number[1:, :-1], np.sqrt(2)),
    )
    sources = np.concatenate([a[there] for there, a, _, _ in steps])
    targets = np.concatenate([b[there] for there, _, b, _ in steps])
    lengths = np.concatenate([np.full(np.count_nonzero(there), length) for there, _, _, length in steps])
    nodes = int(number[-1, -1]) + 1
    return coo_matrix((lengths, (sources, targets)), (nodes, nodes)).tocsr()
