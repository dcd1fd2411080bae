"""Requests under way as owned tasks, and their outcomes as facts; Check Fence on a thread: the loop never waits."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from hawk.comm.protocol.commands import Ack, Outgoing
from hawk.comm.protocol.heartbeat import ClientId
from hawk.ddc.acts import Ask, JudgeFence
from hawk.ddc.facts import Answer
from hawk.ddc.fence.plan import check_answer
from hawk.ddc.settings import DdcSettings
from hawk.model.operation import UserError
from hawk.model.sentences import say, words_of
from hawk.runtime.supervision import end_tasks

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
        await end_tasks(*self._tasks.values())

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


PAUSE_S = 0.05
"""Real seconds between two checks: a thread that computes without a pause takes the interpreter lock from the loop."""
REPLACED = say("You asked about another fence since.")

_LOGGER = logging.getLogger(__name__)


class FenceChecks:
    """One fence after the other, in the order in which clients asked.

    At most one question of a client waits: a newer one replaces it, and the answer to the older one says so.
    """

    def __init__(self, settings: DdcSettings, reply: Callable[[ClientId, Outgoing], None]) -> None:
        self._settings = settings
        self._reply = reply
        self._waiting: dict[ClientId, JudgeFence] = {}
        self._executor = ThreadPoolExecutor(max_workers=1, thread_name_prefix="hawk-fence")
        self._task: asyncio.Task[None] | None = None

    def ask(self, question: JudgeFence) -> None:
        """Take a question on the running loop; its answer goes to the client."""
        older = self._waiting.pop(question.client, None)
        if older is not None:
            self._reply(older.client, Ack(id=older.command.id, accepted=False, reason=REPLACED))
        self._waiting[question.client] = question
        if self._task is None or self._task.done():
            self._task = asyncio.get_running_loop().create_task(self._answer_all(), name="ddc: fence checks")

    def close(self) -> None:
        """Answer nobody any more, and end the thread."""
        if self._task is not None:
            self._task.cancel()
        self._executor.shutdown(wait=False, cancel_futures=True)

    async def _answer_all(self) -> None:
        while self._waiting:
            question = self._waiting.pop(next(iter(self._waiting)))
            self._reply(question.client, await self._answer(question))
            await asyncio.sleep(PAUSE_S)

    async def _answer(self, question: JudgeFence) -> Outgoing:
        loop, command = asyncio.get_running_loop(), question.command
        try:
            return await loop.run_in_executor(
                self._executor, check_answer, command, self._settings, question.heights, question.standpoint
            )
        except Exception as error:
            _LOGGER.exception("a fence could not be checked")
            reason = say(
                "The fence could not be checked: {name}: {error}.", name=type(error).__name__, error=str(error)
            )
            return Ack(id=command.id, accepted=False, reason=reason)
