"""Base Socket in the server's role (specification, section 6): for `MessageSocket("SERVER", ...)`."""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import ssl

from aiohttp import WSMsgType, web

from hawk.comm.base_socket import (
    CLOSE_TIMEOUT_S,
    LOOPBACK,
    PING_INTERVAL_S,
    RECEIVE_LIMIT_BYTES,
    ConnectionTimeout,
    FailedToSend,
    SocketClosedError,
)


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
