"""Ground that an operator asked to survey, as cells: it stands in for the lot that vision would have to find first.

Inside it every cell is wanted until half of it was seen well, whatever it looks like. Outside it nothing is wanted. It
says what is worth seeing and never where the drone may be: the fence alone decides that.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from hawk.algo.ground import COARSE_M, CoarseLayers, Floats, LotMap, Mask, Place, Window
from hawk.model.limits import AskedGround
from hawk.model.poses import Ring

LOOKED_AT: Final = 0.5
"""Share of a cell that must have been seen well: the cell counts as looked at then."""
_BLOCK: Final = 128  # cells a side of the blocks in which a large outline is read


class OutlinedGround:
    """The cells (of `COARSE_M`) with their centre in the asked ground."""

    def __init__(self, ground: AskedGround) -> None:
        self.ground = ground
        rings = [ring for piece in ground.pieces for ring in piece]
        corners = np.array([corner for ring in rings for corner in ring]).reshape(-1, 2)
        self.extent: Floats | None = None if len(corners) == 0 else np.stack([corners.min(0), corners.max(0)])
        """Two corners (2, 2) of (north, east) about the ground, metres; None when there is none."""
        self._window = Window(0, 0, 1, 1, COARSE_M) if len(corners) == 0 else Window.around(corners, COARSE_M)
        self._mask = cells_inside(rings, self._window)

    @property
    def area_m2(self) -> float:
        """Area of the cells, square metres."""
        return float(np.count_nonzero(self._mask)) * COARSE_M**2

    def mask(self, window: Window) -> Mask:
        """Return 1 for the cells of a window that belong to the ground, 0 for others."""
        mask = np.zeros(window.shape, np.uint8)
        top, left = max(window.row, self._window.row), max(window.column, self._window.column)
        bottom = min(window.row + window.rows, self._window.row + self._window.rows)
        right = min(window.column + window.columns, self._window.column + self._window.columns)
        if bottom > top and right > left:
            both = Window(top, left, bottom - top, right - left, COARSE_M)
            mask[window.part(both)] = self._mask[self._window.part(both)]
        return mask

    def contains(self, place: Place) -> bool:
        """Return True when the cell at a place (metres, map frame) belongs to the ground."""
        rows, columns, inside = self._window.cells_at(np.array([place]))
        return bool(inside[0] and self._mask[rows[0], columns[0]])

    def on(self, layers: CoarseLayers) -> CoarseLayers:
        """Return the map's layers with this ground as the lot, and everything outside it as seen."""
        outlined = self.mask(layers.window).astype(np.float32)
        looked_at = outlined * (layers.well >= LOOKED_AT)
        return replace(
            layers,
            lot=outlined,
            likely=outlined,
            seen=np.maximum(layers.seen, 1 - outlined),
            well=np.maximum(layers.well, looked_at),
        )

    def unseen_m2(self, known: LotMap) -> float:
        """Return the area of the cells that were not looked at, square metres."""
        left = 0
        for block in self._blocks():
            outlined = self.mask(block) > 0
            if outlined.any():
                left += int(np.count_nonzero(outlined & (known.coarse(block).well < LOOKED_AT)))
        return left * COARSE_M**2

    def _blocks(self) -> Iterator[Window]:
        whole = self._window
        for row in range(0, whole.rows, _BLOCK):
            for column in range(0, whole.columns, _BLOCK):
                rows, columns = min(_BLOCK, whole.rows - row), min(_BLOCK, whole.columns - column)
                yield Window(whole.row + row, whole.column + column, rows, columns, whole.cell_m)


def cells_inside(rings: list[Ring], window: Window) -> Mask:
    """Return 1 for the cells of a window with their centre inside an odd number of rings of (north, east), else 0.

    A side changes the answer for every cell east of it, in the rows whose middle it crosses.
    """
    changes = np.zeros((window.rows, window.columns + 1), np.uint8)
    for ring in rings:
        corners = window.cells_of(*np.array(ring, dtype=np.float64).T)
        for (x, y), (x_next, y_next) in zip(corners.tolist(), np.roll(corners, -1, axis=0).tolist(), strict=True):
            low, high = min(y, y_next), max(y, y_next)
            rows = np.arange(max(math.ceil(low), 0), min(math.ceil(high), window.rows))  # half open: no corner twice
            if len(rows):
                crossed = x + (rows - y) * ((x_next - x) / (y_next - y))
                changes[rows, np.clip(np.ceil(crossed), 0, window.columns).astype(np.intp)] ^= 1
    return np.asarray(np.bitwise_xor.accumulate(changes[:, :-1], axis=1))
