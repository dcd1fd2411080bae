"""From rows of strokes to stalls: where strokes begin and end, long ones split, hidden ones bridged, ends gone on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.classical.lattice import Row
from hawk.algo.vision.classical.strokes import View
from hawk.algo.vision.decode import Stalls
from hawk.algo.vision.seen import FloatArray

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
"""Logistic regression on the features of `scores`; fitted to drawn lots."""


@dataclass(frozen=True, slots=True)
class Bays:
    """Places between neighbouring strokes of a row: ``stalls`` in pixels of the picture; ``left``, ``right`` and
    ``middle`` (N,) tell how surely paint runs along both sides and between; ``lines`` (N,) how many strokes their row
    has; ``past`` (N,) how many bays they lie past the row's outermost stroke, 0 within."""

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
    low, high = np.minimum(bays.left, bays.right), np.maximum(bays.left, bays.right)
    most, past = _MOST_PAINT, bays.past > 0
    features = np.column_stack(
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
    return np.asarray(1 / (1 + np.exp(-(features @ _SCORE))))


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
    """Return whether paint as strong runs between the strokes, too, as in crosswalks and hatching."""
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
    """Return where the strokes begin and end, metres along (of u = 0): where what is seen of them falls off."""
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
