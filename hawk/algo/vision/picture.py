"""Decodes a camera's JPEG and refuses what is not a usable picture."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.errors import NoImage

MINIMUM_SIDE = 64
"""Pixels; a smaller picture is refused."""
MAXIMUM_PIXELS = 24_000_000
"""A larger picture is refused before it is decoded: it would hold up the worker."""
_BLACK_MEAN = 4.0
_FRAME_HEADERS = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_BARE_MARKERS = frozenset((0x01, *range(0xD0, 0xD8)))


def decode(jpeg: bytes) -> NDArray[np.uint8]:
    """Return the picture, uint8 BGR (H, W, 3). Raises NoImage with the reason when it cannot be used."""
    if not jpeg:
        raise NoImage("the camera gave an empty picture")
    width, height = jpeg_size(jpeg)
    if min(width, height) < MINIMUM_SIDE:
        raise NoImage(f"the picture is {width} x {height} pixels; at least {MINIMUM_SIDE} a side are needed")
    if width * height > MAXIMUM_PIXELS:
        raise NoImage(f"the picture is {width} x {height} pixels; at most {MAXIMUM_PIXELS // 1_000_000} million fit")
    if b"\xff\xd9" not in jpeg[-64:]:
        raise NoImage("the picture is torn: its end is missing")
    try:
        image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error as error:
        raise NoImage(f"the picture cannot be decoded: {error}") from error
    if image is None:
        raise NoImage("the picture cannot be decoded")
    if float(image[::8, ::8].mean()) < _BLACK_MEAN:
        raise NoImage("the picture is black: is the lens covered?")
    return np.asarray(image, np.uint8)


def jpeg_size(jpeg: bytes) -> tuple[int, int]:
    """Return width and height from the frame header (ITU T.81, B.2.2). Raises NoImage when there is none."""
    if jpeg[:2] != b"\xff\xd8":
        raise NoImage("the picture is not a JPEG")
    at = 2
    while at + 9 <= len(jpeg) and jpeg[at] == 0xFF:
        marker = jpeg[at + 1]
        if marker in _FRAME_HEADERS:
            return int.from_bytes(jpeg[at + 7 : at + 9], "big"), int.from_bytes(jpeg[at + 5 : at + 7], "big")
        if marker == 0xFF:
            at += 1
        elif marker in _BARE_MARKERS:
            at += 2
        else:
            at += 2 + int.from_bytes(jpeg[at + 2 : at + 4], "big")
    raise NoImage("the picture is torn: it has no frame header")
