"""Which of this frame's stalls is which of the known ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from hawk.algo.vision import quads

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_ACROSS = 0.5  # of the width: half a pitch, beyond it the neighbour is nearer
_ALONG = 0.45  # of the length
_ANGLE = 0.35  # radians
_FAR = 1e3


def pair(
    known: tuple[Floats, Floats, Floats, Floats, Floats], found: tuple[Floats, Floats, Floats]
) -> tuple[Indices, Indices]:
    """Return indices of pairs (known, found), one-to-one, with the least sum of squared distances.

    ``known`` is north, east, angle, width, length; ``found`` north, east, angle. A pair must agree within half a width
    across, 0.45 of the length along, and 20 degrees.
    """
    north, east, angle, width, length = known
    if len(north) == 0 or len(found[0]) == 0:
        none = np.zeros(0, np.intp)
        return none, none
    d_north, d_east = found[0][None] - north[:, None], found[1][None] - east[:, None]
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along = np.abs(d_north * cos + d_east * sin) / length[:, None]
    across = np.abs(d_east * cos - d_north * sin) / width[:, None]
    turn = quads.angle_between(found[2][None], angle[:, None])
    allowed = (across < _ACROSS) & (along < _ALONG) & (turn < _ANGLE)
    cost = (across / _ACROSS) ** 2 + (along / _ALONG) ** 2 + (turn / _ANGLE) ** 2
    rows, columns = np.flatnonzero(allowed.any(1)), np.flatnonzero(allowed.any(0))
    if len(rows) == 0:
        return rows, columns
    cost = np.where(allowed, cost, _FAR)[np.ix_(rows, columns)]
    r, c = linear_sum_assignment(cost)
    good = cost[r, c] < _FAR
    return rows[r[good]], columns[c[good]]
