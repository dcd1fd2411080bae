"""What can be told of a JPEG without decoding it (ITU-T T.81)."""

from __future__ import annotations

_START = b"\xff\xd8"
_END = b"\xff\xd9"
_FRAME_HEADERS = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_PADDING = b"\0\xff\r\n"
"""What some cameras put after the end of a picture, up to `_TAIL` bytes of it."""
_TAIL = 64


def is_whole(data: bytes | bytearray | memoryview) -> bool:
    """Whether the bytes start and end as a JPEG does."""
    return len(data) > 4 and bytes(data[:2]) == _START and bytes(data[-_TAIL:]).rstrip(_PADDING).endswith(_END)


def size(data: bytes) -> tuple[int, int]:
    """Return width and height in pixels. Raises ValueError when the bytes are no JPEG."""
    if data[:2] != _START:
        raise ValueError("not a JPEG: it does not start with FFD8")
    position = 2
    while position + 9 <= len(data):
        if data[position] != 0xFF:
            break
        marker = data[position + 1]
        if marker == 0xFF:  # fill byte
            position += 1
            continue
        if marker in _FRAME_HEADERS:
            height = int.from_bytes(data[position + 5 : position + 7], "big")
            width = int.from_bytes(data[position + 7 : position + 9], "big")
            return width, height
        position += 2 + int.from_bytes(data[position + 2 : position + 4], "big")
    raise ValueError("not a JPEG: it has no frame header")
