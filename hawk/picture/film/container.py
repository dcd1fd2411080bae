"""Facts in an MP4's or MOV's own boxes: when it was made, and by which camera.

ISO 14496-12, 8.2.2 (``mvhd``) and 8.10.1 (``udta``); QuickTime's ``©mod`` is the model, DJI's ``©mdl`` the same without
a length before the text (exiftool, `QuickTime.pm`).
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Final

_EPOCH_1904: Final = 2_082_844_800
_EARLIEST: Final = 946_684_800
"""Unix time of 2000: a camera without a clock writes 0 or 1904."""
_MOST: Final = 1 << 16
"""Bytes of a box that is read."""
_TEXTS: Final = (b"text", b"sbtl", b"subt")
_MODEL: Final = (b"\xa9mdl", b"\xa9mod", b"modl")


@dataclass(frozen=True, slots=True)
class ContainerFacts:
    """``begun``: Unix seconds at which the camera began the film, by its clock. None, "": the file does not say.

    ``has_captions``: a track of the film itself is of text.
    """

    begun: float | None = None
    model: str = ""
    has_captions: bool = False


def read_made(path: Path) -> ContainerFacts:
    """Return what a film's boxes say; nothing for an AVI or a damaged file. Raises OSError."""
    begun, model, has_captions = None, "", False
    with path.open("rb") as stream:
        size = path.stat().st_size
        for name, start, end in _boxes(stream, 0, size):
            if name != b"moov":
                continue
            for inner, at, to in _boxes(stream, start, end):
                if inner == b"mvhd":
                    begun = _begun(_bytes(stream, at, to))
                elif inner == b"udta":
                    model = _model(stream, at, to)
                elif inner == b"trak":
                    has_captions |= _handler(stream, at, to) in _TEXTS
    return ContainerFacts(begun, model, has_captions)


def _boxes(stream: IO[bytes], at: int, end: int) -> Iterator[tuple[bytes, int, int]]:
    """Give name, begin and end of the content of each box."""
    while at + 8 <= end:
        stream.seek(at)
        head = stream.read(16)
        if len(head) < 8:
            return
        size, name, begin = int.from_bytes(head[:4], "big"), head[4:8], at + 8
        if size == 1 and len(head) == 16:
            size, begin = int.from_bytes(head[8:], "big"), at + 16
        elif size == 0:
            size = end - at
        if size < begin - at or at + size > end:
            return
        yield name, begin, at + size
        at += size


def _bytes(stream: IO[bytes], begin: int, end: int) -> bytes:
    stream.seek(begin)
    return stream.read(min(end - begin, _MOST))


def _begun(header: bytes) -> float | None:
    """Return the creation time of an ``mvhd``: seconds since 1904, of 64 bits in version 1."""
    try:
        (seconds,) = struct.unpack_from(">Q" if header[:1] == b"\x01" else ">I", header, 4)
    except struct.error:
        return None
    unix = float(seconds - _EPOCH_1904)
    return unix if unix >= _EARLIEST else None


def _handler(stream: IO[bytes], begin: int, end: int) -> bytes:
    """Return what a track is, by its ``mdia``'s ``hdlr`` (ISO 14496-12, 8.4.3)."""
    for name, at, to in _boxes(stream, begin, end):
        if name == b"mdia":
            found = (_bytes(stream, start, stop) for box, start, stop in _boxes(stream, at, to) if box == b"hdlr")
            return next(found, b"")[8:12]
    return b""


def _model(stream: IO[bytes], begin: int, end: int) -> str:
    for name, at, to in _boxes(stream, begin, end):
        if name in _MODEL:
            text = _bytes(stream, at, to)
            if len(text) >= 4 and int.from_bytes(text[:2], "big") == len(text) - 4:
                text = text[4:]  # a length and a language before it
            return text.split(b"\x00", 1)[0].decode("ascii", "ignore").strip()
    return ""
