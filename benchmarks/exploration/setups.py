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
DISC_M: Final = 20.0
"""Radius of the ground that the prototype's set-up sees, metres."""
_DISC_CORNERS: Final = 32
_AREAS_M2: Final = (3_000.0, 10_000.0, 30_000.0)


@dataclass(frozen=True, slots=True)
class Setup:
    """One set-up. ``version`` rises with every change that makes older tours worthless; ``lot`` draws a seed's lot."""

    name: str
    version: int
    lot: Callable[[int], Lot]
    camera: CameraModel
    height: float
    is_disc: bool

    @property
    def swath(self) -> Swath:
        """Ground seen when the drone is level; of a disc its box."""
        if self.is_disc:
            return Swath(2 * DISC_M, 2 * DISC_M, self.height)
        return Swath.of(self.camera, self.height, GOOD_SHARE)

    @property
    def footprint_area(self) -> float:
        """Square metres seen from one place."""
        return math.pi * DISC_M**2 if self.is_disc else self.swath.width * self.swath.depth

    def outline(self, pose: MapPose, share: float) -> NDArray[np.float64]:
        """Return the corners (N, 2) of the ground in the middle ``share`` of a picture; a disc lies below the drone."""
        if not self.is_disc:
            inner = replace(self.camera, fx=self.camera.fx / share, fy=self.camera.fy / share)
            return np.array([(p.north, p.east) for p in ground_footprint(inner, pose)])
        angles = np.arange(_DISC_CORNERS) * (math.tau / _DISC_CORNERS)
        # as large as the disc: corners lie outside it, sides cut into it
        radius = DISC_M * share / GOOD_SHARE * math.sqrt(math.tau / _DISC_CORNERS / math.sin(math.tau / _DISC_CORNERS))
        return np.column_stack([pose.north + radius * np.cos(angles), pose.east + radius * np.sin(angles)])

    def bound(self, area: float) -> float:
        """Return the least distance that any tour needs, metres: (area - one look) / width swept."""
        return max(0.0, area - self.footprint_area) / self.swath.width


def flown() -> Setup:
    """Return the default flight: its camera at the desired height, lots of 0.3, 1 and 3 ha."""
    camera = _camera(1280, 720, 640 / math.tan(math.radians(CameraSettings().horizontal_fov_deg) / 2))
    return Setup("flown", 3, _flown_lot, camera, HeightSettings().desired_m, is_disc=False)


def prototype() -> Setup:
    """Return the set-up of the prototype: islands in rotated rectangles of 0.5 ha, seen through a disc.

    The camera's picture is the disc's box; a planner that uses footprints gets the disc.
    """
    height = HeightSettings().desired_m
    camera = _camera(1280, 1280, 1280 * GOOD_SHARE * height / (2 * DISC_M))
    return Setup("prototype", 1, lambda seed: draw_lot(seed, 5_000.0, "islands"), camera, height, is_disc=True)


def _camera(width: int, height: int, focal: float) -> CameraModel:
    return CameraModel(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)


def _flown_lot(seed: int) -> Lot:
    """Every size with every kind in turn: fifteen seeds show all."""
    kinds = tuple(KINDS)
    return draw_lot(seed, _AREAS_M2[seed % len(_AREAS_M2)], kinds[seed // len(_AREAS_M2) % len(kinds)])
