"""Carries a client's strings over a WebSocket on a loop thread of its own, for callers without asyncio."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import Callable, Coroutine
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from typing import Any, Final, TypeVar

from hawk.comm.async_message_socket import AsyncMessageSocket
from hawk.comm.base_socket import BaseSocket, FailedToSend

CLOSE_TIMEOUT_S: Final = 3.0

T = TypeVar("T")


class ClientTransport:
    """A `hawk.comm.message_socket.Transport` for the operator's role."""

    def __init__(self, socket: BaseSocket, *, timeout_s: float) -> None:
        self._base = socket
        self._timeout = timeout_s
        self._thread: _LoopThread | None = None
        self._socket: AsyncMessageSocket | None = None
        self._pump: Future[None] | None = None

    @property
    def is_connected(self) -> bool:
        """Whether there is a connection now."""
        return self._socket is not None and self._socket.is_connected

    def open(self, on_message: Callable[[str], None]) -> None:
        """Connect. Raises ConnectionTimeout, and leaves no thread behind then."""
        self.close()
        self._thread = _LoopThread()
        try:
            self._socket = self._thread.call(self._start())
        except BaseException:
            self.close()
            raise
        self._pump = self._thread.begin(self._forward(self._socket, on_message))

    def send(self, text: str) -> None:
        """Send and wait until it is sent. Raises FailedToSend."""
        thread, socket = self._running()
        thread.call(socket.send_message(text))

    def post(self, text: str) -> None:
        """Send in the background. Raises FailedToSend when too many messages wait."""
        thread, socket = self._running()
        thread.call(_post(socket, text))

    def close(self) -> None:
        """End connection and thread; closing twice is no error."""
        thread, self._thread = self._thread, None
        socket, self._socket = self._socket, None
        pump, self._pump = self._pump, None
        if thread is None:
            return
        if pump is not None:
            pump.cancel()
        with contextlib.suppress(TimeoutError, CancelledError):
            thread.call((socket.close if socket is not None else self._base.close)(), CLOSE_TIMEOUT_S)
        thread.stop()

    async def _start(self) -> AsyncMessageSocket:
        socket = AsyncMessageSocket(self._base, timeout_s=self._timeout)
        await socket.init()
        return socket

    async def _forward(self, socket: AsyncMessageSocket, on_message: Callable[[str], None]) -> None:
        """Hand messages over on a thread of their own: a full queue blocks there, not on the loop."""
        loop = asyncio.get_running_loop()
        with ThreadPoolExecutor(1, thread_name_prefix="message-socket-queue") as executor:
            while True:
                await loop.run_in_executor(executor, on_message, await socket.get_message())

    def _running(self) -> tuple[_LoopThread, AsyncMessageSocket]:
        if self._thread is None or self._socket is None:
            raise FailedToSend("the socket is not open; call init() first")
        return self._thread, self._socket


class _LoopThread:
    """An event loop on a daemon thread."""

    def __init__(self) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="message-socket", daemon=True)
        self._thread.start()

    def begin(self, work: Coroutine[Any, Any, T]) -> Future[T]:
        return asyncio.run_coroutine_threadsafe(work, self._loop)

    def call(self, work: Coroutine[Any, Any, T], timeout_s: float | None = None) -> T:
        return self.begin(work).result(timeout_s)

    def stop(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(CLOSE_TIMEOUT_S)
        if not self._thread.is_alive():
            self._loop.run_until_complete(self._loop.shutdown_asyncgens())
            self._loop.close()


async def _post(socket: AsyncMessageSocket, text: str) -> None:
    socket.post_message(text)
