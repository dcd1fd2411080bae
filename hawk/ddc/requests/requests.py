"""Requests under way as owned tasks, and the outcomes that become facts: the loop never waits for an answer."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Any

from hawk.ddc.acts import Ask
from hawk.ddc.facts import Answer
from hawk.model.operation import UserError
from hawk.model.sentences import say, words_of

KEPT_S = 30.0
"""An answer remains a fact for this time, seconds."""

Key = tuple[str, float]


@dataclass(slots=True)
class Outcomes:
    """Outcomes of acts other than requests."""

    target_refusal: str = ""
    """Reason why the last target was not sent; empty when it was."""
    starts_in_air: int | None = None
    desired_count: int = 0
    """Number of the newest desired pose."""
    user_error: UserError = UserError.NONE
    user_error_text: str = ""


class Requests:
    """Owns the tasks of all requests: each is named, kept until it ends, reported once, and cancelled at the close."""

    def __init__(self, clock: Callable[[], float], report: Callable[[str, str], None]) -> None:
        self._clock = clock
        self._report = report
        self._tasks: dict[Key, asyncio.Task[Any]] = {}
        self._ended: dict[Key, tuple[float, Answer]] = {}

    @property
    def is_busy(self) -> bool:
        """True while any request is under way."""
        return bool(self._tasks)

    def answers(self) -> tuple[Answer, ...]:
        """Return the requests under way, and those that ended within `KEPT_S`, as facts."""
        now = self._clock()
        if self._ended:
            self._ended = {key: ended for key, ended in self._ended.items() if now - ended[0] <= KEPT_S}
        pending = [Answer(name, asked, "pending") for name, asked in self._tasks]
        return (*pending, *(answer for _, answer in self._ended.values()))

    def start(self, ask: Ask, call: Callable[[], Coroutine[Any, Any, Any]]) -> None:
        """Start a request on the running loop, once."""
        key = (ask.name, ask.at)
        if key in self._tasks or key in self._ended:
            return
        work = call()
        task = asyncio.get_running_loop().create_task(_in_time(work, ask.limit_s), name=f"ddc: {ask.name}")
        self._tasks[key] = task

        def end(done: asyncio.Task[Any]) -> None:
            work.close()  # of a task that was cancelled before it began
            self._end(key, done)

        task.add_done_callback(end)

    async def finish(self) -> None:
        """Wait until every request under way has ended."""
        await asyncio.gather(*self._tasks.values(), return_exceptions=True)

    async def close(self) -> None:
        """Cancel what is under way and wait until it has ended."""
        tasks = tuple(self._tasks.values())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def _end(self, key: Key, task: asyncio.Task[Any]) -> None:
        self._tasks.pop(key, None)
        answer = _answer(key, task)
        self._ended[key] = (self._clock(), answer)
        if not task.cancelled():
            self._report(key[0], answer.reason if answer.has_failed else "")


async def _in_time(call: Coroutine[Any, Any, Any], limit_s: float) -> Any:
    """Await a call. Raises TimeoutError with words for the operator when it takes longer than its limit."""
    try:
        async with asyncio.timeout(limit_s):
            return await call
    except TimeoutError as error:
        raise TimeoutError(words_of(error) or say("no answer within {limit:g} s", limit=limit_s)) from error


def _answer(key: Key, task: asyncio.Task[Any]) -> Answer:
    name, asked = key
    if task.cancelled():
        return Answer(name, asked, "failed", say("cancelled"))
    error = task.exception()
    if error is None:
        value = task.result()
        return Answer(name, asked, "done", value=float(value) if isinstance(value, int | float) else None)
    return Answer(name, asked, "failed", words_of(error) or type(error).__name__)
