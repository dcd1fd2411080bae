"""Messages from another thread handed to the loop: in order, bounded, one wake-up for many."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

_LOG = logging.getLogger(__name__)
T = TypeVar("T")


class Inbox(Generic[T]):
    """Takes items on any thread and handles them on the loop. The oldest are dropped when the loop does not come."""

    def __init__(self, loop: asyncio.AbstractEventLoop, handle: Callable[[T], None], size: int = 2000) -> None:
        self._loop = loop
        self._handle = handle
        self._items: deque[T] = deque(maxlen=size)
        self._lock = threading.Lock()
        self._woken = False
        self._closed = False
        self.dropped = 0

    def put(self, item: T) -> None:
        """Take an item; never blocks. Called on any thread."""
        with self._lock:
            if self._closed:
                return
            self.dropped += len(self._items) == self._items.maxlen
            self._items.append(item)
            if self._woken:
                return
            self._woken = True
        try:
            self._loop.call_soon_threadsafe(self._drain)
        except RuntimeError:  # the loop has ended
            self.close()

    def close(self) -> None:
        """Take nothing any more and forget what waits."""
        with self._lock:
            self._closed = True
            self._items.clear()

    def _drain(self) -> None:
        with self._lock:
            items = list(self._items)
            self._items.clear()
            self._woken = False
        for item in items:
            try:
                self._handle(item)
            except Exception:  # one bad item must not stop the others
                _LOG.exception("An item could not be handled")
