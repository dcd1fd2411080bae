"""Cameras, and frames as the algorithms get them in flight."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.frame import FrameInput
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import HeightParameters
from hawk.model.poses import MapPose
from hawk.worlds.camera import WorldCamera
from hawk.worlds.world import World

PIXELS: Final = (1280, 720)
FIELD_OF_VIEW: Final = math.radians(70)
"""Of the default camera, across the longer side."""
FOCAL_PX: Final = PIXELS[0] / 2 / math.tan(FIELD_OF_VIEW / 2)
QUALITY: Final = 85
LENS: Final = (-0.1, 0.02, 0.0005, -0.0005, 0.0)
"""Distortion of a usual lens."""


def camera_model(
    width: int = PIXELS[0], height: int = PIXELS[1], focal: float = FOCAL_PX, distortion: tuple[float, ...] = ()
) -> CameraModel:
    """Return a camera whose axis goes through the middle of its picture; the default camera without arguments."""
    return CameraModel(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2, distortion)


def encoded(picture: NDArray[np.uint8], quality: int = QUALITY) -> bytes:
    """Return a picture as JPEG."""
    return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()


def frame_of(sequence: int, captured: float, camera: CameraModel, pose: MapPose | None, **more: Any) -> FrameInput:
    """Return a frame of an exploration without a picture, a fence and a home; ``more`` are other values of it."""
    plain: dict[str, Any] = {
        "jpeg": b"", "speed": 0.0, "state": StateName.AUTONOMOUS_EXPLORE, "desired": None,
        "heights": HeightParameters(), "fence": None, "home": None,
    }  # fmt: skip
    return FrameInput(sequence=sequence, captured=captured, camera=camera, pose=pose, **{**plain, **more})


def drawn_frames(
    world: World,
    poses: Iterable[tuple[float, float, float, float, float]],
    height_m: float,
    rng: np.random.Generator,
    *,
    pictures_s: float,
    reported: CameraModel | None = None,
) -> Iterator[FrameInput]:
    """Give the frames that the default camera takes over a world.

    Args:
        world: What is seen.
        poses: x east, y south (metres), roll, pitch and yaw (radians) of each.
        height_m: Height above the ground.
        rng: Of the camera's noise.
        pictures_s: Pictures a second.
        reported: The camera that the frames name; None: the one that takes them.
    """
    eye = WorldCamera(world, camera_model())
    for number, (x, y, roll, pitch, yaw) in enumerate(poses):
        image = eye.render(x, y, height_m, roll, pitch, yaw, rng=rng)
        pose = MapPose(-y, x, height_m, roll, pitch, yaw)
        yield frame_of(number, 1.0 + number / pictures_s, reported or camera_model(), pose, jpeg=encoded(image))
