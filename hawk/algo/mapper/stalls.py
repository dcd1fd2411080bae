"""Stalls as objects that stay: association, fused geometry, existence, and taken or free.

Frames taken from nearly the same place repeat each other, so that each frame has a weight (0..1, its share of an
independent look); the first look at a stall has weight 1. A frame of no weight finds no new stall and loses none: it
only sees a car come or leave.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from hawk.algo.mapper import plan_rows, table
from hawk.algo.mapper.delta import Recent
from hawk.algo.vision import quads

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
InPicture = Callable[[Floats], Mask]
"""True for each point (N, 2) of (north, east) in the good part of the present picture."""

_WHOLE = 0.9  # visible share from which a find determines the geometry
_SCORE_ZERO = 0.3  # score at which a find is no evidence
_SCORE_GAIN = 2.0  # log-odds per unit of score
_MISS = -0.4  # log-odds of a frame that shows the place and no stall
_EXISTS_LIMIT = 5.0
_CONFIRM = 1.3  # evidence of a valid stall: one look with a score of .95, or several with less
_REVOKE = 1.0  # a stall is valid down to this far below it
_DROP = -1.0
_SOLID = 10.0  # weight of all looks at most: what comes later still moves a stall
_TAKEN_LOOK = 2.2  # log-odds that one look may claim
_TAKEN_LIMIT = 3.5  # a car that leaves is seen within two looks
_CALL = 0.4  # log-odds from which a state is called
_KEEP = 0.1  # and down to which it is kept
_CHANGED = 0.9  # probability with which a look shows another state
_OVERLAP = 0.3
_CLOSE_M = 2.2
_ON_GIVEN_M, _ON_GIVEN = 6.0, 0.1
"""A find lies on a given stall where they overlap by more than this, intersection over union."""
_ATTEND_STEP_M = 20.0  # distance flown until the rows about the drone are chosen again

RAISED = 0.06
"""Lean of what stands off the ground: 2 m seen from 35 m. Stalls on the ground stay below it, with cars on them too."""
_LEAN_SIGMA = 0.08  # of one look: 0.15 m of noise in two places, over the distance between two frames
_MOST_LEAN_LOOKS = 20.0


@dataclass(frozen=True, slots=True)
class GivenLook:
    """Look of one frame at given stalls: their rows ``index`` (N,), the probability (N,) that each is taken, and the
    share (N,) of each that is in the picture.
    """

    index: NDArray[np.intp]
    taken: Floats
    visible: Floats


_NOTHING_GIVEN = GivenLook(np.zeros(0, np.intp), np.zeros(0), np.zeros(0))


@dataclass(frozen=True, slots=True)
class Look:
    """One frame as the tracker sees it: stalls, weight as an independent look, time, what lies in the picture, the
    map's version, the metres flown so far, the weight of a car that came or left while nothing else was new, the
    states of given stalls, and whether the picture is blurred.
    """

    found: table.Detections
    weight: float
    time: float
    in_picture: InPicture
    version: int
    flown_m: float = 0.0
    change: float = 0.0
    given: GivenLook = _NOTHING_GIVEN
    is_blurred: bool = False


class StallTracker:
    """The known stalls. ``rows`` are those about the drone (`attend`); the others are kept by squares of ground."""

    def __init__(self) -> None:
        self.rows: table.Rows = np.zeros(0, table.STALL_DTYPE)
        self.next_id = 1
        self.gone: Recent[int] = Recent()
        """Stalls that counted and do no more, by the map version at which they went."""
        self._just_gone: list[int] = []
        self._far = table.FarStalls()
        self._attended: tuple[float, float, float] | None = None

    @property
    def count(self) -> int:
        """Number of all rows."""
        return len(self.rows) + self._far.count

    def count_in(self, box: NDArray[np.float64]) -> int:
        """Return the number of stalls in a box, two corners (2, 2) of (north, east); of far ones some more."""
        return int(table.is_in(self.rows, box).sum()) + self._far.count_in(box)

    @property
    def confirmed(self) -> table.Rows:
        """A copy of all valid rows."""
        rows = np.concatenate([self.rows, self._far.all()])
        confirmed: table.Rows = rows[rows["confirmed"]]
        return confirmed

    def attend(self, north: float, east: float, reach: float) -> None:
        """Load all stalls within reach (metres) of a place into ``rows``, and evict those far beyond.

        Indices of rows that were asked for before are void.
        """
        if self._attended is not None:
            moved = math.hypot(north - self._attended[0], east - self._attended[1])
            if moved + reach <= self._attended[2]:
                return
        wide = reach + _ATTEND_STEP_M
        self._attended = (north, east, wide)
        distance = np.hypot(self.rows["north"] - north, self.rows["east"] - east)
        far = distance > wide + table.SQUARE_M
        self._far.put(self.rows[far])
        self.rows = np.concatenate([self.rows[~far], self._far.take(north, east, wide)])

    def about(self, north: float, east: float, reach: float) -> table.Rows:
        """Return a copy of the valid rows within reach (metres) of a place, and perhaps a few more."""
        rows = np.concatenate([self.rows[self.near(north, east, reach)], self._far.about(north, east, reach)])
        confirmed: table.Rows = rows[rows["confirmed"]]
        return confirmed

    def touched_since(self, version: int) -> Iterator[table.Rows]:
        """Yield the valid rows that were touched after a version."""
        for rows in (self.rows, *self._far.since(version)):
            yield rows[rows["confirmed"] & (rows["touched"] > version)]

    def near(self, north: float, east: float, radius: float) -> NDArray[np.intp]:
        """Return indices of rows within a radius (metres); it must lie within the reach of `attend`."""
        distance = np.hypot(self.rows["north"] - north, self.rows["east"] - east)
        return np.flatnonzero(distance < radius)

    def fuse(self, look: Look, local: NDArray[np.intp]) -> None:
        """Fuse one frame. ``local`` are the rows that may be in the picture."""
        before = self.rows[local].copy()
        k, f = table.pair(table.geometry_of(before), (look.found.north, look.found.east, look.found.angle))
        is_given = before["given"][k]
        self._look_at_given(local[k[is_given]], look.found.score[f[is_given]], look)
        self._hit(local[k[~is_given]], look.found.take(f[~is_given]), look)
        missed = np.delete(local, k)
        self._miss(missed[~self.rows["given"][missed]], look)
        if look.weight > 0:
            fresh = look.found.take(others(len(look.found), f))
            self._birth(fresh.take(~_lies_on(fresh, before[before["given"]])), look)
        self._drop(look.version)
        self._merge(look)
        self.settle(look.version)

    def settle(self, version: int) -> None:
        """Decide which of the rows touched in this version are valid: found well enough, not alone, on the ground."""
        index = np.flatnonzero((self.rows["touched"] == version) & ~self.rows["inferred"] & ~self.rows["given"])
        rows = self.rows[index]
        good = rows["exists"] >= np.where(rows["confirmed"], _CONFIRM - _REVOKE, _CONFIRM)
        counts = good & ~rows["lone"] & ~rows["raised"]
        self._part_with(rows["id"][rows["confirmed"] & ~counts], version)
        for stall_id in rows["id"][~rows["confirmed"] & counts].tolist():
            self.gone.forget(stall_id)
        self.rows["confirmed"][index] = counts
        plan_rows.mark_extra(self.rows, index, version)

    def put_plan(self, plan: plan_rows.PlanStalls, version: int) -> NDArray[np.intp]:
        """Put the stalls of a lot's plan into the table, in place of earlier plans; see `plan_rows.with_plan`.

        All rows are loaded until `attend` is called. Returns the indices of those that changed.
        """
        everything = np.concatenate([self.rows, self._far.all()])
        self._far, self._attended = table.FarStalls(), None
        self.rows, lost = plan_rows.with_plan(everything, plan, version)
        fresh = self.rows["id"] == 0
        self.rows["id"][fresh] = self.next_id + np.arange(int(fresh.sum()))
        self.next_id += int(fresh.sum())
        self._part_with(lost, version)
        self.settle(version)
        beside = np.flatnonzero(self.rows["confirmed"] & (self.rows["plan"] == 0))
        plan_rows.mark_extra(self.rows, beside, version)
        self.rows["touched"][beside] = version
        return np.flatnonzero(self.rows["touched"] == version)

    def take_gone(self) -> list[int]:
        """Return the ids that went since the last call."""
        gone, self._just_gone = self._just_gone, []
        return gone

    def restore(self, rows: table.Rows, next_id: int) -> None:
        """Restore the stalls of an earlier run."""
        self.rows = rows
        self._far, self._attended = table.FarStalls(), None
        self.next_id = max(next_id, int(rows["id"].max(initial=0)) + 1)

    def move_younger(self, flown_m: float, step: Floats, version: int) -> NDArray[np.intp]:
        """Move the stalls that were found after ``flown_m`` by a step (2,) of metres north and east.

        All rows are loaded until `attend` is called. Returns the indices of those that were moved.
        """
        self.rows = np.concatenate([self.rows, self._far.all()])
        self._far, self._attended = table.FarStalls(), None
        index = np.flatnonzero((self.rows["born"] > flown_m) & ~self.rows["inferred"])
        for name, metres in zip(("north", "east"), step, strict=True):
            self.rows[name][index] += metres
        self.rows["touched"][index] = version
        return index

    def _hit(self, index: NDArray[np.intp], found: table.Detections, look: Look) -> None:
        if len(index) == 0:
            return
        rows = self.rows[index]
        weight = _novelty(rows["looks"], look.weight)
        _fuse_geometry(rows, found, weight)
        note_leans(rows, found.lean)
        gain = weight * _SCORE_GAIN * (found.score - _SCORE_ZERO)
        rows["exists"] = np.clip(rows["exists"] + gain, -_EXISTS_LIMIT, _EXISTS_LIMIT)
        rows["born"] = np.where(rows["inferred"], look.flown_m, rows["born"])
        rows["inferred"] = False
        _vote(rows, found.taken, found.visible, weight, look)
        self.rows[index] = rows

    def _look_at_given(self, found: NDArray[np.intp], score: Floats, look: Look) -> None:
        """Take the states of given stalls, and count for or against each whether the frame found it, too.

        They are neither moved nor lost by that.
        """
        index, given = look.given.index, look.given
        rows = self.rows[index]
        weight = _novelty(rows["looks"], look.weight)
        scores = np.full(len(self.rows), np.nan)
        scores[found] = score
        shown = scores[index]
        gain = np.where(np.isnan(shown), (given.visible > _WHOLE) * _MISS, _SCORE_GAIN * (shown - _SCORE_ZERO))
        rows["exists"] = np.clip(rows["exists"] + weight * gain, -_EXISTS_LIMIT, _EXISTS_LIMIT)
        _vote(rows, given.taken, given.visible, weight, look)
        self.rows[index] = rows

    def _miss(self, index: NDArray[np.intp], look: Look) -> None:
        if len(index) == 0:
            return
        corners = table.corners_of(self.rows[index])
        inside = look.in_picture(corners.reshape(-1, 2)).reshape(-1, 4).all(1)
        index = index[inside & ~self.rows["inferred"][index]]
        rows = self.rows[index]
        weight = _novelty(rows["looks"], look.weight)
        rows["exists"] = np.maximum(rows["exists"] + weight * _MISS, -_EXISTS_LIMIT)
        rows["looks"] += weight
        rows["touched"] = look.version
        self.rows[index] = rows

    def _birth(self, found: table.Detections, look: Look) -> None:
        if len(found) == 0:
            return
        rows = np.zeros(len(found), table.STALL_DTYPE)
        for name, value in table.columns_of(found):
            rows[name] = value
        rows["solidity"] = np.maximum(_geometry_weight(found), 1e-3)
        rows["exists"] = _SCORE_GAIN * (found.score - _SCORE_ZERO)
        rows["taken"] = np.clip(found.visible, 0, 1) * _taken_log_odds(found.taken)
        rows["looks"], rows["seen"], rows["last_seen"], rows["born"] = 1, 1, look.time, look.flown_m
        rows["blurred"] = look.is_blurred
        rows["state"] = call_state(rows["taken"], rows["state"])
        rows["touched"] = look.version
        self.add(rows)

    def _drop(self, version: int) -> None:
        bad = (self.rows["exists"] < _DROP) & ~self.rows["inferred"] & ~self.rows["given"]
        self.remove(np.flatnonzero(bad), version)

    def add(self, rows: table.Rows) -> None:
        """Put rows into the table under ids of their own."""
        rows["id"] = self.next_id + np.arange(len(rows))
        self.next_id += len(rows)
        self.rows = np.concatenate([self.rows, rows])

    def remove(self, index: NDArray[np.intp], version: int) -> None:
        """Take rows out of the table."""
        rows = self.rows[index]
        self._part_with(rows["id"][rows["confirmed"]], version)
        self.rows = np.delete(self.rows, index)

    def _part_with(self, ids: NDArray[np.int64], version: int) -> None:
        for stall_id in ids.tolist():
            self.gone.note(stall_id, version)
            self._just_gone.append(stall_id)

    def _merge(self, look: Look) -> None:
        """Keep one of two rows that overlap: a given one, then a valid one before others, then the older id."""
        if len(self.rows) < 2:
            return
        fresh = np.flatnonzero(self.rows["touched"] == look.version)
        if len(fresh) == 0:
            return
        places = np.stack([self.rows["north"], self.rows["east"]], -1)
        low, high = places[fresh].min(0) - _CLOSE_M, places[fresh].max(0) + _CLOSE_M
        about = np.flatnonzero(((places >= low) & (places <= high)).all(1))
        pairs = about[cKDTree(places[about]).query_pairs(_CLOSE_M, output_type="ndarray")]
        pairs = pairs[(self.rows["touched"][pairs] == look.version).any(1)]
        if len(pairs) == 0:
            return
        pairs = np.unique(np.sort(pairs, 1), axis=0)
        pairs = pairs[~self.rows["given"][pairs].all(1)]
        overlap = quads.overlap_more(
            table.corners_of(self.rows[pairs[:, 0]]), table.corners_of(self.rows[pairs[:, 1]]), _OVERLAP
        )
        losers: set[int] = set()
        for first, second in pairs[overlap]:
            if first not in losers and second not in losers:
                losers.add(int(min((first, second), key=self._standing)))
        self.remove(np.array(sorted(losers), np.intp), look.version)

    def _standing(self, index: int) -> tuple[bool, bool, bool, int]:
        row = self.rows[index]
        return bool(row["given"]), bool(row["confirmed"]), not row["inferred"], -int(row["id"])


def _vote(rows: table.Rows, taken: Floats, visible: Floats, weight: Floats, look: Look) -> None:
    """Count a look at stalls (N,): the probability that each is taken, the share of each that is in the picture."""
    votes = np.where(_shows_change(rows, taken), np.maximum(weight, look.change), weight)
    votes *= np.clip(visible, 0, 1)
    rows["taken"] = np.clip(rows["taken"] + votes * _taken_log_odds(taken), -_TAKEN_LIMIT, _TAKEN_LIMIT)
    rows["looks"] += weight
    rows["seen"] += 1
    rows["blurred"] += look.is_blurred
    rows["last_seen"] = look.time
    rows["state"] = call_state(rows["taken"], rows["state"])
    rows["touched"] = look.version


def _shows_change(rows: table.Rows, taken: Floats) -> NDArray[np.bool_]:
    """Return True (N,) for the stalls that a look shows clearly in another state than the called one."""
    came = (rows["state"] != table.TAKEN) & (taken >= _CHANGED)
    left = (rows["state"] != table.FREE) & (taken <= 1 - _CHANGED)
    return np.asarray(came | left)


def _lies_on(found: table.Detections, rows: table.Rows) -> Mask:
    """Return which found stalls (N,) lie on one of the rows."""
    on = np.zeros(len(found), np.bool_)
    if len(found) and len(rows):
        places = np.column_stack([found.north, found.east])
        i, j = quads.near_pairs(places, np.column_stack([rows["north"], rows["east"]]), _ON_GIVEN_M)
        shapes = quads.corners(found.north, found.east, found.angle, found.width, found.length)
        on[i[quads.overlap_more(shapes[i], table.corners_of(rows[j]), _ON_GIVEN)]] = True
    return on


def note_leans(rows: table.Rows, leans: NDArray[np.float64]) -> None:
    """Add a measured lean (share of the drone's movement, see `Slip`) to each of the stalls (N,); NaN: not measured."""
    is_known = np.isfinite(leans)
    rows["lean_looks"] = np.minimum(rows["lean_looks"] + is_known, _MOST_LEAN_LOOKS)
    step = (np.where(is_known, leans, 0) - rows["lean"]) / np.maximum(rows["lean_looks"], 1)
    rows["lean"] += np.where(is_known, step, 0)
    rows["raised"] = rows["lean"] > RAISED + _LEAN_SIGMA / np.sqrt(np.maximum(rows["lean_looks"], 1))


def call_state(taken: Floats, before: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the states of log-odds ``taken``, with hysteresis about the states before."""
    keep_taken = (before == table.TAKEN) & (taken > _KEEP)
    keep_free = (before == table.FREE) & (taken < -_KEEP)
    is_taken = (taken >= _CALL) | keep_taken
    is_free = (taken <= -_CALL) | keep_free
    return np.where(is_taken, table.TAKEN, np.where(is_free, table.FREE, table.UNKNOWN)).astype(np.int64)


def score_of(exists: Floats) -> Floats:
    """Return the score (0..1) with which one look would give these log-odds of a stall."""
    return np.clip(_SCORE_ZERO + exists / _SCORE_GAIN, 0, 1)


def others(count: int, index: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the indices below ``count`` that are not in ``index``."""
    return np.delete(np.arange(count), index)


def _novelty(looks: Floats, weight: float) -> Floats:
    return np.clip(1 - looks, weight, 1)


def _geometry_weight(found: table.Detections) -> Floats:
    """Return the weights (N,): stalls cut by the picture's edge determine little of their centre and length."""
    return np.clip(found.score, 0.05, 1) * np.where(found.visible >= _WHOLE, 1.0, 0.05)


def _fuse_geometry(rows: table.Rows, found: table.Detections, weight: Floats) -> None:
    weight = weight * _geometry_weight(found)
    total = rows["solidity"] + weight
    rate = weight / np.maximum(total, 1e-9)
    for name, value in table.columns_of(found):
        rows[name] += (value - rows[name]) * rate
    norm = np.maximum(np.hypot(rows["cos2"], rows["sin2"]), 1e-9)
    rows["cos2"] /= norm
    rows["sin2"] /= norm
    rows["solidity"] = np.minimum(total, _SOLID)


def _taken_log_odds(taken: Floats) -> Floats:
    edge = 1 / (1 + np.exp(_TAKEN_LOOK))
    p = np.clip(taken, edge, 1 - edge)
    return np.asarray(np.log(p / (1 - p)))
