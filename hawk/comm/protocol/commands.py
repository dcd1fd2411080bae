"""Messages between drone and operator (JSON over a WebSocket), one pydantic model each.

Names and keys are the specification's (sections 18.4.5 and 20.4.5); our own are listed in ``docs/protocol.md``. An
unknown value is null: never NaN, never 0.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Annotated, Any, Final, Literal, Self

from pydantic import BaseModel, Field, TypeAdapter, ValidationError, ValidationInfo, field_validator, model_validator

from hawk.comm.protocol.authority import PersonName
from hawk.comm.protocol.base import Command as Command
from hawk.comm.protocol.base import Finite, Height, Metres, Spoken, Words
from hawk.comm.protocol.base import Outgoing as Outgoing
from hawk.comm.protocol.heartbeat import LEAST_CORNERS as LEAST_CORNERS
from hawk.comm.protocol.heartbeat import MOST_CORNERS as MOST_CORNERS
from hawk.comm.protocol.heartbeat import Corners, FenceCorner, Heartbeat, Point
from hawk.formats.validation import reason_of

MOST_LOTS: Final = 12
"""Lots of a round: the search for their order doubles with each."""
MOST_OUTLINE_RINGS = 12
"""Polygons, and holes, of an outline."""
MOST_OUTLINE_CORNERS = 200
"""Corners of all polygons and holes of an outline: some 12 kB of a message."""


def outline_problem(polygons: Sequence[int], holes: Sequence[int]) -> str:
    """Return why an outline cannot have rings with these numbers of corners; empty if it can."""
    for name, rings in (("polygons", polygons), ("holes", holes)):
        if len(rings) > MOST_OUTLINE_RINGS:
            return f"an outline has at most {MOST_OUTLINE_RINGS} {name}, this one has {len(rings)}: leave some out"
    count = sum(polygons) + sum(holes)
    if count > MOST_OUTLINE_CORNERS:
        return f"an outline has at most {MOST_OUTLINE_CORNERS} corners, this one has {count}: leave some out"
    return ""


class SetOutline(Command):
    """Survey this area: the next Explore sees every place of it inside the fence, and nothing else.

    Not while it explores. Corners in order, not closed.
    """

    type: Literal["Set Outline"] = "Set Outline"
    polygons: Annotated[list[Corners], Field(min_length=1)]
    """Places in one of them belong to the outline."""
    holes: list[Corners] = Field(default_factory=list, validate_default=True)
    """Places in one of them do not."""

    @field_validator("polygons", "holes", mode="before")
    @classmethod
    def _counted(cls, value: Any, info: ValidationInfo) -> Any:
        for number, ring in enumerate(value if isinstance(value, list) else (), 1):
            if isinstance(ring, list) and not LEAST_CORNERS <= len(ring) <= MOST_CORNERS:
                name = "polygon" if info.field_name == "polygons" else "hole"
                wanted = f"{LEAST_CORNERS} to {MOST_CORNERS}"
                raise ValueError(f"{name} {number} has {len(ring)} corners: draw {wanted}")
        return value

    @field_validator("holes", mode="after")
    @classmethod
    def _together(cls, value: list[list[FenceCorner]], info: ValidationInfo) -> list[list[FenceCorner]]:
        polygons = [len(ring) for ring in info.data.get("polygons", ())]
        problem = outline_problem(polygons, [len(ring) for ring in value])
        if problem:
            raise ValueError(problem)
        return value


class ClearOutline(Command):
    """Drop the outline: the next Explore finds the lot by looking. Not while it explores."""

    type: Literal["Clear Outline"] = "Clear Outline"


class SurveyAgain(Command):
    """Survey known lots again: the next Explore looks at every stall of their plans once more, then at new ones at
    their rims. It sets the lots' ground as the outline; Clear Outline ends it. Not while it explores.
    """

    type: Literal["Survey Again"] = "Survey Again"
    lots: list[Annotated[str, Field(min_length=1, max_length=64)]] = Field(default=[], max_length=MOST_LOTS)
    """Ids of the lots, as in ``/api/v1/lots``."""
    due: bool = False
    """True, without ``Lots``: all lots inside the fence whose survey is due."""

    @model_validator(mode="after")
    def _lots_or_due(self) -> Self:
        if bool(self.lots) is self.due:
            raise ValueError("Lots: must name lots, or be empty with Due")
        return self


class FlyPlan(Command):
    """Fly the plan of the lot as somebody changed it since the motors are on. Without this the flight goes on with the
    plan that it began with, and the next one begins with the changed one.
    """

    type: Literal["Fly Plan"] = "Fly Plan"
    plan: str = Field(min_length=1, max_length=80)
    """``Plan`` of the heartbeat's ``Plan Offer``."""


class Control(Command):
    """Control: Request it, Release it; Ask the one who has it, Withdraw that; answer such a question by Give or Keep.

    Request is granted while control is free, its holder is lost, or a question of this client was not answered in time.
    """

    type: Literal["Control"] = "Control"
    action: Literal["Request", "Release", "Ask", "Withdraw", "Give", "Keep"]


class OperatorName(Command):
    """The name by which the others know the sender; null: none. It is shown, and proves nothing."""

    type: Literal["Name"] = "Name"
    name: PersonName | None


MAX_MESSAGE_BYTES = 16 * 1024
"""A command has a few hundred bytes, a fence of 69 corners some 4 kB; a larger message is refused unread."""

LONGEST_NAME = 60
"""Characters of a name that a refusal repeats."""
MOST_ZONES = 12
MOST_ZONED_CORNERS = 66
"""Corners of a fence and its zones together that ArduCopter stores with `MOST_ZONES` zones."""


# -- to the drone -----------------------------------------------------------------------------------------------------


class Configure(Command):
    """Travel heights, metres above the arm place."""

    type: Literal["Configure"] = "Configure"
    min: Height
    des: Height
    max: Height


class Arm(Command):
    """Start the motors."""

    type: Literal["Arm"] = "Arm"


class Takeoff(Command):
    """Climb to the desired height."""

    type: Literal["Takeoff"] = "Takeoff"


class AutonomousExplore(Command):
    """Explore the whole lot."""

    type: Literal["Autonomous Explore"] = "Autonomous Explore"


class _Move(Command):
    x: Metres
    y: Metres
    frame: Literal["Relative", "Map"] = "Relative"
    """Relative: metres north (X) and east (Y) of the drone; Map: coordinates of the map."""


class CompulsiveMove(_Move):
    """Fly to any place inside the fence."""

    type: Literal["Compulsive Move"] = "Compulsive Move"
    height: Height | None = None
    """Metres above the arm place, within Min and Max; absent: the present height."""


class AutonomousMove(_Move):
    """Fly to a place inside the lot."""

    type: Literal["Autonomous Move"] = "Autonomous Move"


class RouteRequest(_Move):
    """Ask for the route that an Autonomous Move there would fly (answered by RouteAnswer); nothing is flown."""

    type: Literal["Route Request"] = "Route Request"


class Hold(Command):
    """Stop and stay."""

    type: Literal["Hold"] = "Hold"


class Confirmable(Command):
    """Base of the commands that would overrule a pilot."""

    confirmed: bool = False
    """Needed while someone else flies (Manual)."""


class ReturnToLaunch(Confirmable):
    """Fly home and land."""

    type: Literal["Return To Launch"] = "Return To Launch"


class Land(Confirmable):
    """Straight down."""

    type: Literal["Land"] = "Land"


class Disarm(Command):
    """Stop the motors on the ground."""

    type: Literal["Disarm"] = "Disarm"


class Resume(Confirmable):
    """Take the drone back from Manual."""

    type: Literal["Resume"] = "Resume"


class KillRequest(Command):
    """First step of cutting the motors: ask for a one-use token (answered by KillToken)."""

    type: Literal["Kill Request"] = "Kill Request"


class Kill(Command):
    """Second step: cut the motors at once, with the token that was given for it."""

    type: Literal["Kill"] = "Kill"
    token: Annotated[str, Field(min_length=16, max_length=128)]


class ClearKill(Command):
    """On the ground after a kill: Arm may be asked for again."""

    type: Literal["Clear Kill"] = "Clear Kill"


class SetFailsafes(Command):
    """Set the autopilot's own failsafes that the preflight check found missing."""

    type: Literal["Set Failsafes"] = "Set Failsafes"


def zones_problem(corners: int, zones: Sequence[int]) -> str:
    """Return why the autopilot cannot store zones with these numbers of corners beside a fence's; empty if it can."""
    if len(zones) > MOST_ZONES:
        return f"a fence has at most {MOST_ZONES} zones, this one has {len(zones)}: draw one around several places"
    count = corners + sum(zones)
    if zones and count > MOST_ZONED_CORNERS:
        most = f"at most {MOST_ZONED_CORNERS} corners"
        return f"a fence and its zones have {most} together, these have {count}: leave some out"
    return ""


class _Fence(Command):
    corners: Corners
    """The autopilot's limit, in order, not closed; ours lies inside it by the margin."""
    ceiling: Height
    """The autopilot's ceiling, metres above the arm place; ours is lower by the margin."""
    zones: list[Corners] = Field(default_factory=list)
    """Exclusion zones inside the fence, each in order, not closed; ours lies around each of them by the margin."""

    @field_validator("corners", mode="before")
    @classmethod
    def _counted(cls, value: Any) -> Any:
        if isinstance(value, list) and not LEAST_CORNERS <= len(value) <= MOST_CORNERS:
            wanted = f"{LEAST_CORNERS} to {MOST_CORNERS} corners"
            raise ValueError(f"a fence has {wanted}, this one has {len(value)}: add some or leave some out")
        return value

    @field_validator("zones", mode="before")
    @classmethod
    def _counted_zones(cls, value: Any) -> Any:
        for number, zone in enumerate(value if isinstance(value, list) else (), 1):
            if isinstance(zone, list) and len(zone) < LEAST_CORNERS:
                raise ValueError(f"zone {number} has {len(zone)} corners: add some, {LEAST_CORNERS} at least")
        return value

    @field_validator("zones", mode="after")
    @classmethod
    def _shared(cls, value: list[list[FenceCorner]], info: ValidationInfo) -> list[list[FenceCorner]]:
        problem = zones_problem(len(info.data.get("corners", ())), [len(zone) for zone in value])
        if problem:
            raise ValueError(problem)
        return value


class SetFence(_Fence):
    """Store this fence: the next Arm uploads it and puts it in force. On the ground only."""

    type: Literal["Set Fence"] = "Set Fence"


class ClearFence(Command):
    """Delete the drawn fence: the configured file or circle is valid again. On the ground only."""

    type: Literal["Clear Fence"] = "Clear Fence"


class NewSurvey(Command):
    """Begin another survey with an empty map. The earlier one stays stored. On the ground only."""

    type: Literal["New Survey"] = "New Survey"


class CheckFence(_Fence):
    """Check this fence (answered by FenceCheck); changes nothing and needs no control."""

    type: Literal["Check Fence"] = "Check Fence"


class OperatorHeartbeat(Command):
    """The operator's sign of life."""

    type: Literal["Heartbeat"] = "Heartbeat"
    hidden: bool = False
    """The page is hidden, as in a pocket or behind another window: nobody looks at it. A program leaves it out."""


class MapResync(Command):
    """Send this client the whole map again."""

    type: Literal["Map Resync"] = "Map Resync"


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
    | NewSurvey
    | CheckFence
    | SetOutline
    | ClearOutline
    | SurveyAgain
    | FlyPlan
    | OperatorHeartbeat
    | OperatorName
    | Control
    | MapResync,
    Field(discriminator="type"),
]

_COMMANDS: TypeAdapter[Any] = TypeAdapter(AnyCommand)


class BadMessageError(ValueError):
    """A message that is not valid; the text names the field and the remedy."""

    def __init__(self, reason: str, message_id: str | int | None = None) -> None:
        super().__init__(reason)
        self.message_id = message_id


def parse_command(text: str) -> Command:
    """Return the command in a JSON text.

    Raises:
        BadMessageError: The text is not a command; the error names the field and the remedy.
    """
    size = len(text.encode("utf-8", "replace"))
    if size > MAX_MESSAGE_BYTES:
        raise BadMessageError(f"message of {size} bytes is too large: send at most {MAX_MESSAGE_BYTES}")
    try:
        command = _COMMANDS.validate_json(text, by_alias=True, by_name=False)
    except ValidationError as error:
        raise BadMessageError(_explain(error), _message_id(text)) from None
    assert isinstance(command, Command)  # noqa: S101 - narrows the union for the type checker
    return command


def _explain(error: ValidationError) -> str:
    """Return the first problem as "field: what is wrong"."""
    problem = error.errors(include_url=False)[0]
    kind = problem["type"]
    if kind == "json_invalid":
        return f"not JSON: {problem['ctx']['error']}; send one JSON object with a Type"
    if kind == "union_tag_not_found":
        return 'Type: missing; send one JSON object such as {"Type": "Hold"}'
    if kind == "union_tag_invalid":
        return f"Type: {_shown_type(problem['input'])} is no command; send a Type of /api/schema.json, such as Hold"
    location = [str(part)[:LONGEST_NAME] for part in problem["loc"][1:]] or ["message"]
    if kind == "missing":
        return f"{'.'.join(location)}: missing; send it with a {problem['loc'][0]}"
    if kind == "extra_forbidden":
        return f"{'.'.join(location)}: is no key of a {problem['loc'][0]}; leave it out"
    if location[0] == "Id":
        return "Id: is neither a text of 64 characters at most nor a whole number; send one of them, or leave it out"
    return f"{'.'.join(location)}: {reason_of(kind, problem.get('ctx', {}))}"


def _shown_type(message: Any) -> str:
    found = message.get("Type") if isinstance(message, dict) else None
    return repr(found)[:LONGEST_NAME]


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


class Ack(Spoken):
    """Answer to one command, to the client that sent it."""

    type: Literal["Ack"] = "Ack"
    id: str | int | None
    accepted: bool
    reason: Words = ""


class KillToken(Outgoing):
    """One-use token for Kill, valid for ``Valid For`` seconds."""

    type: Literal["Kill Token"] = "Kill Token"
    id: str | int | None
    token: str
    valid_for: Finite


class Welcome(Outgoing):
    """First message to a client: its session, the server, and the values that stay during the connection."""

    type: Literal["Welcome"] = "Welcome"
    session: str
    role: Literal["viewer", "operator"]
    login: bool
    """True when there is a login that can be ended (POST /logout)."""
    version: str
    simulation: bool
    cell_size: Finite
    """Side of a cell of the map, metres."""
    tile_cells: int
    """Cells along a side of a tile."""
    operator_timeout: Finite
    """Seconds without a sign of life until the operator counts as lost."""
    operator_hold: Finite
    """Seconds that the drone then holds before it returns home."""
    speed: Finite
    """Simulated seconds a second; 1 for a real drone."""
    camera_fov: Finite
    """Horizontal angle of view of the camera, degrees."""
    travel_speed: Finite
    """Speed over ground at which the drone is led from place to place, m/s."""
    desk: bool
    """True where no drone is: lots and plans alone, and every command to a drone is refused."""


class RouteAnswer(Spoken):
    """Answer to Route Request: points from the drone to the place and length in metres, or the reason for no route."""

    type: Literal["Route"] = "Route"
    id: str | int | None
    points: list[Point]
    length: Finite | None
    refused: Words | None
    """Reason why an Autonomous Move there would be refused; null when it would be accepted."""


class FenceCheck(Spoken):
    """Result of checking a fence."""

    type: Literal["Fence Check"] = "Fence Check"
    id: str | int | None
    problem: Words
    """Reason why it cannot be stored; empty when it can."""
    notes: list[Words]
    """Objections to a flight in it from the drone's present place."""
    inner: list[FenceCorner]
    """Our own limit; empty when there is none."""
    inner_zones: list[list[FenceCorner]]
    """Our own limit around the zones."""
    north_south: Finite | None
    east_west: Finite | None
    """Extent, metres."""
    area: Finite | None
    """Square metres inside the autopilot's limit."""


Answer = Ack | FenceCheck | KillToken | RouteAnswer
"""Answers to the client that sent a command."""


def schema() -> dict[str, Any]:
    """Return the JSON schema of every message, as served at /api/schema.json."""
    models: list[type[BaseModel]] = [Heartbeat, Ack, FenceCheck, KillToken, RouteAnswer, Welcome]
    return {
        "toDrone": _COMMANDS.json_schema(by_alias=True),
        "fromDrone": {model.__name__: model.model_json_schema(by_alias=True, mode="serialization") for model in models},
    }
