"""The pictures that both servers get: JPEGs of a real size, each stamped when it is handed over.

The stamp is a JPEG comment right behind the start marker (ITU-T T.81, B.2.4.5): CLOCK_MONOTONIC in nanoseconds as 16
hexadecimal digits. It passes any server unchanged, and all processes of one machine share the clock.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

WIDTH, HEIGHT = 1280, 720
"""Pixels of a picture."""
BYTES: Final = 90_000
"""Bytes of a JPEG, about."""
COUNT: Final = 30
_COMMENT: Final = b"\xff\xfe\x00\x12"
"""Marker COM and the length of what follows, itself included: 18."""
_DIGITS: Final = 16
STAMP_BYTES: Final = len(_COMMENT) + _DIGITS
STAMP_ENDS: Final = 2 + STAMP_BYTES
"""Number of bytes of a picture up to the end of its stamp."""


def stamped(jpeg: bytes, now_ns: int) -> bytes:
    """Return the picture with the time in it."""
    return b"".join((jpeg[:2], _COMMENT, b"%016x" % now_ns, jpeg[2:]))


def stamp_of(start: bytes) -> int:
    """Return the nanoseconds in the first `STAMP_ENDS` bytes of a picture. Raises ValueError without a stamp."""
    if start[2:6] != _COMMENT:
        raise ValueError("the picture has no stamp")
    return int(start[6:STAMP_ENDS], 16)


def draw(count: int = COUNT) -> list[bytes]:
    """Return different JPEGs of about `BYTES` each: ground with rectangles as large as cars, moving."""
    rng = np.random.default_rng(1)
    rough = rng.normal(110, 7, (HEIGHT // 2, WIDTH // 2 + count * 4)).clip(0, 255).astype(np.uint8)
    ground = cv2.cvtColor(cv2.resize(rough, None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC), cv2.COLOR_GRAY2BGR)
    for x in range(20, ground.shape[1] - 60, 60):
        for y in (60, 200, 420, 560):
            cv2.rectangle(ground, (x, y), (x + 50, y + 100), (235, 235, 235), 2)
            if rng.random() < 0.6:
                colour = tuple(int(value) for value in rng.integers(20, 235, 3))
                cv2.rectangle(ground, (x + 10, y + 12), (x + 40, y + 88), colour, -1)
    views = [np.ascontiguousarray(ground[:, 8 * number : 8 * number + WIDTH], np.uint8) for number in range(count)]
    quality = _quality(views[0])
    return [_encoded(view, quality) for view in views]


def write(path: Path, pictures: list[bytes]) -> None:
    """Write pictures as both servers read them: a count, then for each its length (u32, little-endian) and its JPEG."""
    with path.open("wb") as file:
        file.write(struct.pack("<I", len(pictures)))
        for jpeg in pictures:
            file.write(struct.pack("<I", len(jpeg)) + jpeg)


def read(path: Path) -> list[bytes]:
    """Return the pictures of a file."""
    data = path.read_bytes()
    (count,) = struct.unpack_from("<I", data)
    pictures, at = [], 4
    for _ in range(count):
        (length,) = struct.unpack_from("<I", data, at)
        pictures.append(data[at + 4 : at + 4 + length])
        at += 4 + length
    return pictures


def _quality(view: NDArray[np.uint8]) -> int:
    """Return the quality whose JPEG comes nearest to `BYTES`."""
    return min(range(30, 96), key=lambda quality: abs(len(_encoded(view, quality)) - BYTES))


def _encoded(view: NDArray[np.uint8], quality: int) -> bytes:
    _, data = cv2.imencode(".jpg", view, [cv2.IMWRITE_JPEG_QUALITY, quality])
    return bytes(data)
