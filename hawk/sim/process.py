"""When to end: a signal, or the parent's death."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal


class ParentGoneError(Exception):
    """There is no process of that number."""


class EndSignal:
    """Set by SIGTERM, SIGINT, or the end of a parent process. Use as a context manager on the loop."""

    def __init__(self, parent_pid: int | None = None) -> None:
        self._parent_pid = parent_pid
        self._event = asyncio.Event()
        self._pidfd: int | None = None

    def __enter__(self) -> EndSignal:
        loop = asyncio.get_running_loop()
        if self._parent_pid is not None:
            try:
                self._pidfd = os.pidfd_open(self._parent_pid)
            except OSError as error:
                raise ParentGoneError(f"no process {self._parent_pid}") from error
            # a pidfd becomes readable when its process ends
            loop.add_reader(self._pidfd, self._event.set)
        for number in (signal.SIGTERM, signal.SIGINT):
            loop.add_signal_handler(number, self._event.set)
        return self

    def __exit__(self, *_: object) -> None:
        loop = asyncio.get_running_loop()
        for number in (signal.SIGTERM, signal.SIGINT):
            loop.remove_signal_handler(number)
        if self._pidfd is not None:
            loop.remove_reader(self._pidfd)
            with contextlib.suppress(OSError):
                os.close(self._pidfd)

    async def wait(self) -> None:
        """Wait until it is time to end."""
        await self._event.wait()
