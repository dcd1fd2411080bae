"""Long-running tasks, each reported and started again when it ends; and an exit that cannot hang."""

from __future__ import annotations

import asyncio
import logging
import os
import threading
import time
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any, Final, TypeVar

from hawk.model.operation import Health
from hawk.model.sentences import say, semicolons

_LOG = logging.getLogger(__name__)

PAUSE_S: Final = 1.0
"""Real seconds before a task that ended is started again."""
RECENT_S: Final = 30.0
"""Real seconds for which an ended task makes the program unhealthy."""
HUNG_STATUS: Final = 70
"""Exit status of a program that leaves because it hangs: EX_SOFTWARE of sysexits.h."""
_WORDS_S: Final = 0.2
LOOK_S: Final = 0.25
"""Real seconds between two looks whether work may go on."""
T = TypeVar("T")


async def done_while(may_go_on: Callable[[], bool], work: Coroutine[Any, Any, T]) -> T | None:
    """Return what work returns; None where it may go on no longer: it is ended within `LOOK_S` then."""
    task = asyncio.create_task(work)
    try:
        while not task.done():
            if not may_go_on():
                return None
            await asyncio.wait([task], timeout=LOOK_S)
        return task.result()
    finally:
        if not task.done():
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)


class Supervisor:
    """Owns long-running tasks. None of them may end: one that does is reported and started again."""

    def __init__(
        self,
        report: Callable[[str, str], None] = lambda _name, _words: None,
        pause_s: float = PAUSE_S,
        monotonic: Callable[[], float] = time.monotonic,
    ) -> None:
        """``report`` receives name and reason of each task that ended; ``pause_s`` as PAUSE_S."""
        self._report = report
        self._pause = pause_s
        self._monotonic = monotonic
        self._tasks: set[asyncio.Task[None]] = set()
        self._ended: dict[str, tuple[float, str]] = {}

    def start(self, name: str, work: Callable[[], Awaitable[None]]) -> asyncio.Task[None]:
        """Run ``work`` until the returned task is cancelled; needs the running loop."""
        task = asyncio.get_running_loop().create_task(self._keep(name, work), name=name)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    @property
    def health(self) -> Health:
        """Unhealthy while a task ended within RECENT_S."""
        now = self._monotonic()
        recent = [
            say("{name} ended: {words}", name=name, words=words)
            for name, (at, words) in self._ended.items()
            if now - at <= RECENT_S
        ]
        return Health.bad(semicolons(*recent)) if recent else Health()

    async def close(self) -> None:
        """Cancel every task and wait until it has ended."""
        await end_tasks(*self._tasks)

    async def _keep(self, name: str, work: Callable[[], Awaitable[None]]) -> None:
        while True:
            words: str = say("it returned")
            try:
                await work()
            except asyncio.CancelledError:
                if _is_being_cancelled():
                    raise
                words = say("something in it was cancelled")
            except Exception as error:
                _LOG.exception("%s ended", name)
                words = f"{type(error).__name__}: {error}"
            self._note_end(name, words)
            await asyncio.sleep(self._pause)

    def _note_end(self, name: str, words: str) -> None:
        self._ended[name] = (self._monotonic(), words)
        try:
            self._report(name, words)
        except Exception:  # the report must not cost the task
            _LOG.exception("the end of %s could not be reported", name)


async def end_tasks(*tasks: asyncio.Future[Any]) -> list[Any]:
    """Cancel tasks and wait until they have ended; return their results and errors, in that order."""
    for task in tasks:
        task.cancel()
    return await asyncio.gather(*tasks, return_exceptions=True)


async def until_first_ends(*works: Coroutine[Any, Any, None]) -> None:
    """Run coroutines beside each other; when one ends, cancel the others. Raises the error of one that failed."""
    tasks = [asyncio.ensure_future(work) for work in works]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        ended = await end_tasks(*tasks)
    for outcome in ended:
        if isinstance(outcome, Exception):
            raise outcome


def leave_at_once(words: str, status: int = HUNG_STATUS, leave: Callable[[int], None] = os._exit) -> None:
    """End this process without waiting for anything: no thread, no file, no exit handler. The journal is on the disk.

    The log gets ``words`` if it takes them within 0.2 s.
    """
    telling = threading.Thread(target=_LOG.critical, args=("%s", words), daemon=True)
    telling.start()
    telling.join(_WORDS_S)
    leave(status)


def _is_being_cancelled() -> bool:
    task = asyncio.current_task()
    return task is not None and task.cancelling() > 0
