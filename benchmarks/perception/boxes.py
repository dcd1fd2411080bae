"""Stalls as rectangles: the smallest ones around labelled or found quads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Boxes:
    """Smallest rectangles around quads: ``centre`` (N, 2), unit vectors ``across`` and ``along`` (N, 2) of the short
    and the long side, ``width`` and ``length`` (N,), metres.
    """

    centre: Floats
    across: Floats
    along: Floats
    width: Floats
    length: Floats

    @classmethod
    def of(cls, stalls: Floats) -> Boxes:
        """Return the rectangles of quads (N, 4, 2)."""
        if not len(stalls):
            none = np.zeros((0, 2))
            return cls(none, none, none, np.zeros(0), np.zeros(0))
        around = shapely.minimum_rotated_rectangle(shapely.convex_hull(shapely.polygons(stalls)))
        corners = shapely.get_coordinates(around).reshape(-1, 5, 2)
        first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 1]
        long_first = np.hypot(*first.T) > np.hypot(*second.T)
        along = np.where(long_first[:, None], first, second)
        across = np.where(long_first[:, None], second, first)
        length, width = (np.maximum(np.hypot(*side.T), 1e-6) for side in (along, across))
        return cls(corners[:, :4].mean(axis=1), across / width[:, None], along / length[:, None], width, length)
