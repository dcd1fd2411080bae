"""Message Socket (specification, section 6): strings between drone and operator, whole and in order.

It has the specification's access programs for both roles. It runs on a loop thread of its own, so that plain Python can
use it; the product has `hawk.comm.message_socket`.
"""

from __future__ import annotations

import asyncio
import contextlib
import ssl
import threading
from collections import deque
from collections.abc import Callable, Coroutine
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from typing import Final, Literal

from hawk.comm.base_socket import BaseSocket, ConnectionTimeout, FailedToSend
from hawk.comm.message_socket import QUEUE_LIMIT, RETRY_S, AsyncMessageSocket
from hawk.specification.loop_thread import LoopThread
from hawk.specification.server_base_socket import ServerBaseSocket

CLOSE_TIMEOUT_S: Final = 3.0
SERVER_RETRY_S: Final = (0.05,)
"""Pause between attempts to listen on a port that is taken; for a client a server waits without one."""


class NoMessagesError(Exception):
    """There is no message to take."""


class MessageSocket:
    """The specification's Message Socket, for programs without asyncio.

    After `init` a lost connection is restored in the background. After a failed `init` both programs that send connect
    again (specification 6.4.4): `send_message_sync` at once, `send_message_async` in the background.
    """

    def __init__(
        self,
        in_type: Literal["SERVER", "OPERATOR"],
        in_host: str,
        in_port: int,
        *,
        timeout_s: float = 5.0,
        token: str | None = None,
        tls: ssl.SSLContext | None = None,
        queue_limit: int = QUEUE_LIMIT,
    ) -> None:
        """Keep the address; nothing is opened before `init`.

        Args:
            in_type: "SERVER" (drone) or "OPERATOR" (client).
            in_host: The drone's address; a server listens on it (empty: see `ServerBaseSocket`).
            in_port: TCP port.
            timeout_s: Real seconds to wait for a connection, and for a client before a server's message fails.
            token: Bearer token that a client sends and a server demands.
            tls: For HTTPS: the certificates that a client trusts, or the server's certificate and key; None: HTTP.
            queue_limit: Received messages that wait at most; a full queue holds the sender up.

        Raises:
            ValueError: Another ``in_type``, or a server that the network could reach without a token.
        """
        if in_type not in ("SERVER", "OPERATOR"):
            raise ValueError(f'in_type must be "SERVER" or "OPERATOR", not {in_type!r}')
        self.type = in_type
        self.host = in_host
        self.port = in_port
        is_server = in_type == "SERVER"
        self._base = (ServerBaseSocket if is_server else BaseSocket)(in_host, in_port, token=token, tls=tls)
        self._retry_s = SERVER_RETRY_S if is_server else RETRY_S
        self._timeout = timeout_s
        self._received: deque[str] = deque()
        self._limit = queue_limit
        self._room = threading.Condition()
        self._initialised = False
        self._opening = threading.Lock()
        self._thread: LoopThread | None = None
        self._socket: AsyncMessageSocket | None = None
        self._pump: Future[None] | None = None

    def init(self) -> None:
        """Connect (client) or listen (server), with empty queues. Raises ConnectionTimeout."""
        self.close()
        with self._room:
            self._received.clear()
            self._initialised = True
        self._open(self._connect)

    def send_message_sync(self, x: str) -> None:
        """Send and block until it is sent; connect first when not connected. Raises FailedToSend."""
        with self._opening:
            if self._initialised and self._thread is None:
                try:
                    self._open(self._connect)
                except ConnectionTimeout as error:
                    raise FailedToSend(str(error)) from error
        thread, socket = self._running()
        thread.call(socket.send_message(x))

    def send_message_async(self, x: str) -> None:
        """Send in the background; connect there first when not connected. A message that waits for 2 s is dropped.

        Raises:
            FailedToSend: `init` was not called, or too many messages wait already.
        """
        with self._opening:
            if self._initialised and self._thread is None:
                self._open(self._connect_later)
        thread, socket = self._running()
        thread.call(_post(socket, x))

    def get_message(self) -> str:
        """Return the oldest message that was not taken yet. Raises NoMessagesError when there is none."""
        with self._room:
            if not self._received:
                raise NoMessagesError("no message has come")
            text = self._received.popleft()
            self._room.notify()
        return text

    def is_connected(self) -> bool:
        """Return True while a connection is established (server: while a client is connected)."""
        return self._socket is not None and self._socket.is_connected

    def close(self) -> None:
        """Close the connection and end the threads. Closing twice is no error."""
        with self._room:
            self._initialised = False
            self._room.notify_all()
        self._stop()

    def _open(self, connect: Callable[[], Coroutine[None, None, AsyncMessageSocket]]) -> None:
        """Start the thread and connect. Raises ConnectionTimeout, and leaves no thread behind then."""
        self._thread = LoopThread("message-socket")
        try:
            self._socket = self._thread.call(connect())
        except BaseException:
            self._stop()
            raise
        self._pump = self._thread.begin(self._forward(self._socket))

    def _stop(self) -> None:
        thread, self._thread = self._thread, None
        socket, self._socket = self._socket, None
        pump, self._pump = self._pump, None
        if thread is None:
            return
        if pump is not None:
            pump.cancel()
        with contextlib.suppress(TimeoutError, CancelledError):
            thread.call((socket or self._base).close(), CLOSE_TIMEOUT_S)
        thread.stop()

    async def _connect(self) -> AsyncMessageSocket:
        socket = AsyncMessageSocket(self._base, timeout_s=self._timeout, retry_s=self._retry_s)
        await socket.init()
        return socket

    async def _connect_later(self) -> AsyncMessageSocket:
        socket = AsyncMessageSocket(self._base, timeout_s=self._timeout, retry_s=self._retry_s)
        socket.begin()
        return socket

    async def _forward(self, socket: AsyncMessageSocket) -> None:
        """Hand messages over on a thread of their own: a full queue blocks there, not on the loop."""
        loop = asyncio.get_running_loop()
        with ThreadPoolExecutor(1, thread_name_prefix="message-socket-queue") as executor:
            while True:
                await loop.run_in_executor(executor, self._put, await socket.get_message())

    def _put(self, text: str) -> None:
        """Keep a message; a full queue holds the sender up (TCP passes that on), so nothing is lost."""
        with self._room:
            self._room.wait_for(lambda: len(self._received) < self._limit or not self._initialised)
            if self._initialised:
                self._received.append(text)

    def _running(self) -> tuple[LoopThread, AsyncMessageSocket]:
        if self._thread is None or self._socket is None:
            raise FailedToSend("the socket is not open; call init() first")
        return self._thread, self._socket


async def _post(socket: AsyncMessageSocket, text: str) -> None:
    socket.post_message(text)
