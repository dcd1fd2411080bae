"""Accepts connections at a pace that leaves the loop its time, whatever goes wrong with one of them."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import socket
import ssl
from collections.abc import Callable
from typing import Final

from hawk.web.access.paced_log import PacedLog
from hawk.web.door import FIRST_REQUEST_S, Door, WebConnection

ACCEPTS_PER_S: Final = 500.0
HANDSHAKES_PER_S: Final = 50.0
"""Connections a second with TLS. A handshake costs the loop 0.4 ms with an ECDSA key, 1 ms with RSA of 2048 bits and
5 ms with RSA of 4096 bits (measured on one core of a 2-core virtual machine, OpenSSL 3.0)."""
HANDSHAKE_BURST: Final = 20
BURST: Final = 100
"""Connections that are accepted at once after a pause; a page opens about ten."""
BACKLOG: Final = 128
PAUSE_S: Final = 0.1
"""Real seconds until the next attempt when the process has no room for a connection."""
SWEEP_S: Final = 1.0
SHUTDOWN_S: Final = 2.0
"""Real seconds in which the other side has to answer the end of TLS."""
NO_ROOM: Final = frozenset({errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM})


class Listener:
    """Listens on every address of a host name: `start`, then `port`, then `close`."""

    def __init__(
        self, door: Door, make: Callable[[], asyncio.Protocol], log: PacedLog, tls: ssl.SSLContext | None = None
    ) -> None:
        """``make`` returns aiohttp's protocol for a connection. ``tls``: certificate and key; None: plain HTTP."""
        self._door = door
        self._make = make
        self._log = log
        self._sockets: list[socket.socket] = []
        self._tasks: list[asyncio.Task[None]] = []
        self._due = float("-inf")
        self._tls = tls
        self._per_s, self._burst = (ACCEPTS_PER_S, BURST) if tls is None else (HANDSHAKES_PER_S, HANDSHAKE_BURST)
        self._handshakes: set[asyncio.Task[bool]] = set()
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
        """Stop listening; connections stay, handshakes end."""
        ending = [*self._tasks, *self._handshakes]
        for task in ending:
            task.cancel()
        await asyncio.gather(*ending, return_exceptions=True)
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
            connection = WebConnection(self._door, self._make())
            if self._tls is None:
                await asyncio.get_running_loop().connect_accepted_socket(lambda: connection, accepted)
            else:
                self._begin_handshake(connection, accepted, self._tls)
            undo.pop_all()

    def _begin_handshake(self, connection: WebConnection, accepted: socket.socket, tls: ssl.SSLContext) -> None:
        """Let a connection wait while it shakes hands: the next one is accepted meanwhile."""
        peer = accepted.getpeername()
        task = asyncio.create_task(self._shake_hands(connection, accepted, tls), name="web-handshake")
        self._handshakes.add(task)

        def ended(_: object) -> None:  # also one that was cancelled before its first step
            self._handshakes.discard(task)
            error = None if task.cancelled() else task.exception()
            if error is not None:
                self._log.error("a TLS handshake failed by a fault inside: %r", error)
            if task.cancelled() or error is not None or not task.result():
                connection.is_gone = True
                self._door.leave(connection)
                accepted.close()

        task.add_done_callback(ended)
        connection.arrive(peer[0], task.cancel)

    async def _shake_hands(self, connection: WebConnection, accepted: socket.socket, tls: ssl.SSLContext) -> bool:
        """Begin TLS; return False for a connection that fails, stalls or speaks no TLS."""
        try:
            await asyncio.get_running_loop().connect_accepted_socket(
                lambda: connection,
                accepted,
                ssl=tls,
                ssl_handshake_timeout=FIRST_REQUEST_S,
                ssl_shutdown_timeout=SHUTDOWN_S,
            )
        except OSError as error:  # SSLError and the timeout are OSErrors
            self._log.info("no TLS handshake with %s: %s", connection.address, _short(error))
            return False
        return True

    async def _note(self, error: OSError) -> None:
        """A connection that ended before it was accepted is none; without room for it, one that waits goes."""
        if error.errno in NO_ROOM:
            self._log.error("no room for a connection: %s; raise LimitNOFILE or lower web.maximum_clients", error)
            self._door.make_room()
            await asyncio.sleep(PAUSE_S)

    async def _pace(self) -> None:
        """Wait for the next place in time: N a second, after a pause some at once."""
        now = asyncio.get_running_loop().time()
        self._due = max(self._due, now - self._burst / self._per_s) + 1 / self._per_s
        await asyncio.sleep(max(0.0, self._due - now))

    async def _sweep(self) -> None:
        while True:
            await asyncio.sleep(SWEEP_S)
            self._door.sweep()


def _short(error: OSError) -> str:
    """Return the reason without the library's own place in its source."""
    return (error.reason or "no TLS") if isinstance(error, ssl.SSLError) else (str(error) or type(error).__name__)
