"""Ground of an orthophoto as the sheet of a survey draws it: north up, about the survey's origin."""

from __future__ import annotations

import math
from typing import Final

import cv2
import numpy as np

from hawk.exports.ground import Ground
from hawk.lots.registration.georeference import about
from hawk.model.lot_map import CELL_M
from hawk.picture.orthophoto.bands import Pixels
from hawk.picture.orthophoto.grid import Box
from hawk.picture.orthophoto.source import Orthophoto
from hawk.picture.values import PictureError

_LEAST_M: Final = 1.0
_LEAST_PIXELS: Final = 512
"""Pixels a side of a part that is left out where it cannot be read as a whole."""


def ground_of_box(
    source: Orthophoto, box: tuple[float, float, float, float], origin: tuple[float, float], largest: float
) -> Ground | None:
    """Return the ground of a part of a picture; None for a part longer than ``largest`` (metres).

    Args:
        source: The picture.
        box: Left, top, right and bottom, (column, row) times the metres of a pixel.
        origin: Latitude and longitude of the survey's frame.
        largest: Metres a side.

    Parts of the file that cannot be read are ground that was not seen.
    """
    wide, high = box[2] - box[0], box[3] - box[1]
    if not (_LEAST_M <= wide <= largest and _LEAST_M <= high <= largest):
        return None
    metres = np.array(source.grid.metres)
    step = max(1, int(CELL_M / metres.max()))
    left, top = (int(side / m) for side, m in zip(box[:2], metres, strict=True))
    right, bottom = (
        min(math.ceil(side / m), most)
        for side, m, most in zip(box[2:], metres, (source.grid.columns, source.grid.rows), strict=True)
    )
    part = _readable(source, (left, top, right, bottom), step)
    rows, columns = part.valid.shape
    if not part.valid.any():
        return None
    ends = np.array([(0, 0), (columns, 0), (0, rows), (columns, rows)], np.float64)
    there = about(origin, source.grid.on_earth(ends * step + (left, top)))[:, :2]
    north, east = float(there[:, 0].max()), float(there[:, 1].min())
    size = (math.ceil((there[:, 1].max() - east) / CELL_M), math.ceil((north - there[:, 0].min()) / CELL_M))
    onto = np.column_stack([there[:, 1] - east, north - there[:, 0]]) / CELL_M
    matrix = cv2.getAffineTransform((ends[:3] - 0.5).astype(np.float32), (onto[:3] - 0.5).astype(np.float32))
    image = cv2.warpAffine(part.image, matrix, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    seen = cv2.warpAffine(part.valid.astype(np.uint8) * 255, matrix, size, flags=cv2.INTER_NEAREST)
    return Ground(np.asarray(image, np.uint8), np.asarray(seen, np.uint8), north, east, CELL_M)


def _readable(source: Orthophoto, box: Box, step: int) -> Pixels:
    """Return a part of a picture; what of it cannot be read is not valid."""
    try:
        return source.read(box, step)
    except PictureError:
        left, top, right, bottom = box
        columns, rows = (right - left) // step, (bottom - top) // step
        if max(columns, rows) * step <= _LEAST_PIXELS:
            return Pixels(np.zeros((rows, columns, 3), np.uint8), np.zeros((rows, columns), np.bool_))
        is_wide = columns > rows
        middle = (left + columns // 2 * step) if is_wide else (top + rows // 2 * step)
        first = (left, top, middle, bottom) if is_wide else (left, top, right, middle)
        second = (middle, top, right, bottom) if is_wide else (left, middle, right, bottom)
        halves = [_readable(source, half, step) for half in (first, second)]
        axis = 1 if is_wide else 0
        return Pixels(*(np.concatenate([getattr(half, name) for half in halves], axis) for name in ("image", "valid")))
