"""Acknowledgements of live pictures, read before aiohttp does.

Each picture of each viewer is acknowledged by one short message. Through aiohttp's parser, queue and task it takes the
loop about as long as sending the picture. Only a piece that is exactly one acknowledgement is taken; aiohttp reads
every other one, with the same result. One in a while is left to aiohttp, which pings and ends a connection that it does
not hear.
"""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable
from typing import Final

_USUAL: Final = re.compile(rb'\{"ack": ?([0-9]{1,10})\}')
"""An acknowledgement as JSON writers write it."""
LEFT_S: Final = 2.0
"""Real seconds after which an acknowledgement is left to aiohttp."""
_WHOLE_TEXT: Final = 0x81
_FINAL: Final = 0x80
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
