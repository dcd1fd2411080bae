"""A web server with everything around it in the hands of the test."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Any

import aiohttp
from aiohttp import web
from aiohttp.test_utils import TestServer

from hawk.comm.protocol.authority import authority_refusal
from hawk.comm.protocol.command_table import sender_of
from hawk.comm.protocol.commands import Ack, Command, KillRequest, KillToken, Outgoing
from hawk.comm.protocol.heartbeat import ClientId, DroneStatus, StatusStamp
from hawk.comm.topic import Topic
from hawk.config.reference import reference_text, settings
from hawk.config.sections import Config, OperatorSettings, WebSettings
from hawk.lots.store import LotStore
from hawk.model.day_plan import DayPlan, Forecast
from hawk.model.lot_map import OccupancyMap
from hawk.model.pictures import AnnotatedFrame
from hawk.runtime.performance import LagSummary
from hawk.store.inbox import InboxFolder
from hawk.store.recording import NoRecordingError
from hawk.store.recording_requests import RecordingRequests
from hawk.store.recordings import Recordings
from hawk.web.access.tls import Tls
from hawk.web.app import Page, create_app
from hawk.web.documentation import Documentation
from hawk.web.services import OperatorSide, WebServices, _no_area
from hawk.web.sessions import ControlDesk
from tests.manual_clock import ManualClock
from tests.unit.comm.waiting import until

PATIENCE_S = 5.0
DayPlanOf = Callable[[Forecast | None, int], Awaitable[DayPlan]]


class FakeManager:
    """Accepts what a client may send: through the queue if so set, urgent commands at once."""

    def __init__(self) -> None:
        self.urgent: list[tuple[ClientId, Command]] = []
        self.fail = False
        self.desk: ControlDesk | None = None

    def refusal(self, client: ClientId, command: Command) -> Ack | None:
        """The judge's first question."""
        assert self.desk is not None
        has_control = client in self.desk.controlling_clients()
        sender, control = sender_of(command.type), self.desk.tenure()
        reason = authority_refusal(sender, has_control=has_control, control=control, homing=False)
        return Ack(id=command.id, accepted=False, reason=reason) if reason else None

    def handle_now(self, client: ClientId, command: Command) -> Outgoing:
        if self.fail:
            raise RuntimeError("a defect")
        if (refused := self.refusal(client, command)) is not None:
            return refused
        self.urgent.append((client, command))
        if isinstance(command, KillRequest):
            return KillToken(id=command.id, token="t" * 32, valid_for=10.0)
        return Ack(id=command.id, accepted=True)


def _no_recording() -> Path:
    raise NoRecordingError("Nothing is recorded here.")


@dataclass
class Rig:
    """A web server on the loop with everything around it in the hands of the test."""

    clock: ManualClock = field(default_factory=ManualClock)
    real: ManualClock = field(default_factory=ManualClock)
    web: WebSettings = field(default_factory=WebSettings)
    operator: OperatorSettings = field(default_factory=OperatorSettings)
    manager: FakeManager = field(default_factory=FakeManager)
    page: Page = field(default_factory=lambda: Page.load(Path("nowhere")))
    documentation: Documentation = field(default_factory=lambda: Documentation.load(Path("nowhere")))
    simulation: bool = True
    cookie_secret: bytes = b"s" * 32
    folder: Path | None = None
    lots: LotStore | None = None
    collects: bool = False
    inbox: InboxFolder | None = None
    due: Callable[[str, str, float | None, float, int], list[datetime]] | None = None
    day_plan: DayPlanOf | None = None
    tls: Tls | None = None
    wall: ManualClock = field(default_factory=lambda: ManualClock(1.8e9))
    newest_recording: Callable[[], Path] = _no_recording
    recordings: Recordings | None = None
    recording_requests: RecordingRequests | None = None
    free: int = 10**12
    read_area: Callable[[bytes, str], str] = _no_area
    never: asyncio.Event = field(default_factory=asyncio.Event)

    def __post_init__(self) -> None:
        self.side = OperatorSide.create(self.clock, self.operator)
        self.manager.desk = self.side.desk
        self.side.socket.attach(self.manager.handle_now)
        self.status: Topic[DroneStatus] = Topic("status", self.clock)
        self.map: Topic[OccupancyMap] = Topic("map", self.clock)
        self.video: Topic[AnnotatedFrame] = Topic("video", self.clock)
        self.server: TestServer | None = None
        self.app: web.Application | None = None

    def services(self) -> WebServices:
        return WebServices(
            clock=self.clock,
            web=self.web,
            operator=self.operator,
            side=self.side,
            status=self.status,
            occupancy_map=self.map,
            video=self.video,
            version="1.2.3",
            simulation=self.simulation,
            cookie_secret=self.cookie_secret,
            camera_fov_deg=70.0,
            travel_speed_m_s=4.0,
            loop_lag=lambda: LagSummary(0.5, 4.0, 9.0, 100),
            counters=lambda: {"camera_pictures_damaged": 7},
            queues=lambda: {"journal": 5},
            monotonic=self.real,
            folder=self.folder,
            lots=self.lots,
            collects=self.collects,
            inbox=self.inbox,
            due=self.due,
            day_plan=None if self.day_plan is None else self._planned,
            tls=self.tls,
            wall=self.wall,
            settings=settings(Config(web=self.web), reference_text()),
            newest_recording=lambda: self.newest_recording(),
            recordings=self.recordings,
            recording_requests=self.recording_requests,
            read_area=lambda data, kind: self.read_area(data, kind),
        )

    async def _planned(self, forecast: Forecast | None, batteries: int) -> DayPlan:
        assert self.day_plan is not None
        return await self.day_plan(forecast, batteries)

    async def start(self) -> TestServer:
        self.app = create_app(self.services(), self.page, self.documentation)
        self.server = TestServer(self.app)
        await self.server.start_server()
        return self.server

    @property
    def sequence(self) -> int:
        """Number of the last status."""
        return 0 if self.status.value is None else self.status.value.stamp.sequence

    async def nobody_connected(self) -> None:
        """Wait until every connection has ended."""
        await until(lambda: not len(self.side.hub))

    def publish(self, status: DroneStatus | None = None) -> None:
        """One heartbeat's worth of time passes, and the manager publishes its status."""
        self.clock.advance(0.2)
        self.publish_status(status)

    def publish_status(self, status: DroneStatus | None = None) -> None:
        """The manager publishes its status; no time passes for a lease."""
        self.real.advance(0.2)
        before = self.status.value or DroneStatus()
        self.status.publish(
            replace(status or before, stamp=StatusStamp(sequence=before.stamp.sequence + 1, time=self.clock()))
        )

    def serve_commands(self) -> list[tuple[ClientId, Command]]:
        """Do what the manager's ticks do: accept everything that its sender may send; return that."""
        accepted = []
        while commands := self.side.socket.receive():
            for client, command in commands:
                refused = self.manager.refusal(client, command)
                if refused is None:
                    accepted.append((client, command))
                self.side.socket.reply(client, refused or Ack(id=command.id, accepted=True))
        return accepted


class Visitor:
    """A page: reads messages by type."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self.socket = socket
        self.welcome: dict[str, Any] = {}

    async def next(self, kind: str) -> dict[str, Any]:
        async with asyncio.timeout(PATIENCE_S):
            while True:
                message = await self.socket.receive()
                assert message.type is aiohttp.WSMsgType.TEXT, message
                found: dict[str, Any] = json.loads(message.data)
                if found["Type"] == kind:
                    return found

    async def send(self, **keys: Any) -> None:
        await self.socket.send_str(json.dumps(keys))

    async def ask(self, **keys: Any) -> dict[str, Any]:
        """Send a command that is answered without the manager."""
        await self.send(**keys)
        return await self.next("Ack")

    async def take_control(self) -> dict[str, Any]:
        return await self.ask(Type="Control", Action="Request")


Connect = Callable[..., Awaitable[Visitor]]


@asynccontextmanager
async def browser(**options: Any) -> AsyncIterator[aiohttp.ClientSession]:
    async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True), **options) as session:
        yield session
