"""Shares of an independent look: a frame counts by the ground and the sides that earlier frames did not show."""

from __future__ import annotations

import math
from typing import Final

from hawk.model.poses import MapPose

TURN: Final = 0.6
"""Turn on the spot, radians, after which a frame is an independent look: most of the picture shows other ground."""
MOST_STILL: Final = 0.5
"""Sum of all frames from one place after the first: they average its noise, and see nothing new."""


class Novelty:
    """Shares (0..1) of an independent look, from the places of the frames.

    A place counts once: a drone that hovers, swayed by the wind, learns nothing by swaying. Distance counts as far as
    the drone has got from the last independent look, not along its path.
    """

    def __init__(self, look_m: float, still_weight: float) -> None:
        """Make it.

        Args:
            look_m: Distance after which a frame is an independent look.
            still_weight: Share of a frame from the same place, until `MOST_STILL` is reached.
        """
        self._look_m = look_m
        self._still_weight = still_weight
        self._from: MapPose | None = None
        self._reached = self._still = 0.0

    def of(self, pose: MapPose) -> float:
        """Return the share of the frame from a pose, 0 from one that has shown all it can."""
        if self._from is None:
            self._begin(pose)
            return 1.0
        share = self._apart(self._from, pose)
        gained = max(0.0, share - self._reached)
        still = min(self._still_weight, MOST_STILL - self._still)
        self._reached, self._still = max(self._reached, share), self._still + still
        if share >= 1.0:
            self._begin(pose)
        return min(1.0, gained + still)

    def _begin(self, pose: MapPose) -> None:
        self._from, self._reached, self._still = pose, 0.0, 0.0

    def _apart(self, first: MapPose, second: MapPose) -> float:
        places = ((one.north, one.east, one.height) for one in (first, second))
        turn = abs(math.remainder(second.yaw - first.yaw, math.tau))
        return math.dist(*places) / self._look_m + turn / TURN
