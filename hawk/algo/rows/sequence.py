"""Which stalls stand in a row: the best sequence of stalls and gaps along its strip, exactly.

A dynamic programme over the steps of the strip: a stall takes `STEPS` of them and brings its log-odds; a gap takes any
number, and beginning or ending a run of stalls costs. So the phase of a run comes from all its stalls, a stall that
nothing shows is filled in where a gap would cost more, and a run ends where the evidence does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from hawk.algo.rows.evidence import STEPS, Strip
from hawk.algo.rows.fit import Finds, Indices, Row
from hawk.algo.vision import quads
from hawk.algo.vision.detection import FloatArray

_NEVER: Final = -1e9
_UNSEEN: Final = 6.0
"""Taken from the log-odds of a stall of which less than half was seen."""
_MEMBER_PITCHES: Final = 0.4
"""A find is that stall whose centre lies within this of its own, in pitches."""
_ROBUST_M: Final = 0.25
_LATTICE_FINDS: Final = 3
_PITCH_CHANGE: Final = 0.06
_OFF, _BESIDE = 0.15, 0.4
"""A find is off its even place from this share of a pitch; a neighbour is within this share of the next place."""


@dataclass(frozen=True, slots=True)
class RowOptions:
    """Log-odds.

    ``bias`` is added to each stall; ``end`` is taken from each past the row's last find, ``bare`` from each that
    neither a find nor the ground shows: islands, drives. The ground shows one from a mean core of ``shown_from``
    (0..1). ``begin`` and ``close`` are the costs of a run of stalls. A
    run counts from ``least`` in all, one of a single stall from ``single``. Finds that no row takes stay from
    ``lone_score`` (0..1). ``finds_from`` is the score (0..1) from which finds make rows.
    """

    bias: float = 0.5
    end: float = 0.5
    bare: float = 4.0
    shown_from: float = 0.2
    begin: float = 1.5
    close: float = 1.0
    least: float = 0.5
    single: float = 1.0
    lone_score: float = 0.6
    finds_from: float = 0.35


@dataclass(frozen=True, slots=True)
class Chosen:
    """Stalls of one row: ``t`` (N,) metres along it, their widths (N,), log-odds (N,), the number (N,) of each one's
    run, and the find (N,) that it is, -1 for none.
    """

    t: FloatArray
    width: FloatArray
    log_odds: FloatArray
    run: Indices
    source: Indices


def choose(row: Row, strip: Strip, finds: Finds, options: RowOptions) -> Chosen:
    """Return the best stalls of a row."""
    beyond = (strip.t < row.low - 0.5 * row.pitch) | (strip.t > row.high + 0.5 * row.pitch)
    value = strip.log_odds() + options.bias - options.end * beyond
    value -= options.bare * strip.is_bare(options.shown_from) + _UNSEEN * (strip.seen < 0.5)
    begin = best_sequence(value, options)
    run = np.concatenate([[0], np.cumsum(np.diff(begin) > STEPS)])[: len(begin)].astype(np.intp)
    total, count = np.bincount(run, value[begin]), np.bincount(run)
    kept = total[run] >= np.where(count[run] == 1, options.single, options.least)
    begin, run = begin[kept], run[kept]
    source = _sources(row, strip.t[begin], finds)
    even = _aligned(row, strip.t[begin], run, source, finds)
    t, width = _with_own_places(row, even, source, finds)
    return Chosen(t, width, value[begin], run, source)


def best_sequence(value: FloatArray, options: RowOptions) -> Indices:
    """Return the steps (K,), in order, at which the stalls of the best sequence begin; ``value`` (M,) is what a stall
    that begins at each step brings.
    """
    count = len(value) + STEPS - 1
    values = value.tolist()
    stall, gap = [_NEVER] * (count + 1), [0.0] * (count + 1)
    goes_on, ended = [False] * (count + 1), [False] * (count + 1)
    for j in range(1, count + 1):
        i = j - STEPS
        if i >= 0:
            goes_on[j] = stall[i] >= gap[i] - options.begin
            stall[j] = values[i] + max(stall[i], gap[i] - options.begin)
        closed = stall[j] - options.close
        ended[j] = closed > gap[j - 1]
        gap[j] = max(gap[j - 1], closed)
    return _traced(goes_on, ended)


def _traced(goes_on: list[bool], ended: list[bool]) -> Indices:
    """Return the steps at which stalls begin, from the last one back."""
    begins: list[int] = []
    j, in_run = len(ended) - 1, False
    while j > 0:
        if in_run or ended[j]:
            begins.append(j - STEPS)
            in_run, j = goes_on[j], j - STEPS
        else:
            j -= 1
    return np.array(begins[::-1], np.intp)


def _sources(row: Row, t: FloatArray, finds: Finds) -> Indices:
    """Return the best find (N,) at each stall, -1 where there is none; no find is two stalls."""
    source = np.full(len(t), -1, np.intp)
    if not len(t) or not len(finds):
        return source
    place, aside = row.place(finds.centres)
    alike = quads.angle_between(row.angle, finds.angle) < 0.35
    nearest = np.abs(place[:, None] - t).argmin(axis=1)
    is_there = np.abs(place - t[nearest]) < _MEMBER_PITCHES * row.pitch
    near = np.flatnonzero(alike & is_there & (np.abs(aside) < 0.4 * row.length))
    worst_first = near[np.argsort(finds.score[near], kind="stable")]
    source[nearest[worst_first]] = worst_first  # of several finds the last one written stays
    return source


def _aligned(row: Row, t: FloatArray, run: Indices, source: Indices, finds: Finds) -> FloatArray:
    """Return the centres (N,) on an even lattice for each run: a line through its finds' own places, robustly."""
    result = t.copy()
    for number in np.unique(run).tolist():
        mine = np.flatnonzero(run == number)
        found = mine[source[mine] >= 0]
        if not len(found):
            continue
        k = np.rint((t - t[mine[0]]) / row.pitch)
        place = row.place(finds.centres[source[found]])[0]
        score = finds.score[source[found]]
        first, pitch = _lattice(k[found], place, score, row.pitch)
        even = first + pitch * k[mine]
        if np.abs(even - t[mine]).max() < 0.5 * row.pitch:
            result[mine] = even
    return result


def _with_own_places(row: Row, even: FloatArray, source: Indices, finds: Finds) -> tuple[FloatArray, FloatArray]:
    """Return centres and widths (N,): finds off their even place stay where they are, unless a neighbour stands there.

    So the wide stall at the end of a row keeps its place, and one that a shadow shifts towards its neighbour does not.
    """
    t, width = even.copy(), np.full(len(even), row.width)
    is_find = np.flatnonzero(source >= 0)
    if not len(is_find):
        return t, width
    own = row.place(finds.centres[source[is_find]])[0]
    off = own - even[is_find]
    beside = even[is_find] + np.sign(off) * row.pitch
    has_neighbour = (np.abs(even[None] - beside[:, None]) < _BESIDE * row.pitch).any(axis=1)
    kept = (np.abs(off) > _OFF * row.pitch) & ~has_neighbour
    t[is_find[kept]] = own[kept]
    width[is_find[kept]] = np.maximum(finds.width[source[is_find[kept]]], row.width)
    return t, width


def _lattice(k: FloatArray, place: FloatArray, score: FloatArray, pitch: float) -> tuple[float, float]:
    """Return first place and pitch of the lattice through places (N,) of numbers ``k`` (N,)."""
    weight = np.maximum(score, 0.05)
    first = float(np.average(place - pitch * k, weights=weight))
    if len(k) < _LATTICE_FINDS:
        return first, pitch
    kept, slope = weight, pitch
    for _ in range(3):
        middle, about = np.average(k, weights=kept), np.average(place, weights=kept)
        spread = float(kept @ (k - middle) ** 2)
        slope = float(kept @ ((k - middle) * (place - about))) / spread if spread > 0 else pitch
        slope = float(np.clip(slope, pitch * (1 - _PITCH_CHANGE), pitch * (1 + _PITCH_CHANGE)))
        first = float(about - slope * middle)
        kept = weight / (1 + ((place - first - slope * k) / _ROBUST_M) ** 2)
    return first, slope
