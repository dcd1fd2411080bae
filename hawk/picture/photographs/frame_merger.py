"""Levelled photographs fused into one map, by the drone's own mapper."""

from __future__ import annotations

from typing import Final

from hawk.algo.frame import FrameInput
from hawk.algo.mapper.app import MapperApp
from hawk.algo.mapper.core import MapperSettings
from hawk.algo.vision.blur import BLURRED, blur_of
from hawk.algo.vision.detection import Found, FrameGround, GroundImage, VisionResult
from hawk.model.lot_map import OccupancyMap
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import HeightParameters
from hawk.model.poses import MapPose

SETTINGS: Final = MapperSettings(
    registers=False,
    look_m=1.0,
    slow_pieces=6,
    rows_frames=1,
    outline_frames=1,
    cars_frames=1,
    cars_step_m=0.0,
    mosaic_blended_tiles=100_000,
    mosaic_step_m=0.0,
    tiles_per_frame=1,
    mosaic_tiles_per_frame=8,
)
"""Photographs are few, adjusted already, and nobody waits for one: each is an independent look, and all is done."""


class FrameMerger:
    """A map that grows by photographs."""

    def __init__(self, name: str) -> None:
        self._mapper = MapperApp(SETTINGS, name)
        self._count = 0

    def add(self, picture: GroundImage, found: Found, pose: MapPose, time: float) -> None:
        """Fuse a photograph with what was found in it. ``pose``: of its camera above the ground below."""
        ground = FrameGround(
            found.stalls, found.lot, found.car, found.core, found.taken, picture=picture, pose=pose, captured=time,
            is_blurred=blur_of(picture) >= BLURRED,
        )  # fmt: skip
        self._count += 1
        frame = FrameInput(
            sequence=self._count, captured=time, jpeg=b"", camera=_NO_CAMERA, pose=pose, speed=0.0,
            state=StateName.AUTONOMOUS_EXPLORE, desired=None, heights=HeightParameters(), fence=None, home=None,
        )  # fmt: skip
        self._mapper.fuse(frame, VisionResult(ground=ground))

    def finish(self) -> OccupancyMap:
        """Return the whole map."""
        return self._mapper.finish()


_NO_CAMERA: Final = CameraModel(1, 1, 1.0, 1.0, 0.0, 0.0)
