"""The operator's role of Message Socket for asyncio: a queue each way over a connection that comes back by itself."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections import deque
from collections.abc import Callable
from typing import Final

from hawk.comm.base_socket import BaseSocket, ConnectionTimeout, FailedToSend, SocketClosedError

QUEUE_LIMIT: Final = 256
"""Messages that wait in each direction. A full receive queue stops reading: the drone then sends fewer heartbeats."""
STALE_S: Final = 2.0
"""A message that could not be sent for so long is not sent any more: the drone must not act on an old wish."""
RETRY_S: Final = (0.1, 0.25, 0.5, 1.0, 2.0)
"""Pauses between attempts to connect again; the last one repeats."""


class AsyncMessageSocket:
    """`init`, then `send_message`, `post_message` and `get_message` until `close`. One loop only."""

    def __init__(
        self,
        socket: BaseSocket,
        *,
        timeout_s: float = 5.0,
        queue_limit: int = QUEUE_LIMIT,
        monotonic: Callable[[], float] = time.monotonic,
    ) -> None:
        self._socket = socket
        self._timeout = timeout_s
        self._monotonic = monotonic
        self._received: asyncio.Queue[str] = asyncio.Queue(queue_limit)
        self._waiting: asyncio.Queue[tuple[float, str]] = asyncio.Queue(queue_limit)
        self._undelivered: deque[str] = deque(maxlen=queue_limit)
        self._connected = asyncio.Event()
        self._connecting = asyncio.Lock()
        self._tasks: list[asyncio.Task[None]] = []

    @property
    def is_connected(self) -> bool:
        """Whether there is a connection now."""
        return self._connected.is_set() and self._socket.is_connected

    @property
    def socket(self) -> BaseSocket:
        """The connection below, for HTTP requests of the same session."""
        return self._socket

    async def init(self) -> None:
        """Connect and start the tasks that read and write. Raises ConnectionTimeout."""
        try:
            await self._connect()
        except ConnectionTimeout:
            if not self._tasks:
                await self._socket.close()
            raise
        if not self._tasks:
            self._tasks = [
                asyncio.create_task(self._read(), name="message-socket-read"),
                asyncio.create_task(self._write(), name="message-socket-write"),
            ]

    async def send_message(self, text: str) -> None:
        """Send now; connects again first when there is no connection. Raises FailedToSend."""
        if not self.is_connected:
            try:
                await self._connect()
            except ConnectionTimeout as error:
                raise FailedToSend(str(error)) from error
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

    def take_undelivered(self) -> list[str]:
        """Return, once, the last posted messages that were given up because the link was away too long."""
        lost = list(self._undelivered)
        self._undelivered.clear()
        return lost

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
            await self._socket.connect(self._timeout)
            self._connected.set()

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
            await asyncio.sleep(RETRY_S[min(attempt, len(RETRY_S) - 1)])
            attempt += 1
            with contextlib.suppress(ConnectionTimeout):
                await self._connect()

    async def _write(self) -> None:
        while True:
            posted, text = await self._waiting.get()
            await self._connected.wait()
            if self._monotonic() - posted > STALE_S:
                self._undelivered.append(text)
                continue
            try:
                await self._socket.send(text)
            except FailedToSend:
                self._connected.clear()
                self._undelivered.append(text)
