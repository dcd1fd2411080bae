"""Windows merged: each stall once, whichever windows saw it, in the same order whatever theirs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from hawk.algo.vision import quads
from hawk.picture.orthophoto.grid import FloatArray
from hawk.picture.orthophoto.tile_detector import TileVehicles
from hawk.picture.orthophoto.windows import WindowStalls

SAME: Final = 0.30
"""Share of the smaller of two stalls from which two windows mean one stall."""
_STALL_REACH_M: Final = 9.0
"""Distance between the middles of two stalls of usual size beyond which they do not overlap."""


@dataclass(frozen=True, slots=True)
class Stalls:
    """Stalls of a picture, from its upper left to its lower right, and its vehicles: as of `WindowStalls`."""

    corners: FloatArray = field(repr=False)
    taken: FloatArray = field(repr=False)
    score: FloatArray = field(repr=False)
    suggested: FloatArray = field(repr=False)
    vehicles: TileVehicles | None = field(default=None, repr=False)

    def __len__(self) -> int:
        return len(self.score)

    @property
    def vehicle_corners(self) -> FloatArray:
        """Corners (V, 4, 2) of the vehicles; none of a network that knows none."""
        return np.zeros((0, 4, 2)) if self.vehicles is None else self.vehicles.corners


def merge_tiles(windows: Sequence[WindowStalls], metres: tuple[float, float]) -> Stalls:
    """Return the stalls of a picture.

    A stall is the window's whose core holds its middle. Of stalls of several windows that overlap by more than `SAME`
    one is kept: first one in its own core, then the one that is farther from what its window shows. A stall that only
    a neighbour found, because each put it on the other's side of the seam, is kept.

    Args:
        windows: The findings of the windows, in any order.
        metres: Of a pixel along a row and along a column.
    """
    parts = sorted(windows, key=lambda part: part.window.core[1::-1])
    corners, taken, score = (
        np.concatenate([getattr(part, name) for part in parts] or [np.zeros(shape)])
        for name, shape in (("corners", (0, 4, 2)), ("taken", 0), ("score", 0))
    )
    owner = np.repeat(np.arange(len(parts)), [len(part.score) for part in parts])
    places = corners * np.array(metres)
    order = _standing(parts, owner, places, score, np.array(metres))
    kept = _kept(places, owner, order)
    kept = kept[np.lexsort((corners[kept].mean(1)[:, 0], corners[kept].mean(1)[:, 1]))]
    suggested = np.concatenate([part.suggested for part in parts] or [np.zeros((0, 4, 2))])
    suggested = suggested[_free(suggested * np.array(metres), places[kept])]
    suggested = suggested[quads.suppress(suggested * np.array(metres), np.zeros(len(suggested)), SAME)]
    return Stalls(corners[kept], taken[kept], score[kept], suggested, _vehicles(parts, np.array(metres)))


def _vehicles(parts: Sequence[WindowStalls], metres: FloatArray) -> TileVehicles | None:
    """Return the vehicles of all windows, each once; None of a network that knows none."""
    given = [part.vehicles for part in parts if part.vehicles is not None]
    if not given:
        return None
    every = TileVehicles(*(np.concatenate([getattr(one, f.name) for one in given]) for f in fields(TileVehicles)))
    return every.chosen(quads.suppress(every.corners * metres, every.probability, SAME))


def _standing(
    parts: Sequence[WindowStalls], owner: NDArray[np.intp], places: FloatArray, score: FloatArray, metres: FloatArray
) -> NDArray[np.intp]:
    """Return the indices of the stalls, the one that wins over all others first."""
    if not len(owner):
        return np.zeros(0, np.intp)
    cores, boxes = (
        np.array([getattr(part.window, name) for part in parts], np.float64)[owner] * np.tile(metres, 2)
        for name in ("core", "box")
    )
    middle = places.mean(axis=1)
    is_own = (middle >= cores[:, :2]).all(axis=1) & (middle < cores[:, 2:]).all(axis=1)
    depth = np.minimum(middle - boxes[:, :2], boxes[:, 2:] - middle).min(axis=1)
    return np.lexsort((middle[:, 0], middle[:, 1], -score, -np.round(depth, 3), ~is_own))


def _kept(places: FloatArray, owner: NDArray[np.intp], order: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return which stalls stay: of two windows' stalls that are one, that which stands higher in the order."""
    stays = np.ones(len(places), np.bool_)
    if len(places) < 2:
        return np.flatnonzero(stays)
    middle = places.mean(axis=1)
    longest = float(np.hypot(*(places[:, 0] - places[:, 2]).T).max())
    pairs = cKDTree(middle).query_pairs(max(longest, _STALL_REACH_M), output_type="ndarray")
    pairs = pairs[owner[pairs[:, 0]] != owner[pairs[:, 1]]]
    pairs = pairs[_share(places[pairs[:, 0]], places[pairs[:, 1]]) > SAME]
    rank = np.empty(len(places), np.intp)
    rank[order] = np.arange(len(places))
    ranked = np.where((rank[pairs[:, 0]] < rank[pairs[:, 1]])[:, None], pairs, pairs[:, ::-1])
    for winner, loser in ranked[np.lexsort((rank[ranked[:, 1]], rank[ranked[:, 0]]))].tolist():
        if stays[winner]:
            stays[loser] = False
    return np.flatnonzero(stays)


def _free(suggested: FloatArray, places: FloatArray) -> NDArray[np.bool_]:
    """Return which suggestions lie on no stall."""
    free = np.ones(len(suggested), np.bool_)
    if len(suggested) and len(places):
        i, j = quads.near_pairs(suggested.mean(axis=1), places.mean(axis=1), _STALL_REACH_M)
        free[i[_share(suggested[i], places[j]) > SAME]] = False
    return free


def _share(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the common area of pairs of quads as a share of the smaller one, (N,)."""
    overlap = quads.overlaps(first, second)
    areas = np.stack([_area(first), _area(second)])
    return np.asarray(overlap / (1 + overlap) * areas.sum(axis=0) / np.maximum(areas.min(axis=0), 1e-9))


def _area(corners: FloatArray) -> FloatArray:
    one, other = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    return np.asarray(np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]) / 2)
