"""The connected clients: the answers and heartbeats that each of them receives next. A slow one delays no other."""

from __future__ import annotations

import asyncio
import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from hawk.comm.protocol.heartbeat import (
    ClientHeartbeat,
    ClientId,
    DroneStatus,
    FenceSetup,
    LogEntry,
    OutlineSetup,
    Point,
    SectionsUpdate,
    SectionUpdate,
)
from hawk.model.known_lot import FlownSection
from hawk.model.lot_map import OccupancyMap
from hawk.web.map_view import MapView
from hawk.web.sessions import ControlView

OUTBOX_LIMIT: Final = 64
"""Answers that wait for one client; a client that reads none of them is disconnected."""
LOG_LIMIT: Final = 50
"""Log entries in one heartbeat; the rest comes with the next."""
TRAIL_LIMIT: Final = 500
"""Trail points in one heartbeat."""
SECTION_LIMIT: Final = 100
"""Sections in one heartbeat."""


@dataclass(slots=True)
class ClientView:
    """Map, log, trail, fence and sections as one client has received them."""

    map: MapView = field(default_factory=MapView)
    _log: int = -1
    _trail: int = 0
    _trail_id: int | None = None
    _fence: FenceSetup | None = None
    _outline: OutlineSetup | None = None
    _sections: dict[str, FlownSection] = field(default_factory=dict)
    _whole: Sequence[FlownSection] = ()

    def heartbeat(
        self,
        status: DroneStatus,
        current: OccupancyMap | None,
        control: ControlView,
        sections: Sequence[FlownSection] = (),
    ) -> str:
        """Return the client's Heartbeat as JSON and mark its content as sent."""
        start, trail = self._next_trail(status)
        own = ClientHeartbeat(
            occupancy_map=None if current is None else self.map.update(current, status.pose.place),
            messages=self._next_log(status),
            trail=trail,
            trail_start=start,
            fence_setup=None if status.fence_setup is self._fence else status.fence_setup,
            outline_setup=None if status.outline_setup is self._outline else status.outline_setup,
            sections=self._next_sections(sections),
            controller=control.controller,
            controller_lost=control.controller_lost,
            in_control=control.in_control,
            control_taken_by=control.taken_by,
            own_name=control.name,
            control_asked_by=control.asked_by,
            control_free_in=control.free_in,
            control_kept=control.kept,
        )
        self._fence, self._outline = status.fence_setup, status.outline_setup
        return own.join(status.shared_json)

    def _next_log(self, status: DroneStatus) -> list[LogEntry]:
        entries = [entry for entry in status.log if entry.number > self._log][:LOG_LIMIT]
        if entries:
            self._log = entries[-1].number
        return entries

    def _next_sections(self, sections: Sequence[FlownSection]) -> SectionsUpdate | None:
        if sections is self._whole:
            return None
        there, sent = {each.id for each in sections}, self._sections
        changed = [each for each in sections if sent.get(each.id) != each][:SECTION_LIMIT]
        removed = [each for each in sent if each not in there]
        if not changed and not removed:
            self._whole = sections
            return None
        self._sections = {key: each for key, each in sent.items() if key in there} | {each.id: each for each in changed}
        return SectionsUpdate(changed=[SectionUpdate.of(each) for each in changed], removed=removed)

    def _next_trail(self, status: DroneStatus) -> tuple[bool, list[Point]]:
        start = status.trail_id != self._trail_id or len(status.trail) < self._trail
        if start:
            self._trail_id = status.trail_id
            self._trail = 0
        points = status.trail[self._trail : self._trail + TRAIL_LIMIT]
        self._trail += len(points)
        return start, [Point.of(p) for p in points if math.isfinite(p.north) and math.isfinite(p.east)]


class Client:
    """One connection: what it has received, the answers that wait for it, and the mark of a heartbeat that is due."""

    def __init__(self, client_id: ClientId) -> None:
        self.id = client_id
        self.view = ClientView()
        self._texts: deque[str] = deque()
        self._wake = asyncio.Event()
        self._pong: bytes | None = None
        self.heartbeat_due = False
        self.overflowed = False

    @property
    def waiting(self) -> int:
        """Answers that wait."""
        return len(self._texts)

    def put(self, text: str) -> None:
        """Queue an answer; set `overflowed` when too many wait already."""
        if len(self._texts) >= OUTBOX_LIMIT:
            self.overflowed = True
        else:
            self._texts.append(text)
        self._wake.set()

    def heartbeat(self) -> None:
        """Mark a heartbeat as due: the newest one goes out when the client can receive it."""
        self.heartbeat_due = True
        self._wake.set()

    def pong(self, mark: bytes) -> None:
        """Queue the answer to a ping; only the newest needs one (RFC 6455, section 5.5.3)."""
        self._pong = mark
        self._wake.set()

    def take_pong(self) -> bytes | None:
        """Return the ping that waits for its answer, once."""
        mark, self._pong = self._pong, None
        return mark

    def wake(self) -> None:
        """Wake the writer: it may send again."""
        self._wake.set()

    def take(self) -> str | None:
        """Return the oldest answer, None when there is none."""
        return self._texts.popleft() if self._texts else None

    async def wait(self) -> None:
        """Wait until there is something to do."""
        await self._wake.wait()
        self._wake.clear()


class ClientHub:
    """All connections of the command socket."""

    def __init__(self) -> None:
        self._clients: dict[ClientId, Client] = {}
        self._count = 0

    def __len__(self) -> int:
        return len(self._clients)

    @property
    def waiting(self) -> int:
        """Answers that wait for their clients."""
        return sum(client.waiting for client in self._clients.values())

    def add(self) -> Client:
        """Add a new connection."""
        self._count += 1
        client = Client(f"client-{self._count}")
        self._clients[client.id] = client
        return client

    def remove(self, client: Client) -> None:
        """Forget a connection."""
        self._clients.pop(client.id, None)

    def heartbeat(self) -> None:
        """Mark a heartbeat as due for every client."""
        for client in self._clients.values():
            client.heartbeat()

    def forget_map(self, client: ClientId) -> None:
        """Send this client the whole map again."""
        found = self._clients.get(client)
        if found is not None:
            found.view.map.forget()

    def send_to(self, client: ClientId, text: str) -> None:
        """Queue for one client; one that has gone is no error."""
        found = self._clients.get(client)
        if found is not None:
            found.put(text)
