"""What vision can read: from what height it sees enough, and how fast it can be flown past.

The secret is what reading needs: a pixel on the ground small enough, each place in several pictures that were worked on
while it was in sight, and no picture smeared by more than a pixel of what the network looks at.
"""

from __future__ import annotations

from collections import deque
from typing import Final

import numpy as np

from hawk.model import CameraModel, HeightParameters

LOOKS: Final = 3
"""A place is to be in so many pictures while the drone flies past."""
SMEAR_M: Final = 0.1
"""Ground that may pass while the shutter is open: a pixel of the network (`hawk.algo.vision.network`)."""
SLOWEST_M_S: Final = 0.5
"""It is never slower than this: a drone that gets nowhere counts as stuck."""
_TIMES: Final = 8


def exploring_height(heights: HeightParameters, camera: CameraModel, cm_per_pixel: float | None) -> float:
    """Return the height to explore from, metres, within Min and Max: where a pixel right below the camera is so many
    centimetres wide, or for None the operator's desired one."""
    return heights.bounded(heights.desired if cm_per_pixel is None else cm_per_pixel / 100 * camera.fx)


class ReadableSpeed:
    """Follows how often pictures are worked on; frames that are dropped because the computer is busy do not count."""

    def __init__(self, exposure_s: float) -> None:
        """``exposure_s`` is the longest time that the shutter is open, seconds."""
        self._smearless = SMEAR_M / exposure_s
        self._times: deque[float] = deque(maxlen=_TIMES)

    def take(self, captured: float) -> None:
        """Take note of a picture that is being worked on; ``captured`` in seconds."""
        if self._times and captured <= self._times[-1]:
            self._times.clear()
        self._times.append(captured)

    def limit(self, depth: float) -> float:
        """Return the fastest that the drone may fly, m/s, where pictures show ``depth`` metres along the way."""
        fastest = self._smearless
        if len(self._times) > 1:
            fastest = min(fastest, depth / (LOOKS * float(np.median(np.diff(self._times)))))
        return max(fastest, SLOWEST_M_S)
