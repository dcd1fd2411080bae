"""How the drone's lean moves the picture: the camera is fixed to it, and leans with it.

The secret is how much it leans: what the settings say, until flying has shown that it is less (a heavy drone, gentle
limits, a camera that is kept level).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.sweep import Swath
from hawk.model import MapPose

_MOVES_M_S: Final = 2.0
_ENOUGH: Final = 30
"""Frames from a moving drone that tell how it leans: it has sped up and slowed down or turned by then."""


@dataclass(frozen=True, slots=True)
class Lean:
    """How far the picture moves when the drone leans, metres: outwards at a corner for each unit by which the direction
    changes, ``start`` behind the drone as it speeds up, ``stop`` ahead as it brakes at the end.

    ``radius`` is how far about its middle a picture that leans at a corner shows the ground.
    """

    corner: float
    start: float
    stop: float
    radius: float

    @classmethod
    def of(cls, swath: Swath, settings: PathPlanSettings, leans: float = 1.0) -> Lean:
        """Return it for a camera that looks straight down while the drone is level, and a drone that leans by a share
        of what the settings say."""
        side = math.atan2(swath.depth / 2, swath.height)

        def beyond(lean_deg: float) -> float:
            return swath.height * math.tan(side + math.radians(lean_deg * leans)) - swath.depth / 2

        corner = swath.height * math.tan(math.radians(settings.lean_deg * leans))
        radius = swath.width / 2 * settings.lean_share
        return cls(corner, beyond(settings.lean_deg), beyond(settings.stop_lean_deg), radius)


class LeanWatch:
    """Finds out in flight by how much the drone leans."""

    def __init__(self, settings: PathPlanSettings) -> None:
        self._expected = settings.lean_deg
        self._most = 0.0
        self._moving = 0

    def take(self, pose: MapPose, speed: float) -> None:
        """Take the pose of one frame and the speed over ground, m/s."""
        self._moving += speed > _MOVES_M_S
        self._most = max(self._most, math.degrees(math.hypot(pose.roll, pose.pitch)))

    @property
    def share(self) -> float:
        """What it leans against what was expected, 0..1; 1 until enough was flown to tell."""
        if self._moving < _ENOUGH or self._expected <= 0:
            return 1.0
        return min(1.0, self._most / self._expected)
