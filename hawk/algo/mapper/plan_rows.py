"""The plan of a lot in the table of stalls.

A stall that a person has confirmed is given: the map takes its state from the pictures, and keeps all else. The other
stalls of the plan are as if found before: flights may move and lose them. What is found beside given stalls, and is not
in the plan, is extra: proposed to a person, and not counted. So is a find beyond them that has no company.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from hawk.algo.mapper.register import mutual_nearest
from hawk.algo.mapper.table import STALL_DTYPE, UNKNOWN, Rows, angle_of, corners_of
from hawk.algo.rows.fit import Rectangles
from hawk.algo.vision import quads

EXTRA_M: Final = 15.0
"""Ground this near to a stall of the plan is known ground: two rows and an aisle."""
_PART: Final = 4
"""From this number of finds within `EXTRA_M` of each other on, ground beyond the plan is a part of the lot that nobody
knew. Fewer are cars in a street, or what looks like them."""
_BEFORE_M: Final = -1e6
"""``born`` of a stall that earlier flights knew."""
_PRIOR: Final = 2.5
"""Log-odds of a stall of the plan that nobody has confirmed: some looks that show none end it. A given stall begins
with 0: they are what the flight has seen of it, and decide nothing."""
_ON: Final = 0.2
"""Intersection over union from which a row on a given stall is that stall."""
_NEAR_M: Final = 6.0


@dataclass(frozen=True, slots=True)
class PlanStalls:
    """Stalls (N,) of a lot's plan with their numbers from ``first`` on, and which a person ``is_confirmed`` (N,).

    ``others`` are the numbers of plans of other lots that stay.
    """

    stalls: Rectangles
    is_confirmed: NDArray[np.bool_]
    first: int = 1
    others: tuple[range, ...] = ()


def with_plan(rows: Rows, given: PlanStalls, version: int) -> tuple[Rows, NDArray[np.int64]]:
    """Return the table with the stalls of a plan (N,), and the ids of valid rows that had to go.

    A row that is a stall of the plan keeps its id and its state. New rows have the id 0. Rows of an earlier plan that
    neither this one nor the others have are rows like any other.
    """
    rows, plan, is_confirmed = rows.copy(), given.stalls, given.is_confirmed
    stays = np.zeros(len(rows), np.bool_)
    for numbers in given.others:
        stays |= (rows["plan"] >= numbers.start) & (rows["plan"] < numbers.stop)
    was_planned = (rows["plan"] > 0) & ~stays
    rows["plan"][was_planned], rows["given"][was_planned] = 0, False
    rows["touched"][was_planned] = version
    places = np.column_stack([rows["north"], rows["east"], angle_of(rows)])
    known, ours = mutual_nearest(places, plan.centres, plan.angle)
    rows["plan"][known], rows["given"][known] = ours + given.first, is_confirmed[ours]
    rows["touched"][known] = version
    rows["confirmed"][known] |= is_confirmed[ours]
    fixed = is_confirmed[ours]
    _shape(rows, known[fixed], plan, ours[fixed])
    fresh = np.setdiff1d(np.arange(len(plan)), ours)
    added = _new_rows(given, fresh, version)
    gone = _on_given(rows, np.concatenate([rows[rows["given"]], added[added["given"]]]))
    lost: NDArray[np.int64] = rows["id"][gone & rows["confirmed"]]
    return np.concatenate([rows[~gone], added]), lost


def mark_extra(rows: Rows, index: NDArray[np.intp], version: int) -> None:
    """Mark which of the rows ``index``, and of the valid ones about them, are extra; touch those that changed.

    Extra is what the plan has not, where the nearest stall of the plan is given: on known ground, or alone beyond it.
    """
    planned = np.flatnonzero(rows["plan"] > 0)
    if len(planned) == 0:
        rows["extra"][index] = False
        return
    is_asked = rows["confirmed"].copy()
    is_asked[index] = True
    beside = np.flatnonzero((rows["plan"] == 0) & is_asked)
    if len(index) == 0 or len(beside) == 0:
        return
    places = np.column_stack([rows["north"], rows["east"]])
    away, nearest = cKDTree(places[planned]).query(places[beside])
    is_beyond = away >= EXTRA_M
    extra = rows["given"][planned[nearest]] & (~is_beyond | _is_alone(rows, places, beside, is_beyond))
    is_near = cKDTree(places[index]).query(places[beside])[0] < EXTRA_M
    changed = is_near & (rows["extra"][beside] != extra)
    rows["extra"][beside[changed]] = extra[changed]
    rows["touched"][beside[changed]] = version


def _is_alone(
    rows: Rows, places: NDArray[np.float64], beside: NDArray[np.intp], is_beyond: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return which of the rows ``beside`` have too few finds beyond the known ground about them to be a lot's part."""
    found = beside[is_beyond & rows["confirmed"][beside] & ~rows["inferred"][beside]]
    if len(found) < _PART:
        return np.ones(len(beside), np.bool_)
    about = cKDTree(places[found]).query_ball_point(places[beside], EXTRA_M, return_length=True)
    return np.asarray(about < _PART)


def _shape(rows: Rows, index: NDArray[np.intp], plan: Rectangles, ours: NDArray[np.intp]) -> None:
    """Give rows the shape of stalls of the plan, as an earlier pass would have found them."""
    rows["north"][index], rows["east"][index] = plan.centres[ours].T
    rows["cos2"][index], rows["sin2"][index] = np.cos(2 * plan.angle[ours]), np.sin(2 * plan.angle[ours])
    rows["width"][index], rows["length"][index] = plan.width[ours], plan.length[ours]
    rows["born"][index] = _BEFORE_M
    for name in ("inferred", "lone", "raised", "extra"):
        rows[name][index] = False


def _new_rows(plan: PlanStalls, ours: NDArray[np.intp], version: int) -> Rows:
    rows, is_confirmed = np.zeros(len(ours), STALL_DTYPE), plan.is_confirmed[ours]
    _shape(rows, np.arange(len(ours)), plan.stalls, ours)
    rows["plan"], rows["given"] = ours + plan.first, is_confirmed
    rows["exists"], rows["solidity"], rows["state"] = np.where(is_confirmed, 0.0, _PRIOR), 1.0, UNKNOWN
    rows["confirmed"], rows["touched"] = True, version
    return rows


def _on_given(rows: Rows, given: Rows) -> NDArray[np.bool_]:
    """Return which rows (N,) lie on a given stall without being one."""
    on = np.zeros(len(rows), np.bool_)
    others = np.flatnonzero(~rows["given"])
    if len(others) and len(given):
        places, known = (np.column_stack([each["north"], each["east"]]) for each in (rows[others], given))
        i, j = quads.near_pairs(places, known, _NEAR_M)
        on[others[i[quads.overlap_more(corners_of(rows[others[i]]), corners_of(given[j]), _ON)]]] = True
    return on
