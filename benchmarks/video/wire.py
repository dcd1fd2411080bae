"""Reads a client's bytes at little cost: it finds the pictures and keeps only their times.

A picture of µStreamer has its time inside (`benchmarks.video.pictures`). hawk says the same time beside each picture,
which a smaller form of it keeps too.
"""

from __future__ import annotations

import base64
import os
import re
import struct
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import Final

from benchmarks.video.pictures import STAMP_ENDS, stamp_of

Send = Callable[[bytes], None]
_LENGTH: Final = re.compile(rb"(?i)\r\ncontent-length: *(\d+)")
_TIME: Final = re.compile(rb"(?i)\r\nx-timestamp: *(\d+)\.(\d{6})")
_HEAD_END: Final = b"\r\n\r\n"
_VIDEO_HEADER: Final = struct.Struct("<4sIdI")
"""Of ``/video``: magic, sequence, capture time, flags."""

_TEXT, _BINARY, _CLOSE, _PING, _PONG = 1, 2, 8, 9, 10
_KEPT: Final = 125
"""First bytes of a message that are kept: the header of a picture, or a whole ping."""


class WireError(Exception):
    """The server sent what it should not."""


class Reader(ABC):
    """Reads one connection: `request` goes out first, then `feed` takes what comes."""

    request: bytes

    @abstractmethod
    def feed(self, data: memoryview) -> Iterator[tuple[int, int]]:
        """Return time (CLOCK_MONOTONIC, nanoseconds) and bytes of the pictures that ``data`` completes.

        Raises WireError, ValueError.
        """


class StreamReader(Reader):
    """``multipart/x-mixed-replace`` over HTTP/1.0: hawk's ``/stream.mjpg`` and µStreamer's ``/stream``."""

    def __init__(self, path: str, host: str, *, is_stamped: bool) -> None:
        """``is_stamped``: the time is in the picture, not in its head."""
        self.request = f"GET {path} HTTP/1.0\r\nHost: {host}\r\n\r\n".encode()
        self._is_stamped = is_stamped
        self._time_ns = 0
        self._length = 0
        self._head = bytearray()
        self._start = bytearray()
        self._missing = 0

    def feed(self, data: memoryview) -> Iterator[tuple[int, int]]:
        """As `Reader.feed`."""
        at, end = 0, len(data)
        while at < end:
            if self._missing == 0:
                at = self._read_head(data, at)
                continue
            if len(self._start) < STAMP_ENDS:
                self._start += data[at : at + min(STAMP_ENDS - len(self._start), self._missing)]
            taken = min(self._missing, end - at)
            at += taken
            self._missing -= taken
            if self._missing == 0:
                yield (stamp_of(bytes(self._start)) if self._is_stamped else self._time_ns), self._length

    def _read_head(self, data: memoryview, at: int) -> int:
        """Read up to the end of a head; return where the rest begins. A head without a length is the answer's own."""
        known = len(self._head)
        self._head += data[at : at + 2048]
        found = self._head.find(_HEAD_END, max(0, known - 3))
        if found < 0:
            if len(self._head) > 8192:
                raise WireError("a head does not end")
            return min(at + 2048, len(data))
        length = _LENGTH.search(self._head, 0, found + 2)
        self._missing = self._length = 0 if length is None else int(length[1])
        if self._missing > 0 and not self._is_stamped:
            self._time_ns = _time_in(self._head)
        self._head.clear()
        self._start.clear()
        return at + found + len(_HEAD_END) - known


class SocketReader(Reader):
    """hawk's ``/video``: a WebSocket whose every picture is acknowledged."""

    def __init__(self, path: str, host: str, send: Send) -> None:
        key = base64.b64encode(os.urandom(16)).decode()
        self.request = (
            f"GET {path} HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n"
        ).encode()
        self._send = send
        self._is_open = False
        self._head = bytearray()
        self._start = bytearray()
        self._opcode = 0
        self._length = 0
        self._missing = 0

    def feed(self, data: memoryview) -> Iterator[tuple[int, int]]:
        """As `Reader.feed`."""
        at, end = 0, len(data)
        while at < end:
            if self._missing == 0:
                at = self._read_head(data, at)
                continue
            if len(self._start) < _KEPT:
                self._start += data[at : at + min(_KEPT - len(self._start), self._missing)]
            taken = min(self._missing, end - at)
            at += taken
            self._missing -= taken
            if self._missing == 0 and self._opcode == _PING:
                self._send(client_frame(_PONG, bytes(self._start)))
            elif self._missing == 0 and self._opcode == _BINARY:
                _, sequence, captured_s, _ = _VIDEO_HEADER.unpack_from(self._start)
                yield round(captured_s * 1e9), self._length - _VIDEO_HEADER.size
                self._send(client_frame(_TEXT, b'{"ack":%d}' % sequence))

    def _read_head(self, data: memoryview, at: int) -> int:
        """Read one byte after the other of the answer's head, then of each message's (RFC 6455, 5.2)."""
        while at < len(data):
            self._head.append(data[at])
            at += 1
            if not self._is_open:
                if self._head.endswith(_HEAD_END):
                    if b" 101 " not in self._head[:16]:
                        raise WireError(f"no WebSocket: {bytes(self._head[:80])!r}")
                    self._is_open = True
                    self._head.clear()
                continue
            size = _message_size(self._head)
            if size is not None:
                self._opcode, self._missing, self._length = self._head[0] & 0x0F, size, size
                if self._opcode == _CLOSE:
                    raise WireError("the server closed the connection")
                self._head.clear()
                self._start.clear()
                if size > 0:
                    break
                if self._opcode == _PING:
                    self._send(client_frame(_PONG, b""))
        return at


def client_frame(opcode: int, content: bytes) -> bytes:
    """Return a client's message of less than 126 bytes, masked by zeros (RFC 6455, 5.3)."""
    return bytes((0x80 | opcode, 0x80 | len(content), 0, 0, 0, 0)) + content


def _time_in(head: bytearray) -> int:
    """Return the nanoseconds of X-Timestamp. Raises WireError."""
    found = _TIME.search(head)
    if found is None:
        raise WireError("a picture has no X-Timestamp")
    return int(found[1]) * 1_000_000_000 + int(found[2]) * 1000


def _message_size(head: bytearray) -> int | None:
    """Return the size of the message whose header this is, None when bytes of it are missing."""
    if len(head) < 2:
        return None
    short = head[1] & 0x7F
    if short < 126:
        return short
    needed, form = (4, ">H") if short == 126 else (10, ">Q")
    return int(struct.unpack_from(form, head, 2)[0]) if len(head) == needed else None
