"""Rows over the known map: stalls are aligned in their rows, and what cars and crowns hide is inferred from the row.

An inferred stall is valid when the row implies it repeatedly by the fused evidence. A find of its own makes it a stall
like any other, with the same id. A find against which its row speaks is no stall.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.algo.frame import Steps
from hawk.algo.mapper.fused_ground import FusedGround
from hawk.algo.mapper.grid import EvidenceGrid
from hawk.algo.mapper.plan_rows import mark_extra
from hawk.algo.mapper.stalls import StallTracker, call_state, others, score_of
from hawk.algo.mapper.table import STALL_DTYPE, Rows, columns_of, corners_of, geometry_of, pair
from hawk.algo.rows.fit import Finds, row_of
from hawk.algo.rows.lot import NO_ROW, RowStalls, completion
from hawk.algo.rows.sequence import RowOptions
from hawk.algo.vision import quads

_OPTIONS: Final = RowOptions(shown_from=0.35)
"""Over many frames planted islands and hatched bays show a little core too."""
_PULL = 0.3
"""Share of the distance to its place in the row by which one run moves a stall."""
_NEAR_PLACE_M = 0.8
"""A stall farther from its place in the row stays where it was found: the row may be wrong there."""
_IMPLIED, _NOT_IMPLIED = 1.0, -1.0
"""Log-odds of one run for and against an inferred stall."""
_SUPPORTED = 0.45
"""Mean core from which the ground supports a find that is too rare to be valid by itself."""
_REFUSED = -0.5
"""Log-odds of one run against a find that contradicts its row."""
_NEAR_M, _OVERLAP = 6.0, 0.2
"""A find contradicts its row where it lies on another stall of it by this intersection over union."""
_MOST = 3.0
_COUNTS = 1.5
_BEYOND_M = 12.0
"""Rows are cut at the reach: as far on, other stalls may lie where the cut row goes on."""
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Run:
    """A run under way: its middle, the ground and the ids of the stalls as it began, and the steps to do."""

    middle: tuple[float, float]
    ground: FusedGround
    given: NDArray[np.int64]
    steps: Steps[RowStalls]


class RowFiller:
    """Completes rows among the stalls near the drone: a run is begun, and goes on by one step a frame.

    So no frame pays for a whole run. Stalls that come or go meanwhile are left to the next run.
    """

    def __init__(self, reach_m: float) -> None:
        """``reach_m`` is the radius about a place within which rows are completed."""
        self._reach_m = reach_m
        self._run: _Run | None = None

    def __getstate__(self) -> dict[str, object]:
        """Return the state of a copy: a run under way is not copied."""
        return {"_reach_m": self._reach_m, "_run": None}

    @property
    def is_under_way(self) -> bool:
        """A run has been begun and has not ended."""
        return self._run is not None

    def begin(self, tracker: StallTracker, grid: EvidenceGrid, middle: tuple[float, float]) -> None:
        """Begin a run about a place (north, east), in place of one under way; not without a stall there."""
        self._run = None
        near = tracker.near(*middle, self._reach_m)
        given = near[~tracker.rows["inferred"][near] & ~tracker.rows["raised"][near]]
        if len(given) == 0:
            return
        ground = FusedGround(grid, middle, self._reach_m + _BEYOND_M)
        steps = completion(_finds(tracker.rows[given]), ground.at, _OPTIONS)
        self._run = _Run(middle, ground, tracker.rows["id"][given], steps)

    def go_on(self, tracker: StallTracker, version: int) -> None:
        """Do the next step of the run under way. The last one changes stalls, and touches them with ``version``."""
        run = self._run
        if run is None:
            return
        try:
            next(run.steps)
        except StopIteration as end:
            self._run = None
            self._finish(run, end.value, tracker, version)

    def drop(self) -> None:
        """Give up a run under way: the stalls were moved."""
        self._run = None

    def _finish(self, run: _Run, completed: RowStalls, tracker: StallTracker, version: int) -> None:
        now = _index_of(run.given, tracker.rows)
        completed = completed[completed.inferred | (now[completed.source] >= 0)]
        given = now[now >= 0]
        inner = tracker.near(*run.middle, self._reach_m - _BEYOND_M)
        members = completed[~completed.inferred]
        member = now[members.source]
        is_in_row = members.row != NO_ROW
        _judge_company(tracker.rows, given, member[is_in_row], inner, version)
        unused = np.setdiff1d(np.intersect1d(given, inner), member)
        _refuse(tracker.rows, unused[_touch(tracker.rows[unused], completed)], version)
        tracker.settle(version)
        in_row, member = members[is_in_row], member[is_in_row]
        _pull(tracker.rows, member, in_row, version)
        _support(tracker.rows, member[run.ground.within(in_row.corners())[0] >= _SUPPORTED], version)
        implied = completed[completed.inferred]
        around = tracker.near(*run.middle, self._reach_m + _BEYOND_M)
        known, found = pair(geometry_of(tracker.rows[around]), (implied.north, implied.east, implied.angle))
        _place(tracker.rows, around[known], implied[found])
        fresh = implied[others(len(implied), found)]
        is_implied = np.zeros(len(tracker.rows), np.bool_)
        is_implied[around[known]] = True
        missing = inner[~is_implied[inner]]
        _judge(tracker, around[known], missing, version)
        _add(tracker, fresh, version)
        _call(tracker.rows, run.ground, version)


def _index_of(ids: NDArray[np.int64], rows: Rows) -> NDArray[np.intp]:
    """Return the index of each id (N,) in the table, -1 for one that is gone."""
    order = np.argsort(rows["id"])
    at = np.searchsorted(rows["id"], ids, sorter=order)
    index = order[np.minimum(at, len(order) - 1)] if len(order) else np.zeros(len(ids), np.intp)
    is_there = rows["id"][index] == ids if len(order) else np.zeros(len(ids), np.bool_)
    return np.where(is_there, index, -1)


def _finds(rows: Rows) -> Finds:
    north, east, angle, width, length = geometry_of(rows)
    score = np.where(rows["given"], 1.0, score_of(rows["exists"]))
    return Finds(np.column_stack([north, east]), angle, width, length, score)


def _judge_company(
    rows: Rows, given: NDArray[np.intp], in_row: NDArray[np.intp], judged: NDArray[np.intp], version: int
) -> None:
    """Mark those of the ``judged`` stalls that stand in no row: cars in an aisle look like stalls, but stand alone.

    ``in_row`` are the ``given`` ones that are stalls of rows.
    """
    likely = given[rows["exists"][given] > 0]
    if len(likely) == 0:
        return
    group = row_of(_finds(rows[likely]))
    lone, is_judged = np.zeros((2, len(rows)), np.bool_)
    lone[likely] = np.bincount(group)[group] == 1
    lone[in_row] = False
    is_judged[np.intersect1d(likely, judged)] = True
    changed = np.flatnonzero(is_judged & (rows["lone"] != lone))
    rows["lone"][changed] = lone[changed]
    rows["touched"][changed] = version


def _support(rows: Rows, index: NDArray[np.intp], version: int) -> None:
    """Count one run for finds in a row that are too rare to be valid by themselves."""
    rare = index[~rows["confirmed"][index]]
    rows["exists"][rare] = np.minimum(rows["exists"][rare] + _IMPLIED, _MOST)
    rows["touched"][rare] = version


def _touch(rows: Rows, stalls: RowStalls) -> NDArray[np.bool_]:
    """Return which rows (N,) of the table lie on one of the stalls."""
    touching = np.zeros(len(rows), np.bool_)
    if len(rows) and len(stalls):
        places = np.column_stack([rows["north"], rows["east"]])
        i, j = quads.near_pairs(places, stalls.centres, _NEAR_M)
        touching[i[quads.overlap_more(corners_of(rows[i]), stalls.corners()[j], _OVERLAP)]] = True
    return touching


def _refuse(rows: Rows, refused: NDArray[np.intp], version: int) -> None:
    """Count one run against finds that contradict their row; finds of a stall outweigh it, as it stands."""
    doubted = refused[(rows["exists"][refused] > 0) & ~rows["given"][refused]]
    rows["exists"][doubted] += _REFUSED
    rows["touched"][doubted] = version


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
    mark_extra(rows, gains, version)
    rows["touched"][gains] = rows["touched"][loses] = version
    tracker.remove(loses[rows["exists"][loses] <= 0], version)


def _pull(rows: Rows, index: NDArray[np.intp], to: RowStalls, version: int) -> None:
    """Move stalls towards their places in the row, where these are near."""
    near = np.hypot(to.north - rows["north"][index], to.east - rows["east"][index]) < _NEAR_PLACE_M
    near &= ~rows["given"][index]
    index, to = index[near], to[near]
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


def _call(rows: Rows, ground: FusedGround, version: int) -> None:
    """Call the states of inferred stalls by their ground."""
    index = np.flatnonzero(rows["inferred"] & (rows["touched"] == version))
    taken = ground.taken(quads.corners(*geometry_of(rows[index])))
    rows["taken"][index] = taken
    rows["state"][index] = call_state(taken, rows["state"][index])
