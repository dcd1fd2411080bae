"""The picture of one map tile: a JPEG that says which of its pixels were seen.

A comment segment of the JPEG (ITU-T T.81, COM) holds the mask: `MASK_MARK`, then zlib of one bit a pixel, row by row, 1
where it was seen. WebP with opacity takes 6 to 10 ms a tile to encode, JPEG and mask 0.4 ms. Pixels that were not seen
have the colours of those about them, so that a reader without the mask shows no black either.
"""

from __future__ import annotations

import struct
import zlib
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.model.lot_map import TILE_CELLS

MASK_MARK: Final = b"hawk seen\0"
"""Beginning of the comment segment."""
_SHAPE: Final = (TILE_CELLS, TILE_CELLS)
_QUALITY: Final = (cv2.IMWRITE_JPEG_QUALITY, 88)
_START: Final = b"\xff\xd8"
_COMMENT: Final = b"\xff\xfe"
_LENGTH: Final = struct.Struct(">H")
_BLACK: Final = 12
_CAR: Final = 1500  # pixels: what is black and smaller may be a car
_RINGS: Final = 7  # pixels about black ground that JPEG darkens
_SIDE: Final = 32  # blocks that colours are spread by
_REACH: Final = 13
_SPREADS: Final = 5  # each reaches half of it farther: over the whole tile
_LITTLE: Final = 0.02

Picture = NDArray[np.uint8]
Mask = NDArray[np.uint8]
"""(256, 256): 255 where a pixel was seen, else 0."""


def encode_picture(pixels: Picture, seen: Mask) -> bytes:
    """Return a tile's picture, BGR (256, 256, 3), with its mask."""
    shown = pixels if seen.all() else _filled(pixels, seen)
    jpeg = cv2.imencode(".jpg", shown, _QUALITY)[1].tobytes()
    mask = MASK_MARK + zlib.compress(np.packbits(seen > 0).tobytes(), 1)
    return b"".join((_START, _COMMENT, _LENGTH.pack(len(mask) + 2), mask, jpeg[len(_START) :]))


def decode_picture(data: bytes) -> tuple[Picture, Mask]:
    """Return a tile's picture and its mask. A picture without a mask was not seen where a large part is black.

    Raises ValueError when it is no picture of a tile.
    """
    try:
        pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        pixels = None
    if pixels is None or pixels.shape != (*_SHAPE, 3):
        raise ValueError("mosaic tile: not a picture of the right size")
    picture = np.asarray(pixels, np.uint8)
    seen = _mask_in(data)
    return picture, _not_black(picture) if seen is None else seen


def has_mask(data: bytes) -> bool:
    """Return True for a picture with a mask."""
    return data.startswith(_START + _COMMENT) and data[6 : 6 + len(MASK_MARK)] == MASK_MARK


def _mask_in(data: bytes) -> Mask | None:
    if not has_mask(data):
        return None
    packed = data[6 + len(MASK_MARK) : 4 + _LENGTH.unpack_from(data, 4)[0]]
    try:
        bits = np.unpackbits(np.frombuffer(zlib.decompress(packed), np.uint8))
        return np.asarray(bits.reshape(_SHAPE) * np.uint8(255))
    except (zlib.error, ValueError) as error:
        raise ValueError(f"mosaic tile: its mask cannot be read: {error}") from error


def _not_black(pixels: Picture) -> Mask:
    black = (pixels.max(axis=2) < _BLACK).astype(np.uint8)
    count, labels, found, _ = cv2.connectedComponentsWithStats(black, connectivity=4)
    large = np.zeros(count, np.uint8)
    large[1:] = found[1:, cv2.CC_STAT_AREA] > _CAR
    unseen = cv2.dilate(large[labels], np.ones((_RINGS, _RINGS), np.uint8))
    return np.asarray(np.where(unseen > 0, 0, 255), np.uint8)


def _filled(pixels: Picture, seen: Mask) -> Picture:
    """Return the picture with colours of the nearest seen ground where nothing was seen, coarsely."""
    side = (_SIDE, _SIDE)
    weight = np.asarray(cv2.resize(seen, side, interpolation=cv2.INTER_AREA), np.float32) / np.float32(255)
    colour = np.asarray(cv2.resize(cv2.copyTo(pixels, seen), side, interpolation=cv2.INTER_AREA), np.float32)
    for _ in range(_SPREADS):
        wide_weight, wide_colour = _wide(weight), _wide(colour)
        empty = weight < _LITTLE
        weight, colour = np.where(empty, wide_weight, weight), np.where(empty[..., None], wide_colour, colour)
    mean = colour / np.maximum(weight, np.float32(1e-3))[..., None]
    shown = np.asarray(np.clip(cv2.resize(mean, _SHAPE, interpolation=cv2.INTER_LINEAR), 0, 255), np.uint8)
    cv2.copyTo(pixels, seen, shown)
    return shown


def _wide(layer: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.asarray(cv2.blur(layer, (_REACH, _REACH), borderType=cv2.BORDER_REPLICATE), np.float32)
