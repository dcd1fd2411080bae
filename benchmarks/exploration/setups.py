"""The set-ups: what is flown over, how much of the ground a look shows, from what height, and with what errors."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.exploration.lots import KINDS, Lot, draw_lot
from hawk.algo.path_plan.footprint import Swath
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.vision.rectify import ground_footprint
from hawk.config.sections import CameraSettings, HeightSettings
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose

GOOD_SHARE: Final = PathPlanSettings().good_share
"""Share of the picture, about its middle, that the mapper treats as seen well."""
_AREAS_M2: Final = (3_000.0, 10_000.0, 30_000.0)


@dataclass(frozen=True, slots=True)
class Setup:
    """One set-up. ``version`` rises with every change that makes older tours worthless; ``lot`` draws a seed's lot."""

    name: str
    version: int
    lot: Callable[[int], Lot]
    camera: CameraModel
    height: float

    @property
    def swath(self) -> Swath:
        """Ground seen when the drone is level."""
        return Swath.of(self.camera, self.height, GOOD_SHARE)

    @property
    def footprint_area(self) -> float:
        """Square metres seen from one place."""
        return self.swath.width * self.swath.depth

    def outline(self, pose: MapPose, share: float) -> NDArray[np.float64]:
        """Return the corners (N, 2) of the ground in the middle ``share`` of a picture."""
        inner = replace(self.camera, fx=self.camera.fx / share, fy=self.camera.fy / share)
        return np.array([(p.north, p.east) for p in ground_footprint(inner, pose)])

    def bound(self, area: float) -> float:
        """Return the least distance that any tour needs, metres: (area - one look) / width swept."""
        return max(0.0, area - self.footprint_area) / self.swath.width


def flown() -> Setup:
    """Return the default flight: its camera at the desired height, lots of 0.3, 1 and 3 ha."""
    camera = _camera(1280, 720, 640 / math.tan(math.radians(CameraSettings().horizontal_fov_deg) / 2))
    return Setup("flown", 3, _flown_lot, camera, HeightSettings().desired_m)


def _camera(width: int, height: int, focal: float) -> CameraModel:
    return CameraModel(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)


def _flown_lot(seed: int) -> Lot:
    """Every size with every kind in turn: fifteen seeds show all."""
    kinds = tuple(KINDS)
    return draw_lot(seed, _AREAS_M2[seed % len(_AREAS_M2)], kinds[seed // len(_AREAS_M2) % len(kinds)])
