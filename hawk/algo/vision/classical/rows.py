"""Rows of strokes (side by side, equally long, at a stall's pitch) and the bays between their strokes.

Long strokes are split, hidden ones bridged, and rows go on past their ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from hawk.algo.vision.classical.strokes import Strokes, View
from hawk.algo.vision.decode import Stalls
from hawk.algo.vision.seen import FloatArray

_PITCHES_M = np.arange(2.2, 3.34, 0.04)
_MOST_STEPS = 4
_OFF_M = 0.3
_SAME_PITCH_M = 0.13
_ALIKE, _ALIKE_LEANING = 0.5, 0.25
"""Least share of their common extent in which two strokes lie side by side; next ones of an angled row share less, but
are equally long."""
_EQUAL = 0.2
_LEAST_SUPPORT = 0.55
_LEAST_LINES = 3
_MOST_PARTS = 4
_STEP_M = 0.2
_BEYOND_M = 4.0
_EDGE_SHARE = 0.5
_SINGLE_M = (2.6, 7.2)
_DOUBLE_M = (8.4, 13.0)
_USUAL_M = 5.2
_SHORT_M = 4.4
_PAST_END = 6
_INNER = (0.15, 0.85)
_SAMPLES = 12
_BETWEEN = (1 / 3, 1 / 2, 2 / 3)
_STRIPED = 0.6
_MOST_PAINT = 0.6
_MANY_LINES = 10
_SCORE: FloatArray = np.array([-0.26, 1.23, 2.45, -7.8, -0.59, 0.35, -2.25, -0.14, 1.12, 4.19, -2.24])
"""Logistic regression on the `score_features`, fitted to drawn lots (`training.fit_classical`)."""


@dataclass(frozen=True, slots=True)
class Row:
    """Strokes k at u = ``first`` + ``pitch`` * k + ``slope`` * v, ends along at ``low``.. ``high`` + ``lean`` * u,
    metres in the view. ``places`` (N,) are the k of the strokes seen.
    """

    first: float
    pitch: float
    slope: float
    lean: float
    low: float
    high: float
    places: NDArray[np.intp] = field(repr=False)


def rows_of(strokes: Strokes) -> list[Row]:
    """Return the rows that strokes of one view stand in."""
    if len(strokes) < _LEAST_LINES:
        return []
    i, j, du = _beside(strokes)
    pitch, support = _pitches(strokes, i, j, du)
    steps = np.rint(du / pitch[i])
    inlier = (np.abs(du - steps * pitch[i]) < _OFF_M) & (np.abs(steps) >= 1) & (np.abs(steps) <= _MOST_STEPS)
    sound = support > _LEAST_SUPPORT
    together = inlier & sound[i] & sound[j] & (np.abs(pitch[i] - pitch[j]) < _SAME_PITCH_M)
    i, j = i[together], j[together]
    links = coo_array((np.ones(len(i)), (i, j)), shape=(len(strokes),) * 2)
    count, group = connected_components(links, directed=False)
    big = np.flatnonzero(np.bincount(group, minlength=count) >= _LEAST_LINES)
    return [row for g in big.tolist() for row in _rows(strokes, np.flatnonzero(group == g), pitch)]


def _beside(strokes: Strokes) -> tuple[NDArray[np.intp], NDArray[np.intp], FloatArray]:
    """Return pairs (i, j), in both orders, that lie beside each other, with the distance across from i to j."""
    reach = float(_PITCHES_M[-1]) * _MOST_STEPS + _OFF_M
    order = np.argsort(strokes.u, kind="stable")
    u, low, high = strokes.u[order], strokes.low[order], strokes.high[order]
    until = np.searchsorted(u, u + reach)
    number = until - np.arange(len(u)) - 1
    i = np.repeat(np.arange(len(u)), number)
    j = np.arange(len(i)) - np.repeat(np.cumsum(number) - number, number) + i + 1
    shared = np.minimum(high[i], high[j]) - np.maximum(low[i], low[j])
    whole = np.maximum(high[i], high[j]) - np.minimum(low[i], low[j])
    du, length = u[j] - u[i], high - low
    equal = np.abs(length[i] - length[j]) < _EQUAL * np.maximum(length[i], length[j])
    leaning = equal & (shared > _ALIKE_LEANING * whole) & (du < _PITCHES_M[-1] + _OFF_M)
    good = (shared > _ALIKE * whole) | leaning
    i, j, du = i[good], j[good], du[good]
    i, j = order[i], order[j]
    return np.concatenate([i, j]), np.concatenate([j, i]), np.concatenate([du, -du])


def _pitches(
    strokes: Strokes, i: NDArray[np.intp], j: NDArray[np.intp], du: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return each stroke's most likely pitch, and how well its neighbours support it.

    Neighbours at whole multiples support a pitch, those in between oppose it: the stripes of a crosswalk and
    of hatching lie at half a stall's pitch, too.
    """
    phase = du[:, None] / _PITCHES_M
    steps = np.rint(phase)
    off = np.abs(phase - steps) * _PITCHES_M
    weight = strokes.strength[j][:, None]
    near = np.abs(steps) <= _MOST_STEPS
    gain = np.where((off < _OFF_M) & (steps != 0) & near, (1 - (off / _OFF_M) ** 2) / np.maximum(np.abs(steps), 1), 0)
    loss = np.where((off > 2 * _OFF_M) & (np.abs(phase) < 1.7), 0.5, 0)
    score = np.zeros((len(strokes), len(_PITCHES_M)))
    np.add.at(score, i, weight * (gain - loss))
    best = score.argmax(axis=1)
    return _PITCHES_M[best], score[np.arange(len(strokes)), best]


def _rows(strokes: Strokes, members: NDArray[np.intp], pitch: FloatArray) -> list[Row]:
    """Fit rows to strokes that stand together: one, or more where an island breaks the rhythm."""
    rows: list[Row] = []
    left = members[np.argsort(strokes.u[members], kind="stable")]
    while len(left) >= _LEAST_LINES and len(rows) < _MOST_PARTS:
        usual = float(np.average(pitch[left], weights=strokes.strength[left]))
        row, used = _row(strokes[left], usual)
        if row is not None:
            rows.append(row)
        if not used.any():
            break
        left = left[~used]
    return rows


def _row(chosen: Strokes, usual: float) -> tuple[Row | None, NDArray[np.bool_]]:
    """Fit one row to strokes in order; returns it (None without a rhythm) and which strokes (N,) it used."""
    slope = float(np.average(chosen.slope, weights=chosen.strength * (chosen.high - chosen.low)))
    u = chosen.u - slope * (chosen.low + chosen.high) / 2
    places = np.concatenate([[0], np.cumsum(np.rint(np.diff(u) / usual))]).astype(np.intp)
    weight, solution = chosen.strength, np.array([u[0], usual])
    design = np.column_stack([np.ones(len(u)), places])
    for _ in range(4):
        solution = np.linalg.lstsq(design * weight[:, None], u * weight, rcond=None)[0]
        weight = chosen.strength / (1 + ((u - design @ solution) / 0.2) ** 2)
    good = np.abs(u - design @ solution) < _OFF_M
    if len(np.unique(places[good])) < _LEAST_LINES or not _PITCHES_M[0] - 0.1 < solution[1] < _PITCHES_M[-1] + 0.1:
        return None, good
    chosen, places = chosen[good], places[good]
    lean = _lean(chosen)
    low, high = chosen.low - lean * chosen.u, chosen.high - lean * chosen.u
    row = Row(
        float(solution[0]), float(solution[1]), slope, lean, float(np.percentile(low, 20)),
        float(np.percentile(high, 80)), places,
    )  # fmt: skip
    return row, good


def _lean(strokes: Strokes) -> float:
    """Return how the strokes' ends shift along from one to the next (v over u): the usual value over pairs."""
    i, j = np.triu_indices(len(strokes), 1)
    du = strokes.u[j] - strokes.u[i]
    near = (du > 2.0) & (du < 7.0)
    if not near.any():
        return 0.0
    i, j, du = i[near], j[near], du[near]
    leans = np.concatenate([(strokes.low[j] - strokes.low[i]) / du, (strokes.high[j] - strokes.high[i]) / du])
    tries = np.arange(-1.3, 1.31, 0.02)
    votes = np.exp(-(((leans - tries[:, None]) / 0.06) ** 2)).sum(axis=1) - 0.02 * np.abs(tries)
    return float(tries[votes.argmax()])


@dataclass(frozen=True, slots=True)
class Bays:
    """Places between neighbouring strokes of a row: ``stalls`` in pixels of the picture; ``left``, ``right`` and
    ``middle`` (N,) are how surely paint runs along both sides and between; ``lines`` (N,) how many strokes their row
    has; ``past`` (N,) how many bays they lie past the row's outermost stroke, 0 within.
    """

    stalls: Stalls
    left: FloatArray = field(repr=False)
    right: FloatArray = field(repr=False)
    middle: FloatArray = field(repr=False)
    lines: NDArray[np.intp] = field(repr=False)
    past: NDArray[np.intp] = field(repr=False)

    def __getitem__(self, which: Any) -> Bays:
        return Bays(*(getattr(self, f.name)[which] for f in fields(self)))


def joined(parts: Sequence[Bays]) -> Bays:
    """Return all bays as one, in order."""
    if not parts:
        none, number = np.zeros(0), np.zeros(0, np.intp)
        return Bays(Stalls(none, none, none, none, none, none), none, none, none, number, number)
    stalls = Stalls(*(np.concatenate([getattr(p.stalls, f.name) for p in parts]) for f in fields(Stalls)))
    rest = [np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Bays)[1:]]
    return Bays(stalls, *rest)


def scores(bays: Bays, taken: FloatArray) -> FloatArray:
    """Return how likely each bay (N,) is a stall: by paint on both sides, none between, and cars that hide it."""
    return np.asarray(1 / (1 + np.exp(-(score_features(bays, taken) @ _SCORE))))


def score_features(bays: Bays, taken: FloatArray) -> FloatArray:
    """Return the features (N, 11) of each bay, the constant first; what `scores` weighs."""
    low, high = np.minimum(bays.left, bays.right), np.maximum(bays.left, bays.right)
    most, past = _MOST_PAINT, bays.past > 0
    return np.column_stack(
        [
            np.ones(len(taken)),
            np.minimum(low, most),
            np.minimum(high, most),
            np.minimum(bays.middle, most) * (1 - taken),
            taken * ~past,
            np.log(np.minimum(bays.lines, _MANY_LINES)),
            past,
            bays.past,
            past * taken,
            past * low,
            past * taken * low,
        ]
    )


def bays_of(view: View, row: Row) -> list[Bays]:
    """Return the bays of a row: one strip of them, two when its strokes are long enough for stalls head to head."""
    first, last = int(row.places.min()), int(row.places.max())
    low, high = _extent(view, row)
    if _SINGLE_M[0] < high - low < _SINGLE_M[1]:
        strips = [(low, high)]
    elif _DOUBLE_M[0] < high - low < _DOUBLE_M[1]:
        strips = [(low, (low + high) / 2), ((low + high) / 2, high)]
    else:
        return []
    if _is_striped(view, row, np.linspace(low, high, _SAMPLES + 2)[1:-1]):
        return []
    k = np.arange(first - _PAST_END, last + _PAST_END)
    past = np.maximum(np.maximum(first - k, k - last + 1), 0)
    return [_strip(view, row, k, past, *strip) for strip in strips]


def _is_striped(view: View, row: Row, along: FloatArray) -> bool:
    """Return True when equally strong paint runs between the strokes, as in crosswalks and hatching."""
    k = np.arange(int(row.places.min()), int(row.places.max()))
    lines = np.median(_read(view, row, np.unique(row.places), along).mean(axis=1))
    between = [np.median(_read(view, row, k + share, along).mean(axis=1)) for share in _BETWEEN]
    return bool(max(between) > _STRIPED * lines)


def _strip(view: View, row: Row, k: NDArray[np.intp], past: NDArray[np.intp], low: float, high: float) -> Bays:
    if high - low < _SHORT_M:
        low, high = (low + high - _USUAL_M) / 2, (low + high + _USUAL_M) / 2
    along = low + (high - low) * np.linspace(*_INNER, _SAMPLES)
    lines = _read(view, row, np.append(k, k[-1] + 1), along).mean(axis=1)
    between = _read(view, row, k + 0.5, along).mean(axis=1)
    u = row.first + row.pitch * (k + 0.5)
    v = (low + high) / 2 + row.lean * u
    centre = np.column_stack([u + row.slope * v, v, np.full(len(u), view.side)]) / view.side @ view.to_picture.T
    linear = view.to_picture[:, :2] @ np.array([row.slope, 1.0])
    ones = np.ones(len(k))
    stalls = Stalls(
        centre[:, 0], centre[:, 1], np.arctan2(linear[1], linear[0]) * ones,
        row.pitch / view.side * ones, (high - low) / view.side * ones, 0.5 * ones,
    )  # fmt: skip
    count = np.full(len(k), len(np.unique(row.places)), np.intp)
    return Bays(stalls, lines[:-1], lines[1:], between, count, past)


def _extent(view: View, row: Row) -> tuple[float, float]:
    """Return where the strokes begin and end, metres along (of u = 0): where their visible paint falls off."""
    along = np.arange(row.low - _BEYOND_M, row.high + _BEYOND_M, _STEP_M)
    read = np.sort(_read(view, row, np.unique(row.places), along), axis=0)
    usual = read[len(read) // 2 :].mean(axis=0)  # cars hide up to half of the strokes
    within = (along >= row.low) & (along <= row.high)
    strong = usual > _EDGE_SHARE * np.percentile(usual[within], 80)
    middle = int(np.flatnonzero(within)[within.sum() // 2])
    weak_before = np.flatnonzero(~strong[:middle])
    weak_after = np.flatnonzero(~strong[middle:])
    first = weak_before[-1] + 1 if len(weak_before) else 0
    last = middle + weak_after[0] - 1 if len(weak_after) else len(along) - 1
    return float(along[first] - _STEP_M / 2), float(along[max(last, first)] + _STEP_M / 2)


def _read(view: View, row: Row, k: NDArray[np.floating | np.integer], along: FloatArray) -> FloatArray:
    """Return the ridge (K, S) on strokes k at the places along; nothing outside the picture."""
    base = row.first + row.pitch * np.asarray(k, float)
    v = along[None, :] + row.lean * base[:, None]
    u = base[:, None] + row.slope * v
    columns, rows = np.rint(u / view.side).astype(np.intp), np.rint(v / view.side).astype(np.intp)
    height, width = view.ridge.shape
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    read = view.ridge[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]
    return np.where(inside, np.maximum(read, 0), 0.0)
