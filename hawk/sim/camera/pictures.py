"""Damage and marks that a bad link or an odd camera puts into a JPEG."""

from __future__ import annotations

import struct
from typing import Final

LOST_BYTES: Final = 3000
EVERY: Final = 10
"""One picture of this number is damaged."""
UPRIGHT: Final = 1
"""EXIF orientation of a picture that is not turned."""
_ORIENTATION_TAG: Final = 0x0112
_SHORT: Final = 3
_START: Final = 2
"""Bytes of a JPEG's start mark."""


def damage(jpeg: bytes, sequence: int) -> bytes:
    """Return the picture without `LOST_BYTES` of its middle, where it is one of the damaged ones."""
    if sequence % EVERY or len(jpeg) < 2 * LOST_BYTES:
        return jpeg
    middle = len(jpeg) // 2
    return jpeg[: middle - LOST_BYTES // 2] + jpeg[middle + LOST_BYTES // 2 :]


def orient(jpeg: bytes, orientation: int) -> bytes:
    """Return the picture with an EXIF orientation, 1 to 8; the pixels stay (EXIF 2.32, 4.6.4)."""
    if orientation == UPRIGHT:
        return jpeg
    entry = struct.pack(">HHIHH", _ORIENTATION_TAG, _SHORT, 1, orientation, 0)
    tiff = b"MM\0*" + struct.pack(">IH", 8, 1) + entry + struct.pack(">I", 0)
    exif = b"Exif\0\0" + tiff
    return jpeg[:_START] + b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + jpeg[_START:]
