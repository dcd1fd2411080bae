"""A thread that sends the newest item and forgets older ones: the caller never waits, nothing is sent twice."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from typing import Generic, TypeVar

_LOG = logging.getLogger(__name__)
T = TypeVar("T")


class LatestSender(Generic[T]):
    """One slot, one thread. What was not sent when the next comes is dropped; nothing is ever repeated."""

    def __init__(self, name: str, send: Callable[[T], None]) -> None:
        self._send = send
        self._ready = threading.Condition()
        self._slot: list[T] = []
        self._closed = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def put(self, item: T) -> None:
        """Replace what waits to be sent. Never blocks."""
        with self._ready:
            self._slot = [item]
            self._ready.notify()

    def clear(self) -> None:
        """Drop what waits to be sent."""
        with self._ready:
            self._slot = []

    def close(self, timeout_s: float = 1.0) -> None:
        """End the thread."""
        with self._ready:
            self._closed = True
            self._slot = []
            self._ready.notify()
        self._thread.join(timeout_s)

    def _run(self) -> None:
        while True:
            with self._ready:
                while not self._slot and not self._closed:
                    self._ready.wait()
                if self._closed:
                    return
                item = self._slot.pop()
            try:
                self._send(item)
            except Exception as error:  # the next one may get through
                _LOG.warning("A target was not sent: %s", error)
