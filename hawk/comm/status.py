"""Where the operations manager and the operator's side meet: what the drone tells, and who holds control.

The manager publishes one `DroneStatus` for everybody; the web server makes each client's Heartbeat of it, adding what
that client has not been sent yet of the map, the log and the trail.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from hawk.comm.fence_messages import FenceSetup
from hawk.comm.messages import CheckItem, Command, CommandOption, HealthItem, LogEntry, Outgoing
from hawk.model import HealthStatus, MapPoint, StateName, UserError

ClientId = str
"""One connected session."""

KillState = Literal["none", "sending", "confirmed", "not confirmed"]


@dataclass(frozen=True, slots=True)
class DroneStatus:
    """All of `hawk.comm.messages.Heartbeat` that is the same for every client, under the same field names.

    Metres, metres a second, degrees (latitude, longitude), radians (yaw, roll, pitch), seconds. What is not known is
    None; every number is finite.
    """

    sequence: int = 0
    """Rises by one with each status: one status is one heartbeat."""
    time: float = 0.0
    utc: str = ""
    state: StateName = StateName.IDLE
    detail: str = ""
    ardupilot_state: str | None = None
    armed: bool | None = None
    connected: bool = False
    landed: str = "UNDEFINED"
    relative_altitude: float | None = None
    latitude: float | None = None
    longitude: float | None = None
    local_position_x: float | None = None
    local_position_y: float | None = None
    north: float | None = None
    east: float | None = None
    yaw: float | None = None
    roll: float | None = None
    pitch: float | None = None
    speed: float | None = None
    climb: float | None = None
    pose_age: float | None = None
    link_age: float | None = None
    battery_percentage: float | None = None
    battery_age: float | None = None
    voltage: float | None = None
    battery_time_left: float | None = None
    satellites: int | None = None
    user_error: UserError = UserError.NONE
    user_error_text: str = ""
    health_status: HealthStatus = HealthStatus.HEALTHY
    health: tuple[HealthItem, ...] = ()
    home: MapPoint | None = None
    datum: tuple[float, float] | None = None
    """Latitude and longitude of the map's origin."""
    target: MapPoint | None = None
    route: tuple[MapPoint, ...] = ()
    footprint: tuple[MapPoint, ...] = ()
    fence: tuple[MapPoint, ...] = ()
    fence_limit: tuple[MapPoint, ...] = ()
    """The autopilot's."""
    fence_setup: FenceSetup | None = None
    """The same object until it changes: a client is sent each once."""
    ceiling: float | None = None
    heights: tuple[float, float, float] = (15.0, 35.0, 60.0)
    """Min, Des, Max."""
    explored: float | None = None
    explore_done: bool = False
    remaining_m: float | None = None
    lot_area: float | None = None
    park_lot_detected: bool | None = None
    free: int = 0
    taken: int = 0
    unknown: int = 0
    vision_rate: float | None = None
    camera_age: float | None = None
    options: tuple[CommandOption, ...] = ()
    checks: tuple[CheckItem, ...] = ()
    killed: bool = False
    kill_state: KillState = "none"
    return_in: float | None = None
    flight_time: float | None = None
    way: float | None = None
    log: tuple[LogEntry, ...] = ()
    """The last entries (bounded), rising by `LogEntry.number`: a client is sent those above its last number."""
    trail: tuple[MapPoint, ...] = ()
    """Where the drone flew: grows at the end only, until ``trail_id`` changes."""
    trail_id: int = 0
    """Changes when the trail starts anew."""


class OperatorDesk(Protocol):
    """Who holds control, as the web server knows it."""

    def operator_present(self, now: float) -> bool:
        """Whether a session with control showed a sign of life within ``operator_timeout_s``."""
        ...

    def controller(self) -> ClientId | None:
        """The session that has control."""
        ...

    def has_control(self, client: ClientId) -> bool:
        """Whether this session has control."""
        ...


class CommandSocket(Protocol):
    """The server role of the message socket as the operations manager needs it."""

    def receive(self) -> list[tuple[ClientId, Command]]:
        """Take all commands that wait, oldest first."""
        ...

    def reply(self, client: ClientId, message: Outgoing) -> None:
        """Answer one client; a client that has gone is no error. Never blocks."""
        ...


class CommandHandler(Protocol):
    """What the web server calls for Hold, Kill Request and Kill, which pass every queue."""

    def handle_now(self, client: ClientId, command: Command) -> Outgoing:
        """Act on the command at once and return the answer for the client (an Ack, or a KillToken)."""
        ...
