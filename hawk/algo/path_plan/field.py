"""What is still to be learned, place by place: expected lot that was not seen well, square metres a coarse cell.

The secret is the guess about what nobody has seen: the border of a lot is uncertain, and what lies beyond it is lot the
likelier, the nearer known lot is, and the unlikelier, the nearer it lies to ground known not to be lot.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.mapper.grid import CoarseLayers
from hawk.algo.mapper.window import Window
from hawk.algo.path_plan.bridges import with_bridges

_REACH_M = 10.0  # how far beyond known lot more of it is expected: most of a double row with its aisle
_TURNED = 2.0  # the higher, the more the nearest known ground alone decides
_SCOUT_M = 30.0
_FAR_M = 1e3
_ALIKE = 0.7  # ground that looks like lot, without stalls near it, leads to lot less often
_LONGEST_BRIDGE_M = 60.0  # across other ground, from one part of the lot to another
_SEEN_BADLY = 0.15  # what a second look at a place near a picture's edge is worth, against a first look

Grid = NDArray[np.float32]
Place = tuple[float, float]
"""(north, east), metres."""


@dataclass(frozen=True, slots=True)
class InformationField:
    """``gain`` is expected new lot in square metres a cell.

    ``allowed`` is where the drone may be, ``passable`` the same with a cell more for the way and corridors between
    parts of the lot; ``lot`` shares of known lot, ``well`` of well seen, ``seen`` of seen at all.
    """

    window: Window
    gain: Grid
    allowed: NDArray[np.uint8]
    passable: NDArray[np.uint8]
    lot: Grid
    well: Grid
    seen: Grid

    @property
    def seen_share(self) -> float:
        """Share (0..1) of the known lot that was seen well, 0 when none is known."""
        area = float(self.lot.sum())
        return 0.0 if area == 0 else float(np.minimum(self.lot, self.well).sum()) / area


def information_field(layers: CoarseLayers, fenced: NDArray[np.uint8], near_lot_m: float) -> InformationField:
    """Return the field for the map's coarse layers; ``fenced`` is 1 inside the fence."""
    cell = layers.window.cell_m
    is_lot = layers.lot > 0.5 * np.maximum(layers.seen, 0.3)
    to_lot = _distance(is_lot) * cell
    new = (1 - layers.seen) + _SEEN_BADLY * np.maximum(layers.seen - layers.well, 0)
    gain = (new * _likely_lot(layers, is_lot, to_lot) * cell**2).astype(np.float32)
    allowed = ((to_lot <= near_lot_m) & (fenced > 0)).astype(np.uint8)
    passable = np.where(fenced > 0, cv2.dilate(allowed, np.ones((3, 3), np.uint8)), 0).astype(np.uint8)
    passable = with_bridges(passable, fenced, _LONGEST_BRIDGE_M / cell)
    return InformationField(layers.window, gain, allowed, passable, layers.lot, layers.well, layers.seen)


def guessed(layers: CoarseLayers, place: Place) -> CoarseLayers:
    """Return the layers for looking for a lot while none is known: what looks like lot counts as lot, or else the
    ground below the drone, as far as the window shows it."""
    lot = layers.likely
    if not (lot > 0).any():
        lot = np.zeros(layers.window.shape, np.float32)
        column, row = np.round(layers.window.cells_of(np.array(place[0]), np.array(place[1]))).astype(np.intp)
        if 0 <= row < lot.shape[0] and 0 <= column < lot.shape[1]:
            lot[row, column] = 1.0
    return replace(layers, lot=lot)


def scouting_field(layers: CoarseLayers, fenced: NDArray[np.uint8], near_lot_m: float) -> InformationField:
    """Return the field for looking around a lot that seems too small to be the whole: all unseen ground counts that is
    near the lot, whatever lies between."""
    cell = layers.window.cell_m
    to_lot = _distance(layers.lot > 0.5 * np.maximum(layers.seen, 0.3)) * cell
    gain = ((1 - layers.seen) * np.exp(-to_lot / _SCOUT_M) * cell**2).astype(np.float32)
    allowed = ((to_lot <= near_lot_m) & (fenced > 0)).astype(np.uint8)
    return InformationField(layers.window, gain, allowed, allowed, layers.lot, layers.well, layers.seen)


def _likely_lot(layers: CoarseLayers, is_lot: NDArray[np.bool_], to_lot: Grid) -> Grid:
    """Probability of being lot: what was seen as it is, the rest by what is nearest."""
    known = layers.seen > 0.5
    looks_alike = layers.likely > 0.5 * np.maximum(layers.seen, 0.3)
    to_other = np.maximum(_distance(known & ~is_lot & ~looks_alike) * layers.window.cell_m, 0.5)
    to_alike = _distance(looks_alike) * layers.window.cell_m
    expected = np.maximum(_beyond(to_lot, to_other), _ALIKE * _beyond(to_alike, to_other))
    seen = layers.lot / np.maximum(layers.seen, 1e-3)
    return np.where(known, seen, expected).astype(np.float32)


def _beyond(to_lot: Grid, to_other: Grid) -> Grid:
    """Probability that unseen ground is lot, by the distances to known lot and to what is none."""
    return np.asarray(np.exp(-to_lot / _REACH_M) / (1 + (to_lot / to_other) ** _TURNED), dtype=np.float32)


def _distance(mask: NDArray[np.bool_]) -> Grid:
    """Distance of each cell to the nearest in the mask, cells."""
    if not mask.any():
        return np.full(mask.shape, _FAR_M, np.float32)
    return np.asarray(cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 5), dtype=np.float32)
