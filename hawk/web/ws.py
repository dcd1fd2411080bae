"""The command and heartbeat WebSocket ``/ws``: one `CommandConnection` a client."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import logging
import socket
from collections import deque
from collections.abc import Callable, Iterator
from typing import Final

from aiohttp import WSCloseCode, WSMsgType, hdrs, web

from hawk.comm.protocol.authority import Role
from hawk.comm.protocol.commands import Ack, Welcome
from hawk.model.lot_map import CELL_M, TILE_CELLS
from hawk.model.sentences import say
from hawk.runtime.supervision import until_first_ends
from hawk.web.access.access import BOOK, OPEN, Access, access_of
from hawk.web.access.admission import cookie_name, set_strict_cookie
from hawk.web.clients import Client
from hawk.web.services import COUNTERS, KEPT_PLACES, SERVICES, Counters, WebServices

LOG = logging.getLogger(__name__)

READ_LIMIT_BYTES: Final = 1024 * 1024
"""A message up to here is answered with an error, a larger one ends the connection (close code 1009)."""
PING_INTERVAL_S: Final = 10.0
"""Real seconds of silence until a client is pinged: a dead connection is noticed after 1.5 times this."""
IN_FLIGHT_LIMIT: Final = 3
"""Heartbeats in flight to one client: at 5 Hz enough for a round trip of 0.6 s; on a slower link they become fewer."""
SEND_BUFFER_BYTES: Final = 128 * 1024
"""Kernel and user space buffer for one client: data in it is old when it arrives."""
HEARTBEAT_INTERVAL_S: Final = 0.1
"""Least real time between two heartbeats: a simulation at speed N makes them N times as often."""
INTERVAL_SLACK_S: Final = 0.01
READS_PER_S: Final = 50.0
"""Messages of one client that are read each real second."""
READS_AT_ONCE: Final = 50
"""Messages that are read at once after a pause; fewer than the answers that may wait for a client."""
FLOOD_S: Final = 2.0
"""A client that sends faster for this time is disconnected, real seconds: what waits in its buffers grows old."""
ACCESS_ENDED: Final = 4401
"""Close code when the login or its token has ended: the page shows the login page (RFC 6455, section 7.4.2)."""
END_S: Final = 2.0
"""Real seconds in which a client receives the end of its access; then the connection is cut."""
NOBODY: Final = Access(Role.VIEWER)
FLOODED: Final = say("Too many messages: send at most {rate:.0f} a second.", rate=READS_PER_S)

SOCKETS: web.AppKey[set[web.WebSocketResponse]] = web.AppKey("sockets", set)


async def command_socket(request: web.Request) -> web.StreamResponse:
    """Serve one client until it goes."""
    services = request.app[SERVICES]
    refuse_crowd(request)
    access = access_of(request) or NOBODY
    client = services.side.hub.add()
    session = services.side.desk.connect(client.id, control_secret(request), access.role)
    try:
        response = web.WebSocketResponse(
            heartbeat=PING_INTERVAL_S, autoping=False, max_msg_size=READ_LIMIT_BYTES, compress=False, timeout=1.0
        )
        if access.login is None:
            set_strict_cookie(request, response, "session", session.secret)
        await response.prepare(request)
        limit_buffers(request)
        client.put(_welcome(services, session.name, access).to_json())
        book = request.app[BOOK]
        connection = CommandConnection(
            services, client, response, request.app[COUNTERS], has_access=lambda: book.holds(access)
        )
        with registered(request, response, lambda: services.side.desk.release(client.id)):
            await connection.run()
    finally:
        services.side.desk.disconnect(client.id)
        services.side.hub.remove(client)
    return response


class ReadPace:
    """Paces the reading of one client (the generic cell rate algorithm), so that none takes the loop for itself."""

    def __init__(self, per_s: float | None = None) -> None:
        """``per_s``: messages a second; None: `READS_PER_S`."""
        self._per_s = READS_PER_S if per_s is None else per_s
        self._due = float("-inf")
        self._fast_since: float | None = None
        self.is_flooded = False
        """True once the client has sent faster than it is read for `FLOOD_S`."""

    def pause(self, now: float) -> float:
        """Return the seconds to wait after a message that was read at ``now``, seconds."""
        self._due = max(self._due, now - READS_AT_ONCE / self._per_s) + 1.0 / self._per_s
        if self._due <= now:
            self._fast_since = None
            return 0.0
        if self._fast_since is None:
            self._fast_since = now
        self.is_flooded = now - self._fast_since >= FLOOD_S
        return self._due - now


class CommandConnection:
    """Reads commands and writes answers and heartbeats of one client."""

    def __init__(
        self,
        services: WebServices,
        client: Client,
        response: web.WebSocketResponse,
        counters: Counters,
        has_access: Callable[[], bool] = lambda: True,
    ) -> None:
        """``has_access``: False once its login or token has ended; nothing that it sends is taken then."""
        self._has_access = has_access
        self._services = services
        self._client = client
        self._socket = response
        self._counters = counters
        self._marks = itertools.count(1)
        self._pace = ReadPace(services.reads_per_s)
        self._in_flight: deque[bytes] = deque()
        """Marks of heartbeats in flight: a ping follows each, and its pong shows that the heartbeat arrived."""

    async def run(self) -> None:
        """Serve until the connection ends."""
        await until_first_ends(self._read(), self._write())  # a client that hears nothing connects again

    async def _read(self) -> None:
        async for message in self._socket:
            if not self._has_access():
                break
            if message.type is WSMsgType.TEXT:
                self._take(message.data)
            elif message.type is WSMsgType.BINARY:
                self._refuse(say("message: is binary; send JSON text"))
            elif message.type is WSMsgType.PING:
                self._client.pong(message.data)
            elif message.type is WSMsgType.PONG:
                self._arrived(message.data)
            else:
                break
            if self._client.overflowed:
                LOG.warning("%s does not read its answers; disconnected", self._client.id)
                break
            if (pause := self._pace.pause(asyncio.get_running_loop().time())) > 0.0:
                await asyncio.sleep(pause)
            if self._pace.is_flooded:
                LOG.warning("%s sends too much; disconnected", self._client.id)
                await self._socket.close(code=WSCloseCode.POLICY_VIOLATION, message=FLOODED.encode())
                break

    def _arrived(self, mark: bytes) -> None:
        """Note a pong: everything before its ping has arrived. Marks of other pings are ignored."""
        if mark in self._in_flight:
            while self._in_flight.popleft() != mark:
                pass
            self._client.wake()

    def _take(self, text: str) -> None:
        try:
            self._services.side.socket.feed(self._client.id, text)
        except Exception:  # a defect behind one command must not cost the operator the connection
            LOG.exception("a command of %s failed: %.200s", self._client.id, text)
            self._refuse(say("The drone could not carry that out: an error inside; see its log."))

    def _refuse(self, reason: str) -> None:
        self._client.put(Ack(id=None, accepted=False, reason=reason).to_json())

    async def _write(self) -> None:
        client = self._client
        try:
            while True:
                await client.wait()
                while (text := client.take()) is not None:
                    await self._socket.send_str(text)
                if (pong := client.take_pong()) is not None:
                    await self._socket.pong(pong)
                if client.heartbeat_due and len(self._in_flight) < IN_FLIGHT_LIMIT:
                    client.heartbeat_due = False
                    await self._send_heartbeat()
        except ConnectionError:
            pass  # the reader sees the end too

    async def _send_heartbeat(self) -> None:
        """Build the heartbeat when it can go out, so that everything marked as sent was sent."""
        services = self._services
        status = services.status.value
        desk = services.side.desk
        if status is None or desk.is_lost(self._client.id):
            return
        try:
            text = self._client.view.heartbeat(
                status, services.occupancy_map.value, desk.seen_by(self._client.id), services.sections()
            )
        except Exception:  # a status that cannot be encoded must not end the heartbeats after it
            self._counters.heartbeats_failed += 1
            if self._counters.heartbeats_failed == 1:
                LOG.exception("a heartbeat could not be built")
            return
        mark = next(self._marks).to_bytes(8, "big")
        self._in_flight.append(mark)
        await self._socket.send_str(text)
        await self._socket.ping(mark)
        self._counters.heartbeats += 1


class HeartbeatPace:
    """Marks a heartbeat as due for every client with each status, at most every `HEARTBEAT_INTERVAL_S`."""

    def __init__(self, services: WebServices) -> None:
        self._services = services
        self._last = float("-inf")

    def on_status(self, _: object) -> None:
        """Listener of the status topic."""
        now = self._services.monotonic()
        if now - self._last >= HEARTBEAT_INTERVAL_S - INTERVAL_SLACK_S:
            self._last = now
            self._services.side.hub.heartbeat()


def control_secret(request: web.Request) -> str | None:
    """Return the key of the session of control: that of the login; without one, what the cookie says."""
    access = access_of(request)
    if access is not None and access.login is not None:
        return request.app[BOOK].logins.control_secret(access.login)
    return request.cookies.get(cookie_name(request, "session"))


def keeps_place(request: web.Request) -> bool:
    """Return True when the operator in control asks: it gets in when the server is full."""
    access = access_of(request)
    if access is not None and (access.role is not Role.OPERATOR or access.lots is not None):
        return False
    return request.app[SERVICES].side.desk.keeps_place(control_secret(request))


def places(request: web.Request) -> int:
    """Return how many connections of one kind may be open for this client to open another."""
    limit = request.app[SERVICES].web.maximum_clients
    access = access_of(request)
    if access is not None and access.role is Role.VIEWER:
        return max(1, limit - KEPT_PLACES)  # viewers leave some to operators
    return limit + (KEPT_PLACES if keeps_place(request) else 0)


def refuse_crowd(request: web.Request) -> None:
    """Raise 503 when `maximum_clients` pages are open."""
    services = request.app[SERVICES]
    if len(services.side.hub) >= places(request):
        raise web.HTTPServiceUnavailable(
            text=say("{count} pages are open already; close one (web.maximum_clients)", count=len(services.side.hub)),
            headers={hdrs.RETRY_AFTER: "5"},
        )


def limit_buffers(request: web.Request) -> None:
    """Limit the buffers, so that a slow client receives fewer messages, never old ones."""
    if request.transport is None:
        return
    request.transport.set_write_buffer_limits(high=SEND_BUFFER_BYTES)
    found = request.transport.get_extra_info("socket")
    if found is not None:
        with contextlib.suppress(OSError):
            found.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER_BYTES)


@contextlib.contextmanager
def registered(
    request: web.Request, response: web.WebSocketResponse, at_end: Callable[[], object] = lambda: None
) -> Iterator[None]:
    """Keep the socket among those that are closed when the server stops, or when its access ends.

    ``at_end`` is called when its access ends, before it is closed.
    """
    app = request.app
    closing: set[asyncio.Task[None]] = set()

    def end() -> None:
        at_end()
        closing.add(asyncio.create_task(_end_access(request, response), name="web-end-access"))

    app[SOCKETS].add(response)
    try:
        with app[OPEN].kept(access_of(request) or NOBODY, end):
            yield
    finally:
        app[SOCKETS].discard(response)


async def _end_access(request: web.Request, response: web.WebSocketResponse) -> None:
    """Close a socket whose login or token has ended; cut one that is not read."""
    transport = request.transport
    try:
        async with asyncio.timeout(END_S):
            await response.close(code=ACCESS_ENDED, message=b"log in again")
    except (TimeoutError, ConnectionError):
        if transport is not None:
            transport.abort()


def _welcome(services: WebServices, name: str, access: Access) -> Welcome:
    return Welcome(
        session=name,
        role=access.role.value,
        login=access.login is not None,
        version=services.version,
        simulation=services.simulation,
        cell_size=CELL_M,
        tile_cells=TILE_CELLS,
        operator_timeout=services.operator.operator_timeout_s,
        operator_hold=services.operator.operator_hold_s,
        speed=services.clock.speed,
        camera_fov=services.camera_fov_deg,
        travel_speed=services.travel_speed_m_s,
        desk=services.is_desk,
    )
