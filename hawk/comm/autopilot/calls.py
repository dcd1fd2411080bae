"""Calls into MAVSDK, each on a thread that does nothing else meanwhile, with a deadline.

One that hangs delays no other, nor the exit.
"""

from __future__ import annotations

import asyncio
import contextlib
import functools
import logging
import time
from collections import deque
from collections.abc import Callable
from typing import Any, Final, TypeVar

from hawk.comm.autopilot.vehicle import AutopilotError
from hawk.comm.threads import Workers
from hawk.model.operation import Health
from hawk.model.sentences import say

_LOG = logging.getLogger(__name__)
T = TypeVar("T")

DEADLINE_S: Final = 3.0
"""Real seconds that a call may take: MAVSDK waits 2 s for an acknowledgement."""
RECENT_S: Final = 60.0
"""A call that came back late counts as overdue for this time, real seconds."""
HANGING_LIMIT: Final = 16
"""Number of hanging calls after which no other is begun, but for Kill and other ``urgent`` ones."""


class Calls:
    """Runs blocking calls for the loop and counts those that do not return in time."""

    def __init__(
        self, prefix: str, deadline_s: float = DEADLINE_S, monotonic: Callable[[], float] = time.monotonic
    ) -> None:
        """``prefix`` is the threads' name."""
        self._workers = Workers(prefix)
        self.deadline_s = deadline_s
        """For calls without a deadline of their own, real seconds."""
        self._monotonic = monotonic
        self._hanging: dict[object, str] = {}
        self._late: deque[float] = deque(maxlen=HANGING_LIMIT)
        self._under_way = 0
        self._idle = asyncio.Event()
        self._idle.set()
        self.on_overdue: Callable[[str], None] = lambda _name: None
        """Called on the loop with the name of a call that has passed its deadline."""

    @property
    def overdue(self) -> int:
        """Number of calls that hang past their deadline, or came back late within RECENT_S."""
        while self._late and self._monotonic() - self._late[0] > RECENT_S:
            self._late.popleft()
        return len(self._hanging) + len(self._late)

    @property
    def health(self) -> Health:
        """Unhealthy while a call is overdue."""
        if self._hanging:
            names = ", ".join(sorted(set(self._hanging.values())))
            return Health.bad(say("MAVSDK does not return: {names}. Restart the program on the ground.", names=names))
        return Health.bad(say("MAVSDK returned late.")) if self.overdue else Health()

    async def run(
        self,
        name: str,
        function: Callable[..., T],
        *arguments: Any,
        deadline_s: float | None = None,
        urgent: bool = False,
    ) -> T:
        """Call on another thread and return the result.

        Args:
            name: For messages.
            function: May block.
            arguments: Its arguments.
            deadline_s: Real seconds; None: the usual ones.
            urgent: Begun however many calls hang.

        Raises:
            AutopilotError: The call has not returned by its deadline, or too many hang already.
            Exception: The function's own.
        """
        if len(self._hanging) >= HANGING_LIMIT and not urgent:
            raise AutopilotError(
                say("{name}: not begun, {hanging} calls hang in MAVSDK", name=name, hanging=len(self._hanging))
            )
        loop = asyncio.get_running_loop()
        limit = self.deadline_s if deadline_s is None else deadline_s
        outcome: asyncio.Future[T] = loop.create_future()
        key = object()
        timer = loop.call_later(limit, self._pass_deadline, key, name, limit, outcome)
        self._under_way += 1
        self._idle.clear()

        def end(result: T | None, error: BaseException | None) -> None:
            timer.cancel()
            self._return(key, name)
            if outcome.done():
                return
            if error is not None:
                outcome.set_exception(error)
            else:
                outcome.set_result(result)  # type: ignore[arg-type]

        self._workers.begin(functools.partial(_work, loop, end, function, arguments))
        return await outcome

    async def finish(self, wait_s: float) -> bool:
        """Wait until no call is under way, real seconds at most; return False when some are."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(wait_s):
                await self._idle.wait()
        return self._idle.is_set()

    def note_overdue(self, name: str) -> None:
        """Count a call of another thread that does not return, for ever."""
        self._hanging[object()] = name
        self._report_overdue(name)

    def _pass_deadline(self, key: object, name: str, limit: float, outcome: asyncio.Future[Any]) -> None:
        self._hanging[key] = name
        if not outcome.done():
            outcome.set_exception(
                AutopilotError(say("{name}: MAVSDK did not return within {limit:g} s", name=name, limit=limit))
            )
        self._report_overdue(name)

    def _report_overdue(self, name: str) -> None:
        self.on_overdue(name)  # before anything that may block
        _LOG.error("MAVSDK hangs in: %s", name)

    def _return(self, key: object, name: str) -> None:
        self._under_way -= 1
        if not self._under_way:
            self._idle.set()
        if self._hanging.pop(key, None) is not None:
            _LOG.warning("MAVSDK returned late from: %s", name)
            self._late.append(self._monotonic())


def _work(
    loop: asyncio.AbstractEventLoop,
    end: Callable[[Any, BaseException | None], None],
    function: Callable[..., Any],
    arguments: tuple[Any, ...],
) -> None:
    result: Any = None
    error: BaseException | None = None
    try:
        result = function(*arguments)
    except BaseException as raised:  # it belongs to the caller
        error = raised
    try:
        loop.call_soon_threadsafe(end, result, error)
    except RuntimeError:  # the loop has ended
        return
