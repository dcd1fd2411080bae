"""The ground that a picture shows, for display."""

from __future__ import annotations

import math

import numpy as np

from hawk.algo.vision.rectify import camera_to_ned
from hawk.model import CameraModel, MapPoint, MapPose

_FLATTEST = math.cos(math.radians(75))  # rays that meet the ground flatter than this are cut there


def ground_footprint(camera: CameraModel, pose: MapPose) -> tuple[MapPoint, ...]:
    """Return the four corners of the picture on the ground (map frame), from its upper left one clockwise.

    Lens distortion is left out. Empty when the pose is not finite or on the ground.
    """
    if not pose.is_finite() or pose.height <= 0:
        return ()
    columns = np.array([0.0, camera.width, camera.width, 0.0]) - 0.5
    rows = np.array([0.0, 0.0, camera.height, camera.height]) - 0.5
    rays = np.stack([(columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy, np.ones(4)])
    north, east, down = camera_to_ned(camera, pose) @ (rays / np.linalg.norm(rays, axis=0))
    reach = pose.height / np.maximum(down, _FLATTEST)
    return tuple(
        MapPoint(round(pose.north + float(n), 3), round(pose.east + float(e), 3))
        for n, e in zip(north * reach, east * reach, strict=True)
    )
