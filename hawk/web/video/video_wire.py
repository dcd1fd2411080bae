"""Live pictures as bytes on the wire: the same bytes for every viewer of one kind, made once.

A server's WebSocket messages are not masked (RFC 6455, 5.1), so that a message with its frame header is the same for
every viewer, and goes out by one write without a copy for each.
"""

from __future__ import annotations

import json
import re
import struct
import time
from collections.abc import Callable
from typing import Final

from hawk.model.pictures import AnnotatedFrame

_USUAL: Final = re.compile(rb'\{"ack": ?([0-9]{1,10})\}')
"""An acknowledgement as JSON writers write it."""
LEFT_S: Final = 2.0
"""Real seconds after which an acknowledgement is left to aiohttp."""
_WHOLE_TEXT: Final = 0x81
_MASKED: Final = 0x80
_LONG: Final = 126
_MASK_BYTES: Final = 4
_HEAD_BYTES: Final = 2 + _MASK_BYTES


class AckTap:
    """Takes what one connection receives; returns True when nobody else needs to see it."""

    def __init__(self, acknowledged: Callable[[int], None], monotonic: Callable[[], float] = time.monotonic) -> None:
        """``acknowledged`` is called with the sequence of each acknowledgement taken."""
        self._acknowledged = acknowledged
        self._monotonic = monotonic
        self._left_at = monotonic()
        self._is_in_step = True
        """False once a piece was not one whole message: later pieces may begin anywhere."""

    def __call__(self, data: bytes) -> bool:
        """Take one acknowledgement."""
        if not self._is_in_step:
            return False
        if not _is_one_message(data):
            self._is_in_step = False
            return False
        found = _USUAL.fullmatch(_unmasked(data)) if data[0] == _WHOLE_TEXT else None
        now = self._monotonic()
        if found is None or now - self._left_at >= LEFT_S:
            self._left_at = now
            return False
        self._acknowledged(int(found[1]))
        return True


def acknowledged_sequence(text: str) -> int | None:
    """Return the sequence of an acknowledgement ``{"ack": sequence}``, None when it is none."""
    try:
        found = json.loads(text)["ack"]
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    return found if isinstance(found, int) and not isinstance(found, bool) else None


def _is_one_message(data: bytes) -> bool:
    """Return True for one whole, unfragmented, short WebSocket message of a client (RFC 6455, 5.2)."""
    if len(data) < _HEAD_BYTES or not data[0] & _FINAL or not data[1] & _MASKED:
        return False
    size = data[1] & ~_MASKED
    return size < _LONG and len(data) == _HEAD_BYTES + size


def _unmasked(data: bytes) -> bytes:
    """Return the content of a short message (RFC 6455, 5.3)."""
    size = len(data) - _HEAD_BYTES
    mask = data[2:_HEAD_BYTES] * (size // _MASK_BYTES + 1)
    return (int.from_bytes(data[_HEAD_BYTES:], "big") ^ int.from_bytes(mask[:size], "big")).to_bytes(size, "big")


Wire = Callable[[AnnotatedFrame], bytes]
"""Returns a frame as one kind of viewer receives it."""

HEADER: Final = struct.Struct("<4sIdI")
"""Magic, sequence (mod 2**32), capture time (seconds of the daemon's clock), flags (0). Little-endian, 20 bytes."""
MAGIC: Final = b"HWK1"
BOUNDARY: Final = "hawkframe"
_DELIMITER: Final = f"--{BOUNDARY}\r\n".encode("ascii")
_BINARY: Final = 0x2
_PING: Final = 0x9
_FINAL: Final = 0x80
_MARK: Final = struct.Struct(">I")
_KEPT: Final = 16
"""Newest frames, whole and small, by kinds of viewers."""


def sequence_of(frame: AnnotatedFrame) -> int:
    """Return the sequence as it goes over the wire."""
    return frame.sequence & 0xFFFFFFFF


def socket_frame(frame: AnnotatedFrame) -> bytes:
    """Return the message of ``/video``, header and picture, as a WebSocket frame."""
    size = HEADER.size + len(frame.jpeg)
    header = HEADER.pack(MAGIC, sequence_of(frame), frame.captured, 0)
    return b"".join((_message_head(_BINARY, size), header, frame.jpeg))


def plain_socket_frame(frame: AnnotatedFrame) -> bytes:
    """Return the picture alone as a WebSocket message, and a ping behind it: its pong shows that both arrived."""
    mark = ping_mark(frame)
    return b"".join((_message_head(_BINARY, len(frame.jpeg)), frame.jpeg, _message_head(_PING, len(mark)), mark))


def ping_mark(frame: AnnotatedFrame) -> bytes:
    """Return the content of the ping behind a picture."""
    return _MARK.pack(sequence_of(frame))


def marked_sequence(mark: bytes) -> int | None:
    """Return the sequence in the content of a pong; None when it answers another ping."""
    return int(_MARK.unpack(mark)[0]) if len(mark) == _MARK.size else None


def opening() -> bytes:
    """Return what goes before the first part of the multipart stream."""
    return _DELIMITER


def part(frame: AnnotatedFrame) -> bytes:
    """Return one part of the multipart stream behind its delimiter, ending in the next one.

    A reader that looks for delimiters need not wait for the next picture.
    """
    head = f"Content-Type: image/jpeg\r\nContent-Length: {len(frame.jpeg)}\r\nX-Timestamp: {frame.captured:.6f}\r\n\r\n"
    return b"".join((head.encode("ascii"), frame.jpeg, b"\r\n", _DELIMITER))


def chunked_part(frame: AnnotatedFrame) -> bytes:
    """Return `part` as one chunk of an HTTP/1.1 answer (RFC 9112, 7.1)."""
    whole = part(frame)
    return b"".join((f"{len(whole):x}\r\n".encode("ascii"), whole, b"\r\n"))


class WireCache:
    """Keeps the bytes of the newest frames."""

    def __init__(self) -> None:
        self._kept: dict[tuple[Wire, int], tuple[AnnotatedFrame, bytes]] = {}

    def of(self, wire: Wire, frame: AnnotatedFrame) -> bytes:
        """Return a frame's bytes for one kind of viewer."""
        key = (wire, id(frame))  # the frame is kept with them, so that its id is no other's
        kept = self._kept.get(key)
        if kept is None:
            if len(self._kept) >= _KEPT:
                del self._kept[next(iter(self._kept))]
            kept = self._kept[key] = (frame, wire(frame))
        return kept[1]


def _message_head(opcode: int, size: int) -> bytes:
    """Return the header of an unmasked, unfragmented WebSocket frame (RFC 6455, 5.2)."""
    first = _FINAL | opcode
    if size < 126:
        return struct.pack(">BB", first, size)
    if size < 1 << 16:
        return struct.pack(">BBH", first, 126, size)
    return struct.pack(">BBQ", first, 127, size)
