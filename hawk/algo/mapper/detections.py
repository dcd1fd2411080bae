"""One frame's stalls as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hawk.algo.mapper.geometry import transform_points
from hawk.algo.vision import quads
from hawk.algo.vision.seen import StallSeen

Floats = NDArray[np.float64]

_WHOLE = 0.9  # visible share


@dataclass(frozen=True, slots=True)
class Detections:
    """Stalls seen in one frame: arrays of equal length, fields as `StallSeen`.

    ``lean`` is the share of the drone's way by which a stall moves against the ground, NaN where it was not measured.
    """

    north: Floats
    east: Floats
    angle: Floats
    width: Floats
    length: Floats
    score: Floats
    taken: Floats
    visible: Floats
    lean: Floats

    @classmethod
    def of(cls, stalls: Sequence[StallSeen]) -> Detections:
        """Gather stalls; one with a number that is not finite or a size that no stall has is left out."""
        rows = [(s.north, s.east, s.angle, s.width, s.length, s.score, s.taken, s.visible) for s in stalls]
        table = np.array(rows, np.float64).reshape(-1, 8)
        sane = np.isfinite(table).all(1) & (table[:, 3] > 0.5) & (table[:, 4] > 0.5)
        whole = np.column_stack([table, np.full(len(table), np.nan)])[sane]
        return cls(*whole.T)

    def __len__(self) -> int:
        return len(self.north)

    def take(self, index: NDArray[np.bool_] | NDArray[np.intp]) -> Detections:
        """Return some of them."""
        return Detections(
            self.north[index],
            self.east[index],
            self.angle[index],
            self.width[index],
            self.length[index],
            self.score[index],
            self.taken[index],
            self.visible[index],
            self.lean[index],
        )

    @property
    def is_whole(self) -> NDArray[np.bool_]:
        """Which of them lie in the picture as a whole: cut ones tell little of their centre."""
        return self.visible > _WHOLE

    def leaning(self, leans: Floats) -> Detections:
        """Return them with the leans of those that are whole, as many as these."""
        lean = self.lean.copy()
        lean[self.is_whole] = leans
        return replace(self, lean=lean)

    def moved(self, correction: Floats) -> Detections:
        """Return them with places, directions and sizes corrected by a (2, 3) map-to-map similarity."""
        centre = transform_points(correction, np.stack([self.north, self.east], -1))
        turn = float(np.arctan2(correction[1, 0], correction[0, 0]))
        scale = float(np.sqrt(abs(np.linalg.det(correction[:, :2]))))
        return replace(
            self,
            north=centre[:, 0],
            east=centre[:, 1],
            angle=(self.angle + turn) % np.pi,
            width=self.width * scale,
            length=self.length * scale,
        )

    def corners(self) -> Floats:
        """Return corners (N, 4, 2) of (north, east)."""
        return quads.corners(self.north, self.east, self.angle, self.width, self.length)
