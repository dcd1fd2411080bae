"""Small pictures and servers of pictures for the camera tests."""

from __future__ import annotations

import asyncio
import contextlib
import ssl
from collections.abc import Awaitable, Callable

import cv2
import numpy as np
from aiohttp import web
from aiohttp.test_utils import TestServer

BOUNDARY = "frame"
CONTENT_TYPE = f"multipart/x-mixed-replace;boundary={BOUNDARY}"


def picture(width: int = 64, height: int = 48, grey: int = 128) -> bytes:
    """Return a JPEG of one grey."""
    done, data = cv2.imencode(".jpg", np.full((height, width, 3), grey, np.uint8))
    assert done
    return bytes(data.tobytes())


def part(jpeg: bytes, *, stamp: float | None = None, length: int | None = -1) -> bytes:
    """Return one part of a stream; ``length`` None: without Content-Length, -1: the true one."""
    lines = [f"--{BOUNDARY}", "Content-Type: image/jpeg"]
    if length is not None:
        lines.append(f"Content-Length: {len(jpeg) if length == -1 else length}")
    if stamp is not None:
        lines.append(f"X-Timestamp: {stamp:.6f}")
    return "\r\n".join(lines).encode() + b"\r\n\r\n" + jpeg + b"\r\n"


Writer = Callable[[web.StreamResponse, web.Request], Awaitable[None]]


class StreamServer:
    """An MJPEG server whose stream is what ``writer`` writes; requests are counted."""

    def __init__(self, writer: Writer, content_type: str = CONTENT_TYPE, port: int = 0) -> None:
        self.writer = writer
        self.content_type = content_type
        self.status = 200
        self.requests: list[web.Request] = []
        app = web.Application()
        app.router.add_get("/stream", self._stream)
        app.router.add_get("/stream.mjpg", self._stream)
        self.server = TestServer(app, port=port)

    async def start(self, tls: ssl.SSLContext | None = None) -> str:
        """Start to serve and return the address of the stream."""
        await self.server.start_server(shutdown_timeout=0.01, ssl=tls)
        return str(self.server.make_url("/stream"))

    async def close(self) -> None:
        await self.server.close()

    async def _stream(self, request: web.Request) -> web.StreamResponse:
        self.requests.append(request)
        response = web.StreamResponse(status=self.status, headers={"Content-Type": self.content_type})
        await response.prepare(request)
        with contextlib.suppress(ConnectionError, asyncio.CancelledError):
            await self.writer(response, request)
        return response


def forever(*parts: bytes, pause_s: float = 0.01) -> Writer:
    """Write the parts over and over."""

    async def write(response: web.StreamResponse, _: web.Request) -> None:
        while True:
            for one in parts:
                await response.write(one)
                await asyncio.sleep(pause_s)

    return write


def once(*parts: bytes) -> Writer:
    """Write the parts, then end the stream."""

    async def write(response: web.StreamResponse, _: web.Request) -> None:
        for one in parts:
            await response.write(one)

    return write
