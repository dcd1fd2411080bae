"""Rows of strokes: side by side, as long as each other, at a stall's pitch."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from hawk.algo.vision.classical.strokes import Strokes
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


@dataclass(frozen=True, slots=True)
class Row:
    """Strokes k at u = ``first`` + ``pitch`` * k + ``slope`` * v, ends along at ``low``.. ``high`` + ``lean`` * u,
    metres in the view. ``places`` (N,) are the k of the strokes seen."""

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
    """Return pairs (i, j), both ways round, that lie beside each other, with the way across from i to j."""
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
    """Return each stroke's most likely pitch, and how well its neighbours bear it out.

    Neighbours at whole multiples count for a pitch, those in between count against it: the stripes of a crosswalk and
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
