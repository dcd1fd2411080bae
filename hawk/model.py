"""Values that every room shares: poses, enumerations, map and stall types.

Frames (all metres): *local* is NED about the place where the drone was armed; *map* is NED on a tangent plane at the
survey's WGS-84 datum. ``north`` and ``east`` always mean the map frame, ``x`` and ``y`` the local frame. Yaw and every
other angle on the ground is in radians clockwise from north. Times are seconds of the daemon's one clock.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum, StrEnum
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

TILE_CELLS = 256
"""Cells along one side of a map tile."""
CELL_M = 0.10
"""Side of a map cell, metres."""
TILE_M = TILE_CELLS * CELL_M
"""Side of a map tile, metres."""

Ring = tuple[tuple[float, float], ...]
"""Corners of a closed line in order, the first one not repeated: (north, east), or (latitude, longitude)."""


class UserError(IntEnum):
    """User Error of the specification, section 4."""

    NONE = 0
    DESIRED_LOCATION_OUT_OF_BOUNDS = 1
    NO_LOT_DETECTED = 2


class HealthStatus(IntEnum):
    """Health Status of the specification, section 4."""

    HEALTHY = 0
    UNHEALTHY = 1


@dataclass(frozen=True, slots=True)
class Health:
    """Health of one part, with the reason in words when it is unhealthy."""

    status: HealthStatus = HealthStatus.HEALTHY
    reason: str = ""

    @classmethod
    def bad(cls, reason: str) -> Health:
        """Return an unhealthy verdict with its reason."""
        return cls(HealthStatus.UNHEALTHY, reason)

    @property
    def is_healthy(self) -> bool:
        """True when the part works."""
        return self.status is HealthStatus.HEALTHY


class StateName(StrEnum):
    """Identity strings of the operation states, exactly as in the design."""

    IDLE = "Idle"
    CONFIGURE = "Configure"
    ARM = "Arm"
    TAKEOFF = "Takeoff"
    HOVER = "Hover"
    AUTONOMOUS_EXPLORE = "Autonomous Explore"
    AUTONOMOUS_MOVE = "Autonomous Move"
    COMPULSIVE_MOVE = "Compulsive Move"
    RETURN_TO_LAUNCH = "Return To Launch"
    LAND = "Land"
    COMMUNICATION_LOST = "CommunicationLost"
    MANUAL = "Manual"


GROUND_STATES = frozenset({StateName.IDLE, StateName.CONFIGURE, StateName.ARM})
"""States in which the drone is not in the air."""


class CopterMode(IntEnum):
    """ArduCopter's ``custom_mode`` numbers (ArduPilot, ArduCopter/mode.h)."""

    STABILIZE = 0
    ACRO = 1
    ALT_HOLD = 2
    AUTO = 3
    GUIDED = 4
    LOITER = 5
    RTL = 6
    CIRCLE = 7
    LAND = 9
    DRIFT = 11
    SPORT = 13
    FLIP = 14
    AUTOTUNE = 15
    POSHOLD = 16
    BRAKE = 17
    THROW = 18
    AVOID_ADSB = 19
    GUIDED_NOGPS = 20
    SMART_RTL = 21
    FLOWHOLD = 22
    FOLLOW = 23
    ZIGZAG = 24
    SYSTEMID = 25
    AUTOROTATE = 26
    AUTO_RTL = 27


def mode_name(custom_mode: int | None) -> str | None:
    """Return ArduPilot's own name of a mode ("GUIDED"); "MODE(n)" for one that is not known; None for None."""
    if custom_mode is None:
        return None
    try:
        return CopterMode(custom_mode).name
    except ValueError:
        return f"MODE({custom_mode})"


LANDED_TIMEOUT_S = 2.0
"""An older EXTENDED_SYS_STATE (5 Hz) says nothing about the ground, seconds."""


class LandedState(IntEnum):
    """MAV_LANDED_STATE."""

    UNDEFINED = 0
    ON_GROUND = 1
    IN_AIR = 2
    TAKING_OFF = 3
    LANDING = 4


@dataclass(frozen=True, slots=True)
class LocalPose:
    """Pose about the arm place: x north, y east, z down in metres; yaw in radians clockwise from north."""

    x: float
    y: float
    z: float
    yaw: float = 0.0


@dataclass(frozen=True, slots=True)
class GlobalPose:
    """WGS-84 degrees and metres above mean sea level."""

    latitude: float
    longitude: float
    altitude: float


@dataclass(frozen=True, slots=True)
class MapPoint:
    """A place in the map frame, metres north and east of the datum."""

    north: float
    east: float

    def distance(self, other: MapPoint) -> float:
        """Return the horizontal distance in metres."""
        return math.hypot(self.north - other.north, self.east - other.east)


@dataclass(frozen=True, slots=True)
class MapPose:
    """Drone pose in the map frame: ``height`` is metres above the arm place, attitude in radians (NED, FRD body)."""

    north: float
    east: float
    height: float
    roll: float
    pitch: float
    yaw: float

    @property
    def point(self) -> MapPoint:
        """The place on the ground below."""
        return MapPoint(self.north, self.east)

    def is_finite(self) -> bool:
        """Return True when every number is finite."""
        return all(math.isfinite(v) for v in (self.north, self.east, self.height, self.roll, self.pitch, self.yaw))


@dataclass(frozen=True, slots=True)
class ArmPlace:
    """Place where the drone was armed, in WGS-84 and in EKF-local.

    ``ekf_x``, ``ekf_y``, ``ekf_z`` is the arm place in EKF-local (NED metres); ``boot_id`` identifies a boot of
    the autopilot (the wall-clock second at which its ``time_boot_ms`` was zero).
    """

    latitude: float
    longitude: float
    altitude: float
    ekf_x: float
    ekf_y: float
    ekf_z: float
    boot_id: int


@dataclass(frozen=True, slots=True)
class FlightSoFar:
    """A flight in progress: seconds since take-off and metres flown (``way``), as of ``at`` (UTC seconds)."""

    seconds: float
    way: float
    at: float


@dataclass(frozen=True, slots=True)
class FlightDrain:
    """Drain that a flight measured: percent a second, over ``seconds`` in the air, until ``at`` (UTC seconds)."""

    drain: float
    seconds: float
    at: float


@dataclass(frozen=True, slots=True)
class SurveyLeft:
    """Rest of a survey when its last exploration ended.

    ``seen`` is the share (0..1) of ``lot_area`` (square metres) that was seen well; ``remaining_m`` the metres that the
    planner still meant to fly; ``done``: nothing was left to learn; ``flown_s`` the seconds that it explored so far.
    """

    seen: float
    lot_area: float
    remaining_m: float
    done: bool = False
    flown_s: float = 0.0


@dataclass(frozen=True, slots=True)
class HeightParameters:
    """Travel heights above the arm place, metres: 0 < minimum <= desired <= maximum <= ceiling."""

    minimum: float = 15.0
    desired: float = 35.0
    maximum: float = 60.0

    def bounded(self, height: float) -> float:
        """Return the height, metres, or the nearest one between minimum and maximum."""
        return min(max(height, self.minimum), self.maximum)


@dataclass(frozen=True, slots=True)
class Fence:
    """Limits of the flight, map frame. ``polygon`` is our own limit: it lies inside the autopilot's by the margin.

    ``autopilot_zones`` are the exclusion zones as they were drawn, ``zones`` our own limit: the same zones grown by the
    margin, so that they may cross each other and ``polygon``. Rings are (north, east) vertices in order, not closed.
    Heights are metres above the arm place.
    """

    polygon: tuple[tuple[float, float], ...]
    autopilot_polygon: tuple[tuple[float, float], ...]
    ceiling: float
    autopilot_ceiling: float
    zones: tuple[tuple[tuple[float, float], ...], ...] = ()
    autopilot_zones: tuple[tuple[tuple[float, float], ...], ...] = ()


@dataclass(frozen=True, slots=True)
class Outline:
    """Area that an operator asks to survey: what lies in a polygon and in no hole.

    Rings are WGS-84 corners (latitude, longitude) in degrees, in order, not closed. Without polygons there is no
    outline.
    """

    polygons: tuple[Ring, ...] = ()
    holes: tuple[Ring, ...] = ()


@dataclass(frozen=True, slots=True)
class AskedGround:
    """The part of an outline that lies inside the fence, map frame.

    ``pieces`` do not overlap; each is its outer ring, then its holes, rings as in `Fence`. ``area`` is theirs,
    ``outside`` that of the outline outside the fence, square metres.
    """

    pieces: tuple[tuple[Ring, ...], ...]
    area: float
    outside: float = 0.0


@dataclass(frozen=True, slots=True)
class CameraModel:
    """Pinhole camera with radial-tangential distortion (ROS ``plumb_bob``) and its mount.

    ``fx, fy, cx, cy`` in pixels of a ``width`` x ``height`` picture; ``distortion`` is k1, k2, p1, p2, k3. Mount angles
    (radians) turn the camera away from looking straight down with the picture's top towards the nose.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...] = ()
    mount_roll: float = 0.0
    mount_pitch: float = 0.0
    mount_yaw: float = 0.0


class Inbound(StrEnum):
    """Verdict on a place: inside the lot, outside it, or not seen yet."""

    INSIDE = "inside"
    OUTSIDE = "outside"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class DesiredPose:
    """The operator's place for the drone, numbered, so that a verdict belongs to one of them."""

    number: int
    north: float
    east: float


@dataclass(frozen=True, slots=True)
class Route:
    """A route over known lot, map frame: ``points`` from the drone's place to the requested one.

    ``turns`` has a number for each point: metres before and behind it within which its corner may be cut (0: the drone
    stops there). ``refused`` is the reason for no route; it is empty when there is one, and when none was requested.
    """

    points: tuple[MapPoint, ...] = ()
    turns: tuple[float, ...] = ()
    refused: str = ""

    @property
    def length_m(self) -> float:
        """Metres from the first point to the last."""
        return sum(a.distance(b) for a, b in pairwise(self.points))


@dataclass(frozen=True, slots=True)
class Verdict:
    """Path Plan App's answer on the desired pose of that number; ``route`` leads there when it lies inside the lot."""

    number: int
    inbound: Inbound
    route: Route = Route()


class StallState(StrEnum):
    """State of a stall. SUGGESTED: no stall is marked, but a car stood there in several passes; it counts as none."""

    FREE = "free"
    TAKEN = "taken"
    UNKNOWN = "unknown"
    SUGGESTED = "suggested"


@dataclass(frozen=True, slots=True)
class Stall:
    """A stall on the map: an oriented rectangle with a permanent id.

    ``angle`` is the direction of the long side in [0, pi); ``taken`` the probability of being taken; ``score`` the
    probability of being a stall at all; ``seen`` the number of frames that showed it, of passes for a suggested one;
    ``version`` rises when its shown content changes.
    """

    id: int
    north: float
    east: float
    angle: float
    width: float
    length: float
    taken: float
    state: StallState
    score: float
    seen: int
    last_seen: float
    version: int

    def corners(self) -> NDArray[np.float64]:
        """Return the four corners, (4, 2) of (north, east) metres: two ends of the near short side, then the far."""
        along = np.array([math.cos(self.angle), math.sin(self.angle)]) * self.length / 2
        across = np.array([-math.sin(self.angle), math.cos(self.angle)]) * self.width / 2
        centre = np.array([self.north, self.east])
        return np.array(
            [centre - along - across, centre - along + across, centre + along + across, centre + along - across]
        )


class Cell(IntEnum):
    """Class of a map cell."""

    UNKNOWN = 0
    NON_LOT = 1
    LOT = 2
    FREE = 3
    TAKEN = 4


TileKey = tuple[int, int]
"""(row, column) of a tile: it covers north in [-(row + 1), -row) * TILE_M and east in [column, column + 1) * TILE_M, so
that rows grow southwards and columns eastwards, as in a picture; cell (0, 0) of a tile is its north-west corner."""


@dataclass(frozen=True, slots=True)
class EncodedTile:
    """An encoded tile: ``version`` rises only when its shown content changes."""

    version: int
    data: bytes = field(repr=False)


@dataclass(frozen=True, slots=True)
class Counts:
    """Stalls by state. ``free_variance`` is the variance of the number of free ones (`hawk.stall_count`)."""

    free: int = 0
    taken: int = 0
    unknown: int = 0
    free_variance: float = 0.0
    suggested: int = 0

    @property
    def total(self) -> int:
        """All stalls, without the suggested ones."""
        return self.free + self.taken + self.unknown


@dataclass(frozen=True, slots=True)
class AnnotatedFrame:
    """An annotated picture for the operators; ``captured`` is seconds of the daemon's clock."""

    sequence: int
    captured: float
    jpeg: bytes = field(repr=False)


@dataclass(frozen=True, slots=True)
class OccupancyMap:
    """An immutable index of the map: nothing in it is copied when a cell changes.

    ``tiles`` hold TILE_CELLS x TILE_CELLS bytes of `Cell`, row-major from the north-west corner, zlib-compressed.
    ``mosaic`` holds JPEG pictures of the same tiles, TILE_CELLS pixels a side. ``stalls`` by id.
    """

    tiles: Mapping[TileKey, EncodedTile] = field(default_factory=dict)
    mosaic: Mapping[TileKey, EncodedTile] = field(default_factory=dict)
    stalls: Mapping[int, Stall] = field(default_factory=dict)
    counts: Counts = Counts()
    lot_area_m2: float = 0.0
    version: int = 0
    map_id: str = ""
    """Changes when the map starts again: a client drops its copy of another map."""


@dataclass(frozen=True, slots=True)
class ExploreStatus:
    """Progress of the exploration: ``seen`` is the share (0..1) of the known lot that has been seen well.

    ``lot_known`` is False while it still searches around something that looks like a lot. With an outline it is the
    lot: ``asked_m2`` is its area inside the fence, ``unseen_m2`` what was not looked at when it is done, square metres.
    """

    done: bool = False
    seen: float = 0.0
    remaining_m: float | None = None
    reason: str = ""
    lot_known: bool = True
    asked_m2: float | None = None
    unseen_m2: float | None = None

    @property
    def seen_share(self) -> float:
        """Share (0..1) of what is to be surveyed that was looked at: of the outline's whole area once it is done."""
        if not self.asked_m2 or self.unseen_m2 is None:
            return self.seen
        return max(1 - self.unseen_m2 / self.asked_m2, 0.0)


@dataclass(frozen=True, slots=True)
class PathPlan:
    """Next target in the map frame, with its yaw and height, and the route from there for display."""

    target: MapPoint | None = None
    height: float | None = None
    yaw: float | None = None
    route: tuple[MapPoint, ...] = ()
    explore: ExploreStatus = ExploreStatus()
    verdict: Verdict | None = None
    asked: Verdict | None = None
    """Verdict on a place for which only the route was requested."""
    speed: float | None = None
    """Greatest speed at which vision can read the ground, m/s; None: no limit but the travel speed."""


@dataclass(frozen=True, slots=True)
class VehicleState:
    """Autopilot state (mavros_msgs/State of the specification).

    ``armed`` and ``custom_mode`` came with the last HEARTBEAT, at ``time``; ``landed`` with the last
    EXTENDED_SYS_STATE, at ``landed_time``; a boot makes it UNDEFINED.
    """

    connected: bool = False
    armed: bool = False
    custom_mode: int | None = None
    landed: LandedState = LandedState.UNDEFINED
    time: float = -math.inf
    landed_time: float = -math.inf

    def landed_at(self, now: float) -> LandedState:
        """Return the landed state; UNDEFINED when it is older than LANDED_TIMEOUT_S."""
        return self.landed if now - self.landed_time <= LANDED_TIMEOUT_S else LandedState.UNDEFINED

    @property
    def mode(self) -> str | None:
        """ArduPilot's own name of the mode."""
        return mode_name(self.custom_mode)


@dataclass(frozen=True, slots=True)
class BatteryInfo:
    """Battery: percentage 0-100, volts, amperes; None where the autopilot does not know."""

    percentage: float | None = None
    voltage: float | None = None
    current: float | None = None
    time: float = -math.inf


@dataclass(frozen=True, slots=True)
class Diagnostics:
    """Summary of the autopilot's sensors, as it reports them."""

    all_ok: bool = False
    armable: bool = False
    global_position_ok: bool = False
    home_position_ok: bool = False
    gps_fix: int | None = None
    satellites: int | None = None
    horizontal_accuracy: float | None = None
    time: float = -math.inf
    estimator_fault: str = ""
    """Why the position estimator is not to be trusted; empty when it is. Then ``global_position_ok`` is False too."""
    fence_on: bool | None = None
    """The autopilot says that a fence is enabled, whatever enabled it; None while it was not heard."""


@dataclass(frozen=True, slots=True)
class VehiclePose:
    """One consistent pose of the vehicle. ``map`` and ``local`` are None before the first arm; velocity is NED m/s."""

    time: float
    global_: GlobalPose
    relative_altitude: float | None
    local: LocalPose | None
    map: MapPose | None
    velocity: tuple[float, float, float]
    roll: float
    pitch: float
    yaw: float


@dataclass(frozen=True, slots=True)
class StatusText:
    """A message of the autopilot in its own words. ``severity`` is MAV_SEVERITY, 0 (emergency) to 7 (debug)."""

    time: float
    severity: int
    text: str
