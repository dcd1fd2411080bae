"""Pictures out of a bare stream of JPEG, one behind the other, as ``rpicam-vid --codec mjpeg`` writes it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from hawk.comm.cameras.sources.mjpeg import MAX_PART

_START: Final = b"\xff\xd8"
_END: Final = b"\xff\xd9"
_SCAN: Final = 0xDA
_BARE: Final = frozenset((0x01, *range(0xD0, 0xD8)))
"""Markers without a length (ITU-T T.81, B.1.1.3)."""


@dataclass(frozen=True, slots=True)
class StreamPicture:
    """One whole JPEG. ``number`` counts all that began, the torn ones included, from 0."""

    body: bytes = field(repr=False)
    number: int


class JpegSplitter:
    """Feed it bytes, it returns whole pictures. One whose headers make no sense is dropped and counted in ``torn``."""

    def __init__(self, longest: int = MAX_PART) -> None:
        self._longest = longest
        self._buffer = bytearray()
        self._at = 0  # up to here the picture was read; 0: its start is not found yet
        self._in_scan = False
        self._begun = 0
        self.torn = 0

    def feed(self, data: bytes) -> list[StreamPicture]:
        """Return the pictures that these bytes complete."""
        self._buffer += data
        found: list[StreamPicture] = []
        while self._find_start() and self._read_headers():
            # in the scan an FF of the picture's own is followed by 00 or by a restart marker: FF D9 is the end
            end = self._buffer.find(_END, self._at)
            if end < 0:
                self._at = max(self._at, len(self._buffer) - 1)
                if len(self._buffer) <= self._longest:
                    break
                self._lose()
                continue
            end += len(_END)
            found.append(StreamPicture(bytes(self._buffer[:end]), self._begun - 1))
            self._forget(end)
        return found

    def _find_start(self) -> bool:
        if self._at:
            return True
        start = self._buffer.find(_START)
        if start < 0:
            del self._buffer[: max(0, len(self._buffer) - 1)]
            return False
        del self._buffer[:start]
        self._at, self._begun = len(_START), self._begun + 1
        return True

    def _read_headers(self) -> bool:
        """Step over the segments up to the scan; return False when more bytes are needed."""
        while not self._in_scan:
            if len(self._buffer) < self._at + 4:
                return False
            if self._buffer[self._at] != 0xFF:
                self._lose()
                if not self._find_start():
                    return False
                continue
            marker = self._buffer[self._at + 1]
            if marker in _BARE:
                self._at += 2
            elif marker == 0xFF:  # a fill byte
                self._at += 1
            else:
                self._at += 2 + int.from_bytes(self._buffer[self._at + 2 : self._at + 4], "big")
                self._in_scan = marker == _SCAN
        return True

    def _lose(self) -> None:
        self.torn += 1
        self._forget(len(_START))

    def _forget(self, size: int) -> None:
        del self._buffer[:size]
        self._at, self._in_scan = 0, False
