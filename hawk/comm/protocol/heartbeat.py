"""Status and heartbeat of the drone, and updates of its map.

The operations manager publishes one `DroneStatus`. Its parts make the heartbeat's shared part, encoded once for all
clients; the web server adds each client's own part (`ClientHeartbeat`): control, and the changes of map, log and trail
that this client has not received yet.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Annotated, Literal, Protocol, Self

from pydantic import Field, WithJsonSchema

from hawk.comm.protocol.base import Command, Finite, Known, Model, Outgoing, Spoken, Words
from hawk.model.known_lot import FlownSection, PlanOffer
from hawk.model.operation import HealthStatus, StateName, UserError
from hawk.model.plans import LeftOut
from hawk.model.poses import MapPoint


class TileUpdate(Outgoing):
    """A changed tile of the map. Its north-west corner lies -Row tiles north and Column tiles east of the datum."""

    row: int
    """Grows southwards."""
    column: int
    """Grows eastwards."""
    version: int
    data: str
    """Base64 of zlib of Tile Cells² bytes, one a cell, row by row from the north-west corner: 0 unknown, 1 not lot, 2
    lot, 3 free stall, 4 taken stall."""


class StallUpdate(Outgoing):
    """A changed stall. ``Removed``: it is gone. Angle in radians clockwise from north of the long side."""

    id: int
    version: int
    removed: bool = False
    north: Finite | None = None
    east: Finite | None = None
    angle: Finite | None = None
    width: Finite | None = None
    length: Finite | None = None
    state: Literal["free", "taken", "unknown", "suggested"] | None = None
    taken: Finite | None = None
    """Probability that it is taken."""
    seen: int | None = None
    """Frames that showed it; passes for a suggested one."""
    last_seen: Finite | None = None
    score: Finite | None = None
    label: str | None = None
    """Name in the plan of a known lot; null for another stall."""


class MosaicVersion(Outgoing):
    """A changed mosaic tile; its picture is at /api/mosaic/{Row}/{Column}.jpg?v={Version}."""

    row: int
    column: int
    version: int


class MapUpdate(Outgoing):
    """The "Occupancy Map" of a heartbeat: map changes for this client, at most 64 kB, nearest first."""

    map_id: str
    tiles: list[TileUpdate]
    stalls: list[StallUpdate]
    mosaic: list[MosaicVersion]
    backlog: int
    """Tiles and stalls still to come in later heartbeats."""


ClientId = str
"""One connected session."""

KillState = Literal["none", "sending", "confirmed", "not confirmed"]


# -- items of the parts -----------------------------------------------------------------------------------------------


class Point(Outgoing):
    """A place in the map frame, metres."""

    north: Finite
    east: Finite

    @classmethod
    def of(cls, place: MapPoint) -> Point:
        """Return the message's form of a place."""
        return cls(north=place.north, east=place.east)


class HealthItem(Outgoing):
    """Health of one part. Name: link, position, ground, camera, vision, mapper, planner, recording, requests, tasks,
    loop, home, remote control, remote id, or rangefinder where there is one.
    """

    name: str
    healthy: bool
    reason: Words


class CheckItem(Outgoing):
    """One preflight check: its value, and for a failed one the consequence and the remedy."""

    name: Words
    passed: bool
    value: Words
    consequence: Words = ""
    remedy: Words = ""
    remedy_command: Literal["Set Failsafes", "Clear Kill", "Set Fence"] | None = None


class CommandOption(Outgoing):
    """True when a command would be accepted now; otherwise the reason why not."""

    command: str
    possible: bool
    reason: Words = ""


class LogEntry(Spoken):
    """A line of the message list. Level: info, ok, warning or error. Details: the autopilot's own words."""

    number: int
    time: str
    """UTC, ISO 8601."""
    level: Literal["info", "ok", "warning", "error"]
    text: Words
    details: Words = ""


class FenceCorner(Model):
    """A corner of a fence, WGS-84 degrees: a fence outlives the map in which it was drawn."""

    latitude: Annotated[float, Field(allow_inf_nan=False, ge=-90.0, le=90.0)]
    longitude: Annotated[float, Field(allow_inf_nan=False, ge=-180.0, le=180.0)]


class FenceSetup(Spoken):
    """The fence that the next Arm puts in force."""

    source: Literal["drawn", "file", "circle"]
    """Drawn or imported by an operator; the configured file; the configured circle around the arm place."""
    corners: list[FenceCorner]
    """The autopilot's limit; empty for a circle."""
    zones: list[list[FenceCorner]] = Field(default_factory=list)
    """Exclusion zones as drawn, which the autopilot keeps."""
    inner: list[FenceCorner]
    """Our own limit; empty for a circle."""
    inner_zones: list[list[FenceCorner]] = Field(default_factory=list)
    """Our own limit around the zones."""
    radius: Finite | None
    """Radius of a circle, metres."""
    ceiling: Finite
    """The autopilot's ceiling, metres above the arm place."""
    margin: Finite
    """Distance of our own limit inside the autopilot's, metres."""
    ceiling_margin: Finite
    highest_ceiling: Finite
    """Greatest ceiling of any fence, metres."""
    problem: Words
    """Reason why the stored fence cannot be used (no Arm until it is drawn again or deleted); else empty."""


class OutlineSetup(Spoken):
    """The area that Explore is to survey."""

    source: Literal["none", "set", "file"]
    """None: the lot is found by looking; set by an operator; the configured file."""
    polygons: list[list[FenceCorner]]
    holes: list[list[FenceCorner]]
    """Parts of the polygons that do not belong to it."""
    area: Finite
    """Of the whole, also outside the fence, square metres."""
    again: tuple[str, ...] = ()
    """Ids of the known lots that are surveyed again, whose ground it is; empty for any other area."""


class SectionUpdate(Outgoing):
    """A changed section of the known lot that is flown over, with the vehicles counted in it so far."""

    id: str
    name: str
    outline: list[Point]
    capacity: int | None
    """Places; null where nobody says how many."""
    parked: int | None = None
    """Vehicles; null, as the next five, while next to nothing of the section was seen."""
    least: int | None = None
    most: int | None = None
    """Least and greatest number, which hold the true one in nine sections of ten."""
    room: int | None = None
    """Vehicles that fit into the gaps; null also where too much is hidden, or nobody says how vehicles stand."""
    seen_share: Finite | None = None
    """Share of its ground that was seen, 0 to 1."""
    hidden_share: Finite | None = None
    """Share of its ground that was seen without a known state, 0 to 1."""

    @classmethod
    def of(cls, section: FlownSection) -> SectionUpdate:
        """Return the message's form."""
        outline = [Point(north=north, east=east) for north, east in section.outline]
        counted = {} if section.count is None else asdict(section.count)
        return cls(id=section.id, name=section.name, outline=outline, capacity=section.capacity, **counted)


class SectionsUpdate(Outgoing):
    """Changes of the sections for one client; the rest comes with later heartbeats."""

    changed: list[SectionUpdate]
    removed: list[str]
    """Ids of sections that are no more."""


# -- parts of the status, the same for every client -------------------------------------------------------------------


class StatusStamp(Outgoing):
    """Number and time of a status."""

    sequence: int = 0
    """Rises by one with each status: one status is one heartbeat."""
    time: Finite = 0.0
    """Seconds of the daemon's clock."""
    utc: str = ""
    """ISO 8601."""


class OperationStatus(Outgoing):
    """State of the operations manager, and the commands that it would accept."""

    state: Annotated[StateName, WithJsonSchema({"type": "string"})] = StateName.IDLE
    """Operation state; `states.md` lists them."""
    detail: Words = ""
    """One sentence: the present action of the state, or the reason why it was entered."""
    asked_by: str | None = None
    """Name of the one who asked for Hold, Return To Launch, Land or Arm; null when the state began otherwise."""
    user_error: Annotated[UserError, WithJsonSchema({"type": "integer"})] = UserError.NONE
    """0: none; 1: the desired place is out of bounds; 2: no lot is detected."""
    user_error_text: Words = ""
    options: tuple[CommandOption, ...] = ()
    checks: tuple[CheckItem, ...] = ()
    """Preflight checks; empty in the air."""
    killed: bool = False
    """Arm is locked: the motors were cut, or went off in the air."""
    fallen: bool = False
    """The motors went off in the air; nobody cut them. The check "Motors" has place and time."""
    kill_state: KillState = "none"
    return_in: Known = None
    """CommunicationLost: seconds until the return home."""


class VehicleStatus(Outgoing):
    """Autopilot, link and battery. Ages in seconds."""

    ardupilot_state: str | None = None
    """ArduPilot's name of its mode."""
    armed: bool | None = None
    connected: bool = False
    landed: str = "UNDEFINED"
    """Name of the `LandedState` that is believed; UNDEFINED while it is old or contradicted."""
    link_age: Known = None
    battery_percentage: Known = None
    """0 to 100."""
    battery_age: Known = None
    voltage: Known = None
    battery_time_left: Known = None
    """Seconds until the drone must return, at the mean power of this flight."""
    time_home: Known = None
    """Seconds until it has landed at home when it returns now; null on the ground."""
    battery_needed_home: Known = None
    """Charge that the flight home needs, the reserve included, percent; on the ground as from the planned survey."""
    battery_needed_survey: Known = None
    """Charge that the rest of the survey needs, percent."""
    battery_left: Known = None
    """Charge that is left after both, percent; negative where it does not suffice."""
    survey_basis: Literal["planner", "map", "outline", "fence"] | None = None
    """Source of the need: the planner's distance, an earlier survey's map, the outline's area, the fence's area (an
    upper bound)."""
    survey_share: Known = None
    """Share (0..1) of the rest of the survey that the battery allows."""
    survey_batteries: int | None = None
    """Batteries for the rest of the survey, the present one included; null while not known."""
    survey_time_left: Known = None
    """Seconds of the rest of the survey, without take-off and the flight home, as far as `survey_basis` knows it."""
    satellites: int | None = None


class PoseStatus(Outgoing):
    """Pose and velocity of the drone: metres, metres a second, degrees (WGS-84), radians (attitude)."""

    relative_altitude: Known = None
    latitude: Known = None
    longitude: Known = None
    local_position_x: Known = None
    local_position_y: Known = None
    north: Known = None
    """Map frame."""
    east: Known = None
    yaw: Known = None
    """Clockwise from north."""
    roll: Known = None
    pitch: Known = None
    speed: Known = None
    """Over ground."""
    climb: Known = None
    pose_age: Known = None
    height_above_ground: Known = None
    """Metres above the ground below; null without a rangefinder that is believed."""
    wind_speed: Known = None
    """Estimated from how the drone leans; null on the ground and in the first seconds of a flight."""
    wind_from: Known = None
    """Direction that the wind comes from, radians clockwise from north."""

    @property
    def place(self) -> MapPoint | None:
        """Place in the map frame."""
        return None if self.north is None or self.east is None else MapPoint(self.north, self.east)


class RoundLotStatus(Outgoing):
    """A known lot that is surveyed again."""

    lot: str
    """Its id."""
    name: str
    seen: Finite = 0.0
    """Share (0 to 1) of its stalls that were looked at."""
    is_over: bool = False
    """True when it is stored as a survey."""


class PlanOfferStatus(Outgoing):
    """The plan of the lot that is flown over, as somebody changed it since the motors are on; Fly Plan takes it."""

    plan: str
    """Id of the offer."""
    lot: str
    """Name of the lot."""
    by: str | None = None
    """Name that the change is signed with, as its sender gave it; null where it has none."""
    stalls: int
    before: int
    """Stalls of the plan that is flown."""

    @classmethod
    def of(cls, offer: PlanOffer) -> Self:
        """Return the status of an offer."""
        return cls(plan=offer.id, lot=offer.lot, by=offer.by or None, stalls=offer.stalls, before=offer.before)


class SiteStatus(Outgoing):
    """Home, map origin and limits of the flight. Metres; heights above the arm place."""

    home: Point | None = None
    datum: tuple[Finite, Finite] | None = None
    """Latitude and longitude of the map's origin."""
    fence: tuple[Point, ...] = ()
    """Corners of our own limit, which lies inside the autopilot's."""
    fence_limit: tuple[Point, ...] = ()
    """Corners of the autopilot's limit."""
    fence_zones: tuple[tuple[Point, ...], ...] = ()
    """Corners of our own limit around each exclusion zone."""
    fence_zone_limits: tuple[tuple[Point, ...], ...] = ()
    """Corners of each exclusion zone as drawn, the autopilot's limit."""
    ceiling: Known = None
    heights: tuple[Finite, Finite, Finite] = (15.0, 35.0, 60.0)
    """Min, Des, Max."""
    outline_area: Known = None
    """Square metres of the outline inside the fence; null without one."""
    outline_outside: Known = None
    """Square metres of the outline that the fence leaves out; null without one."""
    again_distance: Known = None
    """Length of the planned flight over the lots that are surveyed again, metres; null until it is planned."""
    again_lots: tuple[RoundLotStatus, ...] = ()
    """The lots that are surveyed again."""
    plan_offer: PlanOfferStatus | None = None
    """The changed plan that waits for an answer; null while the flight has the newest one."""


class TravelStatus(Outgoing):
    """Target, route, time and distance of the flight. Map frame, metres, seconds."""

    target: Point | None = None
    route: tuple[Point, ...] = ()
    """The rest of the route while it explores, moves autonomously, or returns inside a bent fence, in order; empty when
    there is none."""
    flight_time: Known = None
    distance_flown: Known = None


class LeftOutStatus(Outgoing):
    """Ground that an exploration did not look at, and why. Square metres."""

    outside: Finite
    """Lot found outside the fence."""
    hidden: Finite
    """Lot found inside the fence that no picture from inside it shows."""
    given_up: Finite
    """Ground that was flown to and showed nothing new."""
    beside: Finite
    """Other ground beside the lot, inside the fence, where it may go on."""

    @classmethod
    def of(cls, left: LeftOut) -> LeftOutStatus:
        """Return the message's form."""
        return cls(outside=left.outside_m2, hidden=left.hidden_m2, given_up=left.given_up_m2, beside=left.beside_m2)


class PerceptionStatus(Outgoing):
    """Results of vision, mapper and planner."""

    vision_rate: Known = None
    """Frames a second."""
    camera_age: Known = None
    """Seconds."""
    footprint: tuple[Point, ...] = ()
    """Corners of the camera's picture on the ground."""
    park_lot_detected: bool | None = None
    lot_area: Known = None
    """Square metres."""
    free: int = 0
    taken: int = 0
    unknown: int = 0
    suggested: int = 0
    """Places without marks on which a car stood in several passes. The other counts leave them out."""
    free_range: tuple[int, int] | None = None
    """Least and greatest number of free stalls of the lot found, or of the outline, which hold the true one in nine
    surveys of ten; null until it is explored and seen whole: nothing is said of ground that was not seen."""
    explored: Known = None
    """Share of the lot found so far, 0 to 1; it falls when more lot comes in sight."""
    explore_done: bool = False
    """True when the lot found, or the outline, is explored; false again when more lot is found."""
    outline_unseen: Known = None
    """Square metres of the outline that no picture could reach, once Explore is done; null before, and without one."""
    left_out: LeftOutStatus | None = None
    """Ground that was not looked at, once Explore is done; null before, and with an outline."""
    remaining: Known = None
    """Metres that the planner means to fly over the lot found so far: how much more is found is not known."""


class PartsStatus(Outgoing):
    """Health of each part, and of all together."""

    health: tuple[HealthItem, ...] = ()
    health_status: Annotated[HealthStatus, WithJsonSchema({"type": "integer"})] = HealthStatus.HEALTHY
    """0: healthy; 1: not."""


class SharedHeartbeat(
    PartsStatus,
    PerceptionStatus,
    TravelStatus,
    SiteStatus,
    PoseStatus,
    VehicleStatus,
    OperationStatus,
    StatusStamp,
    Spoken,
):
    """The part of a heartbeat that is the same for every client."""

    type: Literal["Heartbeat"] = "Heartbeat"


@dataclass(frozen=True)
class DroneStatus:
    """One status of the drone. A value that is not known is None; every number is finite."""

    stamp: StatusStamp = field(default_factory=StatusStamp)
    operation: OperationStatus = field(default_factory=OperationStatus)
    vehicle: VehicleStatus = field(default_factory=VehicleStatus)
    pose: PoseStatus = field(default_factory=PoseStatus)
    site: SiteStatus = field(default_factory=SiteStatus)
    travel: TravelStatus = field(default_factory=TravelStatus)
    perception: PerceptionStatus = field(default_factory=PerceptionStatus)
    parts: PartsStatus = field(default_factory=PartsStatus)
    fence_setup: FenceSetup | None = None
    """The same object until it changes: a client receives each once."""
    outline_setup: OutlineSetup | None = None
    """As for the fence."""
    log: tuple[LogEntry, ...] = ()
    """The last entries (bounded), rising by `LogEntry.number`: a client receives those above its last number."""
    trail: tuple[MapPoint, ...] = ()
    """Path flown: grows at the end only, until ``trail_id`` changes."""
    trail_id: int = 0
    """Changes when the trail starts again."""

    @cached_property
    def shared_json(self) -> str:
        """The shared part of the heartbeat as JSON, encoded once for all clients."""
        first = (self.stamp, self.operation, self.vehicle, self.pose)
        second = (self.site, self.travel, self.perception, self.parts)
        values = {name: value for part in first + second for name, value in part}
        return SharedHeartbeat.model_construct(**values).to_json()


# -- the part of one client -------------------------------------------------------------------------------------------


class ClientHeartbeat(Outgoing):
    """The part of a heartbeat that is one client's own: it holds what this client has not received yet."""

    occupancy_map: MapUpdate | None
    messages: list[LogEntry]
    trail: list[Point]
    trail_start: bool
    """True when the trail begins again with these points: forget earlier ones."""
    fence_setup: FenceSetup | None
    """The fence that the next Arm puts in force; null when it has not changed."""
    outline_setup: OutlineSetup | None
    """The area that Explore is to survey; null when it has not changed."""
    sections: SectionsUpdate | None
    """Sections of the known lot that is flown over; null when none has changed."""
    controller: str | None
    """Session that has control."""
    controller_lost: bool
    """True when that session shows no life: anyone may take control, return home, land and cut the motors."""
    in_control: bool
    control_taken_by: str | None
    """Session that took control from this client's, which was lost or did not answer; null when it has it no more."""
    own_name: str
    """Name of this client's session."""
    control_asked_by: str | None
    """Session that asks the one in control for it; null when nobody asks."""
    control_free_in: Known
    """Seconds until the asking session may take control, unless the question is answered; null when nobody asks."""
    control_kept: bool
    """True when this client's session asked, and the one in control keeps it."""

    def join(self, shared_json: str) -> str:
        """Return the whole heartbeat as JSON, given the part that all clients share."""
        return f"{shared_json[:-1]},{self.to_json()[1:]}"


class Heartbeat(SharedHeartbeat, ClientHeartbeat):
    """Heartbeat of the drone at 5 Hz: the specification's keys (18.4.5) and ours."""


# -- between operations manager and web server - ---------------------------------------------------------------------


class CommandSocket(Protocol):
    """The server role of the message socket, as the operations manager uses it."""

    def receive(self) -> list[tuple[ClientId, Command]]:
        """Take all commands that wait, oldest first."""

    def reply(self, client: ClientId, message: Outgoing) -> None:
        """Answer one client; a client that has gone is no error. Never blocks."""


CommandHandler = Callable[[ClientId, Command], Outgoing]
"""Acts at once on a command that passes every queue (see `hawk.comm.protocol.command_table.Urgency`), and answers."""


LEAST_CORNERS = 3
MOST_CORNERS = 69
"""Corners of a fence without zones that ArduCopter stores on boards with 16 kB for parameters."""

Corners = Annotated[list[FenceCorner], Field(min_length=LEAST_CORNERS, max_length=MOST_CORNERS)]
"""Corners in order, not closed."""
