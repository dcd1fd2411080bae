"""Requests to the autopilot as owned tasks that the tick looks at: the loop never waits for an answer."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from enum import Enum
from typing import Any

from hawk.ddc.errors import ReqFailed


class RequestStatus(Enum):
    """How far a request is."""

    PENDING = "pending"
    DONE = "done"
    FAILED = "failed"


class Request:
    """One request under way: ``name`` for logs, ``started`` in seconds."""

    def __init__(self, name: str, task: asyncio.Task[Any], started: float) -> None:
        self.name = name
        self.started = started
        self._task = task

    @property
    def status(self) -> RequestStatus:
        """Pending, done or failed."""
        if not self._task.done():
            return RequestStatus.PENDING
        if self._task.cancelled() or self._task.exception() is not None:
            return RequestStatus.FAILED
        return RequestStatus.DONE

    @property
    def is_pending(self) -> bool:
        """Whether the answer is still to come."""
        return self.status is RequestStatus.PENDING

    @property
    def is_done(self) -> bool:
        """Whether it was answered well."""
        return self.status is RequestStatus.DONE

    @property
    def has_failed(self) -> bool:
        """Whether it was refused, or not answered."""
        return self.status is RequestStatus.FAILED

    @property
    def reason(self) -> str:
        """Why it failed, in the autopilot's own words where it gave any; empty otherwise."""
        if not self.has_failed:
            return ""
        if self._task.cancelled():
            return "cancelled"
        error = self._task.exception()
        return str(error) or type(error).__name__


class Requests:
    """Owns the tasks of all requests: each is named, kept until it ends, reported once, and cancelled at the close."""

    def __init__(self, clock: Callable[[], float], report: Callable[[str, str], None]) -> None:
        self._clock = clock
        self._report = report
        self._tasks: set[asyncio.Task[Any]] = set()

    @property
    def is_busy(self) -> bool:
        """Whether any request is under way."""
        return bool(self._tasks)

    def start(self, name: str, call: Coroutine[Any, Any, Any]) -> Request:
        """Start a request on the running loop."""
        task = asyncio.get_running_loop().create_task(call, name=f"ddc: {name}")
        self._tasks.add(task)
        task.add_done_callback(lambda done: self._ended(name, done))
        return Request(name, task, self._clock())

    async def finish(self) -> None:
        """Wait until every request under way has ended."""
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def close(self) -> None:
        """Cancel what is under way and wait until it has ended."""
        tasks = tuple(self._tasks)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def _ended(self, name: str, task: asyncio.Task[Any]) -> None:
        self._tasks.discard(task)
        if task.cancelled():
            return
        error = task.exception()
        if error is None:
            self._report(name, "")
        elif isinstance(error, ReqFailed):
            self._report(name, str(error))
        else:
            self._report(name, f"{type(error).__name__}: {error}")
