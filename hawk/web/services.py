"""Everything that the web server is given, and the part of it that the operations manager needs too."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol, TypeVar

from aiohttp import web

from hawk.comm.clock import Clock
from hawk.comm.loop_lag import LagSummary
from hawk.comm.message_socket import ServerMessageSocket
from hawk.comm.status import DroneStatus
from hawk.comm.topic import Topic
from hawk.config import OperatorSettings, WebSettings
from hawk.model import OccupancyMap
from hawk.web.gate import Gate
from hawk.web.hub import ClientHub
from hawk.web.sessions import ControlDesk

T_co = TypeVar("T_co", covariant=True)


class VideoFrame(Protocol):
    """An annotated picture; ``captured`` is seconds of the daemon's clock."""

    @property
    def sequence(self) -> int:
        """Rises with every picture."""
        ...

    @property
    def captured(self) -> float:
        """When its light was caught."""
        ...

    @property
    def jpeg(self) -> bytes:
        """The picture."""
        ...


class Feed(Protocol[T_co]):
    """The reading side of a `hawk.comm.topic.Topic`."""

    @property
    def value(self) -> T_co | None:
        """The newest value."""
        ...

    @property
    def age(self) -> float:
        """Seconds since it was published."""
        ...

    async def next(self) -> T_co:
        """Wait for the next one."""
        ...


@dataclass(frozen=True, slots=True)
class OperatorSide:
    """Clients, control and commands: made before the operations manager, which needs desk and socket."""

    hub: ClientHub
    desk: ControlDesk
    socket: ServerMessageSocket

    @classmethod
    def create(cls, clock: Clock, settings: OperatorSettings, port: int = 3000) -> OperatorSide:
        """Put them together. ``socket.attach(manager)`` follows when the manager exists."""
        hub = ClientHub()
        desk = ControlDesk(clock, settings)
        return cls(hub, desk, ServerMessageSocket(hub, Gate(desk, hub), port))


@dataclass(frozen=True, slots=True)
class WebServices:
    """What the server shows and whom it asks."""

    clock: Clock
    web: WebSettings
    operator: OperatorSettings
    side: OperatorSide
    status: Topic[DroneStatus]
    occupancy_map: Topic[OccupancyMap]
    video: Feed[VideoFrame]
    version: str
    simulation: bool
    camera_fov_deg: float
    loop_lag: Callable[[], LagSummary]
    performance: Callable[[], Mapping[str, object]] = dict
    """Figures of the last minute, as JSON values."""
    monotonic: Callable[[], float] = time.monotonic
    """Real seconds: rates on the wire are real at any speed of the clock."""


SERVICES = web.AppKey("services", WebServices)
