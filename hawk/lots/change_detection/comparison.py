"""A placed survey beside the newest layout: the stalls that are the same, those that only one of both has.

A row that was painted again has stalls near the former ones, some of them nearer than
`hawk.lots.registration.frames.MATCH_M`. They are others: their pitch differs, and a neighbour stands where two stalls
stood.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeVar

import numpy as np
import shapely
from shapely import Polygon, contains_xy, union_all
from shapely.geometry.base import BaseGeometry
from sqlalchemy import Connection, RowMapping, select

from hawk.lots.answers import Comparison, FoundStall, MissedStall
from hawk.lots.plan import geometry
from hawk.lots.plan.queries import all_stalls
from hawk.lots.plan.values import BARE, LayoutStall, shapes_of
from hawk.lots.registration.frames import Move, same_stalls
from hawk.lots.registration.survey_place import Findings, other_ground
from hawk.lots.storage.outlines import ring_of
from hawk.lots.storage.rows import is_among
from hawk.lots.storage.schema import LOT, SURVEY, ZONE
from hawk.lots.survey.order import newest_first
from hawk.lots.values import PLACED, Detection, Placed
from hawk.model.poses import Ring
from hawk.results.label_parts import in_order

EDGE_M: Final = 2.0
"""A stall nearer than this to the edge of what was seen is not expected to be found."""
MISSED_SCORE: Final = 0.2
"""A given stall that was looked at, with a lower score than this, was not there."""
OFF_M: Final = 0.5
OFF_WIDTH_M: Final = 0.08
OFF_STEP_M: Final = 0.2
"""A stall of a row that was painted again which is farther from the former one, or wider by more, is another one; so
is one that is off by another distance than its neighbour. Without new paint, pairs are 0.2 m apart across the stalls
and widths differ by 0.02 m (95 %, drawn lots 2 to 8 in still pictures)."""
_IS_PLACED: Final = (
    SURVEY.c.placed.in_(PLACED), SURVEY.c.north.is_not(None), SURVEY.c.seen_ground.is_not(None),
)  # fmt: skip
_CLASH: Final = 0.2
"""Share of a stall of the plan that another one's find covers where the row was painted again."""
_DOUBLE: Final = 0.3
"""Share of the smaller of two finds of one survey that is the other one's, from which they are one stall."""
_BESIDE: Final = 1.4
"""Neighbours in a row are nearer than this many widths."""
_NEAR_M: Final = 12.0
"""Stalls this near have the same error of the map."""

Floats = np.ndarray[Any, np.dtype[np.float64]]
S = TypeVar("S", LayoutStall, Detection)


@dataclass(frozen=True, slots=True)
class Compared:
    """A survey beside the layout: ``found`` stalls that the layout lacks, ``missed`` ones that it did not find.

    Found ones are in the lot's frame, put where their neighbours are in the plan. ``well_seen``: ground on which it
    would have found every stall.
    """

    seq: int
    survey: str
    found: tuple[Detection, ...] = field(repr=False)
    missed: tuple[LayoutStall, ...] = field(repr=False)
    well_seen: BaseGeometry = field(repr=False)


def placed_surveys(connection: Connection, lot: str) -> Iterator[RowMapping]:
    """Yield the surveys of a lot whose place and ground are known, the newest first."""
    asked = select(SURVEY).where(SURVEY.c.lot == lot, *_IS_PLACED)
    yield from connection.execute(asked.order_by(*newest_first())).mappings()


def newest_placed(connection: Connection, surveys: Collection[str], lot: str | None) -> list[RowMapping]:
    """Return id and datum of those of some surveys, by their ids, whose place and ground are known, the newest first.

    ``lot``: None for those of all lots.
    """
    is_of = LOT.c.merged_into.is_(None) if lot is None else LOT.c.id == lot
    asked = select(SURVEY.c.id, SURVEY.c.latitude, SURVEY.c.longitude).join(LOT, LOT.c.id == SURVEY.c.lot)
    asked = asked.where(is_among(SURVEY.c.id), is_of, *_IS_PLACED).order_by(*newest_first())
    return list(connection.execute(asked, {"among": json.dumps([*surveys])}).mappings())


def witnesses(row: RowMapping) -> tuple[tuple[Detection, ...], BaseGeometry]:
    """Return the stalls that a survey's pictures show, and the ground that it saw well, in the lot's frame."""
    looked, move = Findings.stored(row), Move.stored(row)
    shown = move.stalls([stall for stall in looked.stalls if stall.is_witness])
    return shown, looked.ground(move).buffer(-EDGE_M)


def compare(connection: Connection, lot: str, row: RowMapping) -> Compared:
    """Return a placed survey beside the newest layout of its lot."""
    shown, well_seen = witnesses(row)
    present = tuple(all_stalls(connection, lot))
    same = fitting(present, shown)
    kept, given = {*same.values()}, _given(row)
    missed = [stall for stall in present if stall.id not in kept and _is_missed(stall, given)]
    not_here = union_all([other_ground(connection, lot), *(Polygon(zone) for zone in no_stalls(connection, lot))])
    new = _put_beside(present, shown, same)
    beside = {stall.id for stall in within(not_here, new)}
    found = tuple(stall for stall in new if stall.id not in beside)
    return Compared(int(row["seq"]), str(row["id"]), found, tuple(within(well_seen, missed)), well_seen)


def newest_registered(connection: Connection, lot: str) -> Comparison:
    """Return how the newest registered survey differs from the layout.

    ``found``: its stalls that the layout lacks, in the lot's frame, without those in areas without stalls; ``missed``:
    stalls of the layout on ground that it saw, which it did not find.
    """
    row = next((row for row in placed_surveys(connection, lot) if row["placed"] == Placed.REGISTERED), None)
    if row is None:
        return Comparison(survey=None, found=[], missed=[])
    compared = compare(connection, lot, row)
    return Comparison(
        survey=compared.survey, found=[FoundStall(**found_stall(stall)) for stall in compared.found],
        missed=[MissedStall(id=stall.id, label=stall.label) for stall in in_order(compared.missed)],
    )  # fmt: skip


def found_stall(stall: Detection) -> dict[str, Any]:
    """Return the fields of `FoundStall` of a detection."""
    names = ("id", "north", "east", "angle", "width", "length")
    return {name: round(getattr(stall, name), 4) for name in names} | {"state": stall.state.value}


def no_stalls(connection: Connection, lot: str) -> list[Ring]:
    """Return the areas of a lot's plan without stalls: rings of (north, east), metres in its frame."""
    is_asked = (ZONE.c.lot == lot) & ZONE.c.kind.in_(BARE) & ZONE.c.ends.is_(None)
    return [ring_of(text) for text in connection.execute(select(ZONE.c.outline).where(is_asked)).scalars()]


def within(ground: BaseGeometry, stalls: Sequence[S]) -> list[S]:
    """Return the stalls whose centre lies on some ground."""
    places = shapes_of(stalls)[:, :2]
    return [stall for stall, lies in zip(stalls, contains_xy(ground, places).tolist(), strict=True) if lies]


def fitting(present: Sequence[LayoutStall], shown: Sequence[Detection]) -> dict[int, str]:
    """Return which stall of the plan each found one is, as `same_stalls`, without those of rows painted again.

    From each stall of the plan that another one's find covers, the row is followed as long as its pairs differ in place
    or width: these are no pairs.
    """
    same = same_stalls(present, shown)
    number = {stall.id: k for k, stall in enumerate(present)}
    pair = {number[known]: stall for stall in shown if (known := same.get(stall.id)) is not None}
    off = _Off.of(present, [pair.get(k) for k in range(len(present))])
    covered = _covered(present, shown, {number[known]: at for at, known in same.items()})
    open_ends = [k for k in covered if off.is_off[k]]
    beside = _neighbours(shapes_of(present))
    reached = set(open_ends)
    while open_ends:
        here = open_ends.pop()
        for k in beside[here]:
            if k not in reached and (off.is_off[k] or off.has_step(here, k)):
                reached.add(k)
                open_ends.append(k)
    broken = {pair[k].id for k in reached if k in pair}
    return {found: known for found, known in same.items() if found not in broken}


@dataclass(frozen=True, slots=True)
class _Off:
    """``across``: by how much the pair of each stall of the plan is off across it, metres; NaN without one (N,)."""

    across: Floats
    is_off: list[bool]

    @classmethod
    def of(cls, present: Sequence[LayoutStall], pairs: Sequence[Detection | None]) -> _Off:
        here = shapes_of(present)
        there = np.array([_shape(pair) for pair in pairs], np.float64).reshape(-1, 5)
        away = there[:, :2] - here[:, :2]
        across = away[:, 1] * np.cos(here[:, 2]) - away[:, 0] * np.sin(here[:, 2])
        fits = (np.hypot(*away.T) <= OFF_M) & (np.abs(there[:, 3] - here[:, 3]) <= OFF_WIDTH_M)
        return cls(across, (~fits).tolist())

    def has_step(self, one: int, other: int) -> bool:
        """Return whether the pairs of two neighbours are off by another distance."""
        return bool(abs(self.across[one] - self.across[other]) > OFF_STEP_M)


def _shape(stall: Detection | None) -> tuple[float, ...]:
    return (np.nan,) * 5 if stall is None else stall.shape


def _covered(present: Sequence[LayoutStall], shown: Sequence[Detection], own: Mapping[int, int]) -> list[int]:
    """Return the numbers of stalls of the plan that a find covers which is not their own (``own``: number -> id)."""
    pairs = geometry.overlaps_between(shapes_of(present), shapes_of(shown), _CLASH)
    return list(dict.fromkeys(k for k, n, _ in pairs if own.get(k) != shown[n].id))


def _neighbours(shapes: Floats) -> Mapping[int, list[int]]:
    """Return the numbers of the stalls beside each one."""
    found: dict[int, list[int]] = defaultdict(list)
    points = shapely.points(shapes[:, :2])
    reach = _BESIDE * shapes[:, 3]
    for one, other in shapely.STRtree(points).query(points, predicate="dwithin", distance=reach).T.tolist():
        if one != other:
            found[one].append(other)
    return found


def _put_beside(present: Sequence[LayoutStall], shown: Sequence[Detection], same: Mapping[int, str]) -> list[Detection]:
    """Return the stalls without a pair, moved as the pairs near them are off: the map errs alike there."""
    doubles = _doubles(shown, same)
    new = [stall for stall in shown if stall.id not in same and stall.id not in doubles]
    pairs = [stall for stall in shown if stall.id in same]
    if not new or not pairs:
        return new
    known = {stall.id: stall for stall in present}
    here = shapes_of(pairs)[:, :2]
    off = shapes_of([known[same[stall.id]] for stall in pairs])[:, :2] - here
    tree, moved = shapely.STRtree(shapely.points(here)), []
    for stall in new:
        near = tree.query(shapely.Point(stall.north, stall.east), predicate="dwithin", distance=_NEAR_M)
        north, east = off[near].mean(axis=0).tolist() if len(near) else (0.0, 0.0)
        moved.append(replace(stall, north=stall.north + north, east=stall.east + east))
    return moved


def _doubles(shown: Sequence[Detection], same: Mapping[int, str]) -> set[int]:
    """Return the finds that lie on a better one of the same survey: one that has a pair, or is surer."""
    order = sorted(shown, key=lambda stall: (stall.id not in same, -stall.score, stall.id))
    found = geometry.overlaps(shapes_of(order), np.empty((0, 5)), _DOUBLE)
    return {order[max(one, other)].id for one, other, _ in found}


def _given(row: RowMapping) -> dict[str, float]:
    """Return the score of each stall that the plan gave to a flight, by its id in the plan."""
    return {stall.known: stall.score for stall in Findings.stored(row).stalls if stall.known}


def _is_missed(stall: LayoutStall, given: Mapping[str, float]) -> bool:
    """Return whether a stall that was not found should have been: a flight says how it saw those that it was given."""
    if stall.id in given:
        return given[stall.id] < MISSED_SCORE
    return not (given and stall.is_confirmed)  # the flight knew it, and never looked
