"""Fit of one map of a lot on another, by where their stalls are: the states of stalls are no argument.

Two maps agree where a stall lies on a stall, and disagree where ground that both saw has a stall on one of them only.
The measure is a log-likelihood (natural, "nats"). A map misses stalls and has false ones mostly where a row begins or
ends, so that what disagrees there says less.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from shapely import MultiPolygon, Polygon

from hawk.algo.registration.neighbours import row_ends, row_numbers
from hawk.algo.rows.fit import Indices, Rectangles
from hawk.algo.vision import quads
from hawk.algo.vision.detection import FloatArray

Bools = NDArray[np.bool_]

DEVIATION_M: Final = 0.3
"""Standard deviation, along each axis, of where two maps place one stall."""
MATCH_M: Final = 1.0
"""Two stalls farther apart are not one."""
_ANGLE: Final = 0.2
_WITHIN, _AT_END = 0.03, 0.08
"""Chance that one of two maps lacks a stall inside a row, or at its end; a false stall is taken as likely."""
_PAIR: Final = 1.0
"""Gain of a pair: as much as its distance costs in the mean, over two axes, so that fewer pairs are no gain."""
_ADVANTAGE = {is_end: math.log((1 - chance) / chance) for is_end, chance in ((False, _WITHIN), (True, _AT_END))}
_OF_A_ROW: Final = 3
"""Pairs of a row whose mean says where the row lies."""
_MARGIN_M: Final = 2.0
"""Stalls nearer than this to the edge of what was seen are not expected to be found."""


@dataclass(frozen=True, slots=True)
class StallMap:
    """One map of a lot: its ``stalls``, metres (north, east), and the ground that was ``seen``, in the same frame."""

    stalls: Rectangles
    seen: Polygon | MultiPolygon = field(repr=False)

    def is_row_end(self) -> Bools:
        """Return which stalls (N,) lack a neighbour on one side."""
        return row_ends(self.stalls)

    def well_seen(self) -> Polygon | MultiPolygon:
        """Return the ground on which a whole stall was seen."""
        return self.seen.buffer(-_MARGIN_M)


@dataclass(frozen=True, slots=True)
class Placement:
    """A map lies on another after a ``turn`` (radians, from north to east) about ``pivot`` and a ``shift`` (2,)."""

    turn: float
    shift: tuple[float, float]
    pivot: tuple[float, float]

    def of(self, places: FloatArray) -> FloatArray:
        """Return places (N, 2) of the map on the other one."""
        return np.asarray((places - self.pivot) @ _turned(self.turn).T + self.pivot + self.shift)

    def back(self, places: FloatArray) -> FloatArray:
        """Return places (N, 2) of the other map on this one."""
        return np.asarray((places - self.pivot - self.shift) @ _turned(self.turn) + self.pivot)


@dataclass(frozen=True, slots=True)
class Fit:
    """``score`` in nats; ``pairs`` (K, 2) of stalls, known and found, ``away`` (K,) metres; how many stalls of each lie
    where both saw.
    """

    score: float
    pairs: Indices = field(repr=False)
    away: FloatArray = field(repr=False)
    known_in_view: int
    found_in_view: int

    @property
    def share(self) -> float:
        """Share of the stalls in common view that are paired, 0..1."""
        fewer = min(self.known_in_view, self.found_in_view)
        return min(len(self.pairs) / fewer, 1.0) if fewer else 0.0


class Likelihood:
    """Compares places of a found map on a known one."""

    def __init__(self, known: StallMap, found: StallMap) -> None:
        self.known, self.found = known, found
        self._known_tree = cKDTree(known.stalls.centres)
        self._known_advantage = _advantages(known.is_row_end())
        self._found_advantage = _advantages(found.is_row_end())
        self._known_seen, self._found_seen = known.well_seen(), found.well_seen()
        shapely.prepare(self._known_seen)
        shapely.prepare(self._found_seen)

    def pairs(self, placement: Placement) -> tuple[Indices, FloatArray]:
        """Return pairs (K, 2) of stalls that are each other's nearest, known and found, and their distances (K,)."""
        placed = placement.of(self.found.stalls.centres)
        away, known = self._known_tree.query(placed, distance_upper_bound=MATCH_M)
        found = np.flatnonzero(known < len(self.known.stalls))
        known, away = known[found], away[found]
        turned = self.found.stalls.angle[found] + placement.turn
        alike = quads.angle_between(self.known.stalls.angle[known], turned) < _ANGLE
        known, found, away = known[alike], found[alike], away[alike]
        nearest_first = np.argsort(away, kind="stable")
        _, first = np.unique(known[nearest_first], return_index=True)
        kept = nearest_first[first]
        return np.column_stack([known[kept], found[kept]]).astype(np.intp), np.asarray(away[kept])

    def fit(self, placement: Placement) -> Fit:
        """Return how well the found map fits at a placement.

        A stall that is alone on ground that both saw well costs ``ln((1 - m) / m)``, m being the chance to be missed. A
        pair r metres apart brings 1 - ``r^2 / 2 s^2``, and costs no more than two stalls alone. Elsewhere a stall says
        nothing.
        """
        pairs, away = self.pairs(placement)
        known_view, found_view = self._in_view(placement)
        worst = self._known_advantage[pairs[:, 0]] + self._found_advantage[pairs[:, 1]]
        score = np.maximum(_PAIR - 0.5 * (away / DEVIATION_M) ** 2, -worst).sum()
        known_view[pairs[:, 0]] = found_view[pairs[:, 1]] = True
        known_alone, found_alone = known_view.copy(), found_view.copy()
        known_alone[pairs[:, 0]] = found_alone[pairs[:, 1]] = False
        score -= self._known_advantage[known_alone].sum() + self._found_advantage[found_alone].sum()
        return Fit(float(score), pairs, away, int(known_view.sum()), int(found_view.sum()))

    def rows_off(self, placement: Placement, pairs: Indices) -> float:
        """Return by how much whole rows lie along themselves off their place, metres: the root of the mean square.

        ``pairs`` (K, 2) are those of its `Fit`. Each row counts by its pairs; 0 where fewer than two rows have
        `_OF_A_ROW` pairs. Stalls of one row err alike where it is another lot's row, and each by itself where it is the
        same. A map that is stretched or sheared as a whole, by a wrong height or a compass, is no other lot: what an
        affine map explains is taken out first.
        """
        if not len(pairs):
            return 0.0
        known = self.known.stalls[pairs[:, 0]]
        off = placement.of(self.found.stalls.centres[pairs[:, 1]]) - known.centres
        terms = np.column_stack([np.ones(len(off)), known.centres - known.centres.mean(axis=0)])
        off = off - terms @ np.linalg.lstsq(terms, off)[0]
        _, first, row = np.unique(row_numbers(self.known.stalls)[pairs[:, 0]], return_index=True, return_inverse=True)
        along_row = quads.cross(known.angle[first][row], off)
        count, total = np.bincount(row), np.bincount(row, along_row)
        whole = count >= _OF_A_ROW
        if whole.sum() < 2:
            return 0.0
        return math.sqrt(float((total[whole] ** 2 / count[whole]).sum() / count[whole].sum()))

    def _in_view(self, placement: Placement) -> tuple[Bools, Bools]:
        """Return which known stalls the found map saw well, and which found ones the known map did."""
        back = placement.back(self.known.stalls.centres)
        there = placement.of(self.found.stalls.centres)
        known = shapely.contains_xy(self._found_seen, back[:, 0], back[:, 1])
        found = shapely.contains_xy(self._known_seen, there[:, 0], there[:, 1])
        return np.asarray(known, np.bool_), np.asarray(found, np.bool_)


def _advantages(is_end: Bools) -> FloatArray:
    return np.where(is_end, _ADVANTAGE[True], _ADVANTAGE[False])


def _turned(angle: float) -> FloatArray:
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([[cosine, -sine], [sine, cosine]])
