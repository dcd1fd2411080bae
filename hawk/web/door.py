"""The door of the web server: how many connections may wait, and how long, before they ask something that is answered.

A connection waits from its beginning until its first request passes `hawk.web.security.RequestCheck`, and between two
requests. When the places for waiting are taken, the newest comes in and the oldest goes: a browser sends its request
within milliseconds, so it is served while thousands of others only wait.
"""

from __future__ import annotations

import asyncio
import contextlib
import resource
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final, cast

from aiohttp import hdrs, web
from aiohttp.typedefs import Handler, Middleware

from hawk.web.access.guesses import network_of

FIRST_REQUEST_S: Final = 10.0
"""Real seconds within which the first request of a connection must be there, whole, and pass."""
IDLE_S: Final = 30.0
"""Real seconds between two requests."""
RESERVED_DESCRIPTORS: Final = 256
"""Descriptors that the web server leaves to the flight: autopilot, cameras, journal, recordings."""
MOST_WAITING: Final = 256
LEAST_WAITING: Final = 16
OTHER_REQUESTS: Final = 64
"""Requests under way besides the pages and viewers, which `web.maximum_clients` limits."""


@dataclass(frozen=True, slots=True)
class Places:
    """Connections at one time: that wait, that wait from one address, and that are being answered."""

    waiting: int
    waiting_of_one: int
    answered: int

    @classmethod
    def within(cls, descriptors: int, clients: int) -> Places:
        """Return the places for a process with this limit of descriptors and of pages."""
        answered = 2 * clients + OTHER_REQUESTS
        free = descriptors - RESERVED_DESCRIPTORS - answered
        waiting = max(LEAST_WAITING, min(MOST_WAITING, free))
        return cls(waiting, waiting // 2, answered)

    @property
    def descriptors(self) -> int:
        """Descriptors that the process needs for them."""
        return self.waiting + self.answered + RESERVED_DESCRIPTORS


def descriptor_limit() -> int:
    """Return how many descriptors this process may open (RLIMIT_NOFILE)."""
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return 2**31 if soft == resource.RLIM_INFINITY else soft


class WebConnection(asyncio.Protocol):
    """One connection: passes everything on to aiohttp's protocol, and is known to the door."""

    def __init__(self, door: Door, inner: asyncio.Protocol) -> None:
        self._door = door
        self._inner = inner
        self._transport: asyncio.Transport | None = None
        self._unsent = 0
        self._abandon: Callable[[], object] | None = None
        self.address = ""
        self.since = 0.0
        """Time at which it began to wait."""
        self.is_known = False
        """True once a request of it has passed."""
        self.is_gone = False
        self.tap: Callable[[bytes], bool] | None = None
        """Sees what is received before aiohttp does; returns True for what aiohttp need not see."""

    def arrive(self, host: str | None, abandon: Callable[[], object]) -> None:
        """Come in before the TLS handshake, which ``abandon`` ends."""
        self.address = network_of(host)
        self._abandon = abandon
        self._door.enter(self)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Come in."""
        self._transport = cast(asyncio.Transport, transport)
        peer = transport.get_extra_info("peername")
        self._inner.connection_made(transport)
        if self._abandon is None:
            self.address = network_of(peer[0] if peer else None)
            self._door.enter(self)

    def connection_lost(self, exc: Exception | None) -> None:
        """Leave."""
        self.is_gone = True
        self._door.leave(self)
        self._inner.connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Pass on."""
        if self.tap is None or not self.tap(data):
            self._inner.data_received(data)

    def eof_received(self) -> bool | None:
        """Pass on."""
        return self._inner.eof_received()

    def pause_writing(self) -> None:
        """Pass on."""
        self._inner.pause_writing()

    def resume_writing(self) -> None:
        """Pass on."""
        self._inner.resume_writing()

    def is_receiving(self) -> bool:
        """Return True when more of the last answer has gone out since the last call."""
        before, self._unsent = self._unsent, self.unsent
        return self._unsent > 0 and self._unsent != before

    @property
    def unsent(self) -> int:
        """Bytes of answers that wait to be received."""
        return 0 if self._transport is None else self._transport.get_write_buffer_size()

    def end(self) -> None:
        """Close the connection at once."""
        if self._transport is not None:
            self._transport.abort()
        elif self._abandon is not None:
            self._abandon()


class Door:
    """Knows every connection. One task calls `sweep` every second. Times are real seconds."""

    def __init__(self, places: Places, monotonic: Callable[[], float]) -> None:
        self.places = places
        self._monotonic = monotonic
        self._waiting: dict[str, dict[WebConnection, None]] = {}
        """By address, those that began to wait first at the front."""
        self.waiting = 0
        """Connections that wait."""
        self.answered = 0
        """Requests under way."""
        self.closed = 0
        """Connections that were closed because they waited too long or too many waited, since the start."""

    @property
    def is_full(self) -> bool:
        """True when no further request is answered, except to the operator in control."""
        return self.answered >= self.places.answered

    def waiting_connections(self) -> list[WebConnection]:
        """Return the connections that wait."""
        return [connection for connections in self._waiting.values() for connection in connections]

    def enter(self, connection: WebConnection) -> None:
        """Let a connection wait; another goes when there are too many."""
        if connection.is_gone:
            return
        if len(self._waiting.get(connection.address, ())) >= self.places.waiting_of_one:
            self._close_one(connection.address)
        elif self.waiting >= self.places.waiting:
            self.make_room()
        connection.since = self._monotonic()
        self._waiting.setdefault(connection.address, {})[connection] = None
        self.waiting += 1

    def leave(self, connection: WebConnection) -> None:
        """Forget a connection that waited."""
        connections = self._waiting.get(connection.address)
        if connections is None or connection not in connections:
            return
        del connections[connection]
        self.waiting -= 1
        if not connections:
            del self._waiting[connection.address]

    @contextlib.contextmanager
    def answering(self, connection: WebConnection) -> Iterator[None]:
        """Keep the connection as long as its request is under way."""
        self.leave(connection)
        connection.is_known = True
        self.answered += 1
        try:
            yield
        finally:
            self.answered -= 1
            self.enter(connection)

    def make_room(self) -> None:
        """Close one that waits, from the address that has most of them."""
        if self._waiting:
            self._close_one(max(self._waiting, key=lambda address: len(self._waiting[address])))

    def sweep(self) -> None:
        """Close what has waited too long. An answer that is still being received goes on."""
        now = self._monotonic()
        for connection in self.waiting_connections():
            if now - connection.since < (IDLE_S if connection.is_known else FIRST_REQUEST_S):
                continue
            if connection.is_known and connection.is_receiving():
                connection.since = now
            else:
                self._close(connection)

    def _close_one(self, address: str) -> None:
        connections = self._waiting[address]
        self._close(
            next((connection for connection in connections if not connection.is_known), None) or next(iter(connections))
        )

    def _close(self, connection: WebConnection) -> None:
        self.leave(connection)
        self.closed += 1
        connection.end()


DOOR = web.AppKey("door", Door)


def attend(keeps_place: Callable[[web.Request], bool], public: frozenset[str] = frozenset()) -> Middleware:
    """Return the middleware behind `RequestCheck`.

    Args:
        keeps_place: Returns True for a request of the operator in control.
        public: Paths that are answered to everybody: their connections wait on, so that a form that is sent slowly
            takes no place from the pages.
    """

    @web.middleware
    async def middleware(request: web.Request, handler: Handler) -> web.StreamResponse:
        connection = None if request.transport is None else request.transport.get_protocol()
        if not isinstance(connection, WebConnection) or request.path in public:
            return await handler(request)
        door = request.app[DOOR]
        if door.is_full and not keeps_place(request):
            raise web.HTTPServiceUnavailable(
                text=f"{door.places.answered} requests are being answered; send it again in a moment",
                headers={hdrs.RETRY_AFTER: "1"},
            )
        with door.answering(connection):
            return await handler(request)

    return middleware
