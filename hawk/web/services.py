"""The parts that the web server works with; the operations manager shares `OperatorSide`."""

from __future__ import annotations

import secrets
import time
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Final

from aiohttp import web

from hawk.comm.clock import Clock
from hawk.comm.message_socket import Gate, ServerMessageSocket
from hawk.comm.protocol.authority import role_refusal
from hawk.comm.protocol.command_table import COMMAND_TABLE, sender_of
from hawk.comm.protocol.commands import Ack, Command, Control, MapResync, OperatorHeartbeat, OperatorName, Outgoing
from hawk.comm.protocol.heartbeat import ClientId, DroneStatus
from hawk.comm.topic import Topic
from hawk.config.reference import Setting
from hawk.config.sections import OperatorSettings, WebSettings
from hawk.lots.store import LotStore
from hawk.model.day_plan import DayPlan, Forecast
from hawk.model.known_lot import FlownSection
from hawk.model.lot_map import OccupancyMap
from hawk.model.pictures import AnnotatedFrame
from hawk.model.sentences import say
from hawk.runtime.performance import LagSummary
from hawk.store.inbox import InboxFolder
from hawk.store.recording import NoRecordingError
from hawk.store.recording_requests import RecordingRequests
from hawk.store.recordings import Recordings
from hawk.web.access.tls import Tls
from hawk.web.clients import ClientHub
from hawk.web.sessions import ControlDesk


@dataclass(slots=True)
class Counters:
    """Rising counts, and the age of the last video frame when it was handed out (seconds of the daemon's clock)."""

    heartbeats: int = 0
    heartbeats_failed: int = 0
    video_frames: int = 0
    video_clients: int = 0
    frame_latency_s: float | None = None


@dataclass(frozen=True, slots=True)
class OperatorSide:
    """Clients, control and commands. It exists before the operations manager, which needs desk and socket."""

    hub: ClientHub
    desk: ControlDesk
    socket: ServerMessageSocket

    @classmethod
    def create(
        cls, clock: Clock, settings: OperatorSettings, otherwise: Callable[[ClientId, Command], Outgoing] | None = None
    ) -> OperatorSide:
        """Build it. Call ``socket.attach(manager.handle_now)`` when the manager exists.

        ``otherwise`` answers the commands that do not concern the session alone, where there is no manager.
        """
        hub = ClientHub()
        desk = ControlDesk(clock, settings)
        session = _session_gate(desk, hub)
        gate = session if otherwise is None else lambda client, c: session(client, c) or otherwise(client, c)
        return cls(hub, desk, ServerMessageSocket(hub.send_to, gate))


def _no_recording() -> Path:
    raise NoRecordingError(say("Nothing is recorded here."))


def _no_area(_: bytes, __: str) -> str:
    raise ValueError("cannot be read here")


@dataclass(frozen=True, slots=True)
class WebServices:
    """Values that the server shows, and its settings."""

    clock: Clock
    web: WebSettings
    operator: OperatorSettings
    side: OperatorSide
    status: Topic[DroneStatus]
    occupancy_map: Topic[OccupancyMap]
    video: Topic[AnnotatedFrame]
    version: str
    simulation: bool
    camera_fov_deg: float
    travel_speed_m_s: float
    loop_lag: Callable[[], LagSummary]
    performance: Callable[[], Mapping[str, object]] = dict
    """Figures of the last minute, as JSON values."""
    counters: Callable[[], Mapping[str, int]] = dict
    """Rising counts of other parts, by their name in ``/metrics``."""
    queues: Callable[[], Mapping[str, int]] = dict
    """Items that wait in queues of other parts, by name."""
    settings: Sequence[Setting] = ()
    """All settings as they are shown, without secrets."""
    newest_recording: Callable[[], Path] = _no_recording
    """Returns the newest complete recording; reads the disk. Raises NoRecordingError."""
    recordings: Recordings | None = None
    """The folder of recordings; None: nothing is recorded here."""
    cookie_secret: bytes = field(default_factory=lambda: secrets.token_bytes(32), repr=False)
    """Key of what is derived from logins and from `WebSettings.token`; the same after a restart when it is kept."""
    read_area: Callable[[bytes, str], str] = _no_area
    """Returns the area of a file's bytes for the editor of a kind (fence, outline), as GeoJSON; takes up to 0.1 s.
    Raises ValueError with the words for a file that holds none."""
    is_desk: bool = False
    """No drone is here: the page shows lots and plans alone."""
    collects: bool = False
    """Documents of surveys are taken from drones."""
    inbox: InboxFolder | None = None
    """Folder that programs fill with pictures; None: none are taken here."""
    recording_requests: RecordingRequests | None = None
    """Requests for recordings of surveys that drones sent here; None: no surveys are collected here."""
    due: Callable[[str, str, float | None, float, int], list[datetime]] | None = None
    """Returns when surveys of a lot are due: its id and name, the end of its newest survey, now, both Unix seconds, and
    for how many days. None: there is no schedule.
    """
    day_plan: Callable[[Forecast | None, int], Awaitable[DayPlan]] | None = None
    """Returns the rounds of the next 24 hours for a forecast and a number of full batteries. Raises DayPlanError."""
    sections: Callable[[], Sequence[FlownSection]] = tuple
    """Returns the sections of the known lot that is flown over, as they are counted so far."""
    lots: LotStore | None = None
    """Lots and surveys that last; None: there are none here."""
    folder: Path | None = None
    """Folder of the token file and of the kept logins; None: `WebSettings.token` alone, and nothing is kept."""
    tls: Tls | None = None
    """Certificate and key; None: plain HTTP."""
    wall: Callable[[], float] = time.time
    """Seconds since 1970: how long the daemon was away, for the logins that it kept."""
    monotonic: Callable[[], float] = time.monotonic
    """Real seconds: rates on the wire are real at any speed of the clock."""
    reads_per_s: float | None = None
    """Messages of one client that are read each real second; None: as many as a page needs."""


KEPT_PLACES: Final = 4
"""Connections of the operator in control beyond the limit of all: after a lost link the old ones close late."""

SERVICES = web.AppKey("services", WebServices)
COUNTERS = web.AppKey("counters", Counters)


def _session_gate(desk: ControlDesk, hub: ClientHub) -> Gate:
    """Return the answers to commands that a role does not allow, and that concern the session only; others pass."""

    def answer(client: ClientId, command: Command) -> Outgoing | None:
        if refused := role_refusal(sender_of(command.type), desk.role(client)):
            return Ack(id=command.id, accepted=False, reason=refused)
        row = COMMAND_TABLE[command.type]
        if isinstance(command, OperatorHeartbeat):
            desk.sign_of_life(client, is_hidden=command.hidden)
        else:
            desk.sign_of_life(client, is_hidden=None if row.sent_by_itself else False)
        if not row.sent_by_itself:
            desk.acted(client)
        if not row.answered_by_web_server:
            return None
        reason = None
        if isinstance(command, Control):
            reason = _control(desk, client, command)
        elif isinstance(command, OperatorName):
            reason = desk.call(client, command.name)
        elif isinstance(command, MapResync):
            hub.forget_map(client)
        return Ack(id=command.id, accepted=reason is None, reason=reason or "")

    return answer


def _control(desk: ControlDesk, client: ClientId, command: Control) -> str | None:
    if command.action in ("Give", "Keep"):
        return desk.answer(client, gives=command.action == "Give")
    acts = {"Request": desk.request, "Release": desk.release, "Ask": desk.ask, "Withdraw": desk.withdraw}
    return acts[command.action](client)
