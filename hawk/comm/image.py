"""Pictures: JPEG read without decoding (ITU-T T.81), decoded to arrays, and the one error for having none."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

_START = b"\xff\xd8"
_END = b"\xff\xd9"
_FRAME_HEADERS = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_BARE_MARKERS = frozenset((0x01, *range(0xD0, 0xD8)))
"""Markers without a length (B.1.1.3)."""
_PADDING = b"\0\xff\r\n"
"""Bytes that some cameras append to a picture, `_TAIL` at most."""
_TAIL = 64


class NoImage(Exception):  # noqa: N818 - the specification's name
    """There is no fresh, usable picture; the text gives the reason.

    Specification sections 7, 8 and 10: cameras raise it, Vision App passes it on.
    """


_REDUCED = {1: cv2.IMREAD_COLOR, 2: cv2.IMREAD_REDUCED_COLOR_2, 4: cv2.IMREAD_REDUCED_COLOR_4}


def decode(data: bytes, reduction: int = 1) -> NDArray[np.uint8]:
    """Return a JPEG as (height, width, 3) BGR. Raises NoImage in place of OpenCV's own errors.

    ``reduction`` 2 and 4 give a half and a quarter of its width and height, for less time than the whole.
    """
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), _REDUCED[reduction])
    except cv2.error as error:
        raise NoImage(f"the picture cannot be decoded: {error}") from error
    if image is None:
        raise NoImage("the picture cannot be decoded")
    return np.asarray(image, np.uint8)


def is_whole_jpeg(data: bytes) -> bool:
    """Return True when the bytes start and end as a JPEG does."""
    return len(data) > 4 and data.startswith(_START) and data[-_TAIL:].rstrip(_PADDING).endswith(_END)


def jpeg_size(data: bytes) -> tuple[int, int]:
    """Return width and height in pixels (B.2.2). Raises ValueError when the bytes are no JPEG."""
    if data[:2] != _START:
        raise ValueError("not a JPEG: it does not start with FFD8")
    at = 2
    while at + 9 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker in _FRAME_HEADERS:
            return int.from_bytes(data[at + 7 : at + 9], "big"), int.from_bytes(data[at + 5 : at + 7], "big")
        if marker == 0xFF:  # fill byte
            at += 1
        elif marker in _BARE_MARKERS:
            at += 2
        else:
            at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    raise ValueError("not a JPEG, or torn: it has no frame header")
