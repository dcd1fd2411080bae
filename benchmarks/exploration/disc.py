"""The prototype's footprint: a disc below the drone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hawk.algo.ground import Bools, Floats
from hawk.algo.path_plan.footprint import Corners, Footprint, Singles, legs_about


@dataclass(frozen=True, slots=True)
class Disc(Footprint):
    """A disc as footprint; ``width`` and ``depth`` are its diameter. It shows no more when it turns."""

    def shown(self, cells: Singles, begins: Floats, ends: Floats, corners: Corners | None = None) -> Bools:  # noqa: ARG002
        """Return (K, N): which of N cells (N, 2) each of K straight legs shows."""
        along, across, half, _ = legs_about(cells, begins, ends)
        beyond = np.maximum(np.abs(along) - half, 0)
        return np.asarray(beyond * beyond + across * across <= (self.width / 2) ** 2)

    def seen(self, cells: Singles, places: Floats, yaws: Floats, leans: Floats) -> Bools:  # noqa: ARG002
        """Return (M, N): which of N cells each of M looks shows, whatever the drone's attitude."""
        off = cells[None] - places[:, None].astype(np.float32)
        return np.asarray((off * off).sum(2) <= (self.width / 2) ** 2)
