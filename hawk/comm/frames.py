"""Frames of reference: EKF-local (ArduPilot's own), local (about the arm place) and map (about the datum).

EKF-local stays inside this room. All three are NED in metres; their axes are taken as parallel, which over a lot's
kilometre is wrong by less than a centimetre a metre of height and 0.01 degrees of meridian convergence.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import pymap3d

from hawk.comm.pose_buffer import Attitude, EkfPosition
from hawk.model import ArmPlace, GlobalPose, LocalPose, MapPose

JUMP_M = 1.0
"""EKF-local that moves by more than this against the world has been reset."""
_CONFIRM = 3
_AGREE_M = 0.5


def offset_ned(place: GlobalPose, origin: GlobalPose) -> tuple[float, float, float]:
    """Return where ``place`` lies from ``origin``: metres north, east, down on the tangent plane (WGS-84).

    Heights are treated as ellipsoidal: only their difference counts.
    """
    north, east, down = pymap3d.geodetic2ned(
        place.latitude, place.longitude, place.altitude, origin.latitude, origin.longitude, origin.altitude
    )
    return float(north), float(east), float(down)


def place_at(north: float, east: float, origin: GlobalPose, up: float = 0.0) -> GlobalPose:
    """Return the place that lies so many metres north, east and up of ``origin``."""
    latitude, longitude, altitude = pymap3d.ned2geodetic(
        north, east, -up, origin.latitude, origin.longitude, origin.altitude
    )
    return GlobalPose(float(latitude), float(longitude), float(altitude))


@dataclass(frozen=True, slots=True)
class Frames:
    """The three frames tied together: by the arm place (EKF-local to local) and the datum (local to map)."""

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
        """The arm place on the globe."""
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
        """Return a position on the globe."""
        local = self.local(position, 0.0)
        return place_at(local.x, local.y, self.home, up=-local.z)

    def ekf(self, north: float, east: float, height: float) -> tuple[float, float, float]:
        """Return a place of the map in EKF-local (x, y, z)."""
        return (
            self.arm.ekf_x + north - self.arm_north,
            self.arm.ekf_y + east - self.arm_east,
            self.arm.ekf_z - height,
        )


def anchor(position: EkfPosition, here: GlobalPose, place: GlobalPose, boot_id: int) -> ArmPlace:
    """Return the arm place ``place``, tied to EKF-local by a position whose place on the globe is ``here``."""
    north, east, down = offset_ned(here, place)
    return ArmPlace(
        place.latitude,
        place.longitude,
        place.altitude,
        position.x - north,
        position.y - east,
        position.z - down,
        boot_id,
    )


@dataclass(frozen=True, slots=True)
class FrameJump:
    """EKF-local moved by ``metres``; ``arm`` is the same place on the globe, tied to it anew."""

    metres: float
    arm: ArmPlace


class OffsetWatch:
    """Watches what ties EKF-local to the globe. A jump counts when three looks in a row agree on it."""

    def __init__(self) -> None:
        self._suspects: list[ArmPlace] = []
        self._agreed = _CONFIRM

    @property
    def sure(self) -> bool:
        """Whether the last looks agreed with the anchor."""
        return self._agreed >= _CONFIRM and not self._suspects

    def doubt(self) -> None:
        """Positions moved faster than the drone can: be unsure until three looks agree again."""
        self._agreed = 0
        self._suspects.clear()

    def look(self, arm: ArmPlace, position: EkfPosition, here: GlobalPose) -> FrameJump | None:
        """Compare one position in EKF-local with the same moment's place on the globe."""
        place = GlobalPose(arm.latitude, arm.longitude, arm.altitude)
        found = anchor(position, here, place, arm.boot_id)
        if _ekf_distance(found, arm) <= JUMP_M:
            self._suspects.clear()
            self._agreed = min(self._agreed + 1, _CONFIRM)
            return None
        if self._suspects and _ekf_distance(found, self._suspects[-1]) > _AGREE_M:
            self._suspects.clear()
        self._suspects.append(found)
        if len(self._suspects) < _CONFIRM:
            return None
        anew = _mean(self._suspects)
        self._suspects.clear()
        self._agreed = _CONFIRM
        return FrameJump(_ekf_distance(anew, arm), anew)


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
