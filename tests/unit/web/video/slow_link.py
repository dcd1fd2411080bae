"""A link of few bytes a second between a client and the server."""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

_CHUNK = 1024
_BUFFER = 8 * 1024


@asynccontextmanager
async def slow_link(port: int | None, bytes_per_s: float) -> AsyncIterator[int]:
    """Give the port of a relay to the server; what it sends passes at this rate, all clients together."""
    gate = asyncio.Lock()
    tasks: set[asyncio.Task[None]] = set()
    writers: list[asyncio.StreamWriter] = []

    async def serve(near: asyncio.StreamReader, back: asyncio.StreamWriter) -> None:
        far_socket = socket.socket()
        far_socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)  # what the relay holds is no link's delay
        far_socket.setblocking(False)
        await asyncio.get_running_loop().sock_connect(far_socket, ("127.0.0.1", port))
        far, out = await asyncio.open_connection(sock=far_socket, limit=_CHUNK)
        writers.extend((back, out))

        async def down() -> None:
            while data := await far.read(_CHUNK):
                async with gate:
                    await asyncio.sleep(len(data) / bytes_per_s)
                back.write(data)
                await back.drain()
            back.close()

        async def up() -> None:
            while data := await near.read(_CHUNK):
                out.write(data)
                await out.drain()
            out.close()

        for work in (down(), up()):
            tasks.add(asyncio.create_task(work))

    server = await asyncio.start_server(serve, "127.0.0.1", 0, limit=_CHUNK)
    try:
        yield server.sockets[0].getsockname()[1]
    finally:
        server.close()
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        for writer in writers:
            writer.transport.abort()
            with contextlib.suppress(ConnectionError):
                await writer.wait_closed()
