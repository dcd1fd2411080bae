"""Rows over the known map: stalls are drawn onto their row's lattice, and what cars hide is inferred from the row.

An inferred stall is valid when the row implies it repeatedly by the fused evidence. A find of its own makes it a stall
like any other, with the same id.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import Window
from hawk.algo.mapper.evidence import EVIDENCE_M
from hawk.algo.mapper.grid import EvidenceGrid
from hawk.algo.mapper.stalls import StallTracker, call_state, others
from hawk.algo.mapper.table import STALL_DTYPE, Rows, columns_of, geometry_of, pair, probability
from hawk.algo.vision import quads
from hawk.algo.vision.rows import RowOptions, RowStalls, complete_rows, row_of, row_stalls

_OPTIONS = RowOptions(gap=0.3, end=0.55)  # planted islands stand in rows too
_PULL = 0.4  # share of the distance to the lattice that one run takes
_INNER = 0.7
_SAMPLES = (9, 5)  # along, across
_IMPLIED, _NOT_IMPLIED = 1.0, -1.0  # log-odds of one run for and against an inferred stall
_MOST = 3.0
_COUNTS = 1.5
_BEYOND_M = 12.0  # rows are cut at the reach: as far on, other stalls may lie where the cut row goes on
_COVERED = 0.2  # share of car in a stall at which it may as well be taken
_COVER_GAIN = 14.0
_COVER_LIMIT = 2.2

Floats = NDArray[np.float64]


class RowFiller:
    """Completes rows among the stalls near the drone."""

    def __init__(self, reach_m: float) -> None:
        """``reach_m`` is the radius about a place within which rows are completed."""
        self._reach_m = reach_m

    def run(self, tracker: StallTracker, grid: EvidenceGrid, middle: tuple[float, float], version: int) -> None:
        """Complete the rows about a place (north, east); everything that changes is touched with ``version``."""
        near = tracker.near(*middle, self._reach_m)
        rows = tracker.rows[near]
        _judge_company(tracker.rows, near, tracker.near(*middle, self._reach_m - _BEYOND_M), version)
        tracker.settle(version)
        real = near[tracker.rows["confirmed"][near] & ~rows["inferred"]]
        if len(real) == 0:
            return
        layers = _Layers(grid)
        completed = complete_rows(_as_row_stalls(tracker.rows[real]), layers.core, _OPTIONS)
        members = completed[~completed.inferred]
        _pull(tracker.rows, real[members.source], members, version)
        implied = completed[completed.inferred]
        around = tracker.near(*middle, self._reach_m + _BEYOND_M)
        known, found = pair(geometry_of(tracker.rows[around]), (implied.north, implied.east, implied.angle))
        _place(tracker.rows, around[known], implied[found])
        fresh = implied[others(len(implied), found)]
        is_implied = np.zeros(len(tracker.rows), np.bool_)
        is_implied[around[known]] = True
        inner = tracker.near(*middle, self._reach_m - _BEYOND_M)
        missing = inner[~is_implied[inner]]
        _judge(tracker, around[known], missing, version)
        _add(tracker, fresh, version)
        _call(tracker.rows, layers, version)


def _judge_company(rows: Rows, near: NDArray[np.intp], judged: NDArray[np.intp], version: int) -> None:
    """Mark the stalls that stand in no row: cars in an aisle look like stalls, but they stand alone."""
    likely = near[(rows["exists"][near] > 0) & ~rows["inferred"][near]]
    if len(likely) == 0:
        return
    group = row_of(_as_row_stalls(rows[likely]))
    lone, is_likely = np.zeros((2, len(rows)), np.bool_)
    lone[likely] = np.bincount(group)[group] == 1
    is_likely[likely] = True
    changed = judged[(rows["lone"][judged] != lone[judged]) & is_likely[judged]]
    rows["lone"][changed] = lone[changed]
    rows["touched"][changed] = version


def _judge(tracker: StallTracker, implied: NDArray[np.intp], missing: NDArray[np.intp], version: int) -> None:
    """Count one run for what the rows implied, and against what was inferred before and is not implied any more.

    Finds too rare to be valid gain too; stalls that are valid by themselves are left as they are.
    """
    rows = tracker.rows
    gains = implied[rows["inferred"][implied] | ~rows["confirmed"][implied]]
    loses = missing[rows["inferred"][missing]]
    rows["exists"][gains] = np.minimum(rows["exists"][gains] + _IMPLIED, _MOST)
    rows["exists"][loses] += _NOT_IMPLIED
    rows["confirmed"][gains] |= rows["inferred"][gains] & (rows["exists"][gains] >= _COUNTS)
    rows["touched"][gains] = rows["touched"][loses] = version
    tracker.remove(loses[rows["exists"][loses] <= 0], version)


class _Layers:
    """Mean evidence in quads; of the grid only what lies about them is read."""

    def __init__(self, grid: EvidenceGrid) -> None:
        self._grid = grid

    def core(self, corners: Floats) -> Floats:
        """Return the mean core probability in the inner part of quads (N, 4, 2)."""
        return self._mean("core", corners)

    def car(self, corners: Floats) -> Floats:
        """Return the mean car probability in the inner part of quads (N, 4, 2)."""
        return self._mean("car", corners)

    def _mean(self, name: str, corners: Floats) -> Floats:
        if len(corners) == 0:
            return np.zeros(0)
        a, b = (np.linspace(0.5 - _INNER / 2, 0.5 + _INNER / 2, n) for n in _SAMPLES)
        along, across = (v.ravel()[:, None] for v in np.meshgrid(a, b, indexing="ij"))
        near = corners[:, None, 0] * (1 - across) + corners[:, None, 1] * across
        far = corners[:, None, 3] * (1 - across) + corners[:, None, 2] * across
        points = near * (1 - along) + far * along
        window = Window.around(points.reshape(-1, 2), EVIDENCE_M, EVIDENCE_M)
        cells = np.round(window.cells_of(points[..., 0], points[..., 1])).astype(np.intp)
        values = self._grid.layer(window, name)[cells[..., 1], cells[..., 0]]
        return np.asarray(values.mean(1), dtype=np.float64)


def _as_row_stalls(rows: Rows) -> RowStalls:
    return row_stalls(*geometry_of(rows), probability(rows["exists"]))


def _pull(rows: Rows, index: NDArray[np.intp], to: RowStalls, version: int) -> None:
    """Move stalls towards their places on the lattice."""
    moved = rows[index]
    for name, value in columns_of(to):
        moved[name] += _PULL * (value - moved[name])
    moved["touched"] = version
    rows[index] = moved


def _place(rows: Rows, index: NDArray[np.intp], to: RowStalls) -> None:
    """Put inferred stalls where their row has them by now; what was found itself stays where it was found."""
    inferred = rows["inferred"][index]
    for name, value in columns_of(to):
        rows[name][index] = np.where(inferred, value, rows[name][index])


def _add(tracker: StallTracker, implied: RowStalls, version: int) -> None:
    fresh = np.zeros(len(implied), STALL_DTYPE)
    for name, value in columns_of(implied):
        fresh[name] = value
    fresh["inferred"] = True
    fresh["exists"] = _IMPLIED
    fresh["solidity"] = 0.1
    fresh["touched"] = version
    tracker.add(fresh)


def _call(rows: Rows, layers: _Layers, version: int) -> None:
    """Inferred stalls are taken or free by the cars on them."""
    index = np.flatnonzero(rows["inferred"] & (rows["touched"] == version))
    corners = quads.corners(*geometry_of(rows[index]))
    cover = layers.car(corners)
    taken = np.clip((cover - _COVERED) * _COVER_GAIN, -_COVER_LIMIT, _COVER_LIMIT)
    rows["taken"][index] = taken
    rows["state"][index] = call_state(taken, rows["state"][index])
