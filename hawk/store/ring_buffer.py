"""The last minute before a recording begins, held in memory, bounded by bytes."""

from __future__ import annotations

import heapq
from collections import deque
from dataclasses import dataclass, field
from typing import Any, Final, Literal

RING_S: Final = 60.0
"""Seconds that are held at least; up to a minute more, so that they begin where the recording can be entered."""
RECORD_BYTES: Final = 8_000_000
FRAME_BYTES: Final = 16_000_000
"""Pictures have a limit of their own: they are the first that have no room."""


@dataclass(frozen=True, slots=True)
class Item:
    """One message for the file. ``time_ns``: the daemon's clock. ``size``: bytes, about."""

    topic: str
    payload: Any
    kind: Literal["json", "frame", "view"]
    time_ns: int
    size: int


@dataclass(slots=True)
class _Segment:
    """Records from one entry to the next."""

    begun_ns: int
    is_entered: bool
    """False: no entry came yet, a reader cannot decide these records again."""
    items: list[tuple[int, Item]] = field(default_factory=list)
    size: int = 0


class Ring:
    """Holds messages until a file takes them."""

    def __init__(self, record_bytes: int = RECORD_BYTES, frame_bytes: int = FRAME_BYTES) -> None:
        self._record_bytes, self._frame_bytes = record_bytes, frame_bytes
        self._number = 0
        self._segments: deque[_Segment] = deque()
        self._frames: deque[tuple[int, Item]] = deque()
        self._records_size = self._frames_size = 0

    def add(self, item: Item, *, is_entry: bool) -> bool:
        """Hold a message; ``is_entry``: a reader can begin with it. Return False when the records began again."""
        self._number += 1
        oldest = item.time_ns - round(RING_S * 1e9)
        if item.kind == "frame":
            self._frames.append((self._number, item))
            self._frames_size += item.size
        else:
            if is_entry and self._segments and not self._segments[0].is_entered:
                self._records_size -= self._segments.popleft().size
            if is_entry or not self._segments:
                self._segments.append(_Segment(item.time_ns, is_entry))
            self._segments[-1].items.append((self._number, item))
            self._segments[-1].size += item.size
            self._records_size += item.size
        while self._frames and (self._frames_size > self._frame_bytes or self._frames[0][1].time_ns < oldest):
            self._frames_size -= self._frames.popleft()[1].size
        return self._trim(oldest)

    def take(self) -> list[Item]:
        """Return all that is held, in the order in which it came, and hold nothing any more."""
        records = (held for segment in self._segments for held in segment.items)
        taken = [item for _, item in heapq.merge(records, self._frames, key=lambda held: held[0])]
        self._segments.clear()
        self._frames.clear()
        self._records_size = self._frames_size = 0
        return taken

    def _trim(self, oldest: int) -> bool:
        while len(self._segments) > 1 and (
            self._records_size > self._record_bytes or self._segments[1].begun_ns <= oldest
        ):
            self._records_size -= self._segments.popleft().size
        if self._records_size <= self._record_bytes:
            return True
        self._segments.clear()
        self._records_size = 0
        return False
