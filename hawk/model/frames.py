"""Positions of the autopilot: samples in its own frame, interpolated in time, and the frames of reference.

EKF-local is ArduPilot's own frame and stays inside this room. Local has its origin where the drone was armed, map at
the datum. All three are NED in metres; their axes are taken as parallel, which over a lot's kilometre is wrong by less
than a centimetre a metre of height and 0.01 degrees of meridian convergence.
"""

from __future__ import annotations

import bisect
import logging
import math
import operator
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Protocol, TypeVar

import pymap3d

from hawk.model.moment import Moment
from hawk.model.poses import ArmPlace, GlobalPose, LocalPose, MapPose
from hawk.model.vehicle import LandedState

_LOG = logging.getLogger(__name__)
S = TypeVar("S", bound="Sample")

REACH_S: Final = 0.3
"""A moment farther than this from every sample has no pose."""
JUMP_M: Final = 1.0
"""EKF-local that moves by more than this against the world was reset."""
_CONFIRM: Final = 3
_AGREE_M: Final = 0.5
_BOOT_MATCH_S: Final = 5
_RAN_BEFORE_S: Final = 20.0
"""An autopilot that was armed before this computer booted ran for longer than this by then: GNSS and EKF need it."""
_FRESH_S: Final = 1.0
_LANDED_WAIT_S: Final = 3.0
_PROVISIONAL_MOVE_M: Final = 10.0
_DISARMED_S: Final = 0.5
"""A shorter "disarmed" may be one datagram that came late."""
_STILL_M_S: Final = 1.0
_STANDS_BELOW_M: Final = 3.0
_VECTOR: Final = operator.attrgetter("x", "y", "z", "vx", "vy", "vz")


class Sample(Protocol):
    """Anything with a moment of our clock, seconds."""

    @property
    def time(self) -> float:  # noqa: D102
        ...


@dataclass(frozen=True, slots=True)
class EkfPosition:
    """Position and velocity in EKF-local (NED: x north, y east; metres, m/s) at a moment of our clock."""

    time: float
    x: float
    y: float
    z: float
    vx: float
    vy: float
    vz: float


@dataclass(frozen=True, slots=True)
class Attitude:
    """Roll, pitch, yaw (radians, NED to FRD) at a moment of our clock."""

    time: float
    roll: float
    pitch: float
    yaw: float


def wrap_angle(angle: float) -> float:
    """Return the same direction in [-pi, pi)."""
    return (angle + math.pi) % (2 * math.pi) - math.pi


class PoseBuffer:
    """Samples of the last ``keep_s`` seconds, interpolated. Without a near sample there is no answer."""

    def __init__(self, keep_s: float = 5.0) -> None:
        self._keep = keep_s
        self._positions: list[EkfPosition] = []
        self._attitudes: list[Attitude] = []

    def add_position(self, sample: EkfPosition) -> None:
        """Take a position; one that is not newer than the last is dropped (a repeated or overtaken datagram)."""
        if not self._positions or sample.time > self._positions[-1].time:
            self._positions.append(sample)
            forget(self._positions, sample.time - self._keep)

    def add_attitude(self, sample: Attitude) -> None:
        """Take an attitude; one that is not newer than the last is dropped."""
        if not self._attitudes or sample.time > self._attitudes[-1].time:
            self._attitudes.append(sample)
            forget(self._attitudes, sample.time - self._keep)

    def clear(self) -> None:
        """Forget all samples: their frame or their clock has changed."""
        self._positions.clear()
        self._attitudes.clear()

    @property
    def latest_position(self) -> EkfPosition | None:
        """The newest position."""
        return self._positions[-1] if self._positions else None

    def position_at(self, time: float) -> EkfPosition | None:
        """Return the position at that moment: linear between samples, by its velocity up to `REACH_S` beyond one."""
        before, after = neighbours(self._positions, time)
        if before is not None and after is not None and after.time - before.time <= 2 * REACH_S:
            share = (time - before.time) / (after.time - before.time)
            pairs = zip(_VECTOR(before), _VECTOR(after), strict=True)
            return EkfPosition(time, *(a + (b - a) * share for a, b in pairs))
        near = nearest(before, after, time)
        if near is None:
            return None
        dt = time - near.time
        return EkfPosition(
            time, near.x + near.vx * dt, near.y + near.vy * dt, near.z + near.vz * dt, near.vx, near.vy, near.vz
        )

    def attitude_at(self, time: float) -> Attitude | None:
        """Return the attitude at that moment: every angle along the shorter arc, held up to `REACH_S` beyond one."""
        before, after = neighbours(self._attitudes, time)
        if before is not None and after is not None and after.time - before.time <= 2 * REACH_S:
            share = (time - before.time) / (after.time - before.time)
            return Attitude(
                time,
                _between(before.roll, after.roll, share),
                _between(before.pitch, after.pitch, share),
                _between(before.yaw, after.yaw, share),
            )
        near = nearest(before, after, time)
        return None if near is None else Attitude(time, near.roll, near.pitch, near.yaw)


def offset_ned(place: GlobalPose, origin: GlobalPose) -> tuple[float, float, float]:
    """Return the offset of ``place`` from ``origin``: metres north, east, down on the tangent plane (WGS-84).

    Heights are treated as ellipsoidal: only their difference matters.
    """
    north, east, down = pymap3d.geodetic2ned(
        place.latitude, place.longitude, place.altitude, origin.latitude, origin.longitude, origin.altitude
    )
    return float(north), float(east), float(down)


def place_at(north: float, east: float, origin: GlobalPose, up: float = 0.0) -> GlobalPose:
    """Return the place ``north``, ``east`` and ``up`` metres from ``origin``."""
    latitude, longitude, altitude = pymap3d.ned2geodetic(
        north, east, -up, origin.latitude, origin.longitude, origin.altitude
    )
    return GlobalPose(float(latitude), float(longitude), float(altitude))


@dataclass(frozen=True, slots=True)
class Frames:
    """The three frames: the arm place ties EKF-local to local, the datum ties local to map."""

    arm: ArmPlace
    datum: GlobalPose
    arm_north: float
    arm_east: float

    @classmethod
    def create(cls, arm: ArmPlace, datum: GlobalPose) -> Frames:
        """Tie the frames together; the arm place's height above the datum does not matter to the map."""
        north, east, _ = offset_ned(GlobalPose(arm.latitude, arm.longitude, datum.altitude), datum)
        return cls(arm, datum, north, east)

    @property
    def home(self) -> GlobalPose:
        """The arm place (WGS-84)."""
        return GlobalPose(self.arm.latitude, self.arm.longitude, self.arm.altitude)

    def local(self, position: EkfPosition, yaw: float) -> LocalPose:
        """Return a position about the arm place."""
        return LocalPose(position.x - self.arm.ekf_x, position.y - self.arm.ekf_y, position.z - self.arm.ekf_z, yaw)

    def map(self, position: EkfPosition, attitude: Attitude) -> MapPose:
        """Return a pose on the map, its height above the arm place."""
        local = self.local(position, attitude.yaw)
        return MapPose(
            self.arm_north + local.x,
            self.arm_east + local.y,
            -local.z,
            attitude.roll,
            attitude.pitch,
            attitude.yaw,
        )

    def world(self, position: EkfPosition) -> GlobalPose:
        """Return a position in WGS-84."""
        local = self.local(position, 0.0)
        return place_at(local.x, local.y, self.home, up=-local.z)

    def ekf(self, north: float, east: float, height: float) -> tuple[float, float, float]:
        """Return a place of the map in EKF-local (x, y, z)."""
        return (
            self.arm.ekf_x + north - self.arm_north,
            self.arm.ekf_y + east - self.arm_east,
            self.arm.ekf_z - height,
        )


def anchor(position: EkfPosition, here: GlobalPose, place: GlobalPose, boot: Moment) -> ArmPlace:
    """Return the arm place ``place``, tied to EKF-local by a position whose place on the globe is ``here``."""
    north, east, down = offset_ned(here, place)
    return ArmPlace(
        place.latitude,
        place.longitude,
        place.altitude,
        position.x - north,
        position.y - east,
        position.z - down,
        boot,
    )


@dataclass(frozen=True, slots=True)
class FrameJump:
    """EKF-local moved by ``metres``; ``arm`` is the same place on the globe, tied to it again."""

    metres: float
    arm: ArmPlace
    shift: tuple[float, float, float]
    """The movement of EKF-local's coordinates: north, east, down, metres."""


class OffsetObserver:
    """Observes the offset of EKF-local to the globe. A jump is confirmed when three looks in a row agree on it."""

    def __init__(self) -> None:
        self._suspects: list[ArmPlace] = []
        self._agreed = _CONFIRM

    @property
    def sure(self) -> bool:
        """True when the last looks agreed with the anchor."""
        return self._agreed >= _CONFIRM and not self._suspects

    def doubt(self) -> None:
        """Positions moved faster than the drone can: be unsure until three looks agree again."""
        self._agreed = 0
        self._suspects.clear()

    def look(self, arm: ArmPlace, position: EkfPosition, here: GlobalPose) -> FrameJump | None:
        """Compare one position in EKF-local with the same moment's place on the globe."""
        place = GlobalPose(arm.latitude, arm.longitude, arm.altitude)
        found = anchor(position, here, place, arm.boot)
        if _ekf_distance(found, arm) <= JUMP_M:
            self._suspects.clear()
            self._agreed = min(self._agreed + 1, _CONFIRM)
            return None
        if self._suspects and _ekf_distance(found, self._suspects[-1]) > _AGREE_M:
            self._suspects.clear()
        self._suspects.append(found)
        if len(self._suspects) < _CONFIRM:
            return None
        moved = _mean(self._suspects)
        self._suspects.clear()
        self._agreed = _CONFIRM
        shift = (moved.ekf_x - arm.ekf_x, moved.ekf_y - arm.ekf_y, moved.ekf_z - arm.ekf_z)
        return FrameJump(math.hypot(*shift), moved, shift)


class MapTie:
    """Ties EKF-local to the map: keeps the datum, the arm place and the `Frames` made of them."""

    def __init__(self) -> None:
        self.frames: Frames | None = None
        """None before there is an arm place."""
        self.datum: GlobalPose | None = None
        """Origin of the map frame."""
        self.home: GlobalPose | None = None
        """Home as the autopilot reports it."""
        self.offset = OffsetObserver()
        self._provisional: GlobalPose | None = None
        self._restored: ArmPlace | None = None
        self._armed_at: float | None = None  # armed at this moment and not anchored yet
        self._was_armed_at_start = False
        self._is_armed = False
        self._disarmed: tuple[float, float] | None = None  # first and last of the latest "disarmed"
        self._was_disarmed = True  # before it was armed, beyond doubt

    def set_datum(self, datum: GlobalPose | None) -> None:
        """Set the map frame's origin; None: the next arm place becomes it."""
        self.datum = datum
        if datum is None:
            self.frames = None
        elif self.frames is not None:
            self.frames = Frames.create(self.frames.arm, datum)

    @property
    def fence_origin(self) -> GlobalPose | None:
        """The datum; before there is one the provisional origin: the drone's place, to within 10 m."""
        return self.datum or self._provisional

    def armed(self, time: float, *, at_start: bool) -> None:
        """Anchor from the first "armed" on. ``at_start``: it came with the first HEARTBEAT of this run."""
        if self._is_armed:
            return
        self._is_armed = True
        self._armed_at = time
        self._was_armed_at_start = at_start
        first, last = self._disarmed or (time, time)
        self._was_disarmed = last - first >= _DISARMED_S

    def disarmed(self, time: float) -> None:
        """Stop looking for the arm place."""
        self._disarmed = (time if self._is_armed or self._disarmed is None else self._disarmed[0], time)
        self._is_armed = False
        self._armed_at = None

    def rebooted(self) -> None:
        """Forget everything but the datum: EKF-local is another one."""
        self.offset = OffsetObserver()
        self.frames = self.home = self._armed_at = self._disarmed = None
        self._is_armed = False

    def keep(self, place: ArmPlace) -> None:
        """Keep the arm place of an earlier run until the autopilot's boot is known."""
        self._restored = place

    def restore(self, boot: Moment) -> ArmPlace | None:
        """Return the kept arm place, tied to the map, if it belongs to this boot and nothing newer is known.

        ``boot``: the moment of this computer at which the autopilot booted.
        """
        place, self._restored = self._restored, None
        if place is None or self.frames is not None:
            return None
        if not _is_same_boot(place.boot, boot):
            _LOG.info("The arm place of the earlier run is void: the autopilot has booted since")
            return None
        return self._tie(place)

    def move_provisional(self, here: GlobalPose, *, armed: bool) -> None:
        """Follow the drone with the provisional origin, in steps of 10 m and not while it is armed."""
        old = self._provisional
        if old is None or (not armed and math.hypot(*offset_ned(here, old)[:2]) > _PROVISIONAL_MOVE_M):
            self._provisional = here

    def anchor(
        self, position: EkfPosition, here: GlobalPose, landed: LandedState, boot: Moment, now: float
    ) -> ArmPlace | None:
        """Tie the frames after arming: to ``here`` if the drone stands, else to home as the autopilot reports it.

        ``position`` and ``here`` are the same moment's place in EKF-local and on the globe. ``landed`` is UNDEFINED
        when it is old. After a "disarmed" so short that it may have come late, the arm place moves only if the drone
        stands near its height. Return a new arm place.
        """
        armed_at = self._armed_at
        if armed_at is None:
            return None
        if self._was_armed_at_start and self.frames is not None:
            self._armed_at = None  # restored from the journal
            return None
        stands = landed is LandedState.ON_GROUND and abs(position.vz) <= _STILL_M_S
        if self.frames is not None and not self._was_disarmed:
            if not stands or self.frames.arm.ekf_z - position.z > _STANDS_BELOW_M:
                self._armed_at = None
                return None
        elif (
            not stands and landed in (LandedState.UNDEFINED, LandedState.ON_GROUND) and now - armed_at < _LANDED_WAIT_S
        ):
            return None
        place = here if stands else self.home
        if place is None or position.time < armed_at - _FRESH_S:
            return None
        self._armed_at = None
        return self._tie(anchor(position, here, place, boot))

    def look(self, position: EkfPosition, here: GlobalPose) -> FrameJump | None:
        """Compare EKF-local with the globe; return a jump when it was confirmed and the frames are anchored again."""
        if self.frames is None or self._armed_at is not None:
            return None
        jump = self.offset.look(self.frames.arm, position, here)
        if jump is not None:
            self._tie(jump.arm)
        return jump

    def _tie(self, arm: ArmPlace) -> ArmPlace:
        if self.datum is None:
            self.datum = GlobalPose(arm.latitude, arm.longitude, arm.altitude)
        self.frames = Frames.create(arm, self.datum)
        return arm


def _is_same_boot(kept: Moment, found: Moment) -> bool:
    """Return True when two moments are the same boot of the autopilot.

    Within a boot of this computer its own clock decides. If it has booted since, the autopilot must have run before
    that, and the wall clock must say the same: two clocks that begin again together would agree by themselves.
    """
    apart = found.since(kept)
    if apart is not None:
        return abs(apart) <= _BOOT_MATCH_S
    return found.seconds <= -_RAN_BEFORE_S and abs(found.utc - kept.utc) <= _BOOT_MATCH_S


def _ekf_distance(first: ArmPlace, second: ArmPlace) -> float:
    return math.dist((first.ekf_x, first.ekf_y, first.ekf_z), (second.ekf_x, second.ekf_y, second.ekf_z))


def _mean(places: Sequence[ArmPlace]) -> ArmPlace:
    count = len(places)
    return replace(
        places[-1],
        ekf_x=sum(place.ekf_x for place in places) / count,
        ekf_y=sum(place.ekf_y for place in places) / count,
        ekf_z=sum(place.ekf_z for place in places) / count,
    )


def _between(first: float, second: float, share: float) -> float:
    return wrap_angle(first + wrap_angle(second - first) * share)


def neighbours(samples: Sequence[S], time: float) -> tuple[S | None, S | None]:
    """Return the samples, oldest first, on both sides of a moment; None where there is none."""
    index = bisect.bisect_right(samples, time, key=lambda sample: sample.time)
    return (samples[index - 1] if index else None, samples[index] if index < len(samples) else None)


def nearest(before: S | None, after: S | None, time: float, reach_s: float = REACH_S) -> S | None:
    """Return the nearer one of two samples; None when both are farther away than ``reach_s`` seconds."""
    near = [sample for sample in (before, after) if sample is not None and abs(sample.time - time) <= reach_s]
    return min(near, key=lambda sample: abs(sample.time - time)) if near else None


def forget(samples: list[S], before: float) -> None:
    """Drop the samples, oldest first, from before a moment."""
    index = bisect.bisect_left(samples, before, key=lambda sample: sample.time)
    del samples[:index]
