"""A parser for ``multipart/x-mixed-replace`` bodies as cameras send them, fed with whatever the network gives.

A part ends after its Content-Length, else at the next boundary. A part that is not a whole JPEG, that is too large or
whose length is a lie is dropped and counted, and the parser goes on at the next boundary.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum, auto

from hawk.comm import jpeg

MAX_PART = 8_000_000
"""Bytes of the largest picture that is taken."""
_MAX_HEADERS = 8192


class BoundaryError(ValueError):
    """The Content-Type names no boundary."""


@dataclass(frozen=True, slots=True)
class Part:
    """One picture. ``headers`` in lower case; ``arrival`` is when its first bytes were fed."""

    headers: Mapping[str, str]
    body: bytes = field(repr=False)
    arrival: float


class _State(Enum):
    SEEK = auto()
    HEADERS = auto()
    LENGTH = auto()
    SCAN = auto()


def boundary_of(content_type: str) -> bytes:
    """Return the boundary that a Content-Type names, without its dashes. Raises BoundaryError."""
    found = re.search(r'boundary\s*=\s*(?:"([^"]+)"|([^\s;]+))', content_type, re.IGNORECASE)
    name = (found.group(1) or found.group(2)) if found else ""
    name = name.removeprefix("--")
    if not name:
        raise BoundaryError(f"Content-Type {content_type!r} names no boundary")
    return name.encode("latin-1")


class MultipartParser:
    """Feed it bytes; it gives back whole pictures."""

    def __init__(self, boundary: bytes, max_part: int = MAX_PART) -> None:
        self._mark = b"--" + boundary
        self._max = max_part
        self._buffer = bytearray()
        self._state = _State.SEEK
        self._scanned = 0
        self._headers: dict[str, str] = {}
        self._arrival = 0.0
        self._length = 0
        self.torn = 0

    def feed(self, data: bytes, now: float) -> list[Part]:
        """Take the next bytes and return the pictures that they complete."""
        if not self._buffer:
            self._arrival = now
        self._buffer += data
        parts: list[Part] = []
        while self._step(parts, now):
            pass
        return parts

    def _step(self, parts: list[Part], now: float) -> bool:
        """Take one step; return whether another may follow with the bytes at hand."""
        if self._state is _State.SEEK:
            return self._seek(now)
        if self._state is _State.HEADERS:
            return self._read_headers()
        if self._state is _State.LENGTH:
            return self._read_length(parts, now)
        return self._scan(parts, now)

    def _seek(self, now: float) -> bool:
        start = self._buffer.find(self._mark)
        if start < 0:
            del self._buffer[: max(0, len(self._buffer) - len(self._mark))]
            return False
        end = self._buffer.find(b"\n", start)
        if end < 0:
            del self._buffer[:start]
            if len(self._buffer) > _MAX_HEADERS:
                self._lose(len(self._mark))
                return True
            return False
        del self._buffer[: end + 1]
        self._arrival = now
        self._state = _State.HEADERS
        return True

    def _read_headers(self) -> bool:
        found = re.search(rb"\r?\n\r?\n", self._buffer) if not self._buffer.startswith((b"\r\n", b"\n")) else None
        if found is None and self._buffer.startswith((b"\r\n", b"\n")):
            head, length = b"", self._buffer.index(b"\n") + 1
        elif found is None:
            if len(self._buffer) > _MAX_HEADERS:
                self._lose(0)
                return True
            return False
        else:
            head, length = bytes(self._buffer[: found.start()]), found.end()
        self._headers = _headers(head)
        del self._buffer[:length]
        self._start_body()
        return True

    def _start_body(self) -> None:
        self._scanned = 0
        text = self._headers.get("content-length", "")
        if text.isdecimal() and 0 < int(text) <= self._max:
            self._length = int(text)
            self._state = _State.LENGTH
        elif text.isdecimal() and int(text) > self._max:
            self._lose(0)
        else:
            self._state = _State.SCAN

    def _read_length(self, parts: list[Part], now: float) -> bool:
        if len(self._buffer) < self._length:
            return False
        body = bytes(self._buffer[: self._length])
        if not jpeg.is_whole(body):
            self._lose(0)  # the length may lie: the next boundary may be inside
            return True
        del self._buffer[: self._length]
        self._finish(parts, body, now)
        return True

    def _scan(self, parts: list[Part], now: float) -> bool:
        end = self._buffer.find(self._mark, self._scanned)
        if end < 0:
            self._scanned = max(0, len(self._buffer) - len(self._mark))
            if len(self._buffer) > self._max:
                self._lose(len(self._buffer) - len(self._mark))
            return False
        body = bytes(self._buffer[:end])
        body = body.removesuffix(b"\n").removesuffix(b"\r")
        del self._buffer[:end]
        if jpeg.is_whole(body):
            self._finish(parts, body, now)
        else:
            self._lose(0)
        return True

    def _finish(self, parts: list[Part], body: bytes, now: float) -> None:
        parts.append(Part(self._headers, body, self._arrival))
        self._arrival = now
        self._state = _State.SEEK

    def _lose(self, skip: int) -> None:
        self.torn += 1
        del self._buffer[:skip]
        self._state = _State.SEEK


def _headers(head: bytes) -> dict[str, str]:
    headers = {}
    for line in head.decode("latin-1").splitlines():
        name, colon, value = line.partition(":")
        if colon:
            headers[name.strip().lower()] = value.strip()
    return headers
