"""Answers to Check Fence, computed on a thread of their own: the geometry of 69 corners costs milliseconds."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from hawk.comm.protocol.commands import Ack, Outgoing
from hawk.comm.protocol.heartbeat import ClientId
from hawk.ddc.acts import JudgeFence
from hawk.ddc.fence.plan import check_answer
from hawk.ddc.settings import DdcSettings
from hawk.model.sentences import say

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
