"""Messages between drone and operator (JSON over a WebSocket), one pydantic model each.

Names and keys are the specification's (sections 18.4.5 and 20.4.5); those that it does not have are ours and listed in
``docs/architecture.md``. What is not known is null: never NaN, never 0.
"""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, TypeAdapter, ValidationError

from hawk.comm.fence_messages import CheckFence, ClearFence, FenceCheck, FenceSetup, SetFence
from hawk.comm.message_base import Command as Command
from hawk.comm.message_base import Finite, Height, Metres
from hawk.comm.message_base import Outgoing as Outgoing

MAX_MESSAGE_BYTES = 16 * 1024
"""A command is a few hundred bytes, a fence of 70 corners some 4 kB; anything larger is refused unread."""


# -- to the drone -----------------------------------------------------------------------------------------------------


class Configure(Command):
    """Travel heights, metres above the arm place."""

    type: Literal["Configure"] = Field(default="Configure", alias="Type")
    min: Height = Field(alias="Min")
    des: Height = Field(alias="Des")
    max: Height = Field(alias="Max")


class Arm(Command):
    """Start the motors."""

    type: Literal["Arm"] = Field(default="Arm", alias="Type")


class Takeoff(Command):
    """Climb to the desired height."""

    type: Literal["Takeoff"] = Field(default="Takeoff", alias="Type")


class AutonomousExplore(Command):
    """See the whole lot."""

    type: Literal["Autonomous Explore"] = Field(default="Autonomous Explore", alias="Type")


class _Move(Command):
    x: Metres = Field(alias="X")
    y: Metres = Field(alias="Y")
    frame: Literal["Relative", "Map"] = Field(default="Relative", alias="Frame")
    """Relative: metres north (X) and east (Y) of where the drone is; Map: coordinates of the map."""


class CompulsiveMove(_Move):
    """Fly to any place inside the fence."""

    type: Literal["Compulsive Move"] = Field(default="Compulsive Move", alias="Type")
    height: Height | None = Field(default=None, alias="Height")
    """Metres above the arm place to fly at, within Min and Max; absent: the height it has."""


class AutonomousMove(_Move):
    """Fly to a place inside the lot."""

    type: Literal["Autonomous Move"] = Field(default="Autonomous Move", alias="Type")


class RouteRequest(_Move):
    """Ask for the way that an Autonomous Move there would take (answered by RouteAnswer); nothing is flown."""

    type: Literal["Route Request"] = Field(default="Route Request", alias="Type")


class Hold(Command):
    """Stop and stay."""

    type: Literal["Hold"] = Field(default="Hold", alias="Type")


class ReturnToLaunch(Command):
    """Fly home and land."""

    type: Literal["Return To Launch"] = Field(default="Return To Launch", alias="Type")
    confirmed: bool = Field(default=False, alias="Confirmed")
    """Needed while someone else flies (Manual)."""


class Land(Command):
    """Straight down."""

    type: Literal["Land"] = Field(default="Land", alias="Type")
    confirmed: bool = Field(default=False, alias="Confirmed")
    """Needed while someone else flies (Manual)."""


class Disarm(Command):
    """Stop the motors on the ground."""

    type: Literal["Disarm"] = Field(default="Disarm", alias="Type")


class Resume(Command):
    """Take the drone back from Manual."""

    type: Literal["Resume"] = Field(default="Resume", alias="Type")
    confirmed: bool = Field(default=False, alias="Confirmed")


class KillRequest(Command):
    """First step of cutting the motors: ask for a one-use token (answered by KillToken)."""

    type: Literal["Kill Request"] = Field(default="Kill Request", alias="Type")


class Kill(Command):
    """Second step: cut the motors at once, with the token that was given for it."""

    type: Literal["Kill"] = Field(default="Kill", alias="Type")
    token: Annotated[str, Field(min_length=16, max_length=128)] = Field(alias="Token")


class ClearKill(Command):
    """On the ground after a kill: Arm may be asked for again."""

    type: Literal["Clear Kill"] = Field(default="Clear Kill", alias="Type")


class SetFailsafes(Command):
    """Set the autopilot's own failsafes that the preflight check found missing."""

    type: Literal["Set Failsafes"] = Field(default="Set Failsafes", alias="Type")


class OperatorHeartbeat(Command):
    """The operator's sign of life."""

    type: Literal["Heartbeat"] = Field(default="Heartbeat", alias="Type")


class Control(Command):
    """Ask for control or give it back."""

    type: Literal["Control"] = Field(default="Control", alias="Type")
    action: Literal["Request", "Release"] = Field(alias="Action")


class MapResync(Command):
    """Forget what this client was sent of the map: send it again."""

    type: Literal["Map Resync"] = Field(default="Map Resync", alias="Type")


AnyCommand = Annotated[
    Configure
    | Arm
    | Takeoff
    | AutonomousExplore
    | CompulsiveMove
    | AutonomousMove
    | RouteRequest
    | Hold
    | ReturnToLaunch
    | Land
    | Disarm
    | Resume
    | KillRequest
    | Kill
    | ClearKill
    | SetFailsafes
    | SetFence
    | ClearFence
    | CheckFence
    | OperatorHeartbeat
    | Control
    | MapResync,
    Field(discriminator="type"),
]

_COMMANDS: TypeAdapter[Any] = TypeAdapter(AnyCommand)


class BadMessageError(ValueError):
    """A message that cannot be taken; the text names the field and the remedy. ``id`` is the message's, if any."""

    def __init__(self, reason: str, message_id: str | int | None = None) -> None:
        super().__init__(reason)
        self.message_id = message_id


def parse_command(text: str) -> Command:
    """Return the command that a JSON text holds. Raises BadMessageError naming the field and what to do."""
    size = len(text.encode("utf-8", "replace"))
    if size > MAX_MESSAGE_BYTES:
        raise BadMessageError(f"message of {size} bytes is too large: send at most {MAX_MESSAGE_BYTES}")
    try:
        command = _COMMANDS.validate_json(text)
    except ValidationError as error:
        raise BadMessageError(_explain(error), _message_id(text)) from None
    assert isinstance(command, Command)  # noqa: S101 - narrows the union for the type checker
    return command


def _explain(error: ValidationError) -> str:
    """Return the first problem as "field: what is wrong"."""
    problem = error.errors(include_url=False, include_context=False)[0]
    kind = problem["type"]
    if kind == "json_invalid":
        return f"not JSON: {problem['msg']}; send one JSON object with a Type"
    if kind == "union_tag_not_found":
        return 'Type: missing; send one JSON object such as {"Type": "Hold"}'
    if kind == "union_tag_invalid":
        return f"Type: {problem['msg'][:300]}"
    location = [str(part) for part in problem["loc"][1:]] or ["message"]
    return f"{'.'.join(location)}: {problem['msg'].removeprefix('Value error, ')}"


def _message_id(text: str) -> str | int | None:
    try:
        found = json.loads(text).get("Id")
    except (ValueError, AttributeError, RecursionError):
        return None
    if not isinstance(found, str | int) or isinstance(found, bool):
        return None
    try:
        str(found).encode()
    except ValueError:  # half a surrogate pair, or a number of thousands of digits: neither can be sent back
        return None
    return found


# -- from the drone ---------------------------------------------------------------------------------------------------


class Ack(Outgoing):
    """Answer to one command, to the client that sent it."""

    type: Literal["Ack"] = Field(default="Ack", alias="Type")
    id: str | int | None = Field(alias="Id")
    accepted: bool = Field(alias="Accepted")
    reason: str = Field(default="", alias="Reason")


class KillToken(Outgoing):
    """One-use token for Kill, valid for ``ValidFor`` seconds."""

    type: Literal["Kill Token"] = Field(default="Kill Token", alias="Type")
    id: str | int | None = Field(alias="Id")
    token: str = Field(alias="Token")
    valid_for: Finite = Field(alias="ValidFor")


class Welcome(Outgoing):
    """First message to a client: who it is, which server, and what never changes during the connection."""

    type: Literal["Welcome"] = Field(default="Welcome", alias="Type")
    session: str = Field(alias="Session")
    version: str = Field(alias="Version")
    simulation: bool = Field(alias="Simulation")
    cell_m: Finite = Field(alias="CellSize")
    tile_cells: int = Field(alias="TileCells")
    operator_timeout_s: Finite = Field(alias="OperatorTimeout")
    operator_hold_s: Finite = Field(alias="OperatorHold")
    speed: Finite = Field(alias="Speed")
    camera_fov_deg: Finite = Field(alias="CameraFov")


class HealthItem(Outgoing):
    """Health of one part. Name: link, position, vision, mapper, planner, camera, recording or loop."""

    name: str = Field(alias="Name")
    healthy: bool = Field(alias="Healthy")
    reason: str = Field(alias="Reason")


class TileUpdate(Outgoing):
    """A changed tile: base64 of zlib of TileCells² bytes of cell classes."""

    row: int = Field(alias="Row")
    column: int = Field(alias="Column")
    version: int = Field(alias="Version")
    data: str = Field(alias="Data")


class StallUpdate(Outgoing):
    """A changed stall. ``Removed``: it is gone. Angle in radians clockwise from north of the long side."""

    id: int = Field(alias="Id")
    version: int = Field(alias="Version")
    removed: bool = Field(default=False, alias="Removed")
    north: Finite | None = Field(default=None, alias="North")
    east: Finite | None = Field(default=None, alias="East")
    angle: Finite | None = Field(default=None, alias="Angle")
    width: Finite | None = Field(default=None, alias="Width")
    length: Finite | None = Field(default=None, alias="Length")
    state: Literal["free", "taken", "unknown"] | None = Field(default=None, alias="State")
    taken: Finite | None = Field(default=None, alias="Taken")
    seen: int | None = Field(default=None, alias="Seen")
    last_seen: Finite | None = Field(default=None, alias="LastSeen")
    score: Finite | None = Field(default=None, alias="Score")


class MosaicVersion(Outgoing):
    """A changed mosaic tile; its picture is at /api/mosaic/{Row}/{Column}.jpg?v={Version}."""

    row: int = Field(alias="Row")
    column: int = Field(alias="Column")
    version: int = Field(alias="Version")


class MapUpdate(Outgoing):
    """The "Occupancy Map" of a heartbeat: what changed for this client, at most 64 kB, nearest first."""

    map_id: str = Field(alias="MapId")
    tiles: list[TileUpdate] = Field(alias="Tiles")
    stalls: list[StallUpdate] = Field(alias="Stalls")
    mosaic: list[MosaicVersion] = Field(alias="Mosaic")
    backlog: int = Field(alias="Backlog")
    """Tiles and stalls still to come in later heartbeats."""


class Point(Outgoing):
    """A place in the map frame, metres."""

    north: Finite = Field(alias="North")
    east: Finite = Field(alias="East")


class CheckItem(Outgoing):
    """One preflight check: what was found, and for a failed one the consequence and the remedy."""

    name: str = Field(alias="Name")
    passed: bool = Field(alias="Passed")
    value: str = Field(alias="Value")
    consequence: str = Field(default="", alias="Consequence")
    remedy: str = Field(default="", alias="Remedy")
    remedy_command: Literal["Set Failsafes", "Clear Kill", "Set Fence"] | None = Field(
        default=None, alias="RemedyCommand"
    )


class CommandOption(Outgoing):
    """Whether a command would be taken now, and why not."""

    command: str = Field(alias="Command")
    possible: bool = Field(alias="Possible")
    reason: str = Field(default="", alias="Reason")


class LogEntry(Outgoing):
    """A line of the message list. Level: info, ok, warning or error. Details: the autopilot's own words."""

    number: int = Field(alias="Number")
    time: str = Field(alias="Time")
    """UTC, ISO 8601."""
    level: Literal["info", "ok", "warning", "error"] = Field(alias="Level")
    text: str = Field(alias="Text")
    details: str = Field(default="", alias="Details")


class RouteAnswer(Outgoing):
    """Answer to Route Request: the points of the way from the drone, its length in metres, or why there is none."""

    type: Literal["Route"] = Field(default="Route", alias="Type")
    id: str | int | None = Field(alias="Id")
    points: list[Point] = Field(alias="Points")
    length_m: Finite | None = Field(alias="Length")
    refused: str | None = Field(alias="Refused")
    """Why an Autonomous Move there would be refused, null when it would not."""


Answer = Ack | FenceCheck | KillToken | RouteAnswer
"""What comes back to the client that sent a command."""


class Heartbeat(Outgoing):
    """What the drone tells at 5 Hz: the specification's keys (18.4.5), then ours."""

    type: Literal["Heartbeat"] = Field(default="Heartbeat", alias="Type")
    state: str = Field(alias="State")
    ardupilot_state: str | None = Field(alias="Ardupilot State")
    occupancy_map: MapUpdate | None = Field(alias="Occupancy Map")
    relative_altitude: Finite | None = Field(alias="Relative Altitude")
    armed: bool | None = Field(alias="Armed")
    latitude: Finite | None = Field(alias="Latitude")
    longitude: Finite | None = Field(alias="Longitude")
    local_position_x: Finite | None = Field(alias="Local Position X")
    local_position_y: Finite | None = Field(alias="Local Position Y")
    battery_percentage: Finite | None = Field(alias="Battery Percentage")
    user_error: int = Field(alias="User Error")
    health_status: int = Field(alias="Health Status")

    sequence: int = Field(alias="Sequence")
    time: Finite = Field(alias="Time")
    utc: str = Field(alias="UTC")
    detail: str = Field(alias="Detail")
    """One sentence on what the state is doing or why it was entered."""
    user_error_text: str = Field(alias="User Error Text")
    health: list[HealthItem] = Field(alias="Health")
    landed: str = Field(alias="Landed")
    connected: bool = Field(alias="Connected")
    north: Finite | None = Field(alias="North")
    east: Finite | None = Field(alias="East")
    yaw: Finite | None = Field(alias="Yaw")
    roll: Finite | None = Field(alias="Roll")
    pitch: Finite | None = Field(alias="Pitch")
    speed: Finite | None = Field(alias="Speed")
    climb: Finite | None = Field(alias="Climb")
    pose_age: Finite | None = Field(alias="Pose Age")
    battery_age: Finite | None = Field(alias="Battery Age")
    link_age: Finite | None = Field(alias="Link Age")
    voltage: Finite | None = Field(alias="Voltage")
    battery_time_left: Finite | None = Field(alias="Battery Time Left")
    """Seconds until it must return, by what it drew so far."""
    satellites: int | None = Field(alias="Satellites")
    home: Point | None = Field(alias="Home")
    datum: list[Finite] | None = Field(alias="Datum")
    """Latitude and longitude of the map's origin."""
    target: Point | None = Field(alias="Target")
    route: list[Point] = Field(alias="Route")
    """The way on while it explores or moves autonomously, in order; empty when there is none."""
    footprint: list[Point] = Field(alias="Footprint")
    fence: list[Point] = Field(alias="Fence")
    """Our own limit, which lies inside the autopilot's."""
    fence_limit: list[Point] = Field(alias="Fence Limit")
    """The autopilot's."""
    fence_setup: FenceSetup | None = Field(alias="Fence Setup")
    """Which fence the next Arm puts in force; null: as this client was told last."""
    ceiling: Finite | None = Field(alias="Ceiling")
    heights: list[Finite] = Field(alias="Heights")
    """Min, Des, Max."""
    explored: Finite | None = Field(alias="Explored")
    explore_done: bool = Field(alias="Explore Done")
    remaining_m: Finite | None = Field(alias="Remaining")
    lot_area: Finite | None = Field(alias="Lot Area")
    park_lot_detected: bool | None = Field(alias="Park Lot Detected")
    free: int = Field(alias="Free")
    taken: int = Field(alias="Taken")
    unknown: int = Field(alias="Unknown")
    vision_rate: Finite | None = Field(alias="Vision Rate")
    camera_age: Finite | None = Field(alias="Camera Age")
    options: list[CommandOption] = Field(alias="Options")
    checks: list[CheckItem] = Field(alias="Checks")
    """Preflight checks; empty in the air."""
    messages: list[LogEntry] = Field(alias="Messages")
    """What this client has not been sent yet."""
    controller: str | None = Field(alias="Controller")
    """Session that has control."""
    in_control: bool = Field(alias="In Control")
    killed: bool = Field(alias="Killed")
    kill_state: Literal["none", "sending", "confirmed", "not confirmed"] = Field(alias="Kill State")
    return_in: Finite | None = Field(alias="Return In")
    """CommunicationLost: seconds until it returns home."""
    trail: list[Point] = Field(alias="Trail")
    """Trail points this client has not been sent yet."""
    trail_start: bool = Field(default=False, alias="Trail Start")
    """The trail begins anew with these points: forget earlier ones."""
    flight_time: Finite | None = Field(alias="Flight Time")
    way: Finite | None = Field(alias="Way")


def schema() -> dict[str, Any]:
    """Return the JSON schema of every message, as served at /api/schema.json."""
    models: list[type[BaseModel]] = [Heartbeat, Ack, FenceCheck, KillToken, RouteAnswer, Welcome]
    return {
        "toDrone": _COMMANDS.json_schema(by_alias=True),
        "fromDrone": {model.__name__: model.model_json_schema(by_alias=True) for model in models},
    }
