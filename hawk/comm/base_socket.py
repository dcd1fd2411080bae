"""Base Socket: one WebSocket to the drone, without queue, thread or reconnecting (those are Message Socket's).

WebSocket framing delivers whole messages only, so a string is never half a message or two at once (the specification
leaves that to the developer in 6.4.5).
"""

from __future__ import annotations

import asyncio
from types import TracebackType
from typing import Final, Self

import aiohttp

RECEIVE_LIMIT_BYTES: Final = 4 * 1024 * 1024
"""A heartbeat is at most about 70 kB; anything beyond this limit ends the connection."""
PING_INTERVAL_S: Final = 5.0
"""Real seconds between pings: a dead link shows after one and a half of them."""
CLOSE_TIMEOUT_S: Final = 1.0


class ConnectionTimeout(ConnectionError):  # noqa: N818 - the specification's name
    """No connection came about in time; the text says to what and why."""


class FailedToSend(ConnectionError):  # noqa: N818 - the specification's name
    """The message was not sent; the text says why."""


class SocketClosedError(ConnectionError):
    """The other side, or the link, ended the connection."""


class BaseSocket:
    """A WebSocket client. Cookies outlive the connection, so that a session (and its control) is found again."""

    def __init__(self, host: str, port: int, *, path: str = "/ws", token: str | None = None) -> None:
        shown = f"[{host}]" if ":" in host else host
        self.url = f"http://{shown}:{port}"
        self._path = path
        self._headers = {"Authorization": f"Bearer {token}"} if token else {}
        self._session: aiohttp.ClientSession | None = None
        self._socket: aiohttp.ClientWebSocketResponse | None = None

    @property
    def is_connected(self) -> bool:
        """Whether messages can be sent."""
        return self._socket is not None and not self._socket.closed

    async def connect(self, timeout_s: float) -> None:
        """Open the connection (no matter if there was one). Raises ConnectionTimeout after ``timeout_s`` at most."""
        await self._drop()
        try:
            async with asyncio.timeout(timeout_s):
                self._socket = await self.session().ws_connect(
                    self.url + self._path, heartbeat=PING_INTERVAL_S, max_msg_size=RECEIVE_LIMIT_BYTES
                )
        except aiohttp.WSServerHandshakeError as error:
            raise ConnectionTimeout(f"{self.url} refused the connection: {_refusal(error.status)}") from error
        except TimeoutError as error:
            raise ConnectionTimeout(f"{self.url} did not answer within {timeout_s:g} s") from error
        except (aiohttp.ClientError, OSError) as error:
            raise ConnectionTimeout(f"{self.url} cannot be reached: {error}") from error

    async def send(self, text: str) -> None:
        """Send one message. Raises FailedToSend."""
        if self._socket is None or self._socket.closed:
            raise FailedToSend(f"not connected to {self.url}")
        try:
            await self._socket.send_str(text)
        except (aiohttp.ClientError, ConnectionError, RuntimeError) as error:
            raise FailedToSend(f"{self.url}: {error}") from error

    async def receive(self) -> str:
        """Wait for one message. Raises SocketClosedError when the connection has ended."""
        if self._socket is None:
            raise SocketClosedError(f"not connected to {self.url}")
        while True:
            message = await self._socket.receive()
            if message.type is aiohttp.WSMsgType.TEXT:
                return str(message.data)
            if message.type is not aiohttp.WSMsgType.BINARY:
                raise SocketClosedError(f"{self.url} ended the connection")

    def session(self) -> aiohttp.ClientSession:
        """Return the HTTP session that shares cookies and token with the WebSocket."""
        if self._session is None or self._session.closed:
            # Browsers keep cookies of bare addresses; aiohttp does so only when told.
            self._session = aiohttp.ClientSession(headers=self._headers, cookie_jar=aiohttp.CookieJar(unsafe=True))
        return self._session

    async def close(self) -> None:
        """End the connection and forget the cookies."""
        await self._drop()
        if self._session is not None:
            await self._session.close()
            self._session = None

    async def _drop(self) -> None:
        if self._socket is not None:
            socket, self._socket = self._socket, None
            try:
                async with asyncio.timeout(CLOSE_TIMEOUT_S):
                    await socket.close()
            except TimeoutError:
                pass

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        await self.close()


def _refusal(status: int) -> str:
    return {
        401: "the token is missing or wrong",
        403: "this host name is not allowed there",
        503: "too many pages are open",
    }.get(status, f"HTTP status {status}")
