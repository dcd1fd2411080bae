"""Threads: values for the loop (`Inbox`) and from it (`LatestSender`), and work that may hang (`Workers`)."""

from __future__ import annotations

import asyncio
import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import Final, Generic, TypeVar

_LOG = logging.getLogger(__name__)
T = TypeVar("T")

_Desk = SimpleQueue[Callable[[], None]]

IDLE_S: Final = 30.0


class Inbox(Generic[T]):
    """Takes items on any thread and handles them on the loop, in order. A full inbox drops the oldest."""

    def __init__(self, loop: asyncio.AbstractEventLoop, handle: Callable[[T], None], size: int = 2000) -> None:
        self._loop = loop
        self._handle = handle
        self._items: deque[T] = deque(maxlen=size)
        self._lock = threading.Lock()
        self._woken = False
        self._closed = False
        self.dropped = 0
        """Items dropped because the loop did not come in time."""

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
        """Drop the waiting items and ignore later ones."""
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


class LatestSender(Generic[T]):
    """A thread that sends the newest item once. A newer item replaces one that still waits."""

    def __init__(self, name: str, send: Callable[[T], None]) -> None:
        self._send = send
        self._ready = threading.Condition()
        self._slot: list[T] = []
        self._closed = False
        self._sending_since: float | None = None
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def put(self, item: T) -> None:
        """Replace the waiting item. Never blocks."""
        with self._ready:
            self._slot = [item]
            self._ready.notify()

    def clear(self) -> None:
        """Drop the waiting item."""
        with self._ready:
            self._slot = []

    @property
    def busy_s(self) -> float:
        """Real seconds since the sending of the present item began; 0 when none is being sent."""
        since = self._sending_since
        return 0.0 if since is None else time.monotonic() - since

    def abandon(self) -> None:
        """Drop the waiting item, take no other, and let the thread end when it can."""
        with self._ready:
            self._closed = True
            self._slot = []
            self._ready.notify()

    def close(self, timeout_s: float = 1.0) -> None:
        """End the thread."""
        self.abandon()
        self._thread.join(timeout_s)

    def _run(self) -> None:
        while True:
            with self._ready:
                while not self._slot and not self._closed:
                    self._ready.wait()
                if self._closed:
                    return
                item = self._slot.pop()
            self._sending_since = time.monotonic()
            try:
                self._send(item)
            except Exception as error:  # the next one may get through
                _LOG.warning("A target was not sent: %s", error)
            self._sending_since = None


class Workers:
    """Threads for work that may hang. Each does one piece at a time; none waits for another.

    An idle thread is used again: ``Thread.start`` holds its caller until the new thread gets its turn, which took more
    than a second on a computer that was too busy.
    """

    def __init__(self, name: str, idle_s: float = IDLE_S) -> None:
        """``name`` is that of the threads; one that had nothing to do for ``idle_s`` real seconds ends."""
        self._name = name
        self._idle_s = idle_s
        self._lock = threading.Lock()
        self._idle: list[_Desk] = []

    def begin(self, work: Callable[[], None]) -> None:
        """Begin some work, which raises nothing."""
        with self._lock:
            desk = self._idle.pop() if self._idle else None
        if desk is None:
            desk = SimpleQueue()
            threading.Thread(target=self._run, args=(desk,), name=self._name, daemon=True).start()
        desk.put(work)

    def _run(self, desk: _Desk) -> None:
        while True:
            try:
                work = desk.get(timeout=self._idle_s)
            except Empty:
                with self._lock:
                    if desk in self._idle:
                        self._idle.remove(desk)
                        return
                continue  # work is on its path to this desk
            work()
            del work  # an idle thread keeps nothing alive
            with self._lock:
                self._idle.append(desk)
