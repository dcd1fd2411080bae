"""A photograph's file up to its picture: size, EXIF and XMP. The picture itself is not read."""

from __future__ import annotations

import mmap
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, Final

from hawk.formats.image import JPEG_START

_FRAME_HEADERS: Final = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_SCAN, _APP1 = 0xDA, 0xE1
_BARE: Final = frozenset((0x01, *range(0xD0, 0xD8)))
_END: Final = b"\xff\xd9"
_EXIF: Final = b"Exif\x00\x00"
_XMP: Final = b"http://ns.adobe.com/xap/1.0/\x00"


@dataclass(frozen=True, slots=True)
class Head:
    """Description that a JPEG gives of itself. ``size``: (width, height) of the stored pixels.

    ``exif`` begins with the TIFF header, ``xmp`` is the first packet; b"" where there is none.
    """

    size: tuple[int, int]
    exif: bytes = field(repr=False)
    xmp: bytes = field(repr=False)


def read_head(path: Path) -> Head:
    """Return the head of a JPEG (ITU-T T.81, B.1.1; EXIF 2.32, 4.5; XMP part 3, 1.1.3).

    Raises ValueError, whose text says what is wrong with the file, and OSError. A file without an end marker behind its
    head is torn: the bytes of a picture hold none (B.1.1.5).
    """
    with path.open("rb") as file:
        if file.read(2) != JPEG_START:
            raise ValueError("is no JPEG")
        size, exif, xmp = (0, 0), b"", b""
        while (marker := _next_marker(file)) != _SCAN:
            if marker in _BARE:
                continue
            length = int.from_bytes(file.read(2), "big")
            if length < 2:
                raise ValueError("is torn within its head")
            if marker in _FRAME_HEADERS:
                frame = file.read(length - 2)
                size = int.from_bytes(frame[3:5], "big"), int.from_bytes(frame[1:3], "big")
            elif marker == _APP1:
                segment = file.read(length - 2)
                exif = exif or segment.removeprefix(_EXIF) * segment.startswith(_EXIF)
                xmp = xmp or segment.removeprefix(_XMP) * segment.startswith(_XMP)
            else:
                file.seek(length - 2, 1)
        if min(size) < 1:
            raise ValueError("has no size")
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as whole:
            if whole.rfind(_END, file.tell()) < 0:
                raise ValueError("is torn: its end is missing")
    return Head(size, exif, xmp)


def _next_marker(file: BinaryIO) -> int:
    """Return the code of the next marker, past its fill bytes. Raises ValueError where the file holds none."""
    byte = file.read(1)
    if byte != b"\xff":
        raise ValueError("is torn within its head")
    while byte == b"\xff":
        byte = file.read(1)
    if not byte:
        raise ValueError("is torn within its head")
    return byte[0]
