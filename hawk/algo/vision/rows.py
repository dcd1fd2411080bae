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
from scipy.spatial import cKDTree

from hawk.algo.vision import quads
from hawk.algo.vision.lattices import SHORT_ROW, Lattices, fit_lattices
from hawk.algo.vision.seen import FloatArray

Evidence = Callable[[FloatArray], FloatArray]
"""Takes quads (M, 4, 2) and returns the mean core probability (M,) in their inner part, 0 where nothing was seen."""

_SAME_DIRECTION = 0.14
_NEAR_PLACE_M = 0.8
_GAP_SCORE, _END_SCORE, _SAID_SCORE = 0.3, 0.25, 0.3
_OVERLAP_LIMIT = 0.3
_TOUCH_LIMIT = 0.25


@dataclass(frozen=True, slots=True)
class RowOptions:
    """``gap`` and ``end``: least evidence to fill a hole within a row and to go on past its end (ends need more, or
    hatched bays fill up). ``maximum_gap`` stalls in one hole, ``maximum_end`` past an end. Stalls without company below
    ``lone_score`` are dropped.
    """

    gap: float = 0.20
    end: float = 0.50
    maximum_gap: int = 6
    maximum_end: int = 2
    lone_score: float = 0.6


@dataclass(frozen=True, slots=True)
class RowStalls:
    """Stalls as arrays of length N: metres and radians. ``source`` is the index of the given stall, -1 for one that was
    inferred from its row.
    """

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
    kept = (size[group] >= SHORT_ROW) | (stalls.score >= needed[group])
    lattices = fit_lattices(
        stalls.centres, stalls.angle, stalls.width, stalls.length, stalls.score, group, options.maximum_gap
    )
    snapped, inferred = _snap(stalls, lattices), _infer(lattices, evidence, options)
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
    pairs = cKDTree(stalls.centres).query_pairs(6.5 * float(stalls.width.max()), output_type="ndarray")
    i, j = pairs.T
    pairs = pairs[
        (quads.angle_between(stalls.angle[i], stalls.angle[j]) < _SAME_DIRECTION)
        & (np.abs(stalls.length[i] - stalls.length[j]) < 0.35 * np.maximum(stalls.length[i], stalls.length[j]))
    ]
    i, j = np.concatenate([pairs, pairs[:, ::-1]]).T
    offset = stalls.centres[j] - stalls.centres[i]
    across = quads.cross(stalls.angle[i], offset)
    along = offset[:, 0] * np.cos(stalls.angle[i]) + offset[:, 1] * np.sin(stalls.angle[i])
    width = (stalls.width[i] + stalls.width[j]) / 2
    apart = np.abs(across) > 0.6 * width
    beside = apart & (np.abs(across) < 1.4 * width) & (np.abs(along) < 0.75 * stalls.length[i])
    lean = _mean_by(i[beside], along[beside] / across[beside], count)
    expected = np.where(np.isnan(lean[i]), lean[j], lean[i])
    straight = np.abs(along - np.nan_to_num(expected) * across) < 0.3 * stalls.length[i]
    together = beside | (apart & straight & (np.abs(across) < 4.4 * width))
    links = coo_array((np.ones(int(together.sum())), (i[together], j[together])), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1], np.intp)


def _mean_by(owner: NDArray[np.intp], values: FloatArray, count: int) -> FloatArray:
    """Return the mean of each owner's values, (count,), NaN without any."""
    number = np.bincount(owner, minlength=count)
    total = np.bincount(owner, values, count)
    return np.asarray(np.divide(total, number, out=np.full(count, np.nan), where=number > 0))


def _snap(stalls: RowStalls, lattices: Lattices) -> RowStalls:
    """Move the members that lie near their place on a lattice onto it."""
    to = lattices.centres(lattices.owner, lattices.place)
    near = np.hypot(*(to - stalls.centres[lattices.member]).T) < _NEAR_PLACE_M
    member, owner = lattices.member[near], lattices.owner[near]
    north, east, angle, width, length = (
        v.copy() for v in (stalls.north, stalls.east, stalls.angle, stalls.width, stalls.length)
    )
    north[member], east[member] = to[near].T
    angle[member], width[member], length[member] = lattices.angle[owner], lattices.width[owner], lattices.length[owner]
    return RowStalls(north, east, angle, width, length, stalls.score, stalls.source)


def _infer(lattices: Lattices, evidence: Evidence, options: RowOptions) -> RowStalls:
    """Return the stalls that the lattices imply and the evidence bears out."""
    owner, k, step = _implied(lattices, options.maximum_end)
    centre = lattices.centres(owner, k)
    implied = RowStalls(
        centre[:, 0],
        centre[:, 1],
        lattices.angle[owner],
        lattices.width[owner],
        lattices.length[owner],
        np.where(step > 0, _END_SCORE, _GAP_SCORE),
        np.full(len(k), -1, np.intp),
    )
    if not len(implied):
        return implied
    says = np.asarray(evidence(implied.corners()), np.float64)
    good = says >= np.where(step > 0, options.end, options.gap)
    ends = np.flatnonzero(step)  # an end goes on only where it has not stopped before
    good[ends] = np.logical_and.accumulate(good[ends].reshape(2 * len(lattices), options.maximum_end), axis=1).ravel()
    return replace(implied, score=implied.score + _SAID_SCORE * says)[good]


def _implied(lattices: Lattices, maximum_end: int) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Return lattice and number of the holes of each lattice and of what would follow at its ends, and how many steps
    past the end that is (0 in a hole); the ``maximum_end`` of one end follow each other.
    """
    count, size = len(lattices), lattices.last + 1
    start = np.cumsum(size) - size
    is_hole = np.ones(int(size.sum()), np.bool_)
    is_hole[start[lattices.owner] + lattices.place] = False
    holes = np.flatnonzero(is_hole)
    owner = np.searchsorted(start, holes, side="right") - 1
    steps = np.arange(1, maximum_end + 1)
    ends = np.stack([np.broadcast_to(-steps, (count, maximum_end)), lattices.last[:, None] + steps], axis=1)
    return (
        np.concatenate([owner, np.repeat(np.arange(count), 2 * maximum_end)]).astype(np.intp),
        np.concatenate([holes - start[owner], ends.ravel()]).astype(np.intp),
        np.concatenate([np.zeros(len(holes), np.intp), np.tile(steps, 2 * count)]).astype(np.intp),
    )


def _is_clear(candidates: RowStalls, stalls: RowStalls) -> NDArray[np.bool_]:
    """Return which candidates hardly overlap any stall, (M,)."""
    clear = np.ones(len(candidates), np.bool_)
    if not len(candidates) or not len(stalls):
        return clear
    reach = float(max(candidates.length.max(), stalls.length.max())) * 1.2
    i, j = quads.near_pairs(candidates.centres, stalls.centres, reach)
    touching = quads.overlap_more(candidates.corners()[i], stalls.corners()[j], _TOUCH_LIMIT)
    clear[i[touching]] = False
    return clear


def _join(first: RowStalls, second: RowStalls) -> RowStalls:
    joined = {f.name: np.concatenate([getattr(first, f.name), getattr(second, f.name)]) for f in fields(first)}
    return RowStalls(**joined)
