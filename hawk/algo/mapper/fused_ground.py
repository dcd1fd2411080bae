"""The ground as all frames together show it, about a place."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import Floats, Window
from hawk.algo.mapper.evidence import EVIDENCE_M
from hawk.algo.mapper.grid import EvidenceGrid
from hawk.algo.rows.evidence import Ground

_LOOKS: Final = 0.5
"""Independent looks from which a cell was seen."""
_COVERED: Final = (0.1, 0.3)
"""Mean car of a stall up to which it is free, and from which it is taken; between them it is unclear."""
_SURE = 2.2
"""Log-odds of the state of a stall with no car at all, or full of one."""
_BARE = 0.35
"""Mean core of a stall from which the ground shows that it is free; below it something hides the ground."""
_INNER = 0.7
_SAMPLES = (9, 5)


class FusedGround:
    """The fused evidence about a place, read once."""

    def __init__(self, grid: EvidenceGrid, middle: tuple[float, float], reach_m: float) -> None:
        about = np.array(middle) + np.array([[-reach_m, -reach_m], [reach_m, reach_m]])
        self._window = Window.around(about, EVIDENCE_M)
        core, car, lot, looks = (grid.layer(self._window, name) for name in ("core", "car", "lot", "looks"))
        seen = looks >= _LOOKS
        self._layers = np.stack([core, car, np.where(seen, 1 / (1 + np.exp(-lot)), 0.0), seen], axis=-1)

    def at(self, places: Floats) -> Ground:
        """Return the ground at places (..., 2) of (north, east)."""
        rows, columns, inside = self._window.cells_at(places.reshape(-1, 2))
        values = self._layers[rows, columns]
        values[~inside] = 0
        return Ground(*np.moveaxis(values.reshape(*places.shape[:-1], self._layers.shape[-1]), -1, 0))

    def within(self, corners: Floats) -> tuple[Floats, Floats]:
        """Return the mean core and car (N,) in the inner part of quads (N, 4, 2)."""
        a, b = (np.linspace(0.5 - _INNER / 2, 0.5 + _INNER / 2, n) for n in _SAMPLES)
        along, across = (v.ravel()[:, None] for v in np.meshgrid(a, b, indexing="ij"))
        near = corners[:, None, 0] * (1 - across) + corners[:, None, 1] * across
        far = corners[:, None, 3] * (1 - across) + corners[:, None, 2] * across
        ground = self.at(near * (1 - along) + far * along)
        return np.asarray(ground.core.mean(1), np.float64), np.asarray(ground.car.mean(1), np.float64)

    def taken(self, corners: Floats) -> Floats:
        """Return log-odds (N,) that the stalls of quads (N, 4, 2) are taken: by the cars on them.

        Stalls are free where their bare ground is seen, and unclear, 0, where something hides it.
        """
        core, cover = self.within(corners)
        taken = np.interp(cover, [0, *_COVERED, 2 * _COVERED[1]], [-_SURE, 0, 0, _SURE])
        return np.where((taken < 0) & (core < _BARE), 0.0, taken)

    def seen(self, corners: Floats) -> NDArray[np.bool_]:
        """Return which middles of quads (N, 4, 2) were seen."""
        return np.asarray(self.at(corners.mean(axis=1)).seen > 0)
