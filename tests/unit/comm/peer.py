"""A WebSocket server on a thread of its own, for clients that block."""

from __future__ import annotations

import asyncio
import queue
import threading
from collections.abc import Coroutine
from typing import Any

from aiohttp import WSMsgType, web

PATIENCE_S = 5.0


class Peer:
    """Takes every message into ``received``; sends, drops clients, stops and starts again on the same port."""

    def __init__(self) -> None:
        self.received: queue.Queue[str] = queue.Queue()
        self.connected: queue.Queue[str | None] = queue.Queue()
        self.port = 0
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="peer")
        self._thread.start()
        self._sockets: set[web.WebSocketResponse] = set()
        self._runner: web.AppRunner | None = None

    def start(self) -> None:
        self._call(self._start())

    def stop(self) -> None:
        self._call(self._stop())

    def send(self, *texts: str) -> None:
        self._call(self._send(texts))

    def drop(self) -> None:
        """End every connection without a word."""
        self._call(self._drop())

    def next(self) -> str:
        return self.received.get(timeout=PATIENCE_S)

    def close(self) -> None:
        self.stop()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(PATIENCE_S)
        self._loop.close()

    def _call(self, work: Coroutine[Any, Any, None]) -> None:
        asyncio.run_coroutine_threadsafe(work, self._loop).result(PATIENCE_S)

    async def _start(self) -> None:
        app = web.Application()
        app.router.add_get("/ws", self._serve)
        app.router.add_get("/refuse", self._refuse)
        self._runner = web.AppRunner(app, access_log=None, shutdown_timeout=0.1)
        await self._runner.setup()
        await web.TCPSite(self._runner, "127.0.0.1", self.port).start()
        self.port = self._runner.addresses[0][1]

    async def _stop(self) -> None:
        await self._drop()
        if self._runner is not None:
            await self._runner.cleanup()
            self._runner = None

    async def _send(self, texts: tuple[str, ...]) -> None:
        for socket in tuple(self._sockets):
            for text in texts:
                await socket.send_str(text)

    async def _drop(self) -> None:
        for socket in tuple(self._sockets):
            if socket._req is not None and socket._req.transport is not None:
                socket._req.transport.abort()

    async def _refuse(self, _: web.Request) -> web.StreamResponse:
        raise web.HTTPForbidden

    async def _serve(self, request: web.Request) -> web.StreamResponse:
        socket = web.WebSocketResponse()
        socket.set_cookie("session", "s1")
        await socket.prepare(request)
        self._sockets.add(socket)
        self.connected.put(request.cookies.get("session"))
        try:
            async for message in socket:
                if message.type is WSMsgType.TEXT:
                    self.received.put(message.data)
        finally:
            self._sockets.discard(socket)
        return socket
