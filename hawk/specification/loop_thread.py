"""An event loop on a thread of its own, for programs without asyncio."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Coroutine
from concurrent.futures import Future
from typing import Any, Final, TypeVar

from hawk.runtime.supervision import end_tasks

T = TypeVar("T")

STOP_S: Final = 5.0
"""Real seconds that a loop on a thread may take to end."""


class LoopThread:
    """An event loop on a daemon thread, for callers without asyncio."""

    def __init__(self, name: str) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name=name, daemon=True)
        self._thread.start()

    def begin(self, work: Coroutine[Any, Any, T]) -> Future[T]:
        """Start a coroutine on the loop."""
        return asyncio.run_coroutine_threadsafe(work, self._loop)

    def call(self, work: Coroutine[Any, Any, T], timeout_s: float | None = None) -> T:
        """Run a coroutine on the loop and return its result. Raises TimeoutError."""
        return self.begin(work).result(timeout_s)

    def stop(self) -> None:
        """Cancel the tasks that still run, and end loop and thread."""
        asyncio.run_coroutine_threadsafe(self._cancel_tasks(), self._loop)
        self._thread.join(STOP_S)
        if not self._thread.is_alive():
            self._loop.run_until_complete(self._loop.shutdown_asyncgens())
            self._loop.close()

    async def _cancel_tasks(self) -> None:
        own = asyncio.current_task()
        await end_tasks(*(task for task in asyncio.all_tasks() if task is not own))
        self._loop.call_soon(self._loop.stop)
