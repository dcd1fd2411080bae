"""The boundary to the autopilot: its topics, its commands, and a fence as it holds it.

`hawk.comm.autopilot.autopilot.MavsdkAutopilot` is the real one; unit tests put a fake here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Any, Protocol

from hawk.comm.autopilot.remote_control import RemoteControl
from hawk.comm.autopilot.remote_id import RemoteIdReport
from hawk.comm.autopilot.terrain import Terrain
from hawk.comm.topic import Topic
from hawk.model.frames import place_at
from hawk.model.plans import Fence
from hawk.model.poses import ArmPlace, GlobalPose, VehiclePose
from hawk.model.sentences import say
from hawk.model.vehicle import BatteryInfo, CopterMode, Diagnostics, ForeignWrite, GnssHeight, StatusText, VehicleState


class AutopilotError(Exception):
    """The autopilot refused or did not answer; the text is its own words where it gave any."""


OTHER_FENCE = "The fence that the autopilot holds is another one"


class OtherFenceError(AutopilotError):
    """The autopilot's fence was read, and is not ours."""

    def __init__(self, words: str) -> None:
        super().__init__(f"{OTHER_FENCE}: {words}")


@dataclass(frozen=True, slots=True)
class VehicleTopics:
    """The autopilot's topics; each holds its latest value."""

    state: Topic[VehicleState]
    pose: Topic[VehiclePose]
    battery: Topic[BatteryInfo]
    diagnostics: Topic[Diagnostics]
    status_text: Topic[StatusText]
    arm_place: Topic[ArmPlace]
    """Published when "armed" is first seen, and after a jump of EKF-local."""
    home: Topic[GlobalPose]
    """HOME_POSITION: the place that the autopilot's RTL flies to."""
    terrain: Topic[Terrain]
    """The ground below, published with every message of a rangefinder that looks down; nothing without one."""
    gnss_height: Topic[GnssHeight]
    """Altitude by GNSS, published while there is a fix."""
    frame_jump: Topic[float]
    """Metres by which EKF-local jumped against the world (EKF reset); the pose is anchored again already."""
    estimate_jump: Topic[float]
    """Metres by which the pose on the map jumped while the drone did not: EKF-local and globe leapt together."""

    remote_control: Topic[RemoteControl]
    """The pilot's remote control as the autopilot hears it."""
    remote_id: Topic[RemoteIdReport]
    """The Remote ID transmitter's word, and how far the ellipsoid lies from sea level."""
    foreign_write: Topic[ForeignWrite]
    """Another station changes something in the autopilot, where its message comes by this link."""

    @classmethod
    def create(cls, clock: Callable[[], float]) -> VehicleTopics:
        """Make a set of empty topics."""
        return cls(*(Topic[Any](item.name, clock) for item in fields(cls)))


class Autopilot(Protocol):
    """Commands to the autopilot. All raise AutopilotError; none is repeated."""

    topics: VehicleTopics

    async def arm(self) -> None:
        """Arm. Returns on the acknowledgement; "armed" shows in `VehicleTopics.state` up to 0.9 s later."""

    async def disarm(self) -> None:
        """Disarm; the autopilot refuses it in the air."""

    async def set_mode(self, mode: CopterMode) -> None:
        """Ask for a flight mode by DO_SET_MODE."""

    async def takeoff(self, relative_altitude: float) -> None:
        """Climb to ``relative_altitude``, metres above the arm place."""

    async def set_rtl_altitude(self, metres: float) -> float:
        """Set the return altitude, metres; return the value read back, metres."""

    async def get_parameter(self, name: str) -> float | int:
        """Read one parameter. An unknown name is an AutopilotError."""

    async def set_parameter(self, name: str, value: float) -> None:
        """Set one parameter with the autopilot's type, and read it back until it holds, for 3 s at most."""

    async def upload_fence(self, fence: Fence) -> None:
        """Upload the autopilot's polygon and zones, set ceiling, type, action and FENCE_ENABLE, and read them back."""

    async def compare_fence(self, fence: Fence) -> None:
        """Read polygon, zones, ceiling and FENCE_ENABLE. Raises OtherFenceError when they are not the fence's."""

    async def enable_fence(self) -> None:
        """Switch the fence on by MAV_CMD_DO_FENCE_ENABLE."""

    async def clear_rally_points(self) -> None:
        """Send MISSION_CLEAR_ALL for the rally points and do not wait: RALLY_TOTAL shows whether it was taken."""

    async def set_home(self, place: GlobalPose) -> None:
        """Send MAV_CMD_DO_SET_HOME and do not wait: `VehicleTopics.home` shows whether it was taken."""

    async def kill(self) -> None:
        """Cut the motors at once (MAV_CMD_DO_FLIGHTTERMINATION), on a thread of its own."""

    async def send_mode(self, mode: CopterMode) -> None:
        """Send a mode change at once, on a link that seems dead too, and wait for no answer."""

    def set_voice(self, speaks: bool) -> None:
        """Let our heartbeats go out, or hold them back, so that the autopilot's ground-station failsafe acts."""

    def send_target(self, north: float, east: float, height: float, yaw: float) -> None:
        """Send one SET_POSITION_TARGET_LOCAL_NED. Never blocks.

        Map frame, height above the arm place, metres; yaw in radians. Raises AutopilotError when a number is not
        finite, there is no arm place, or the link is down.
        """

    def set_datum(self, datum: GlobalPose | None) -> None:
        """Set the map frame's origin; None: the next arm place becomes it."""

    @property
    def datum(self) -> GlobalPose | None:
        """Origin of the map frame."""

    @property
    def parameters(self) -> Mapping[str, float | int]:
        """Parameters read so far."""


LEAST_CORNERS = 3
TOLERANCE_DEG = 1e-6
"""A decimetre; the mission protocol carries 1e-7 degrees."""
STORAGE_BYTES = 560
"""Memory for a fence of an ArduCopter board with 16 kB for parameters (ArduPilot, libraries/StorageManager)."""
_HEAD_BYTES, _RING_BYTES, _CORNER_BYTES = 5, 2, 8

Corners = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class FenceRings:
    """An inclusion polygon and exclusion polygons: (latitude, longitude) corners in degrees, in order, not closed."""

    inclusion: Corners
    exclusions: tuple[Corners, ...] = ()

    def __iter__(self) -> Iterator[Corners]:
        """Yield the inclusion polygon, then the exclusion polygons."""
        yield self.inclusion
        yield from self.exclusions


def rings_of(fence: Fence, origin: GlobalPose | None) -> FenceRings:
    """Return the autopilot's limits of a fence whose metres are about ``origin``.

    Raises:
        AutopilotError: The origin is not known, a ring is none, or the autopilot cannot store the fence.
    """
    if origin is None:
        raise AutopilotError(say("The drone does not know where it is yet: the fence cannot be placed"))
    rings = FenceRings(
        _corners(fence.autopilot_polygon, origin), tuple(_corners(zone, origin) for zone in fence.autopilot_zones)
    )
    if len(rings.inclusion) < LEAST_CORNERS:
        raise AutopilotError(say("A fence needs at least {least} corners", least=LEAST_CORNERS))
    if any(len(ring) < LEAST_CORNERS for ring in rings.exclusions):
        raise AutopilotError(say("An exclusion zone needs at least {least} corners", least=LEAST_CORNERS))
    needed = _HEAD_BYTES + sum(_RING_BYTES + _CORNER_BYTES * len(ring) for ring in rings)
    if needed > STORAGE_BYTES:  # ArduCopter ends its program over a fence that fills its memory to the last byte
        raise AutopilotError(
            say(
                "The fence needs {needed} bytes, the autopilot has {most}: leave out corners",
                needed=needed,
                most=STORAGE_BYTES,
            )
        )
    if not all(math.isfinite(value) for ring in rings for corner in ring for value in corner):
        raise AutopilotError(say("A corner of the fence is not finite: not sent"))
    return rings


def difference(ours: FenceRings, found: FenceRings) -> str:
    """Return how the fence that was read differs from ours, in words; empty when it does not.

    Rings and corners are compared in their order.
    """
    if len(ours.exclusions) != len(found.exclusions):
        return say(
            "it has {held} exclusion zones, ours has {ours}", held=len(found.exclusions), ours=len(ours.exclusions)
        )
    for number, (ring, read) in enumerate(zip(ours, found, strict=True)):
        if not _is_same(ring, read):
            zone = say("its zone {number} is another one", number=number)
            return zone if number else say("its polygon is another one")
    return ""


def _corners(ring: Corners, origin: GlobalPose) -> Corners:
    places = [place_at(north, east, origin) for north, east in ring]
    return tuple((place.latitude, place.longitude) for place in places)


def _is_same(ring: Corners, read: Corners) -> bool:
    return len(ring) == len(read) and all(
        math.isclose(ours, theirs, rel_tol=0.0, abs_tol=TOLERANCE_DEG)
        for corner, other in zip(ring, read, strict=True)
        for ours, theirs in zip(corner, other, strict=True)
    )
