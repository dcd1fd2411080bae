"""Cells of a window's core: which show ground, and which are of a lot."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]
Runs = list[int]
"""Rows and columns of a mask, then the lengths of its runs, False first."""
CELL_M: Final = 0.4
"""Side of a cell, metres; those of a core are a little smaller or larger, so that they fill it."""


def lot_cells(
    mask: Mask, side: tuple[float, float], core: NDArray[np.float64], shape: tuple[int, int] | None = None
) -> Mask:
    """Return the part of a window's mask that lies in its core, as cells of about `CELL_M`.

    Args:
        mask: (H, W) of the window, from its upper left corner.
        side: Metres of one of the mask's cells along a row and along a column.
        core: Left, top, right and bottom of the core, metres from that corner.
        shape: Rows and columns of the result; None: as many as fill the core.
    """
    left, top, right, bottom = core.tolist()
    rows, columns = shape or (max(1, round((bottom - top) / CELL_M)), max(1, round((right - left) / CELL_M)))
    x = (left + (np.arange(columns) + 0.5) * ((right - left) / columns)) / side[0]
    y = (top + (np.arange(rows) + 0.5) * ((bottom - top) / rows)) / side[1]
    column, row = (
        np.clip(np.floor(at).astype(np.intp), 0, most - 1) for at, most in ((x, mask.shape[1]), (y, mask.shape[0]))
    )
    return mask[np.ix_(row, column)]


def packed(mask: Mask) -> Runs:
    """Return a mask as runs."""
    flat = np.concatenate([[False], mask.reshape(-1), [not bool(mask.reshape(-1)[-1])]]).astype(np.int8)
    ends = np.flatnonzero(np.diff(flat))
    return [*mask.shape, *np.diff(ends, prepend=0).tolist()]


def unpacked(runs: Runs) -> Mask:
    """Return the mask of `packed`. Raises ValueError for runs that are none of a mask."""
    rows, columns, *lengths = (int(value) for value in runs)
    values = np.arange(len(lengths)) % 2 == 1
    if rows < 1 or columns < 1 or min(lengths, default=0) < 0 or sum(lengths) != rows * columns:
        raise ValueError("its runs do not fill its mask")
    return np.repeat(values, lengths).reshape(rows, columns)
