"""Accepts connections at a pace that leaves the loop its time, whatever goes wrong with one of them."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import socket
from collections.abc import Callable
from typing import Final

from hawk.web.door import Door, Visit
from hawk.web.paced_log import PacedLog

ACCEPTS_PER_S: Final = 500.0
BURST: Final = 100
"""Connections that are accepted at once after a pause; a page opens about ten."""
BACKLOG: Final = 128
PAUSE_S: Final = 0.1
"""Real seconds until the next attempt when the process has no room for a connection."""
SWEEP_S: Final = 1.0
NO_ROOM: Final = frozenset({errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM})


class Listener:
    """Listens on every address of a host name: `start`, then `port`, then `close`."""

    def __init__(self, door: Door, make: Callable[[], asyncio.Protocol], log: PacedLog) -> None:
        """``make`` returns aiohttp's protocol for a connection."""
        self._door = door
        self._make = make
        self._log = log
        self._sockets: list[socket.socket] = []
        self._tasks: list[asyncio.Task[None]] = []
        self._due = float("-inf")
        self.port = 0
        """Port that it listens on."""

    async def start(self, host: str, port: int) -> None:
        """Listen. Raises OSError when the address is in use or not ours."""
        found = await asyncio.get_running_loop().getaddrinfo(
            host or None, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )
        self.port = port
        try:
            for family, _, _, _, address in dict.fromkeys(found):
                place = (str(address[0]), self.port, *address[2:])
                made = socket.create_server(place, family=family, backlog=BACKLOG)
                self._sockets.append(made)
                made.setblocking(False)
                self.port = made.getsockname()[1]
        except OSError:
            await self.close()
            raise
        self._tasks = [asyncio.create_task(self._accept(each), name="web-accept") for each in self._sockets]
        self._tasks.append(asyncio.create_task(self._sweep(), name="web-sweep"))

    async def close(self) -> None:
        """Stop listening; connections stay."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self._tasks.clear()
        for each in self._sockets:
            each.close()
        self._sockets.clear()

    async def _accept(self, listening: socket.socket) -> None:
        loop = asyncio.get_running_loop()
        while True:
            await self._pace()
            try:
                accepted, _ = await loop.sock_accept(listening)
                await self._receive(accepted)
            except OSError as error:
                await self._note(error)
            except Exception:  # whatever one connection does, the others are accepted
                self._log.exception("a connection could not be accepted")

    async def _receive(self, accepted: socket.socket) -> None:
        with contextlib.ExitStack() as undo:
            undo.callback(accepted.close)
            accepted.setblocking(False)
            await asyncio.get_running_loop().connect_accepted_socket(lambda: Visit(self._door, self._make()), accepted)
            undo.pop_all()

    async def _note(self, error: OSError) -> None:
        """A connection that ended before it was accepted is none; without room for it, one that waits goes."""
        if error.errno in NO_ROOM:
            self._log.error("no room for a connection: %s; raise LimitNOFILE or lower web.maximum_clients", error)
            self._door.make_room()
            await asyncio.sleep(PAUSE_S)

    async def _pace(self) -> None:
        """Wait for the next place in time: `ACCEPTS_PER_S`, after a pause `BURST` at once."""
        now = asyncio.get_running_loop().time()
        self._due = max(self._due, now - BURST / ACCEPTS_PER_S) + 1 / ACCEPTS_PER_S
        await asyncio.sleep(max(0.0, self._due - now))

    async def _sweep(self) -> None:
        while True:
            await asyncio.sleep(SWEEP_S)
            self._door.sweep()
