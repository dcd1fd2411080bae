"""Ground of an orthophoto, north up about the survey's origin: for the sheet of a survey, and as tiles of the map."""

from __future__ import annotations

import math
import zlib
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.exports.ground import Ground
from hawk.lots.registration.georeference import about
from hawk.model.lot_map import CELL_M, TILE_CELLS, TILE_M, Cell, EncodedTile, TileKey
from hawk.model.plans import Outline
from hawk.model.tile_picture import encode_picture
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


Tiles = dict[TileKey, EncodedTile]


def tiles_of(ground: Ground, lots: Outline, origin: tuple[float, float]) -> tuple[Tiles, Tiles]:
    """Return cells and pictures of the map's tiles that a ground covers.

    Args:
        ground: The ground.
        lots: Outlines of the lots on it.
        origin: Latitude and longitude of the survey's frame.
    """
    high, wide = (round(side * ground.metres / CELL_M) for side in ground.seen.shape)
    first_row, first_column = (int(np.floor(at / TILE_M)) for at in (-ground.north, ground.east))
    top, left = (
        round((at - first * TILE_M) / CELL_M) for at, first in ((-ground.north, first_row), (ground.east, first_column))
    )
    rows, columns = (-(-(first + side) // TILE_CELLS) for first, side in ((top, high), (left, wide)))
    image = np.zeros((rows * TILE_CELLS, columns * TILE_CELLS, 3), np.uint8)
    seen = np.zeros(image.shape[:2], np.uint8)
    part = slice(top, top + high), slice(left, left + wide)
    image[part] = cv2.resize(ground.image, (wide, high), interpolation=cv2.INTER_AREA)
    seen[part] = cv2.resize(ground.seen, (wide, high), interpolation=cv2.INTER_NEAREST)
    cells = _cells(seen, lots, origin, (first_row, first_column))
    tiles, mosaic = {}, {}
    for row in range(rows):
        for column in range(columns):
            at = (
                slice(row * TILE_CELLS, (row + 1) * TILE_CELLS),
                slice(column * TILE_CELLS, (column + 1) * TILE_CELLS),
            )
            if seen[at].any():
                key = first_row + row, first_column + column
                tiles[key] = EncodedTile(1, zlib.compress(cells[at].tobytes()))
                mosaic[key] = EncodedTile(1, encode_picture(image[at], seen[at]))
    return tiles, mosaic


def _cells(seen: NDArray[np.uint8], lots: Outline, origin: tuple[float, float], first: TileKey) -> NDArray[np.uint8]:
    """Return the cells of the ground that was seen: those of a lot inside its outline, the others beside it."""
    cells = np.where(seen > 0, Cell.NON_LOT, Cell.UNKNOWN).astype(np.uint8)
    inside = np.zeros(seen.shape, np.uint8)
    for ring in lots.polygons:
        metres = about(origin, np.array(ring))[:, :2]
        pixels = np.column_stack([metres[:, 1] - first[1] * TILE_M, -metres[:, 0] - first[0] * TILE_M]) / CELL_M
        cv2.fillPoly(inside, [np.rint(pixels).astype(np.int32)], (1,))
    cells[(inside > 0) & (seen > 0)] = Cell.LOT
    return cells
