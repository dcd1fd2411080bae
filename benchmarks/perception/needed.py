"""Operations that a person needs to correct what vision finds in a picture until it is what the labels say.

A run of missing stalls side by side is one row to add, a run of false ones one removal, and a run that lies aside of
its labels one move: the plan's editor selects and moves stalls of a row together. A row that was found in pieces is
removed and added as a whole where that takes fewer operations.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from benchmarks.figures import Figure, Limit
from benchmarks.perception.edges import counted
from benchmarks.perception.eyes import Eye
from benchmarks.perception.places import Place
from benchmarks.perception.stall_rows import Boxes, Rows, neighbours
from hawk.survey.accuracy import NEAR_M, FloatArray, match

LIMITS = {"places": 1.0, "regions": 1.5}
"""Most operations for ten stalls."""
_ASIDE = 0.15
"""A find that overlaps a label by more, intersection over union, is that stall in another place."""


@dataclass(frozen=True, slots=True)
class Needed:
    """Operations that one place needs. ``stalls`` are its labels."""

    name: str
    stalls: int
    rows: int
    removals: int
    moves: int

    @property
    def operations(self) -> int:
        """All of them."""
        return self.rows + self.removals + self.moves


def needed(eye: Eye, place: Place) -> Needed:
    """Look at a place and count the operations; labels that the picture's edge cuts are left out."""
    kept = counted(eye.look(place.image, place.metres_per_pixel), place)
    found, labels = kept.result.finding.stalls, kept.truth.stalls
    pairs = match(found, labels)
    free_finds, missed = np.ones(len(found), np.bool_), np.ones(len(labels), np.bool_)
    free_finds[pairs.found], missed[pairs.true] = False, False
    aside_find, aside_label = _aside(found, labels, free_finds, missed)
    free_finds[aside_find], missed[aside_label] = False, False
    false = found[free_finds]
    false = false[_is_false(place, labels, false)]
    moved = np.zeros(len(labels), np.bool_)
    moved[aside_label] = True
    rows, again, moves = _rows(labels, missed, moved)
    return Needed(place.name, len(labels), rows=rows, removals=len({*run_of(false).tolist()}) + again, moves=moves)


def _rows(labels: FloatArray, missed: NDArray[np.bool_], moved: NDArray[np.bool_]) -> tuple[int, int, int]:
    """Return rows to add, rows to remove before that, and moves."""
    rows = removals = moves = 0
    axis = Rows.of(labels).axis
    row = run_of(labels, axis)
    for number in np.unique(row).tolist():
        mine = row == number
        pieces, shifts = (len({*run_of(labels[mine & some], axis[mine & some]).tolist()}) for some in (missed, moved))
        is_found = bool((mine & ~missed).any())
        if pieces + shifts > 1 + is_found:
            rows, removals = rows + 1, removals + is_found
        else:
            rows, moves = rows + pieces, moves + shifts
    return rows, removals, moves


def run_of(stalls: FloatArray, axis: NDArray[np.int_] | None = None) -> NDArray[np.intp]:
    """Return the number (N,) of the run of stalls (N, 4, 2) that each is in: side by side, or head to foot.

    ``axis`` (N,) as in `Rows`; None: by these stalls alone.
    """
    if not len(stalls):
        return np.zeros(0, np.intp)
    boxes, axis = Boxes.of(stalls), Rows.of(stalls).axis if axis is None else axis
    side = np.abs(neighbours(boxes, boxes))
    lengthwise = (axis == 1)[:, None] & (axis == 1)[None]
    i, j = np.nonzero((side == 1) | ((side == 2) & lengthwise))
    links = coo_array((np.ones(len(i)), (i, j)), shape=(len(stalls), len(stalls)))
    return np.asarray(connected_components(links, directed=False)[1], np.intp)


def figures(group: str, places: Sequence[Needed]) -> list[Figure]:
    """Return the figures of places or regions."""
    stalls = sum(place.stalls for place in places)
    total = {
        name: sum(getattr(place, name) for place in places) for name in ("operations", "rows", "removals", "moves")
    }
    key = "operations_per_10_stalls" if group == "places" else f"operations_per_10_stalls_{group}"
    ratio = 10 * total["operations"] / stalls if stalls else None
    shown = [Figure(key, f"operations for ten stalls, {group}", ratio, limit=Limit(highest=LIMITS[group]))]
    shown += [Figure(f"{group}_{n}", f"{n}, {group}", float(total[n])) for n in ("rows", "removals", "moves")]
    return [*shown, Figure(f"{group}_stalls", f"labelled stalls, {group}", float(stalls))]


def measure(eye: Eye, group: str, places: Iterable[Place]) -> list[Figure]:
    """Count the operations of every place, print a line for each, and return the figures."""
    found = []
    for place in places:
        one = needed(eye, place)
        print(
            f"  {one.name:24s} {one.operations:3d} operations for {one.stalls:3d} stalls: {one.rows} rows to add, "
            f"{one.removals} removals, {one.moves} moves"
        )
        found.append(one)
    return figures(group, found)


def _aside(
    found: FloatArray, labels: FloatArray, free: NDArray[np.bool_], missed: NDArray[np.bool_]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return finds and labels that are one stall in two places; each at most once, the most overlap first."""
    f, m = np.flatnonzero(free), np.flatnonzero(missed)
    if not len(f) or not len(m):
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    finds, wanted = (shapely.polygons(quads) for quads in (found[f], labels[m]))
    i, j = shapely.STRtree(wanted).query(finds, predicate="intersects")
    shared = shapely.area(shapely.intersection(finds[i], wanted[j], grid_size=1e-6))
    overlap = shared / (shapely.area(finds[i]) + shapely.area(wanted[j]) - shared)
    taken_find: dict[int, int] = {}
    for k in np.argsort(-overlap).tolist():
        if overlap[k] > _ASIDE and i[k] not in taken_find and j[k] not in taken_find.values():
            taken_find[int(i[k])] = int(j[k])
    return f[list(taken_find)], m[list(taken_find.values())]


def _is_false(place: Place, labels: FloatArray, finds: FloatArray) -> NDArray[np.bool_]:
    """Return which finds (N, 4, 2) are counted false alarms, as `hawk.survey.accuracy` counts them."""
    if not len(finds):
        return np.zeros(0, np.bool_)
    points = shapely.points(finds.mean(axis=1))
    stalls = shapely.union_all(shapely.polygons(labels)) if len(labels) else shapely.Polygon()
    lots = shapely.union_all([shapely.Polygon(lot).buffer(0) for lot in place.truth.lots])
    near = shapely.distance(points, stalls) < NEAR_M
    return np.asarray(near | ~shapely.contains(lots, points), np.bool_)
