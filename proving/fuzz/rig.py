"""The daemon's front door with everything behind it but the flight: server, messages, judge, states.

The drone hovers and hears nothing; its clock is moved by hand, a tick after each round of messages.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import math
import re
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any, Final

import aiohttp

from hawk.comm.clock import Clock
from hawk.comm.protocol.authority import OperatorDesk
from hawk.comm.protocol.heartbeat import CommandSocket
from hawk.comm.topic import Topic
from hawk.config.sections import OperatorSettings, WebSettings
from hawk.model.lot_map import OccupancyMap
from hawk.model.pictures import AnnotatedFrame
from hawk.runtime.performance import LagSummary
from hawk.web.app import Page, WebServer
from hawk.web.services import OperatorSide, WebServices
from proving.fuzz.still_drone import StillDrone

ANSWER_TICKS: Final = 200
"""Ticks within which every message is answered: a Move waits 1 s, 20 ticks, for the planner."""
ANSWER_S: Final = 2.0
"""Real seconds that an answer takes at most besides: fences are checked on a thread, with pauses."""
_PATIENCE_S: Final = 20.0
_MALFORMED: Final = re.compile(
    r"Error handling request|Unhandled exception: RequestPayload|\d+ more lines of this kind"
)
"""Log lines of aiohttp about malformed requests. A fault of ours behind one is an answer of status 500 besides."""


class Faults(logging.Handler):
    """Collects errors of the program: whatever is logged with a traceback, or as an error."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.found: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep it. A malformed request is logged as an error of aiohttp's, without a traceback: not one of ours."""
        text = record.getMessage()
        if record.exc_info or not _MALFORMED.match(text):
            if record.exc_info and record.exc_info[1] is not None:
                text += f": {record.exc_info[1]!r}"
            self.found.append(text)


class FuzzRig:
    """Server and manager. `port`, `tick`, and the ``faults`` so far."""

    def __init__(self, folder: Path) -> None:
        self.faults = Faults()
        self._sides: list[OperatorSide] = []
        self.drone = StillDrone(folder, self._seats)
        (self.side,) = self._sides
        self.side.socket.attach(self.drone.manager.handle_now)
        clock = self.drone.clock
        self._video = Topic[AnnotatedFrame]("video", clock)
        services = WebServices(
            clock=clock,
            web=WebSettings(port=0),
            operator=OperatorSettings(),
            side=self.side,
            status=self.drone.manager.status,
            occupancy_map=Topic[OccupancyMap]("map", clock),
            video=self._video,
            version="fuzz",
            simulation=True,
            camera_fov_deg=70.0,
            travel_speed_m_s=4.0,
            loop_lag=lambda: LagSummary(None, None, None, 0),
            reads_per_s=math.inf,
        )
        self.server = WebServer(services, Page.load(folder))
        self.ticks = 0

    def _seats(self, clock: Clock) -> tuple[OperatorDesk, CommandSocket]:
        self._sides.append(OperatorSide.create(clock, OperatorSettings()))
        return self._sides[0].desk, self._sides[0].socket

    @contextlib.asynccontextmanager
    async def open(self) -> AsyncIterator[None]:
        """Serve, and collect faults."""
        root = logging.getLogger()
        root.addHandler(self.faults)
        try:
            await self.server.start()
            yield
        finally:
            await self.server.close()
            await self.drone.close()
            root.removeHandler(self.faults)

    async def tick(self) -> None:
        """Let a tick's time pass; note an unhealthy manager."""
        self.drone.advance()
        self.drone.manager.process()
        self.ticks += 1
        self._video.publish(AnnotatedFrame(self.ticks, self.drone.clock(), b"\xff\xd8 a picture \xff\xd9"))
        health = self.drone.manager.own_health
        if not health.is_healthy:
            self.faults.found.append(f"the manager: {health.reason}")
            self.drone.manager.own_health = type(health)()
        await asyncio.sleep(0)


class FuzzClient:
    """A client on a WebSocket: sends, and collects answers in order."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self._socket = socket
        self.answers: list[dict[str, Any]] = []
        self._reading = asyncio.create_task(self._read(), name="fuzz-client")

    @property
    def has_left(self) -> bool:
        """True when the server ended the connection."""
        return self._reading.done()

    async def send(self, message: str | bytes) -> None:
        """Send one message."""
        if isinstance(message, bytes):
            await self._socket.send_bytes(message)
        else:
            await self._socket.send_str(message)

    async def answered(self, rig: FuzzRig, count: int) -> list[dict[str, Any]]:
        """Tick until ``count`` answers have come, or until they are overdue; return those that came."""
        loop, begun = asyncio.get_running_loop(), rig.ticks
        due = loop.time() + ANSWER_S
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_PATIENCE_S):
                while len(self.answers) < count and not self.has_left:
                    if rig.ticks - begun >= ANSWER_TICKS and loop.time() > due:
                        break
                    await rig.tick()
        taken, self.answers = self.answers[:count], self.answers[count:]
        return taken

    async def close(self) -> None:
        """Leave."""
        self._reading.cancel()
        await asyncio.gather(self._reading, return_exceptions=True)
        await self._socket.close()

    async def _read(self) -> None:
        async for message in self._socket:
            if message.type is not aiohttp.WSMsgType.TEXT:
                continue
            found = json.loads(message.data)
            if found["Type"] not in ("Heartbeat", "Welcome"):
                self.answers.append(found)
