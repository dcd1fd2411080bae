"""Which stalls of a map stand side by side: the ends of rows, and the rows themselves."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from hawk.algo.rows.fit import Indices, Rectangles
from hawk.algo.vision import quads

_ANGLE: Final = 0.2
_NEIGHBOUR: Final = (0.6, 1.4, 0.25)
"""A neighbour lies between the first and the second width beside a stall, and no more than this length out of line."""


def row_ends(stalls: Rectangles) -> NDArray[np.bool_]:
    """Return which stalls (N,) lack a neighbour on one side of them."""
    has = np.zeros((len(stalls), 2), np.bool_)
    first, _, side = _neighbours(stalls)
    has[first, side] = True
    return np.asarray(~has.all(axis=1))


def row_numbers(stalls: Rectangles) -> Indices:
    """Return the number of the row (N,) that each stall stands in, from 0."""
    first, second, _ = _neighbours(stalls)
    links = coo_matrix((np.ones(len(first)), (first, second)), shape=(len(stalls),) * 2)
    return np.asarray(connected_components(links, directed=False)[1], np.intp)


def _neighbours(stalls: Rectangles) -> tuple[Indices, Indices, Indices]:
    """Return stalls (K,), their neighbours (K,), and on which side of the stall each neighbour is (K,), 0 or 1."""
    if len(stalls) < 2:
        return (np.zeros(0, np.intp),) * 3
    reach = float(stalls.width.max()) * _NEIGHBOUR[1] * 1.5
    pairs = cKDTree(stalls.centres).query_pairs(reach, output_type="ndarray")
    i, j = np.concatenate([pairs, pairs[:, ::-1]]).T
    apart = stalls.centres[j] - stalls.centres[i]
    along = np.column_stack([np.cos(stalls.angle[i]), np.sin(stalls.angle[i])])
    lengthwise = (apart * along).sum(1)
    across = quads.cross(stalls.angle[i], apart)
    least, most, aside = _NEIGHBOUR
    in_line = np.abs(lengthwise) < np.maximum(aside * stalls.length[i], np.abs(across))
    beside = (np.abs(across) > least * stalls.width[i]) & (np.abs(across) < most * stalls.width[i]) & in_line
    alike = quads.angle_between(stalls.angle[i], stalls.angle[j]) < _ANGLE
    is_one = beside & alike
    return i[is_one], j[is_one], (across > 0).astype(np.intp)[is_one]
