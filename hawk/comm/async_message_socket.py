"""Message Socket for asyncio: a queue each direction over a connection that is restored after a loss."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from collections.abc import Callable, Coroutine, Sequence
from typing import Final

from hawk.comm.base_socket import BaseSocket, ConnectionTimeout, FailedToSend, ServerBaseSocket, SocketClosedError

_LOG = logging.getLogger(__name__)

QUEUE_LIMIT: Final = 256
"""Messages that wait in each direction. A full receive queue stops reading: the drone then sends fewer heartbeats."""
STALE_S: Final = 2.0
"""A posted message that waited longer for the link is dropped: the drone must not act on an old command."""
_SLACK_S: Final = 0.05
"""Real seconds by which the words of the attempt itself come first."""
RETRY_S: Final = (0.1, 0.25, 0.5, 1.0, 2.0)
"""Pauses between attempts to connect again; the last one repeats."""


class AsyncMessageSocket:
    """`init`, then `send_message`, `post_message` and `get_message` until `close`. One loop only."""

    def __init__(
        self,
        socket: BaseSocket | ServerBaseSocket,
        *,
        timeout_s: float = 5.0,
        queue_limit: int = QUEUE_LIMIT,
        retry_s: Sequence[float] = RETRY_S,
        monotonic: Callable[[], float] = time.monotonic,
    ) -> None:
        self._socket = socket
        self._timeout = timeout_s
        self._retry_s = retry_s
        self._monotonic = monotonic
        self._received: asyncio.Queue[str] = asyncio.Queue(queue_limit)
        self._waiting: asyncio.Queue[tuple[float, str]] = asyncio.Queue(queue_limit)
        self._connected = asyncio.Event()
        self._connecting = asyncio.Lock()
        self._tasks: list[asyncio.Task[None]] = []
        self._problem = ""

    @property
    def is_connected(self) -> bool:
        """True while there is a connection."""
        return self._connected.is_set() and self._socket.is_connected

    async def init(self) -> None:
        """Connect and start the tasks that read and write. Raises ConnectionTimeout."""
        try:
            await self._connect()
        except ConnectionTimeout:
            if not self._tasks:
                await self._socket.close()
            raise

    def begin(self) -> None:
        """Start the tasks, and connect in the background; needs the running loop."""
        if not self._tasks:
            self._start(self._reconnect_and_read())

    async def send_message(self, text: str) -> None:
        """Send now; connect first when there is no connection, within the time-out. Raises FailedToSend."""
        if not self.is_connected:
            try:
                # an attempt in the background may hold the lock: waiting for it counts too
                async with asyncio.timeout(self._timeout + _SLACK_S):
                    await self._connect()
            except ConnectionTimeout as error:
                raise FailedToSend(str(error)) from error
            except TimeoutError:
                raise FailedToSend(self._problem or f"no connection within {self._timeout:g} s") from None
        await self._socket.send(text)

    def post_message(self, text: str) -> None:
        """Send in the background. Raises FailedToSend when too many messages wait already."""
        try:
            self._waiting.put_nowait((self._monotonic(), text))
        except asyncio.QueueFull:
            raise FailedToSend(f"{self._waiting.maxsize} messages wait already; send again later") from None

    async def get_message(self) -> str:
        """Wait for the oldest message that was not taken yet and return it."""
        return await self._received.get()

    async def close(self) -> None:
        """End tasks and connection."""
        tasks, self._tasks = self._tasks, []
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        self._connected.clear()
        await self._socket.close()

    async def _connect(self) -> None:
        async with self._connecting:
            if self.is_connected:
                return
            self._connected.clear()
            try:
                await self._socket.connect(self._timeout)
            except ConnectionTimeout as error:
                self._problem = str(error)
                raise
            self._connected.set()
            if not self._tasks:
                self._start(self._read())

    def _start(self, read: Coroutine[None, None, None]) -> None:
        self._tasks = [
            asyncio.create_task(read, name="message-socket-read"),
            asyncio.create_task(self._write(), name="message-socket-write"),
        ]

    async def _reconnect_and_read(self) -> None:
        await self._reconnect()
        await self._read()

    async def _read(self) -> None:
        """Fill the queue; after a lost connection try again until closed."""
        while True:
            try:
                while True:
                    await self._received.put(await self._socket.receive())
            except SocketClosedError:
                self._connected.clear()
            await self._reconnect()

    async def _reconnect(self) -> None:
        attempt = 0
        while not self.is_connected:
            await asyncio.sleep(self._retry_s[min(attempt, len(self._retry_s) - 1)])
            attempt += 1
            with contextlib.suppress(ConnectionTimeout):
                await self._connect()

    async def _write(self) -> None:
        while True:
            posted, text = await self._waiting.get()
            await self._connected.wait()
            if self._monotonic() - posted > STALE_S:
                _LOG.warning("A message that waited longer than %.0f s for the link was dropped", STALE_S)
                continue
            try:
                await self._socket.send(text)
            except FailedToSend as error:
                self._connected.clear()
                _LOG.warning("A message was not sent: %s", error)
