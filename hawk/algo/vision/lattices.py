"""Lattices of rows of stalls, fitted to all rows at once: stalls side by side share direction, length and pitch.

Arrays hold the members of all rows one after another; what is fitted by row is summed by row. Coordinates are any
metric ones in which a direction is (cos angle, sin angle).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision import quads
from hawk.algo.vision.seen import FloatArray

Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

SHORT_ROW = 3
"""Fewer stalls than these make no lattice."""
_PITCH_M = (1.8, 4.2)
_LATTICE_ERROR_M = 0.3
_STRAIGHT_M = 0.6
_LEAN = 0.6
_ROBUST_M = 0.25
_ROUNDS = 3


@dataclass(frozen=True, slots=True)
class Lattices:
    """L lattices. Stall k of one has its centre at ``origin + along * t + aside * (slope * t + shift)`` with
    t = first + pitch * k, ``aside`` a quarter turn from ``along``; its members have the numbers 0 to ``last``.

    ``origin`` and ``along`` are (L, 2), the other figures (L,). Of each member (M,): ``owner`` is its lattice,
    ``member`` its index among the given stalls, ``place`` its number.
    """

    origin: FloatArray = field(repr=False)
    along: FloatArray = field(repr=False)
    first: FloatArray = field(repr=False)
    pitch: FloatArray = field(repr=False)
    slope: FloatArray = field(repr=False)
    shift: FloatArray = field(repr=False)
    angle: FloatArray = field(repr=False)
    width: FloatArray = field(repr=False)
    length: FloatArray = field(repr=False)
    last: Indices = field(repr=False)
    owner: Indices = field(repr=False)
    member: Indices = field(repr=False)
    place: Indices = field(repr=False)

    def __len__(self) -> int:
        return len(self.pitch)

    def centres(self, which: Indices, k: Indices) -> FloatArray:
        """Return the centres (N, 2) of stalls ``k`` of lattices ``which``, both (N,)."""
        t = self.first[which] + self.pitch[which] * k
        offset = self.slope[which] * t + self.shift[which]
        along = self.along[which]
        aside = np.column_stack([-along[:, 1], along[:, 0]])
        return np.asarray(self.origin[which] + along * t[:, None] + aside * offset[:, None])


@dataclass(frozen=True, slots=True)
class _Rows:
    """Members (M,) sorted by row and along it; R rows."""

    row: Indices
    member: Indices
    t: FloatArray
    residual: FloatArray
    score: FloatArray
    origin: FloatArray
    along: FloatArray
    lean: FloatArray
    angle: FloatArray
    width: FloatArray
    length: FloatArray

    def take(self, which: Mask) -> _Rows:
        """Return the rows with some members only."""
        members = ("row", "member", "t", "residual", "score")
        return replace(self, **{name: getattr(self, name)[which] for name in members})


def fit_lattices(
    centres: FloatArray,
    angle: FloatArray,
    width: FloatArray,
    length: FloatArray,
    score: FloatArray,
    group: Indices,
    maximum_gap: int,
) -> Lattices:
    """Fit lattices to stalls (N,) by the number of their row ``group`` (N,).

    A row with a break in its rhythm (or a gap of more than ``maximum_gap`` stalls) gives several, a crooked one none.
    """
    member = np.flatnonzero(np.bincount(group)[group] >= SHORT_ROW)
    rows = _along_axis(centres, angle, width, length, score, group, member)
    return _fit(rows, *_runs(rows, maximum_gap))


def _along_axis(
    centres: FloatArray,
    angle: FloatArray,
    width: FloatArray,
    length: FloatArray,
    score: FloatArray,
    group: Indices,
    member: Indices,
) -> _Rows:
    """Sort the members of each row along its main axis; those of crooked rows are left out."""
    row = np.unique(group[member], return_inverse=True)[1].reshape(-1)
    count = int(row.max(initial=-1)) + 1
    size = np.maximum(np.bincount(row, minlength=count), 1)
    places = centres[member]
    origin = np.column_stack([np.bincount(row, places[:, k], count) / size for k in (0, 1)])
    x, y = (places - origin[row]).T
    xx, xy, yy = (np.bincount(row, v, count) for v in (x * x, x * y, y * y))
    axis = np.arctan2(2 * xy, xx - yy) / 2
    along = np.column_stack([np.cos(axis), np.sin(axis)])
    t = x * along[row, 0] + y * along[row, 1]
    residual = y * along[row, 0] - x * along[row, 1]
    double = 2 * angle[member]
    mean = np.arctan2(np.bincount(row, np.sin(double), count), np.bincount(row, np.cos(double), count)) / 2 % np.pi
    lean = np.abs(quads.cross(mean, along))  # sine of the angle between row and stalls
    straight = (lean >= _LEAN) & (np.sqrt(np.bincount(row, residual**2, count) / size) <= _STRAIGHT_M)
    rows = _Rows(
        row,
        member,
        t,
        residual,
        score[member],
        origin,
        along,
        lean,
        mean,
        _median_by(row, width[member], count),
        _median_by(row, length[member], count),
    )
    order = np.lexsort((t, row))
    return rows.take(order[straight[row[order]]])  # type: ignore[arg-type]


def _runs(rows: _Rows, maximum_gap: int) -> tuple[Indices, Indices]:
    """Split rows where the rhythm breaks; return each member's run and its number within it."""
    row, count = rows.row, len(rows.lean)
    step, same = np.diff(rows.t), row[1:] == row[:-1]
    owner = row[1:]
    guess = rows.width / np.maximum(rows.lean, _LEAN)
    usual = same & (step > 0.75 * guess[owner]) & (step < 1.3 * guess[owner])
    known = np.bincount(owner[usual], minlength=count) >= 2
    pitch = np.where(known, _median_by(owner[usual], step[usual], count), guess)
    steps = step / pitch[owner]
    whole = np.maximum(np.rint(steps), 1)
    broken = ~same | (np.abs(steps - whole) > 0.28 + 0.03 * whole) | (whole > maximum_gap + 1)
    run = np.concatenate([[0], np.cumsum(broken)]).astype(np.intp)[: len(row)]
    number = np.concatenate([[0], np.cumsum(np.where(broken, 0, whole))]).astype(np.intp)[: len(row)]
    starts = np.flatnonzero(np.concatenate([[True], broken]))[: len(row)]
    return run, number - number[starts][run] if len(row) else number


def _fit(rows: _Rows, run: Indices, number: Indices) -> Lattices:
    """Fit first and pitch of every run of three or more; those that fit no lattice are left out."""
    long = np.bincount(run)[run] >= SHORT_ROW if len(run) else np.zeros(0, np.bool_)
    rows, number = rows.take(long), number[long]
    run = np.unique(run[long], return_inverse=True)[1].reshape(-1)
    count = int(run.max(initial=-1)) + 1
    size = np.bincount(run, minlength=count)
    of_row = rows.row[np.searchsorted(run, np.arange(count))]
    k = number.astype(np.float64)
    weight = rows.score
    for _ in range(_ROUNDS):
        first, pitch = _line_by(run, k, rows.t, weight, count)
        miss = rows.t - first[run] - pitch[run] * k
        weight = rows.score / (1 + (miss / _ROBUST_M) ** 2)
    slope, shift = _line_by(run, rows.t, rows.residual, np.maximum(rows.score, 1e-3), count)[::-1]
    short = size <= SHORT_ROW
    slope = np.where(short, 0.0, slope)
    shift = np.where(short, _median_by(run, rows.residual, count), shift)
    width = pitch * rows.lean[of_row]
    error = _median_by(run, np.abs(miss), count)
    good = (error <= _LATTICE_ERROR_M) & (pitch > 0) & (width > _PITCH_M[0]) & (width < _PITCH_M[1])
    renumbered, stays = np.cumsum(good) - 1, good[run]
    last = np.zeros(count, np.intp)
    np.maximum.at(last, run, number)
    return Lattices(
        origin=rows.origin[of_row][good],
        along=rows.along[of_row][good],
        first=first[good],
        pitch=pitch[good],
        slope=slope[good],
        shift=shift[good],
        angle=rows.angle[of_row][good],
        width=width[good],
        length=rows.length[of_row][good],
        last=last[good],
        owner=renumbered[run[stays]],
        member=rows.member[stays],
        place=number[stays],
    )


def _line_by(
    owner: Indices, x: FloatArray, y: FloatArray, weight: FloatArray, count: int
) -> tuple[FloatArray, FloatArray]:
    """Return value at x = 0 and slope (count,) of the lines that make each owner's sum of (weight * error)² least."""
    w = weight**2
    total = np.maximum(np.bincount(owner, w, count), 1e-300)
    mean_x, mean_y = (np.bincount(owner, w * v, count) / total for v in (x, y))
    dx, dy = x - mean_x[owner], y - mean_y[owner]
    slope = np.bincount(owner, w * dx * dy, count) / np.maximum(np.bincount(owner, w * dx * dx, count), 1e-300)
    return np.asarray(mean_y - slope * mean_x), np.asarray(slope)


def _median_by(owner: Indices, values: FloatArray, count: int) -> FloatArray:
    """Return each owner's median, (count,), NaN without any value."""
    size = np.bincount(owner, minlength=count)
    if not len(values):
        return np.full(count, np.nan)
    ordered = values[np.lexsort((values, owner))]
    start = np.cumsum(size) - size
    low, high = (np.minimum(start + at, len(values) - 1) for at in (np.maximum(size - 1, 0) // 2, size // 2))
    return np.where(size > 0, (ordered[low] + ordered[high]) / 2, np.nan)
