"""Base Socket: WebSockets between drone and operator. Message Socket adds queues, threads and reconnecting.

A WebSocket delivers whole messages, so a received string is never half a message or two at once (the specification
leaves that to the developer in 6.4.5).
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import socket
import ssl
from asyncio.trsock import TransportSocket
from typing import Final

import aiohttp
from aiohttp import WSMsgType, web

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


class ServerBaseSocket:
    """The server's role: clients connect to it, and `send` reaches all of them.

    The daemon's web server stands in its place on the drone (`hawk.web`); this one serves programs that use
    `MessageSocket("SERVER", ...)` alone.
    """

    def __init__(
        self, host: str, port: int, *, path: str = "/ws", token: str | None = None, tls: ssl.SSLContext | None = None
    ) -> None:
        """An empty ``host`` is 127.0.0.1; with a ``token``, which clients must then send, all interfaces.

        ``tls``: the server's certificate and key, for HTTPS; None: HTTP.

        Raises:
            ValueError: The address is not loopback and there is no token.
        """
        if host and host not in LOOPBACK and not token:
            raise ValueError(f"host {host!r} can be reached from the network: a token is needed")
        self._host = host or (None if token else LOOPBACK[0])
        self._port = port
        self._path = path
        self._token = token
        self._tls = tls
        self._clients: set[web.WebSocketResponse] = set()
        self._runner: web.AppRunner | None = None

    @property
    def is_connected(self) -> bool:
        """True while a client is connected."""
        return bool(self._clients)

    async def connect(self, timeout_s: float) -> None:
        """Listen; when already listening, wait for a client. Raises ConnectionTimeout."""
        if self._runner is None:
            await self._listen()
            return
        try:
            async with asyncio.timeout(timeout_s):
                await self._arrived.wait()
        except TimeoutError as error:
            raise ConnectionTimeout(f"no client connected to port {self._port} within {timeout_s:g} s") from error

    async def send(self, text: str) -> None:
        """Send one message to every client. Raises FailedToSend when it reached none."""
        sends = [client.send_str(text) for client in tuple(self._clients)]
        results = await asyncio.gather(*sends, return_exceptions=True)
        if all(isinstance(result, BaseException) for result in results):
            raise FailedToSend(f"no client is connected to port {self._port}")

    async def receive(self) -> str:
        """Wait for a message of any client. Raises SocketClosedError when no client is left."""
        while self._clients or not self._received.empty():
            text = await self._received.get()
            if text is not None:
                return text
        raise SocketClosedError(f"no client is connected to port {self._port}")

    async def close(self) -> None:
        """End all connections and stop listening."""
        runner, self._runner = self._runner, None
        if runner is not None:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(CLOSE_TIMEOUT_S):
                    await asyncio.gather(*(client.close() for client in tuple(self._clients)), return_exceptions=True)
            await runner.cleanup()

    async def _listen(self) -> None:
        self._received: asyncio.Queue[str | None] = asyncio.Queue(1)
        self._arrived = asyncio.Event()
        app = web.Application()
        app.router.add_get(self._path, self._serve)
        runner = web.AppRunner(app, access_log=None, shutdown_timeout=CLOSE_TIMEOUT_S)
        await runner.setup()
        try:
            await web.TCPSite(runner, self._host, self._port, ssl_context=self._tls).start()
        except OSError as error:
            await runner.cleanup()
            raise ConnectionTimeout(f"port {self._port} cannot be listened on: {error}") from error
        self._runner = runner

    async def _serve(self, request: web.Request) -> web.StreamResponse:
        if "Origin" in request.headers:  # a page of another server in somebody's browser
            raise web.HTTPForbidden
        given = request.headers.get("Authorization", "").encode()
        if self._token and not hmac.compare_digest(given, f"Bearer {self._token}".encode()):
            raise web.HTTPUnauthorized
        client = web.WebSocketResponse(heartbeat=PING_INTERVAL_S, max_msg_size=RECEIVE_LIMIT_BYTES)
        await client.prepare(request)
        self._clients.add(client)
        self._arrived.set()
        try:
            async for message in client:
                if message.type is WSMsgType.TEXT:
                    await self._received.put(message.data)
        finally:
            self._clients.discard(client)
            if not self._clients:
                self._arrived.clear()
                with contextlib.suppress(asyncio.QueueFull):  # `receive` then looks again by itself
                    self._received.put_nowait(None)
        return client


def _refusal(status: int) -> str:
    return {
        401: "the token is missing or wrong",
        403: "this host name is not allowed there",
        503: "too many pages are open",
    }.get(status, f"HTTP status {status}")
