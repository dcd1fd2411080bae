"""The camera of a flying drone: ground in a picture from a height, lean of the drone, speed that vision can read.

Vision can read a place when a pixel on the ground is small enough, when the place is in several pictures that were
worked on, and when none is smeared by more than a pixel of the network's input. The camera is fixed to the drone and
leans with it. The settings say how much it leans, until flying has shown that it is less (a heavy drone, gentle limits,
a camera that is kept level).
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Final

import numpy as np

from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.model.limits import HeightParameters
from hawk.model.pictures import CameraModel
from hawk.model.poses import MapPose

LOOKS: Final = 3  # pictures that a place is in while the drone flies past, at least
SMEAR_M: Final = 0.1  # ground that may pass while the shutter is open: a pixel of the network
SLOWEST_M_S: Final = 0.5  # a slower drone would be taken for stuck
_TIMES: Final = 8
_MOVES_M_S: Final = 2.0
_ENOUGH: Final = 30  # frames from a moving drone: it has sped up and slowed down or turned by then


@dataclass(frozen=True, slots=True)
class Swath:
    """Ground in the good part of a picture, metres: ``width`` across the heading, ``depth`` along it, from a height."""

    width: float
    depth: float
    height: float

    @property
    def reach(self) -> float:
        """Distance from the middle of the picture to a corner, metres."""
        return math.hypot(self.width, self.depth) / 2

    @classmethod
    def of(cls, camera: CameraModel, height: float, good_share: float) -> Swath:
        """Return the swath of a level camera at a height (metres); ``good_share`` as in the settings."""
        scale = height * good_share
        return cls(scale * camera.width / camera.fx, scale * camera.height / camera.fy, height)


def exploring_height(heights: HeightParameters, camera: CameraModel, cm_per_pixel: float | None) -> float:
    """Return the height to explore from, metres within Min and Max: for this size of a pixel, or the desired one."""
    return heights.bounded(heights.desired if cm_per_pixel is None else cm_per_pixel / 100 * camera.fx)


class ReadableSpeed:
    """Follows how often pictures are worked on; frames that a busy computer drops are left out."""

    def __init__(self, exposure_s: float) -> None:
        """``exposure_s`` is the longest time that the shutter is open, seconds."""
        self._smearless = SMEAR_M / exposure_s
        self._times: deque[float] = deque(maxlen=_TIMES)

    def take(self, captured: float) -> None:
        """Record a picture that is being worked on; ``captured`` in seconds."""
        if self._times and captured <= self._times[-1]:
            self._times.clear()
        self._times.append(captured)

    def limit(self, depth: float) -> float:
        """Return the highest readable speed, m/s, for pictures that show ``depth`` metres along the path."""
        fastest = self._smearless
        if len(self._times) > 1:
            fastest = min(fastest, depth / (LOOKS * float(np.median(np.diff(self._times)))))
        return max(fastest, SLOWEST_M_S)


@dataclass(frozen=True, slots=True)
class Lean:
    """Distances by which the picture moves when the drone leans, metres.

    ``corner`` is outwards at a corner for each unit by which the direction changes, ``start`` behind the drone as it
    speeds up, ``stop`` ahead as it brakes at the end. ``radius`` is the radius about its middle within which a picture
    that leans at a corner shows the ground.
    """

    corner: float
    start: float
    stop: float
    radius: float

    @classmethod
    def of(cls, swath: Swath, settings: PathPlanSettings, leans: float = 1.0) -> Lean:
        """Return it for a camera that looks straight down, ``leans`` (0..1) being the share of the settings' lean."""
        side = math.atan2(swath.depth / 2, swath.height)

        def beyond(lean_deg: float) -> float:
            return swath.height * math.tan(side + math.radians(lean_deg * leans)) - swath.depth / 2

        corner = swath.height * math.tan(math.radians(settings.lean_deg * leans))
        radius = swath.width / 2 * settings.lean_share
        return cls(corner, beyond(settings.lean_deg), beyond(settings.stop_lean_deg), radius)


class LeanObserver:
    """Finds out in flight by how much the drone leans."""

    def __init__(self, settings: PathPlanSettings) -> None:
        self._expected = settings.lean_deg
        self._most = 0.0
        self._moving = 0

    def take(self, pose: MapPose, speed: float) -> None:
        """Record the pose of one frame and the speed over ground, m/s."""
        self._moving += speed > _MOVES_M_S
        self._most = max(self._most, math.degrees(math.hypot(pose.roll, pose.pitch)))

    @property
    def share(self) -> float:
        """Largest lean against the expected one, 0..1; 1 until enough was flown to know."""
        if self._moving < _ENOUGH or self._expected <= 0:
            return 1.0
        return min(1.0, self._most / self._expected)
