"""Live pictures as bytes on the wire: the same bytes for every viewer of one kind, made once.

A server's WebSocket messages are not masked (RFC 6455, 5.1), so that a message with its frame header is the same for
every viewer, and goes out by one write without a copy for each.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Final

from hawk.model.pictures import AnnotatedFrame

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
