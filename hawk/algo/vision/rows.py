"""Completes rows of stalls: stalls side by side share direction, length and pitch, so that each row is a lattice.

A lattice is fitted to every row; its members are moved onto it, gaps and ends are filled where there is evidence. It
is a pure function of arrays, for one frame's stalls as for those of a whole map. Coordinates are any metric ones in
which a direction is (cos angle, sin angle): (north, east) on the map.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from hawk.algo.vision import quads
from hawk.algo.vision.seen import FloatArray

Evidence = Callable[[FloatArray], FloatArray]
"""Takes quads (M, 4, 2) and returns the mean core probability (M,) in their inner part, 0 where nothing was seen."""

_SAME_DIRECTION = 0.14
_SHORT_ROW = 3
_PITCH_M = (1.8, 4.2)
_LATTICE_ERROR_M = 0.3
_STRAIGHT_M = 0.6
_OVERLAP_LIMIT = 0.3
_TOUCH_LIMIT = 0.25


@dataclass(frozen=True, slots=True)
class RowOptions:
    """``gap`` and ``end``: least evidence to fill a hole within a row and to go on past its end (ends need more, or
    hatched bays fill up). ``maximum_gap`` stalls in one hole, ``maximum_end`` past an end. Stalls without company below
    ``lone_score`` are dropped."""

    gap: float = 0.20
    end: float = 0.50
    maximum_gap: int = 6
    maximum_end: int = 2
    lone_score: float = 0.6


@dataclass(frozen=True, slots=True)
class RowStalls:
    """Stalls as arrays of length N: metres and radians. ``source`` is the index of the given stall, -1 for one that was
    inferred from its row."""

    north: FloatArray = field(repr=False)
    east: FloatArray = field(repr=False)
    angle: FloatArray = field(repr=False)
    width: FloatArray = field(repr=False)
    length: FloatArray = field(repr=False)
    score: FloatArray = field(repr=False)
    source: NDArray[np.intp] = field(repr=False)

    def __len__(self) -> int:
        return len(self.score)

    def __getitem__(self, which: Any) -> RowStalls:
        return RowStalls(**{f.name: getattr(self, f.name)[which] for f in fields(self)})

    @property
    def inferred(self) -> NDArray[np.bool_]:
        """Which were inferred from their row, (N,)."""
        return self.source < 0

    @property
    def centres(self) -> FloatArray:
        """Return (N, 2)."""
        return np.column_stack([self.north, self.east])

    def corners(self) -> FloatArray:
        """Return (N, 4, 2) of (north, east)."""
        return quads.corners(self.north, self.east, self.angle, self.width, self.length)


def row_stalls(
    north: FloatArray, east: FloatArray, angle: FloatArray, width: FloatArray, length: FloatArray, score: FloatArray
) -> RowStalls:
    """Return arrays (N,) as `RowStalls`."""
    n, e, a, w, length_, s = (np.asarray(v, np.float64).reshape(-1) for v in (north, east, angle, width, length, score))
    return RowStalls(n, e, a, w, length_, s, np.arange(len(n), dtype=np.intp))


def complete_rows(stalls: RowStalls, evidence: Evidence, options: RowOptions | None = None) -> RowStalls:
    """Return the stalls moved onto their rows' lattices, together with those that the rows imply.

    Order: given ones first, as given; of those that come to overlap the better one stays.
    """
    options = options or RowOptions()
    if not len(stalls):
        return stalls
    group = row_of(stalls)
    size = np.bincount(group)
    needed = np.where(size == 1, options.lone_score, np.where(size == 2, options.lone_score * 0.75, 0.0))
    kept = (size[group] >= _SHORT_ROW) | (stalls.score >= needed[group])
    snapped, lattices = stalls, []
    for row in np.flatnonzero(size >= _SHORT_ROW):
        members = np.flatnonzero(group == row)
        for lattice in _lattices(stalls[members], members, options):
            snapped = lattice.snap(snapped)
            lattices.append(lattice)
    inferred = _infer(lattices, evidence, options)
    result = snapped[kept]
    result = result[quads.suppress(result.corners(), result.score, _OVERLAP_LIMIT)]
    inferred = inferred[quads.suppress(inferred.corners(), inferred.score, _TOUCH_LIMIT)]
    return _join(result, inferred[_is_clear(inferred, result)])


def row_of(stalls: RowStalls) -> NDArray[np.intp]:
    """Return the number of each stall's row, (N,): neighbours side by side, alike in direction and length.

    In angled rows a neighbour is also shifted along the stall; what next neighbours show of that shift is expected of
    those beyond a gap, too.
    """
    count = len(stalls)
    i, j = quads.near_pairs(stalls.centres, stalls.centres, 6.5 * float(stalls.width.max()))
    offset = stalls.centres[j] - stalls.centres[i]
    across = quads.cross(stalls.angle[i], offset)
    along = offset[:, 0] * np.cos(stalls.angle[i]) + offset[:, 1] * np.sin(stalls.angle[i])
    width = (stalls.width[i] + stalls.width[j]) / 2
    alike = (
        (quads.angle_between(stalls.angle[i], stalls.angle[j]) < _SAME_DIRECTION)
        & (np.abs(across) > 0.6 * width)
        & (np.abs(stalls.length[i] - stalls.length[j]) < 0.35 * stalls.length[i])
    )
    beside = alike & (np.abs(across) < 1.4 * width) & (np.abs(along) < 0.75 * stalls.length[i])
    lean = _mean_by(i[beside], along[beside] / across[beside], count)
    expected = np.where(np.isnan(lean[i]), lean[j], lean[i])
    straight = np.abs(along - np.nan_to_num(expected) * across) < 0.3 * stalls.length[i]
    together = beside | (alike & straight & (np.abs(across) < 4.4 * width))
    links = coo_array((np.ones(int(together.sum())), (i[together], j[together])), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1], np.intp)


def _mean_by(owner: NDArray[np.intp], values: FloatArray, count: int) -> FloatArray:
    """Return the mean of each owner's values, (count,), NaN without any."""
    number = np.bincount(owner, minlength=count)
    total = np.bincount(owner, values, count)
    return np.asarray(np.divide(total, number, out=np.full(count, np.nan), where=number > 0))


@dataclass(frozen=True, slots=True)
class _Lattice:
    """A row's lattice: stall k has its centre at ``origin + along * t + aside * offset(t)``, t = first + pitch * k."""

    origin: FloatArray
    along: FloatArray
    aside: FloatArray
    first: float
    pitch: float
    offset: FloatArray  # polynomial of t, for np.polyval
    angle: float
    width: float
    length: float
    members: NDArray[np.intp]
    places: NDArray[np.intp]

    def centres(self, k: NDArray[Any]) -> FloatArray:
        t = self.first + self.pitch * np.asarray(k, float)
        return self.origin + np.outer(t, self.along) + np.outer(np.polyval(self.offset, t), self.aside)

    def stalls(self, k: NDArray[Any], score: float) -> RowStalls:
        centre, ones = self.centres(k), np.ones(len(k))
        return RowStalls(
            centre[:, 0],
            centre[:, 1],
            self.angle * ones,
            self.width * ones,
            self.length * ones,
            score * ones,
            np.full(len(k), -1, np.intp),
        )

    def snap(self, stalls: RowStalls) -> RowStalls:
        """Move the members that lie near their place onto it."""
        to = self.centres(self.places)
        near = np.hypot(*(to - stalls.centres[self.members]).T) < 0.8
        members = self.members[near]
        north, east = stalls.north.copy(), stalls.east.copy()
        north[members], east[members] = to[near].T
        angle, width, length = stalls.angle.copy(), stalls.width.copy(), stalls.length.copy()
        angle[members], width[members], length[members] = self.angle, self.width, self.length
        return RowStalls(north, east, angle, width, length, stalls.score, stalls.source)


def _lattices(row: RowStalls, index: NDArray[np.intp], options: RowOptions) -> list[_Lattice]:
    """Fit lattices to the stalls of one row; a row with a break in its rhythm gives several, a crooked one none."""
    origin = row.centres.mean(axis=0)
    _, _, axes = np.linalg.svd(row.centres - origin)
    along, aside = axes[0], axes[1]
    angle = float(np.angle(np.exp(2j * row.angle).sum()) / 2 % np.pi)
    lean = abs(float(quads.cross(np.array(angle), along)))  # sine of the angle between row and stalls
    residual = (row.centres - origin) @ aside
    if lean < 0.6 or float(np.abs(residual).std()) > _STRAIGHT_M:
        return []
    order = np.argsort((row.centres - origin) @ along, kind="stable")
    t = ((row.centres - origin) @ along)[order]
    pitch = _pitch(t, float(np.median(row.width)) / lean)
    length = float(np.median(row.length))
    fitted = []
    for part, places in _runs(t, pitch, options.maximum_gap):
        chosen = order[part]
        line = _fit(t[part], places, row.score[chosen])
        if line is None or not _PITCH_M[0] < line[1] * lean < _PITCH_M[1]:
            continue
        offset = _offset(t[part], residual[chosen], row.score[chosen])
        fitted.append(
            _Lattice(
                origin, along, aside, line[0], line[1], offset, angle, line[1] * lean, length, index[chosen], places
            )
        )
    return fitted


def _pitch(t: FloatArray, guess: float) -> float:
    """Return the usual distance of neighbours, near the guess."""
    gaps = np.diff(t)
    usual = gaps[(gaps > 0.75 * guess) & (gaps < 1.3 * guess)]
    return float(np.median(usual)) if len(usual) >= 2 else guess


def _runs(t: FloatArray, pitch: float, maximum_gap: int) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Split sorted places where the rhythm breaks; returns (indices, lattice numbers) of runs of three or more."""
    steps = np.diff(t) / pitch
    whole = np.maximum(np.rint(steps), 1)
    broken = (np.abs(steps - whole) > 0.28 + 0.03 * whole) | (whole > maximum_gap + 1)
    run = np.concatenate([[0], np.cumsum(broken)])
    number = np.concatenate([[0], np.cumsum(np.where(broken, 0, whole))]).astype(np.intp)
    parts = [np.flatnonzero(run == r) for r in range(int(run[-1]) + 1)]
    return [(part, number[part] - number[part[0]]) for part in parts if len(part) >= _SHORT_ROW]


def _fit(t: FloatArray, places: NDArray[np.intp], score: FloatArray) -> tuple[float, float] | None:
    """Return first and pitch by robust least squares (Cauchy weights), None when the places do not fit a lattice."""
    design = np.column_stack([np.ones(len(t)), places])
    weight: FloatArray = score
    solution: FloatArray = np.zeros(2)
    for _ in range(3):
        solution = np.asarray(np.linalg.lstsq(design * weight[:, None], t * weight, rcond=None)[0], np.float64)
        weight = np.asarray(score / (1 + ((t - design @ solution) / 0.25) ** 2))
    if float(np.median(np.abs(t - design @ solution))) > _LATTICE_ERROR_M or solution[1] <= 0:
        return None
    return float(solution[0]), float(solution[1])


def _offset(t: FloatArray, residual: FloatArray, score: FloatArray) -> FloatArray:
    if len(t) <= _SHORT_ROW:
        return np.array([0.0, float(np.median(residual))])
    return np.asarray(np.polyfit(t, residual, 1, w=np.maximum(score, 1e-3)))


def _infer(lattices: list[_Lattice], evidence: Evidence, options: RowOptions) -> RowStalls:
    """Return the stalls that the lattices imply and the evidence bears out."""
    empty = np.zeros(0)
    result = row_stalls(empty, empty, empty, empty, empty, empty)
    wanted: list[tuple[RowStalls, float, float, bool]] = []
    for lattice in lattices:
        last = int(lattice.places.max())
        gaps = np.setdiff1d(np.arange(last + 1), lattice.places)
        steps = np.arange(1, options.maximum_end + 1)
        wanted.append((lattice.stalls(gaps, 0.3), options.gap, 0.3, False))
        wanted.extend((lattice.stalls(k, 0.25), options.end, 0.3, True) for k in (-steps, last + steps))
    if not wanted:
        return result
    says = np.asarray(evidence(np.concatenate([w[0].corners() for w in wanted])), np.float64)
    at = 0
    for stalls, least, gain, in_turn in wanted:
        said = says[at : at + len(stalls)]
        at += len(stalls)
        good = said >= least
        if in_turn:
            good = np.logical_and.accumulate(good)
        scored = replace(stalls, score=stalls.score + gain * said)
        result = _join(result, scored[good])
    return result


def _is_clear(candidates: RowStalls, stalls: RowStalls) -> NDArray[np.bool_]:
    """Return which candidates hardly overlap any stall, (M,)."""
    clear = np.ones(len(candidates), np.bool_)
    if not len(candidates) or not len(stalls):
        return clear
    reach = float(max(candidates.length.max(), stalls.length.max())) * 1.2
    i, j = quads.near_pairs(candidates.centres, stalls.centres, reach)
    touching = quads.overlaps(candidates.corners()[i], stalls.corners()[j]) > _TOUCH_LIMIT
    clear[i[touching]] = False
    return clear


def _join(first: RowStalls, second: RowStalls) -> RowStalls:
    joined = {f.name: np.concatenate([getattr(first, f.name), getattr(second, f.name)]) for f in fields(first)}
    return RowStalls(**joined)
