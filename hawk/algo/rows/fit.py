"""Lines of rows, fitted to found stalls: side by side, of one direction, one length and one pitch.

A row is a line or a flat arc. Coordinates are any metric ones in which a direction is (cos angle, sin angle):
(north, east) on the map.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from hawk.algo.frame import Steps, outcome
from hawk.algo.vision import quads
from hawk.algo.vision.detection import FloatArray

Indices = NDArray[np.intp]

WIDTH_M: Final = (1.7, 4.6)
"""Widths of the stalls of a row, metres."""
_SAME_DIRECTION: Final = 0.14
_LEAST_LEAN: Final = 0.55
"""Sine of the angle between a row and its stalls: stalls more slanted than this stand one behind the other."""
_ROBUST_M: Final = 0.35
_ROUNDS: Final = 4
_OUT_OF_LINE_M: Final = 0.9
_ARC: Final = (6, 12.0, 0.5, 0.6)
"""A row is an arc with this many stalls over this many metres, when it is bent by this many metres, and when that takes
this share of the distances from a line, or less, to remain.
"""
_LEAST_TO_SPLIT: Final = 4
_WHOLE_STEPS: Final = 6
_LONGEST_GAP_M: Final = 14.0
_SAME_LENGTH, _SAME_PITCH = 0.2, 0.09
_GROUPS_A_STEP: Final = 3


@dataclass(frozen=True, slots=True)
class Rectangles:
    """Stalls as arrays of length N: metres and radians, ``centres`` (N, 2)."""

    centres: FloatArray = field(repr=False)
    angle: FloatArray = field(repr=False)
    width: FloatArray = field(repr=False)
    length: FloatArray = field(repr=False)

    def __len__(self) -> int:
        return len(self.angle)

    def __getitem__(self, which: Any) -> Self:
        return type(self)(*(getattr(self, f.name)[which] for f in fields(self)))

    def corners(self) -> FloatArray:
        """Return (N, 4, 2)."""
        x, y = self.centres.T
        return quads.corners(x, y, self.angle, self.width, self.length)


@dataclass(frozen=True, slots=True)
class Finds(Rectangles):
    """Found stalls; ``score`` (N,) 0..1."""

    score: FloatArray = field(repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class Row:
    """One row. The centre of a stall at ``t`` metres along it is ``origin + along t + aside bend t^2``.

    ``along`` and ``aside`` (a quarter turn on) are unit vectors, ``side`` is the direction of the stalls' long side at
    the origin; it turns with the arc. ``pitch`` is measured along the row, ``width`` across a stall. The finds
    ``members`` lie from ``low`` to ``high``.
    """

    origin: FloatArray = field(repr=False)
    along: FloatArray = field(repr=False)
    side: FloatArray = field(repr=False)
    bend: float
    pitch: float
    width: float
    length: float
    low: float
    high: float
    members: Indices = field(repr=False)

    @property
    def aside(self) -> FloatArray:
        """Unit vector (2,), a quarter turn from ``along``."""
        return np.array([-self.along[1], self.along[0]])

    @property
    def angle(self) -> float:
        """Direction of the stalls at the origin, [0, pi)."""
        return float(np.arctan2(self.side[1], self.side[0]) % np.pi)

    def centres(self, t: FloatArray) -> FloatArray:
        """Return the centres (N, 2) at ``t`` (N,)."""
        return np.asarray(self.origin + t[:, None] * self.along + (self.bend * t * t)[:, None] * self.aside)

    def sides(self, t: FloatArray) -> FloatArray:
        """Return the directions (N, 2) of the stalls' long sides at ``t`` (N,)."""
        turn = np.arctan(2 * self.bend * t)
        cos, sin = np.cos(turn), np.sin(turn)
        return np.column_stack([cos * self.side[0] - sin * self.side[1], sin * self.side[0] + cos * self.side[1]])

    def place(self, centres: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return where centres (N, 2) lie: metres along the row, and metres aside of it, both (N,)."""
        offset = centres - self.origin
        t = offset @ self.along
        return t, np.asarray(offset @ self.aside - self.bend * t * t)


def fit_rows(finds: Finds, least_score: float) -> list[Row]:
    """Return the rows of the finds with at least this score; parts of one row are joined, the longest row first."""
    return outcome(fit(finds, least_score))


def fit(finds: Finds, least_score: float) -> Steps[list[Row]]:
    """Do the work of `fit_rows` in steps of a few milliseconds."""
    used = np.flatnonzero(finds.score >= least_score)
    if not len(used):
        return []
    group = row_of(finds[used])
    rows: list[Row] = []
    for number in range(int(group.max()) + 1):
        if number % _GROUPS_A_STEP == 0:
            yield
        rows.extend(_rows_of(finds, used[group == number]))
    yield
    return _joined(rows, finds)


def _rows_of(finds: Finds, members: Indices) -> list[Row]:
    """Return the rows of neighbours: angled rows that interlock are neighbours of each other.

    A group that is no one row is parted into lines, each the one through two neighbours that most of the finds lie on
    (Fischler and Bolles 1981).
    """
    rows: list[Row | None] = []
    while len(members):
        row = fit_row(finds, members)
        is_one = row is not None and np.abs(row.place(finds.centres[members])[1]).max() < _OUT_OF_LINE_M
        is_whole = is_one or len(members) < _LEAST_TO_SPLIT
        on_it = np.zeros(0, np.intp) if is_whole else _best_line(finds[members])
        if len(on_it) in (0, len(members)):
            rows.append(row)
            break
        rows.append(fit_row(finds, members[on_it]))
        members = np.delete(members, on_it)
    return [row for row in rows if row is not None]


def _best_line(finds: Finds) -> Indices:
    """Return the finds (K,) of the line through two neighbours that has most of them, none without neighbours."""
    pairs = cKDTree(finds.centres).query_pairs(1.7 * float(np.median(finds.width)) + 1.0, output_type="ndarray")
    if not len(pairs):
        return np.zeros(0, np.intp)
    origin = finds.centres[pairs[:, 0]]
    step = finds.centres[pairs[:, 1]] - origin
    along = step / np.maximum(np.hypot(*step.T), 1e-6)[:, None]
    side = np.column_stack([np.cos(finds.angle[pairs[:, 0]]), np.sin(finds.angle[pairs[:, 0]])])
    lean = np.abs(side[:, 1] * along[:, 0] - side[:, 0] * along[:, 1])
    offset = finds.centres[None] - origin[:, None]
    aside = np.abs(offset[..., 1] * along[:, None, 0] - offset[..., 0] * along[:, None, 1])
    on_it = (aside < _OUT_OF_LINE_M) & (lean >= _LEAST_LEAN)[:, None]
    best = int((on_it * finds.score * (1 - aside / (2 * _OUT_OF_LINE_M))).sum(axis=1).argmax())
    return np.flatnonzero(on_it[best])


def row_of(finds: Finds) -> Indices:
    """Return the number of each find's row, (N,): neighbours side by side, alike in direction and length.

    In angled rows a neighbour is also shifted along the stall; what next neighbours show of that shift is expected of
    those beyond a gap, too.
    """
    count = len(finds)
    pairs = cKDTree(finds.centres).query_pairs(6.5 * float(finds.width.max()), output_type="ndarray")
    i, j = pairs.T
    pairs = pairs[
        (quads.angle_between(finds.angle[i], finds.angle[j]) < _SAME_DIRECTION)
        & (np.abs(finds.length[i] - finds.length[j]) < 0.35 * np.maximum(finds.length[i], finds.length[j]))
    ]
    i, j = np.concatenate([pairs, pairs[:, ::-1]]).T
    offset = finds.centres[j] - finds.centres[i]
    across = quads.cross(finds.angle[i], offset)
    along = offset[:, 0] * np.cos(finds.angle[i]) + offset[:, 1] * np.sin(finds.angle[i])
    width = (finds.width[i] + finds.width[j]) / 2
    apart = np.abs(across) > 0.6 * width
    beside = apart & (np.abs(across) < 1.4 * width) & (np.abs(along) < 0.75 * finds.length[i])
    lean = _mean_by(i[beside], along[beside] / across[beside], count)
    expected = np.where(np.isnan(lean[i]), lean[j], lean[i])
    straight = np.abs(along - np.nan_to_num(expected) * across) < 0.3 * finds.length[i]
    together = beside | (apart & straight & (np.abs(across) < 4.4 * width))
    links = coo_array((np.ones(int(together.sum())), (i[together], j[together])), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1], np.intp)


def fit_row(finds: Finds, members: Indices) -> Row | None:
    """Return the row through these finds, None where they make none."""
    some = finds[members]
    weight = np.maximum(some.score, 0.05)
    double = 2 * some.angle
    angle = float(np.arctan2(weight @ np.sin(double), weight @ np.cos(double)) / 2)
    side = np.array([np.cos(angle), np.sin(angle)])
    width, length = _median(some.width, weight), _median(some.length, weight)
    origin, along = _line(some.centres, weight, side)
    lean = abs(float(side @ (-along[1], along[0])))
    if lean < _LEAST_LEAN:
        return None
    offset = some.centres - origin
    t, aside = offset @ along, offset @ (-along[1], along[0])
    if len(members) > 2 and np.count_nonzero(np.abs(aside) < _OUT_OF_LINE_M) < 2:
        return None
    bend, shift = _bend(t, aside, weight)
    origin = origin + shift * np.array([-along[1], along[0]])
    order = np.argsort(t)
    pitch = _pitch(t[order], width / lean)
    if not WIDTH_M[0] < pitch * lean < WIDTH_M[1]:
        return None
    low, high = float(t.min()), float(t.max())
    return Row(origin, along, side, bend, pitch, pitch * lean, length, low, high, members[order])


def _line(centres: FloatArray, weight: FloatArray, side: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return origin and direction of the line through centres (N, 2), robustly; of one or two by the stalls' sides."""
    across = np.array([-side[1], side[0]])
    origin, along = np.average(centres, axis=0, weights=weight), across
    if len(centres) == 2:
        step = centres[1] - centres[0]
        size = float(np.hypot(*step))
        along = step / size if abs(float(step @ across)) > 0.75 * size else across
    elif len(centres) > 2:
        kept = weight
        for _ in range(_ROUNDS):
            origin = np.average(centres, axis=0, weights=kept)
            x, y = (centres - origin).T
            axis = np.arctan2(2 * (kept @ (x * y)), kept @ (x * x - y * y)) / 2
            along = np.array([np.cos(axis), np.sin(axis)])
            kept = weight / (1 + (((centres - origin) @ (-along[1], along[0])) / _ROBUST_M) ** 2)
    return origin, along if along @ across >= 0 else -along


def _bend(t: FloatArray, aside: FloatArray, weight: FloatArray) -> tuple[float, float]:
    """Return the bend of an arc through places along and aside of a line (N,), and its distance from the line's origin;
    0 and 0 for a line.
    """
    least, reach, sag, share = _ARC
    half = float(np.ptp(t)) / 2
    if len(t) < least or 2 * half < reach:
        return 0.0, 0.0
    w = np.sqrt(weight) / (1 + (aside / 0.5) ** 2)
    terms = np.column_stack([np.ones_like(t), t, t * t])
    found = np.linalg.lstsq(terms * w[:, None], aside * w, rcond=None)[0]
    left = np.median(np.abs(aside - terms @ found))
    is_arc = abs(found[2]) * half**2 > sag and left < share * np.median(np.abs(aside))
    return (float(found[2]), float(found[0])) if is_arc else (0.0, 0.0)


def _pitch(t: FloatArray, guess: float) -> float:
    """Return the pitch of sorted places (N,) along a row: that of neighbours, refined over runs of whole steps."""
    step = np.diff(t)
    usual = step[(step > 0.72 * guess) & (step < 1.35 * guess)]
    if not len(usual):
        return guess
    pitch = float(np.median(usual))
    whole = np.rint(step / pitch)
    broken = (np.abs(step / pitch - whole) > 0.3) | (whole < 1) | (whole > _WHOLE_STEPS)
    run = np.concatenate([[0], np.cumsum(broken)])
    number = np.concatenate([[0], np.cumsum(np.where(broken, 0, whole))])
    count = np.bincount(run)
    k, place = (v - (np.bincount(run, v) / count)[run] for v in (number, t))
    many = count[run] > 2
    spread = float((k[many] ** 2).sum())
    refined = float((k * place)[many].sum()) / spread if spread else pitch
    return refined if abs(refined / pitch - 1) < 0.12 else pitch


def _joined(rows: list[Row], finds: Finds) -> list[Row]:
    """Join rows that go on in one line with one pitch."""
    rows = sorted(rows, key=lambda row: -len(row.members))
    k = 0
    while k < len(rows):
        for j in range(k + 1, len(rows)):
            if not _goes_on(rows[k], rows[j], finds):
                continue
            whole = fit_row(finds, np.concatenate([rows[k].members, rows[j].members]))
            if whole is not None:
                rows[k] = whole
                del rows[j]
                break
        else:
            k += 1
    return rows


def _goes_on(row: Row, other: Row, finds: Finds) -> bool:
    if len(row.members) < 3 or float(quads.angle_between(row.angle, other.angle)) > 0.12:
        return False
    if abs(row.length - other.length) > _SAME_LENGTH * max(row.length, other.length):
        return False
    if len(other.members) > 2 and abs(row.pitch / other.pitch - 1) > _SAME_PITCH:
        return False
    t, aside = row.place(finds.centres[other.members])
    gap = max(float(t.min()) - row.high, row.low - float(t.max()))
    return bool(np.abs(aside).max() < _OUT_OF_LINE_M and 0.5 * row.pitch < gap < _LONGEST_GAP_M)


def _median(values: FloatArray, weight: FloatArray) -> float:
    order = np.argsort(values)
    total = np.cumsum(weight[order])
    return float(values[order][np.searchsorted(total, total[-1] / 2)])


def _mean_by(owner: Indices, values: FloatArray, count: int) -> FloatArray:
    """Return the mean of each owner's values, (count,), NaN without any."""
    number = np.bincount(owner, minlength=count)
    total = np.bincount(owner, values, count)
    return np.asarray(np.divide(total, number, out=np.full(count, np.nan), where=number > 0))
