"""Steps of brightness or colour in a decoded JPEG that only lost bytes leave behind.

A JPEG stores the mean of each block as its difference from the one before. After a few lost bytes the decoder finds
back to whole codes, often without a warning and with every block in its place; from there to the picture's end the
means are off by one constant. In reading order this is a step between each block and the one above it, over exactly one
row of blocks, which begins anywhere in one. Edges of the ground do not do that: they are neither on the grid of blocks
nor as wide as the picture, and a lens spreads them over some pixels.
"""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

_LEAST: Final = 5.0
"""Grey levels of a step that is reported: smaller ones change no stall."""
_AGREE: Final = 0.75
"""Share of a row's blocks that must step in the same direction."""
_SHARPER: Final = 1.8
"""Times by which the step is larger than the changes within the blocks beside it; colour is smoothed over 4 lines."""
_LEAST_BLOCKS: Final = 12
_FROM_ROW: Final = 1
"""Blocks that it must have in either of the two rows: an edge of what the camera saw has all in one."""
_PART: Final = 0.5
"""Share of the whole step that each of the two parts must have."""
_COLUMN: Final = 16
"""Pixels over whose width changes are averaged."""


def largest_step(image: NDArray[np.uint8], block: int) -> float:
    """Return the largest step of that kind in grey levels, 0.0 where there is none.

    Args:
        image: The whole picture, uint8 (H, W, 3).
        block: Rows of a block as it was stored (an MCU): 8 or 16.
    """
    rows, columns = image.shape[0] // block, image.shape[1] // _COLUMN
    if rows < 3 or columns < _LEAST_BLOCKS:
        return 0.0
    first = np.arange(1, rows) * block
    lines = [_means(image[first + offset], columns) for offset in (-2, -1, 0, 1)]
    at, above, below = lines[2] - lines[1], lines[1] - lines[0], lines[3] - lines[2]
    step = _over_a_row(at, columns)
    agree = _over_a_row(np.sign(at), columns)
    beside = np.maximum(np.abs(_over_a_row(above, columns)), np.abs(_over_a_row(below, columns)))
    size = np.abs(step)
    found = (size >= _LEAST) & (np.abs(agree) >= 2 * _AGREE - 1) & (size >= _SHARPER * beside)
    told = np.where(found, size, 0.0)
    best = told.argmax(axis=0)
    sizes = [
        float(told[begin, colour])
        for colour, begin in enumerate(best.tolist())
        if _goes_on(at[begin : begin + columns, colour], columns - begin % columns)
    ]
    return max(sizes, default=0.0)


def _goes_on(changes: NDArray[np.float32], in_first: int) -> bool:
    """Return True when a run of changes steps in both rows of blocks that it belongs to, ``in_first`` of it in one."""
    if not _FROM_ROW <= in_first <= len(changes) - _FROM_ROW:
        return False
    mean = float(changes.mean())
    parts = (changes[:in_first], changes[in_first:])
    return all(part.mean() / mean >= _PART and np.mean(np.sign(part) == np.sign(mean)) >= _AGREE for part in parts)


def _means(lines: NDArray[np.uint8], columns: int) -> NDArray[np.float32]:
    """Return the means of pieces of lines (N, W, 3), in reading order: (N * columns, 3)."""
    whole = lines[:, : columns * _COLUMN].astype(np.float32)
    means = cv2.resize(whole, (columns, len(lines)), interpolation=cv2.INTER_AREA)
    return np.asarray(means.reshape(-1, 3), np.float32)


def _over_a_row(values: NDArray[np.float32], columns: int) -> NDArray[np.float32]:
    """Return the mean of each run as long as a row, in reading order: (N - columns + 1, 3)."""
    sums = np.cumsum(np.concatenate((np.zeros((1, 3), np.float64), values)), axis=0)
    return np.asarray((sums[columns:] - sums[:-columns]) / columns, np.float32)
