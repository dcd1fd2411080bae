"""JPEG pictures with texture, with an orientation, and with bytes lost from their scan."""

from __future__ import annotations

import struct

import cv2
import numpy as np
from numpy.typing import NDArray


def scene(width: int = 320, height: int = 240, seed: int = 1) -> NDArray[np.uint8]:
    """Return a picture with as much texture as asphalt with paint, BGR."""
    rng = np.random.default_rng(seed)
    coarse = rng.integers(60, 200, (height // 160 + 2, width // 160 + 2, 3), dtype=np.uint8)
    picture = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC).astype(np.int16)
    picture += rng.normal(0, 2.5, (height, width, 1)).round().astype(np.int16)
    return np.clip(picture, 0, 255).astype(np.uint8)


def jpeg(picture: NDArray[np.uint8] | None = None, restarts: int = 0, *, progressive: bool = False) -> bytes:
    """Return a picture as JPEG; ``restarts``: MCUs between two restart markers, 0 for none."""
    options = [cv2.IMWRITE_JPEG_RST_INTERVAL, restarts, cv2.IMWRITE_JPEG_PROGRESSIVE, int(progressive)]
    done, data = cv2.imencode(".jpg", scene() if picture is None else picture, options)
    assert done
    return bytes(data.tobytes())


def scan_start(data: bytes) -> int:
    """Return where the data of the first scan begin."""
    at = data.index(b"\xff\xda")
    return at + 2 + int.from_bytes(data[at + 2 : at + 4], "big")


def without(data: bytes, share: float, count: int) -> bytes:
    """Return a JPEG that lost ``count`` bytes at a share (0..1) of its scan."""
    first, last = scan_start(data), len(data) - 2 - count
    at = first + round(share * (last - first))
    return data[:at] + data[at + count :]


def oriented(data: bytes, orientation: int, order: str = "<") -> bytes:
    """Return a JPEG with an orientation in EXIF; ``order`` of its bytes as `struct` writes it."""
    start = b"II*\0" if order == "<" else b"MM\0*"
    entries = struct.pack(f"{order}HHHIHHHHIHH", 2, 0x0100, 3, 1, 7, 0, 0x0112, 3, 1, orientation, 0)
    segment = b"Exif\0\0" + start + struct.pack(f"{order}I", 8) + entries + bytes(4)
    return data[:2] + b"\xff\xe1" + (len(segment) + 2).to_bytes(2, "big") + segment + data[2:]


def with_extra_bytes(data: bytes, most: int) -> bytes:
    """Return a JPEG with 1 to ``most`` bytes too many before each restart marker, as some webcams send it."""
    start = scan_start(data)
    out, at, count = data[:start], start, 0
    while (found := _next_restart(data, at)) is not None:
        out += data[at:found] + b"\x11" * (1 + count % most) + data[found : found + 2]
        at, count = found + 2, count + 1
    return out + data[at:]


def _next_restart(data: bytes, start: int) -> int | None:
    for at in range(start, len(data) - 1):
        if data[at] == 0xFF and 0xD0 <= data[at + 1] <= 0xD7:
            return at
    return None
