"""Proposals to change a layout after what placed surveys show: stalls that begin, and stalls that end.

A person decides. What a person has decided already is not proposed again by the same evidence: a stall that was
removed, moved or dropped comes back only when a later survey did not find it there and another one did; a stall whose
end was dropped ends only after a later survey found it. A stall that no survey ever found, such as a bay under trees,
never ends.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import Any, Final

import numpy as np
import shapely
from shapely import contains_xy
from shapely.geometry.base import BaseGeometry
from sqlalchemy import Connection, RowMapping, func, or_, select

from hawk.lots.answers import BeginProposal, DoubtfulSurvey, EndProposal, Proposals, SurveyProposals
from hawk.lots.change_detection.comparison import (
    OFF_M,
    OFF_WIDTH_M,
    Compared,
    Floats,
    compare,
    found_stall,
    placed_surveys,
    within,
    witnesses,
)
from hawk.lots.plan import geometry
from hawk.lots.plan.checks import MOST_OVERLAP
from hawk.lots.plan.queries import all_stalls
from hawk.lots.plan.values import SHAPE, LayoutStall, shapes_of
from hawk.lots.registration.frames import MATCH_M
from hawk.lots.registration.georeference import corners_on_earth
from hawk.lots.registration.survey_place import Doubt, datum_of
from hawk.lots.storage.schema import DROPPED, FORMER, STALL, SURVEY
from hawk.lots.survey.order import newest_first
from hawk.lots.values import Detection, Placed, moment
from hawk.results.label_parts import in_order

SURVEYS: Final = 5
"""Newest surveys that are asked: an older one says only what newer ones have not seen."""
_WIDTH_M: Final = 0.2
"""A stall that is wider by more than one that a person removed is another one."""
_ALIKE: Final = 0.2
"""Radians by which the directions of two stalls that are one may differ."""


@dataclass(frozen=True, slots=True)
class LayoutProposals:
    """Proposals of one survey. ``begin``: in the lot's frame. ``instead``: the stalls of the plan that have to end for
    one that begins, by its number in the survey.
    """

    seq: int
    survey: str
    ended: float
    begin: tuple[Detection, ...] = field(repr=False)
    end: tuple[LayoutStall, ...] = field(repr=False)
    instead: dict[int, tuple[str, ...]] = field(repr=False)


def proposals(connection: Connection, lot: str) -> list[LayoutProposals]:
    """Return the proposals of a lot's newest surveys, the newest first; those without any are left out."""
    past = list(placed_surveys(connection, lot))
    history = _History(past)
    decisions = _decisions(connection, lot)
    kept_ends = _kept_ends(connection, lot)
    newer: BaseGeometry = shapely.Polygon()
    found = []
    for row in islice(past, SURVEYS):
        compared = compare(connection, lot, row)
        ground = compared.well_seen.difference(newer)
        newer = newer.union(compared.well_seen)
        begin = _begins(compared, within(ground, compared.found), decisions, history)
        end = _ends(compared, within(ground, compared.missed), kept_ends, history)
        if begin or end:
            instead = _instead(begin, tuple(all_stalls(connection, lot)))
            found.append(LayoutProposals(compared.seq, compared.survey, row["ended"], begin, end, instead))
    return found


def proposed(connection: Connection, lot: str) -> Proposals:
    """Return the proposals of a lot's surveys, and its surveys that wait for a place.

    Corners are WGS-84. Raises no error for a lot without surveys.
    """
    datum = datum_of(connection, lot)
    found = [_shown(each, datum) for each in proposals(connection, lot)]
    return Proposals(lot=lot, datum=list(datum), surveys=found, doubtful=list(_in_doubt(connection, lot)))


def _shown(found: LayoutProposals, datum: tuple[float, float]) -> SurveyProposals:
    begin = [
        BeginProposal(**found_stall(stall), instead=list(found.instead.get(stall.id, ())), corners=corners)
        for stall, corners in zip(found.begin, corners_of(datum, found.begin), strict=True)
    ]
    ending = in_order(found.end)
    end = [
        EndProposal(id=stall.id, label=stall.label, is_confirmed=stall.is_confirmed, corners=corners)
        for stall, corners in zip(ending, corners_of(datum, ending), strict=True)
    ]
    return SurveyProposals(survey=found.survey, ended=moment(found.ended), begin=begin, end=end)


def corners_of(datum: tuple[float, float], stalls: Sequence[LayoutStall] | Sequence[Detection]) -> list[Any]:
    """Return the four corners of each stall: [latitude, longitude], degrees."""
    found: list[Any] = np.round(corners_on_earth(datum, shapes_of(stalls)), 8).tolist()
    return found


def _in_doubt(connection: Connection, lot: str) -> Iterable[DoubtfulSurvey]:
    is_waiting = (SURVEY.c.placed == Placed.UNREGISTERED.value) & SURVEY.c.doubt.is_not(None)
    asked = select(SURVEY.c.id, SURVEY.c.ended, SURVEY.c.doubt).where(SURVEY.c.lot == lot, is_waiting)
    for row in connection.execute(asked.order_by(*newest_first()).limit(SURVEYS)):
        doubt = Doubt.read(row.doubt)
        if doubt is not None and doubt.places:
            yield DoubtfulSurvey(survey=row.id, ended=moment(row.ended), why=doubt.why, places=len(doubt.places))


class _History:
    """The placed surveys of a lot, each read when it is asked about."""

    def __init__(self, rows: Sequence[RowMapping]) -> None:
        self._rows = rows
        self._read: dict[int, tuple[Floats, BaseGeometry]] = {}

    def found(self, shapes: Floats, since: int, before: int) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """Return which shapes (N, 5) a survey from ``since`` to the one before ``before`` found as they are."""
        found = np.zeros(len(shapes), np.bool_)
        for row in self._between(since, before):
            if found.all():
                break
            found |= matching(shapes, self._of(row)[0], OFF_M, OFF_WIDTH_M)
        return found

    def missed(self, shape: Floats, since: int, before: int) -> bool:
        """Return whether such a survey saw the ground of a shape (5,) and found no stall there."""
        for row in self._between(since, before):
            shown, ground = self._of(row)
            if contains_xy(ground, *shape[:2]) and not matching(shape[None], shown).any():
                return True
        return False

    def _between(self, since: int, before: int) -> Iterable[RowMapping]:
        return (row for row in self._rows if since <= row["seq"] < before)

    def _of(self, row: RowMapping) -> tuple[Floats, BaseGeometry]:
        if row["seq"] not in self._read:
            shown, ground = witnesses(row)
            self._read[row["seq"]] = shapes_of(shown), ground
        return self._read[row["seq"]]


def matching(
    shapes: Floats, others: Floats, near_m: float = MATCH_M, width_m: float = np.inf
) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return which shapes (N, 5) have another one in about their place and direction."""
    found = np.zeros(len(shapes), np.bool_)
    if len(shapes) and len(others):
        tree = shapely.STRtree(shapely.points(others[:, :2]))
        mine, theirs = tree.query(shapely.points(shapes[:, :2]), predicate="dwithin", distance=near_m)
        apart = np.abs(shapes[mine, 2] - others[theirs, 2]) % np.pi
        is_same = np.minimum(apart, np.pi - apart) < _ALIKE
        found[mine[is_same & (np.abs(shapes[mine, 3] - others[theirs, 3]) <= width_m)]] = True
    return found


@dataclass(frozen=True, slots=True)
class _Decisions:
    """Places where persons want no stall: shapes (N, 5), and the newest survey that each decision knew (N,)."""

    shapes: Floats
    since: tuple[int, ...]


def _decisions(connection: Connection, lot: str) -> _Decisions:
    """Return the places of stalls that were dropped, and of those that had another place or ended."""
    found = [
        ([row[name] for name in SHAPE], int(row["survey"]))
        for row in connection.execute(select(DROPPED).where(DROPPED.c.lot == lot, DROPPED.c.does == "begin")).mappings()
    ]
    ended, former = ([table.c.ends, *(table.c[name] for name in SHAPE)] for table in (STALL, FORMER))
    is_moved = or_(*(FORMER.c[name] != STALL.c[name] for name in SHAPE))
    asked = (
        select(*ended).where(STALL.c.lot == lot, STALL.c.ends > STALL.c.begins),
        select(*former).join(STALL, STALL.c.key == FORMER.c.stall).where(FORMER.c.lot == lot, is_moved),
    )
    rows = [row for each in asked for row in connection.execute(each)]
    known: dict[int, int] = {}
    for version, *shape in rows:
        if version not in known:
            before = select(func.max(SURVEY.c.seq)).where(SURVEY.c.lot == lot, SURVEY.c.layout < version)
            known[version] = int(connection.execute(before).scalar() or 0)
        found.append((list(shape), known[version]))
    shapes = np.array([shape for shape, _ in found], np.float64).reshape(-1, 5)
    return _Decisions(shapes, tuple(since for _, since in found))


def _kept_ends(connection: Connection, lot: str) -> dict[str, int]:
    """Return the stalls that persons keep though a survey missed them: id -> the newest such survey."""
    asked = select(DROPPED.c.stall, func.max(DROPPED.c.survey)).where(DROPPED.c.lot == lot, DROPPED.c.does == "end")
    return {str(stall): int(seq) for stall, seq in connection.execute(asked.group_by(DROPPED.c.stall))}


def _begins(
    compared: Compared, found: Sequence[Detection], decisions: _Decisions, history: _History
) -> tuple[Detection, ...]:
    """Return the found stalls that nobody has decided about."""
    shapes = shapes_of(found)
    kept = []
    for k, stall in enumerate(found):
        about = np.flatnonzero(matching(decisions.shapes, shapes[k : k + 1], width_m=_WIDTH_M))
        since = max((decisions.since[n] for n in about.tolist()), default=None)
        if since is None or history.missed(shapes[k], since, compared.seq):
            kept.append(stall)
    return tuple(kept)


def _ends(
    compared: Compared, missed: Sequence[LayoutStall], kept: dict[str, int], history: _History
) -> tuple[LayoutStall, ...]:
    """Return the missed stalls that an earlier survey found by itself, after a person kept them."""
    asked = [stall for stall in missed if stall.id not in kept]
    was_found = dict(zip(asked, history.found(shapes_of(asked), 0, compared.seq).tolist(), strict=True))
    for stall in missed:
        if stall.id in kept:
            was_found[stall] = bool(history.found(shapes_of([stall]), kept[stall.id], compared.seq)[0])
    return tuple(stall for stall in missed if was_found[stall])


def _instead(begin: Sequence[Detection], present: Sequence[LayoutStall]) -> dict[int, tuple[str, ...]]:
    """Return the stalls of the plan that each new one overlaps by more than a plan allows, by its number."""
    found: dict[int, tuple[str, ...]] = {}
    for k, n, _ in geometry.overlaps_between(shapes_of(begin), shapes_of(present), MOST_OVERLAP):
        found[begin[k].id] = (*found.get(begin[k].id, ()), present[n].id)
    return found
