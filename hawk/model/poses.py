"""Poses and places.

Frames (all metres): *local* is NED about the place where the drone was armed; *map* is NED on a tangent plane at the
survey's WGS-84 datum. ``north`` and ``east`` always mean the map frame, ``x`` and ``y`` the local frame. Yaw and every
other angle on the ground is in radians clockwise from north. Times are seconds of the daemon's one clock.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from hawk.model.moment import UNKNOWN_MOMENT, Moment

Ring = tuple[tuple[float, float], ...]
"""Corners of a closed line in order, the first one not repeated: (north, east), or (latitude, longitude)."""


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

    def towards(self, end: MapPoint, share: float) -> MapPoint:
        """Return the place on the straight line to ``end`` after that share of it: 0 is here, 1 is there."""
        return MapPoint(self.north + (end.north - self.north) * share, self.east + (end.east - self.east) * share)


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

    def distance(self, other: MapPose) -> float:
        """Return the distance in space, metres."""
        return math.dist((self.north, self.east, self.height), (other.north, other.east, other.height))

    def is_finite(self) -> bool:
        """Return True when every number is finite."""
        return all(math.isfinite(v) for v in (self.north, self.east, self.height, self.roll, self.pitch, self.yaw))


@dataclass(frozen=True, slots=True)
class ArmPlace:
    """Place where the drone was armed, in WGS-84 and in EKF-local.

    ``ekf_x``, ``ekf_y``, ``ekf_z`` is the arm place in EKF-local (NED metres); ``boot`` identifies a boot of the
    autopilot: the moment of this computer at which its ``time_boot_ms`` was zero.
    """

    latitude: float
    longitude: float
    altitude: float
    ekf_x: float
    ekf_y: float
    ekf_z: float
    boot: Moment = UNKNOWN_MOMENT


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
