"""Stalls that rest: rows far from the drone, by squares of ground, so that no frame pays for them."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from hawk.algo.mapper.table import STALL_DTYPE, Rows

SQUARE_M = 64.0

Square = tuple[int, int]


class RestingStalls:
    """Rows of stalls by the square on which they lie."""

    def __init__(self) -> None:
        self._rows: dict[Square, Rows] = {}
        self._touched: dict[Square, int] = {}

    def put(self, rows: Rows) -> None:
        """Lay rows to rest."""
        i, j = (np.floor(rows[name] / SQUARE_M).astype(np.int64) for name in ("north", "east"))
        for square in set(zip(i.tolist(), j.tolist(), strict=True)):
            here = rows[(i == square[0]) & (j == square[1])]
            known = self._rows.get(square)
            self._rows[square] = here.copy() if known is None else np.concatenate([known, here])
            self._touched[square] = max(self._touched.get(square, 0), int(here["touched"].max()))

    def take(self, north: float, east: float, reach: float) -> Rows:
        """Take out all rows of the squares that lie within reach of a place."""
        found = [square for square in squares_about(north, east, reach) if square in self._rows]
        for square in found:
            del self._touched[square]
        return _joined([self._rows.pop(square) for square in found])

    def about(self, north: float, east: float, reach: float) -> Rows:
        """Return all rows of the squares within reach of a place, and perhaps a few more; they go on resting."""
        return _joined([self._rows[s] for s in squares_about(north, east, reach) if s in self._rows])

    def since(self, version: int) -> Iterator[Rows]:
        """Yield the rows of every square in which something was touched after a version."""
        for square, touched in self._touched.items():
            if touched > version:
                yield self._rows[square]

    def all(self) -> Rows:
        """Return every row."""
        return _joined(list(self._rows.values()))


def squares_about(north: float, east: float, reach: float) -> list[Square]:
    """Return the squares that come within reach (metres) of a place."""
    low, high = (math.floor((north + d) / SQUARE_M) for d in (-reach, reach))
    left, right = (math.floor((east + d) / SQUARE_M) for d in (-reach, reach))
    return [
        (i, j)
        for i in range(low, high + 1)
        for j in range(left, right + 1)
        if math.hypot(_beyond(i, north), _beyond(j, east)) <= reach
    ]


def _beyond(index: int, place: float) -> float:
    """Distance along one axis from a place to the square of an index, 0 inside."""
    return max(index * SQUARE_M - place, place - (index + 1) * SQUARE_M, 0.0)


def _joined(parts: list[Rows]) -> Rows:
    return np.concatenate(parts) if parts else np.zeros(0, STALL_DTYPE)
