"""Measures of a survey against the ground truth: pure functions over stalls as quads in metres.

A stall found is right when its rotated rectangle overlaps a true stall's with an intersection over union of at least
0.5; each true stall is matched at most once, and the matching is the one with the most matches, then the most overlap.

Labels of real places are incomplete, hence the starred measures: a stall found that matches nothing is a *counted*
false alarm only when its middle lies within 0.7 m of a labelled stall, or outside every labelled lot. A whole row that
nobody labelled is not counted against the finder.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from hawk.model.lot_map import StallState

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.intp]
StateArray = NDArray[Any]
"""(N,) of `StallState` values as strings."""

MATCH_OVERLAP = 0.5
"""Least intersection over union of a match."""
NEAR_M = 0.7
"""A false alarm this near to a labelled stall is always counted."""
WHOLE_WIDTH_M, WHOLE_LENGTH_M, WHOLE_RATIO = 1.9, 4.0, 1.35
"""Least sides, metres, and ratio of the sides of a label that shows a whole stall."""
_GRID_M = 1e-6


@dataclass(frozen=True, slots=True)
class LabelledPlace:
    """The labels of a place, in metres: stalls (N, 4, 2), their states (N,) and the outlines (M, 2) of the lots.

    A state of ``unknown`` stands for a label that is neither free nor taken: the stall is scored, its state is not.
    """

    stalls: FloatArray = field(repr=False)
    states: StateArray = field(repr=False)
    lots: tuple[FloatArray, ...] = field(default=(), repr=False)


@dataclass(frozen=True, slots=True)
class Finding:
    """Stalls that were found, in the same coordinates."""

    stalls: FloatArray = field(repr=False)
    states: StateArray = field(repr=False)


@dataclass(frozen=True, slots=True)
class Matches:
    """``found[k]`` is the same stall as ``true[k]``."""

    found: IndexArray
    true: IndexArray

    def __len__(self) -> int:
        return len(self.found)


@dataclass(frozen=True, slots=True)
class Tally:
    """Counts behind all measures, which are their ratios; the counts of several places add up with ``+``.

    ``counted``: false alarms in the starred measures. ``free_wrong``: free finds that match a taken label
    or are a counted false alarm. ``judged``: matches whose label is free or taken; ``agreed``: those
    with the right state.
    """

    matched: int = 0
    found: int = 0
    true: int = 0
    counted: int = 0
    whole_matched: int = 0
    whole: int = 0
    free_right: int = 0
    free_wrong: int = 0
    free_true: int = 0
    free_found: int = 0
    agreed: int = 0
    judged: int = 0
    unknown: int = 0

    def __add__(self, other: Tally) -> Tally:
        return Tally(*(getattr(self, name) + getattr(other, name) for name in self.__slots__))

    @property
    def precision(self) -> float:
        """Share of the found stalls that match a true one."""
        return _ratio(self.matched, self.found)

    @property
    def recall(self) -> float:
        """Share of the true stalls that were found."""
        return _ratio(self.matched, self.true)

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall."""
        return _ratio(2 * self.matched, self.found + self.true)

    @property
    def precision_star(self) -> float:
        """Matches over matches and counted false alarms."""
        return _ratio(self.matched, self.matched + self.counted)

    @property
    def recall_whole(self) -> float:
        """Recall of labels that show a whole stall."""
        return _ratio(self.whole_matched, self.whole)

    @property
    def free_precision_star(self) -> float:
        """Free finds that match a free label over those and the wrong ones."""
        return _ratio(self.free_right, self.free_right + self.free_wrong)

    @property
    def free_recall(self) -> float:
        """Share of the free labels that were found and called free; unknown is a miss."""
        return _ratio(self.free_right, self.free_true)

    @property
    def state_accuracy(self) -> float:
        """Share of the matches (of free or taken labels) with the right state; unknown is wrong."""
        return _ratio(self.agreed, self.judged)

    @property
    def unknown_share(self) -> float:
        """Share of the found stalls whose state is unknown; 0 when none was found."""
        return self.unknown / self.found if self.found else 0.0

    @property
    def free_count_error(self) -> int:
        """Absolute error of the number of free stalls."""
        return abs(self.free_found - self.free_true)

    def measures(self) -> dict[str, float]:
        """Return all measures by name."""
        names = (
            "precision recall f1 precision_star recall_whole free_precision_star free_recall state_accuracy "
            "unknown_share free_count_error"
        )
        return {name: float(getattr(self, name)) for name in names.split()}


def match(found: FloatArray, true: FloatArray) -> Matches:
    """Match quads (N, 4, 2) with quads (M, 4, 2), one to one, by rotated overlap of at least `MATCH_OVERLAP`."""
    none = Matches(np.zeros(0, np.intp), np.zeros(0, np.intp))
    if not len(found) or not len(true):
        return none
    first, second = _polygons(found), _polygons(true)
    i, j = shapely.STRtree(second).query(first, predicate="intersects")
    # the grid makes GEOS robust: without it two rectangles that share a side, but for rounding, can match
    shared = shapely.area(shapely.intersection(first[i], second[j], grid_size=_GRID_M))
    overlap = shared / (shapely.area(first[i]) + shapely.area(second[j]) - shared)
    good = overlap >= MATCH_OVERLAP
    table = np.zeros((len(found), len(true)))
    table[i[good], j[good]] = 1 + overlap[good]  # the 1 prefers more matches over better ones
    rows, columns = linear_sum_assignment(table, maximize=True)
    real = table[rows, columns] > 0
    return Matches(rows[real], columns[real])


def tally(finding: Finding, truth: LabelledPlace) -> Tally:
    """Return the counts of a finding against the labels."""
    matches = match(finding.stalls, truth.stalls)
    counted = counted_false_alarms(finding.stalls, matches, truth)
    found_states, true_states = np.asarray(finding.states, object), np.asarray(truth.states, object)
    said, real = found_states[matches.found], true_states[matches.true]
    free_found = found_states == StallState.FREE
    whole = is_whole(truth.stalls)
    judged = (real == StallState.FREE) | (real == StallState.TAKEN)
    return Tally(
        matched=len(matches),
        found=len(finding.stalls),
        true=len(truth.stalls),
        counted=int(counted.sum()),
        whole_matched=int(whole[matches.true].sum()),
        whole=int(whole.sum()),
        free_right=int(((said == StallState.FREE) & (real == StallState.FREE)).sum()),
        free_wrong=int(((said == StallState.FREE) & (real == StallState.TAKEN)).sum() + (counted & free_found).sum()),
        free_true=int((true_states == StallState.FREE).sum()),
        free_found=int(free_found.sum()),
        agreed=int((judged & (said == real)).sum()),
        judged=int(judged.sum()),
        unknown=int((found_states == StallState.UNKNOWN).sum()),
    )


def counted_false_alarms(found: FloatArray, matches: Matches, truth: LabelledPlace) -> NDArray[np.bool_]:
    """Return a mask (N,) of counted false alarms: unmatched, and near a labelled stall or outside the lots."""
    alarm = np.ones(len(found), np.bool_)
    alarm[matches.found] = False
    if not alarm.any():
        return alarm
    middle = shapely.points(found.mean(axis=1))
    near = np.zeros(len(found), np.bool_)
    if len(truth.stalls):
        near = np.asarray(shapely.distance(middle, shapely.union_all(_polygons(truth.stalls))) <= NEAR_M)
    inside = np.asarray(shapely.covers(lot_area(truth.lots), middle))
    return np.asarray(alarm & (near | ~inside))


def is_whole(stalls: FloatArray) -> NDArray[np.bool_]:
    """Return a mask (N,) of labels (N, 4, 2) of whole stalls, by the sides of the smallest rectangle around each."""
    if not len(stalls):
        return np.zeros(0, np.bool_)
    boxes = shapely.get_coordinates(shapely.minimum_rotated_rectangle(_polygons(stalls))).reshape(-1, 5, 2)
    sides = np.sort(np.hypot(*np.moveaxis(boxes[:, 1:3] - boxes[:, :2], -1, 0)), axis=1)
    short, long = sides.T
    return np.asarray((short >= WHOLE_WIDTH_M) & (long >= WHOLE_LENGTH_M) & (long >= WHOLE_RATIO * short))


def lot_area(lots: Sequence[FloatArray]) -> Any:
    """Return the union of outlines (M, 2) as a shapely geometry; empty without any."""
    return shapely.union_all([shapely.make_valid(shapely.Polygon(lot)) for lot in lots])


def mask_iou(found: NDArray[np.bool_], true: NDArray[np.bool_]) -> float:
    """Return the intersection over union of two masks of one raster; NaN when both are empty."""
    return _ratio(float((found & true).sum()), float((found | true).sum()))


def _polygons(quads: FloatArray) -> NDArray[Any]:
    return np.asarray(shapely.convex_hull(shapely.polygons(np.asarray(quads, np.float64))))


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole else float("nan")
