"""Takes proposals of a survey over into the layout, as one new version, or drops them.

Stalls that fit keep ids and labels. New ones get labels of ours. Both are changes that are undone once.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, TypeVar

import numpy as np
from sqlalchemy import Connection

from hawk.lots import change_log, operations
from hawk.lots.answers import Done
from hawk.lots.change_detection.proposals import LayoutProposals, proposals
from hawk.lots.change_log import Change
from hawk.lots.ingest import shape
from hawk.lots.plan import geometry
from hawk.lots.plan.checks import MOST_OVERLAP
from hawk.lots.plan.edits import checked
from hawk.lots.plan.queries import all_stalls, zones_of
from hawk.lots.plan.steps import next_key
from hawk.lots.plan.values import SHAPE, Draft, LayoutStall, shapes_of
from hawk.lots.plan.versions import check_not_edited, newest_layout
from hawk.lots.storage.rows import Row, read_rows
from hawk.lots.storage.schema import DROPPED, OBSERVATION, STALL
from hawk.lots.values import Detection, LotInputError, check_fields, checked_name, new_id

KIND: Final = "take_over"
DROP: Final = "drop"
TAKEN_OVER: Final = "taken over from a survey"
_TAKES: Final = ("survey", "begin", "end", "why")
_DROPS: Final = ("survey", "begin", "end")
T = TypeVar("T", Detection, LayoutStall)


def take_over(connection: Connection, lot: str, asked: Mapping[str, Any], who: str, now: float) -> Done:
    """Write the version of the layout that has what a person takes over of the proposals of ``survey``.

    ``begin`` and ``end`` are lists of ids, "all", or left out. "all" begins the stalls that overlap none that stays,
    and no surer one that begins; it ends no stall that a person has confirmed: those are named. Raises LotInputError,
    BeingEditedError.
    """
    check_not_edited(connection, lot)
    found = _proposals(connection, lot, asked, _TAKES)
    end = _chosen(asked, "end", found.end, [stall for stall in found.end if not stall.is_confirmed])
    ending = {stall.id for stall in end}
    begin = _chosen(asked, "begin", found.begin, _fitting(found, ending))
    if not begin and not end:
        raise LotInputError("begin", 'and end name nothing: write ids of proposals, or "all"')
    why = TAKEN_OVER if asked.get("why") in (None, "") else checked_name(asked["why"], "why")
    is_whole = len(begin) == len(found.begin)
    rows = _rows(connection, lot, found.seq, begin, ending, is_whole=is_whole)
    first = operations.layout_row(lot, _version(connection, lot), why, who, now)
    return change_log.write(connection, Change(KIND, lot, (first, *rows)), who, now)


def drop(connection: Connection, lot: str, asked: Mapping[str, Any], who: str, now: float) -> Done:
    """Drop proposals of ``survey``: the same evidence proposes them no more. Raises LotInputError."""
    found = _proposals(connection, lot, asked, _DROPS)
    begin, end = _chosen(asked, "begin", found.begin, found.begin), _chosen(asked, "end", found.end, found.end)
    if not begin and not end:
        raise LotInputError("begin", 'and end name nothing: write ids of proposals, or "all"')
    none: dict[str, object] = dict.fromkeys(("stall", *SHAPE))
    rows = [{**none, "does": "begin", **shape(stall)} for stall in begin]
    rows += [{**none, "does": "end", "stall": stall.id} for stall in end]
    dropped = []
    for row in rows:
        key = new_id()
        dropped.append(Row(DROPPED.name, (key,), {"id": key, "lot": lot, "survey": found.seq, **row}))
    return change_log.write(connection, Change(DROP, lot, tuple(dropped)), who, now)


def _proposals(connection: Connection, lot: str, asked: Mapping[str, Any], known: Sequence[str]) -> LayoutProposals:
    check_fields(asked, known)
    for found in proposals(connection, lot):
        if found.survey == asked.get("survey"):
            return found
    raise LotInputError("survey", "has no proposals for this lot: read the changes again")


def _chosen(asked: Mapping[str, Any], field: str, found: Sequence[T], every: Sequence[T]) -> list[T]:
    """Return the proposals that a field names; ``every``: those that "all" means."""
    given = asked.get(field, [])
    if given == "all":
        return list(every)
    if not isinstance(given, list):
        raise LotInputError(field, 'must be a list of ids, or "all"')
    by_id = {stall.id: stall for stall in found}
    chosen: dict[object, T] = {}
    for number, each in enumerate(given):
        known = by_id.get(each) if type(each) in (int, str) else None
        if known is None:
            raise LotInputError(f"{field}[{number}]", "is no proposal of this survey: read the changes again")
        chosen[known.id] = known
    return list(chosen.values())


def _fitting(found: LayoutProposals, ending: Collection[str]) -> list[Detection]:
    """Return the stalls that begin which a plan allows beside those that stay, the surer of two that overlap."""
    free = [stall for stall in found.begin if set(ending).issuperset(found.instead.get(stall.id, ()))]
    order = sorted(free, key=lambda stall: -stall.score)
    pairs = geometry.overlaps(shapes_of(order), np.empty((0, 5)), MOST_OVERLAP)
    worse = {order[max(one, other)].id for one, other, _ in pairs}
    return [stall for stall in free if stall.id not in worse]


def _version(connection: Connection, lot: str) -> int:
    return newest_layout(connection, lot) + 1


def _rows(
    connection: Connection, lot: str, seq: int, begin: Sequence[Detection], ending: Collection[str], *, is_whole: bool
) -> list[Row]:
    """Return the rows of stalls and looks of the next version.

    Where ``is_whole``, all that the survey found is in the layout then, and it counts as one that made the layout:
    ground that it saw is ground whose stalls are known.
    """
    version = _version(connection, lot)
    present = all_stalls(connection, lot)
    added = _added(connection, lot, begin, [stall for stall in present if stall.id in ending])
    gone = [(stall.key,) for stall in present if stall.id in ending]
    looks = read_rows(connection, OBSERVATION.name, [(seq, key) for (key,) in gone])  # it looked at another stall
    keys = {seen.id: key for key, seen in enumerate(begin, next_key(connection, STALL))}
    begun = [
        operations.stall_row(
            keys[seen.id], lot, stall.label, shape(seen), stall=stall.id, begins=version,
            first=(seq, seen.id) if is_whole else (None, None),
        )
        for seen, stall in zip(begin, added, strict=True)
    ]  # fmt: skip
    return [
        *(Row(STALL.name, key, {"ends": version}) for key in gone),
        *(Row(OBSERVATION.name, key, None) for key in looks),
        *begun,
        *operations.look_rows(seq, keys, begin),
    ]


def _added(
    connection: Connection, lot: str, begin: Sequence[Detection], ending: Sequence[LayoutStall]
) -> list[LayoutStall]:
    """Return new stalls with labels, in the order given. Raises LotInputError for what fits no plan."""
    blank = LayoutStall("", "", 0.0, 0.0, 0.0, 0.0, 0.0, "", is_confirmed=False, is_named=False)
    new = [replace(blank, id=new_id()).at([*shape(stall).values()]) for stall in begin]
    draft = Draft(added=tuple(new), ended=tuple(ending), field="begin")
    return list(checked(connection, lot, draft, zones_of(connection, lot)).added)
