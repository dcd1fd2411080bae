"""Base Socket: WebSockets between drone and operator. Message Socket adds queues, threads and reconnecting.

A WebSocket delivers whole messages, so a received string is never half a message or two at once (the specification
leaves that to the developer in 6.4.5).
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
import ssl
from asyncio.trsock import TransportSocket
from typing import Final, Protocol

import aiohttp
from aiohttp import WSMsgType

RECEIVE_LIMIT_BYTES: Final = 4 * 1024 * 1024
"""A heartbeat has at most about 70 kB; a message beyond this limit ends the connection."""
PING_INTERVAL_S: Final = 5.0
"""Real seconds between pings: a dead link shows after one and a half of them."""
CLOSE_TIMEOUT_S: Final = 1.0
"""Longest wait for the other side's end of a connection, real seconds; then it is cut off."""
_CLOSED_POLL_S: Final = 0.005
LOOPBACK: Final = ("127.0.0.1", "::1", "localhost")


class ConnectionTimeout(ConnectionError):  # noqa: N818 - the specification's name
    """No connection was made in time; the text names the address and the reason."""


class FailedToSend(ConnectionError):  # noqa: N818 - the specification's name
    """The message was not sent; the text gives the reason."""


class SocketClosedError(ConnectionError):
    """The other side, or the link, ended the connection."""


class MessageLink(Protocol):
    """One end of a WebSocket, as `hawk.comm.message_socket.AsyncMessageSocket` needs it."""

    @property
    def is_connected(self) -> bool:
        """True while messages can be sent."""
        ...

    async def connect(self, timeout_s: float) -> None:
        """Open a connection. Raises ConnectionTimeout."""
        ...

    async def send(self, text: str) -> None:
        """Send one message. Raises FailedToSend."""
        ...

    async def receive(self) -> str:
        """Wait for the next message. Raises SocketClosedError."""
        ...

    async def close(self) -> None:
        """End the connection."""
        ...


class BaseSocket:
    """The client's role. Cookies outlive the connection, so a session (and its control) is found again."""

    def __init__(
        self, host: str, port: int, *, path: str = "/ws", token: str | None = None, tls: ssl.SSLContext | None = None
    ) -> None:
        """``tls``: certificates that are trusted, for a server with HTTPS; None: HTTP."""
        shown = f"[{host}]" if ":" in host else host
        self.url = f"{'http' if tls is None else 'https'}://{shown}:{port}"
        self._tls = tls
        self._path = path
        self._headers = {"Authorization": f"Bearer {token}"} if token else {}
        self._session: aiohttp.ClientSession | None = None
        self._socket: aiohttp.ClientWebSocketResponse | None = None

    @property
    def is_connected(self) -> bool:
        """True while messages can be sent."""
        return self._socket is not None and not self._socket.closed

    async def connect(self, timeout_s: float) -> None:
        """Open a new connection in place of the old one. Raises ConnectionTimeout after ``timeout_s`` at most."""
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
        except aiohttp.ClientConnectorCertificateError as error:
            words = f"{self.url}: its certificate is not trusted: {error.certificate_error}"
            raise ConnectionTimeout(f"{words}; name a self-signed one (--certificate FILE)") from error
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
            if message.type is WSMsgType.TEXT:
                return str(message.data)
            if message.type is not WSMsgType.BINARY:
                raise SocketClosedError(f"{self.url} ended the connection")

    def session(self) -> aiohttp.ClientSession:
        """Return the HTTP session that shares cookies and token with the WebSocket."""
        if self._session is None or self._session.closed:
            # Browsers keep cookies of bare addresses; aiohttp does so only with `unsafe`.
            connector = None if self._tls is None else aiohttp.TCPConnector(ssl=self._tls)
            self._session = aiohttp.ClientSession(
                headers=self._headers, cookie_jar=aiohttp.CookieJar(unsafe=True), connector=connector
            )
        return self._session

    async def close(self) -> None:
        """End the connection and forget the cookies."""
        opened = None if self._socket is None else self._socket.get_extra_info("socket")
        await self._drop()
        if self._session is not None:
            await self._session.close()
            self._session = None
        if opened is not None:
            await _closed(opened)

    async def _drop(self) -> None:
        if self._socket is not None:
            left, self._socket = self._socket, None
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(CLOSE_TIMEOUT_S):
                    await left.close()


async def _closed(opened: TransportSocket) -> None:
    """Wait until asyncio has closed a socket: TLS ends by a handshake, which a loop that stops now would leave open."""
    with contextlib.suppress(OSError):
        opened.shutdown(socket.SHUT_RDWR)
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(CLOSE_TIMEOUT_S):
            while opened.fileno() >= 0:  # noqa: ASYNC110 - a transport reports its end to nobody else
                await asyncio.sleep(_CLOSED_POLL_S)


def _refusal(status: int) -> str:
    return {
        401: "the token is missing or wrong",
        403: "this host name is not allowed there",
        503: "too many pages are open",
    }.get(status, f"HTTP status {status}")
