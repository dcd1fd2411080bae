"""Labels by which people find a stall: the letter of its row and its number along it, as "B 12".

Rows are lettered from north to south, or from west to east where most rows run from north to south. Stalls are numbered
from west to east, or from north to south. Islands and drives part no row. The labels are those of one map: a map with
more rows has others.
"""

from __future__ import annotations

import string
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from hawk.model.lot_map import Stall, StallState
from hawk.runtime.late import late

if TYPE_CHECKING:
    from scipy import sparse, spatial
    from scipy.sparse import csgraph
else:  # loaded by an export: a start in the air does without
    sparse = late("scipy.sparse")
    spatial = late("scipy.spatial")
    csgraph = late("scipy.sparse.csgraph")

_BESIDE: Final = (0.6, 1.6)
"""Widths from a stall to its neighbour, across."""
_OUT_OF_LINE: Final = 0.75
"""Lengths by which a neighbour may lie ahead: rows are angled."""
_TURNED: Final = 0.15
_GAP_M: Final = 15.0
"""Longest island or drive within a row."""
_ASIDE_M: Final = 1.2

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Stalls:
    """Marked stalls as arrays of length N."""

    ids: list[int]
    centres: Floats = field(repr=False)
    angle: Floats = field(repr=False)
    width: Floats = field(repr=False)
    length: Floats = field(repr=False)


def row_labels(stalls: Mapping[int, Stall]) -> dict[int, str]:
    """Return the label of each stall by id; suggested ones have none."""
    marked = [stall for _, stall in sorted(stalls.items()) if stall.state is not StallState.SUGGESTED]
    if not marked:
        return {}
    table = np.array([(s.north, s.east, s.angle, s.width, s.length) for s in marked])
    given = _Stalls([s.id for s in marked], table[:, :2], table[:, 2], table[:, 3], table[:, 4])
    rows = _rows(given)
    down = _reading_direction(given, rows)
    rows.sort(key=lambda row: (len(row) == 1, *_order(given, row, down)))
    labels = {}
    for letter, row in zip(letters(), rows, strict=False):
        along = given.centres[row] @ _along(down)
        for number, index in enumerate(row[np.argsort(along, kind="stable")].tolist(), 1):
            labels[given.ids[index]] = f"{letter} {number}"
    return labels


def letters() -> Iterator[str]:
    """Yield A to Z, AA to AZ, BA and so on, for ever."""
    size = 1
    while True:
        for number in range(26**size):
            yield "".join(string.ascii_uppercase[number // 26**k % 26] for k in reversed(range(size)))
        size += 1


def _rows(stalls: _Stalls) -> list[NDArray[np.intp]]:
    """Return the indices of the stalls of each row."""
    count = len(stalls.ids)
    i, j = spatial.cKDTree(stalls.centres).query_pairs(1.5 * float(np.hypot(stalls.width, stalls.length).max()),
                                                       output_type="ndarray").T  # fmt: skip
    offset = stalls.centres[j] - stalls.centres[i]
    cos, sin = np.cos(stalls.angle[i]), np.sin(stalls.angle[i])
    across = np.abs(offset[:, 1] * cos - offset[:, 0] * sin) / ((stalls.width[i] + stalls.width[j]) / 2)
    along = np.abs(offset[:, 0] * cos + offset[:, 1] * sin) / stalls.length[i]
    level = _between(stalls.angle[i], stalls.angle[j]) < _TURNED
    beside = level & (across > _BESIDE[0]) & (across < _BESIDE[1]) & (along < _OUT_OF_LINE)
    runs = _components(count, i[beside], j[beside])
    group = _components(len(runs), *_going_on(stalls, runs))
    return [np.concatenate([runs[k] for k in members.tolist()]) for members in group]


def _going_on(stalls: _Stalls, runs: list[NDArray[np.intp]]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return pairs of runs of which the second goes on in the line of the first."""
    ordered, begins = np.concatenate(runs), np.cumsum([0, *map(len, runs[:-1])])
    centres, angle = stalls.centres[ordered], stalls.angle[ordered[begins]]
    first, second = [], []
    for number, run in enumerate(runs):
        if len(run) < 2:
            continue
        middle, axis = _axis(stalls.centres[run])
        offset = centres - middle
        aside = np.maximum.reduceat(np.abs(offset @ (-axis[1], axis[0])), begins)
        along = offset @ axis
        low, high = np.minimum.reduceat(along, begins), np.maximum.reduceat(along, begins)
        gap = np.maximum(low - high[number], low[number] - high)
        goes_on = (_between(angle[number], angle) <= _TURNED) & (aside <= _ASIDE_M) & (gap > 0) & (gap < _GAP_M)
        second.append(np.flatnonzero(goes_on))
        first.append(np.full(len(second[-1]), number))
    none = np.zeros(0, np.intp)
    return np.concatenate([none, *first]), np.concatenate([none, *second])


def _axis(centres: Floats) -> tuple[Floats, Floats]:
    """Return the middle of centres (N, 2) and the direction in which they lie; of one centre any."""
    middle = centres.mean(axis=0)
    return middle, np.linalg.svd(centres - middle)[2][0]


def _components(count: int, i: NDArray[np.intp], j: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    links = sparse.coo_array((np.ones(len(i)), (i, j)), shape=(count, count))
    number, label = csgraph.connected_components(links, directed=False)
    return [np.flatnonzero(label == k) for k in range(int(number))]


def _reading_direction(stalls: _Stalls, rows: list[NDArray[np.intp]]) -> Floats:
    """Return the direction (2,) across the rows in which they are lettered: southwards, or eastwards."""
    axes = [(_axis(stalls.centres[row])[1], len(row)) for row in rows if len(row) > 1]
    double = sum((size * (axis[0] + 1j * axis[1]) ** 2 for axis, size in axes), 0j) or -1 + 0j
    along = np.sqrt(double / abs(double))
    across = np.array([-along.imag, along.real])
    towards = -across[0] if abs(across[0]) >= abs(across[1]) else across[1]
    return across if towards > 0 else -across


def _along(down: Floats) -> Floats:
    """Return the direction (2,) in which stalls are numbered: eastwards, or southwards."""
    along = np.array([down[1], -down[0]])
    forwards = along[1] if abs(along[1]) >= abs(along[0]) else -along[0]
    return along if forwards > 0 else -along


def _order(stalls: _Stalls, row: NDArray[np.intp], down: Floats) -> tuple[float, float]:
    """Return how far down a row lies, in steps of half a stall, and how far along."""
    middle = stalls.centres[row].mean(axis=0)
    step = float(stalls.length.mean()) / 2
    return round(float(middle @ down) / step), float(middle @ _along(down))


def _between(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.abs((np.asarray(a) - b + np.pi / 2) % np.pi - np.pi / 2))
