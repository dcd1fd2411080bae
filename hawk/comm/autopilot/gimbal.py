"""The attitude of the camera's gimbal as the autopilot reports it, and the camera's model for a picture taken from it.

GIMBAL_DEVICE_ATTITUDE_STATUS (MAVLink common.xml): ``q`` (w, x, y, z) turns vectors of the gimbal (x along the optical
axis, y right, z down) into a frame whose roll and pitch are the horizon's. Its yaw counts from the drone's nose or from
north, as flags say. ArduPilot sends it for its mounts (a SIYI by MNT1_TYPE 8) with yaw from the nose.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from hawk.model.frames import forget, nearest, neighbours
from hawk.model.pictures import CameraModel, Matrix, angles, rotation
from hawk.model.poses import VehiclePose

FRESH_S: Final = 0.5
"""Seconds between a picture and the nearest reported attitude; beyond, where the camera looks is not known."""
_KEEP_S: Final = 10.0
_FIRST: Final = frozenset((0, 1))
"""``gimbal_device_id`` of the first mount; 0 where the sender gives no number."""
_YAW_LOCK: Final = 16
_YAW_IN_VEHICLE_FRAME: Final = 32
_YAW_IN_EARTH_FRAME: Final = 64
_LEAST_NORM: Final = 0.5


@dataclass(frozen=True, slots=True)
class _Sample:
    time: float
    quaternion: Matrix
    from_north: bool


class GimbalAttitudes:
    """Keeps the attitudes of the last seconds."""

    def __init__(self) -> None:
        self._samples: list[_Sample] = []

    def take(self, fields: Mapping[str, Any], time: float) -> None:
        """Take one message with its time on our clock. Raises KeyError, TypeError, ValueError for one without sense."""
        if int(fields.get("gimbal_device_id") or 0) not in _FIRST:
            return
        quaternion = np.array([float(each) for each in fields["q"]])
        norm = float(np.linalg.norm(quaternion))
        if quaternion.shape != (4,) or not math.isfinite(norm) or norm < _LEAST_NORM:
            raise ValueError(f"q is no rotation: {fields['q']}")
        if self._samples and time <= self._samples[-1].time:
            return  # a repeated or overtaken datagram
        self._samples.append(_Sample(time, quaternion / norm, yaw_counts_from_north(int(fields["flags"]))))
        forget(self._samples, time - _KEEP_S)

    def forget(self) -> None:
        """Drop everything: the autopilot has booted."""
        self._samples.clear()

    def aim(self, camera: CameraModel, time: float, pose: VehiclePose | None) -> tuple[CameraModel, str]:
        """Return the camera as it was mounted at ``time`` by its gimbal, and why nothing can be mapped, else "".

        Args:
            camera: The camera with its mount on the gimbal.
            time: Of the picture, seconds of our clock.
            pose: The drone's at that time.
        """
        sample = self._at(time)
        if sample is None:
            return camera, self._problem(time)
        if pose is None:
            return camera, ""
        to_ned = rotation_of(sample.quaternion)
        if not sample.from_north:
            to_ned = rotation(0.0, 0.0, pose.yaw) @ to_ned
        # a camera that looks straight down is a gimbal pitched by -90 degrees
        down = rotation(0.0, math.pi / 2, 0.0)
        own = rotation(camera.mount_roll, camera.mount_pitch, camera.mount_yaw)
        roll, pitch, yaw = angles(rotation(pose.roll, pose.pitch, pose.yaw).T @ to_ned @ down @ own)
        return replace(camera, mount_roll=roll, mount_pitch=pitch, mount_yaw=yaw), ""

    def off_down(self, time: float) -> float | None:
        """Return the angle of the gimbal's optical axis with straight down at ``time``, radians; None when unknown."""
        sample = self._at(time)
        return None if sample is None else math.acos(min(1.0, max(-1.0, rotation_of(sample.quaternion)[2, 0])))

    def _at(self, time: float) -> _Sample | None:
        """Return the attitude at that time: between two samples, or the nearest within FRESH_S."""
        before, after = neighbours(self._samples, time)
        if before is not None and after is not None and before.from_north == after.from_north:
            span = after.time - before.time
            if span <= 2 * FRESH_S:
                share = (time - before.time) / span
                other = after.quaternion * (1.0 if before.quaternion @ after.quaternion >= 0 else -1.0)
                between = before.quaternion * (1 - share) + other * share
                return _Sample(time, between / np.linalg.norm(between), before.from_north)
        return nearest(before, after, time, FRESH_S)

    def _problem(self, time: float) -> str:
        if not self._samples:
            return "the gimbal's attitude is not reported (MNT1_TYPE): nothing is mapped"
        age = time - self._samples[-1].time
        if age > 0:
            return f"the gimbal's attitude is {age:.0f} s old: nothing is mapped"
        return "the gimbal's attitude at the picture's time is not known: nothing is mapped"


def yaw_counts_from_north(flags: int) -> bool:
    """Return True when the quaternion's yaw counts from north (GIMBAL_DEVICE_FLAGS), False from the drone's nose.

    Senders from before the two flags of the frame mean north by YAW_LOCK.
    """
    if flags & (_YAW_IN_VEHICLE_FRAME | _YAW_IN_EARTH_FRAME):
        return bool(flags & _YAW_IN_EARTH_FRAME)
    return bool(flags & _YAW_LOCK)


def rotation_of(quaternion: Matrix) -> Matrix:
    """Return the rotation matrix (3, 3) of a unit quaternion (w, x, y, z)."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
