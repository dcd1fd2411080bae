"""Parts of long lists, with the keys of ``/api/v1``: lots, layouts, stalls, zones, surveys and observations.

Each list has an order that lasts, and a part begins behind the last item of the one before: neither a long archive nor
an item that was added meanwhile makes a part slow or wrong.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeVar

import numpy as np
from sqlalchemy import ColumnElement, Connection, Row, Select, and_, func, select, true, tuple_

from hawk.lots.answers import (
    ChangeList,
    LayoutList,
    ListedStall,
    Lot,
    LotList,
    Observation,
    ObservationList,
    Part,
    PlacedStall,
    PlacedStallList,
    Stall,
    StallList,
    Survey,
    SurveyList,
    Zone,
    ZoneList,
)
from hawk.lots.labels import parts_of
from hawk.lots.plan.queries import hidden_stalls, in_plan, is_of_row
from hawk.lots.plan.serialize import layout_of
from hawk.lots.plan.values import BARE, LASTING, PRIVATE
from hawk.lots.queries import (
    CHANGE_SHOWN,
    SURVEY_SHOWN,
    NextDue,
    change_of,
    listed_lots,
    lot_row,
    never_due,
    survey_row,
    surveys_of,
    whole_lot,
)
from hawk.lots.registration.georeference import on_earth
from hawk.lots.registration.survey_place import datum_of
from hawk.lots.storage.outlines import ring_of
from hawk.lots.storage.rows import is_among, readable
from hawk.lots.storage.schema import CHANGE, FORMER, LAYOUT, LOT, OBSERVATION, STALL, SURVEY, ZONE
from hawk.lots.survey.order import is_last_look
from hawk.lots.values import DAMAGED, LotInputError, LotStoreError, NotFoundError, moment

_DEGREES: Final = 8
"""Decimals: a millimetre."""
_LONGEST_NUMBER: Final = 15
Found = dict[str, Any]
P = TypeVar("P", bound=Part)


@dataclass(frozen=True, slots=True)
class Asked:
    """The part of a list that is asked for: ``limit`` items at most, behind the place ``after``; None: from the first.

    ``newest_first`` turns the order of surveys and observations round. ``of``: conditions that lots, surveys,
    changes and looks must meet.
    """

    limit: int = 100
    after: str | None = None
    newest_first: bool = False
    of: Sequence[ColumnElement[bool]] = field(default=(), repr=False)


def lots(connection: Connection, asked: Asked, due: NextDue = never_due) -> LotList:
    """Return lots that were not merged into another one, the oldest first. Raises LotInputError for the place."""
    is_behind: ColumnElement[bool] = true()
    if asked.after is not None:
        last = select(LOT.c.made, LOT.c.id).where(LOT.c.id == asked.after, *asked.of)
        row = connection.execute(last).one_or_none()
        if row is None:
            raise _no_place()
        is_behind = tuple_(LOT.c.made, LOT.c.id) > tuple_(row.made, row.id)
    rows = select(LOT).where(LOT.c.merged_into.is_(None), is_behind, *asked.of).order_by(LOT.c.made, LOT.c.id)
    found = _rows(connection, rows, asked)
    items = listed_lots(connection, [row._mapping for row in found[: asked.limit]], due)
    return _cut(LotList, items, found, asked, lambda row: str(row.id))


def lot(connection: Connection, lot_id: str, due: NextDue = never_due) -> Lot:
    """Return a lot with its place on Earth, and who edits its plan. Raises NotFoundError."""
    row = lot_row(connection, lot_id).values
    assert row is not None  # noqa: S101 - it is there
    return whole_lot(connection, row, due)


def layouts(connection: Connection, lot_id: str, asked: Asked) -> LayoutList:
    """Return the versions of a lot's layout, the first one first. Raises NotFoundError, LotInputError."""
    lot_row(connection, lot_id)
    rows = select(LAYOUT).where(LAYOUT.c.lot == lot_id, *behind(LAYOUT.c.version, asked)).order_by(LAYOUT.c.version)
    return part_of(LayoutList, connection, rows, asked, layout_of, lambda row: str(row.version))


def zones(connection: Connection, lot_id: str, asked: Asked) -> ZoneList:
    """Return the zones of a lot's plan, those without stalls too, by their ids. Raises NotFoundError, LotInputError."""
    lot_row(connection, lot_id)
    is_behind = true() if asked.after is None else ZONE.c.id > asked.after
    rows = select(ZONE).where(in_plan(ZONE.c, lot_id), is_behind).order_by(ZONE.c.id)
    datum = datum_of(connection, lot_id)

    def shown(row: Row[Any]) -> Zone:
        corners = [list(corner) for corner in ring_of(row.outline)]
        kind = "" if row.kind in BARE else row.kind
        return Zone(
            id=row.id, name=row.name, kind=kind, has_stalls=row.kind not in BARE,
            is_private=row.kind == PRIVATE, outline=corners,
            ground=places_on_earth(datum, corners),
        )  # fmt: skip

    return part_of(ZoneList, connection, rows, asked, shown, lambda row: str(row.id))


def surveys(connection: Connection, asked: Asked, lot_id: str | None = None) -> SurveyList:
    """Return surveys in the order in which they were stored; None: those of every lot, and of none.

    Raises NotFoundError, LotInputError.
    """
    if lot_id is not None:
        lot_row(connection, lot_id)
    is_of = true() if lot_id is None else SURVEY.c.lot == lot_id
    rows = select(*SURVEY_SHOWN).where(is_of, *asked.of, *behind(SURVEY.c.seq, asked))
    in_order = rows.order_by(SURVEY.c.seq.desc() if asked.newest_first else SURVEY.c.seq)
    found = _rows(connection, in_order, asked)
    items = surveys_of(connection, [row._mapping for row in found[: asked.limit]])
    return _cut(SurveyList, items, found, asked, lambda row: str(row.seq))


def survey(connection: Connection, survey_id: str) -> Survey:
    """Return a survey by its id. Raises NotFoundError."""
    seq = survey_row(connection, survey_id).key[0]
    shown = select(*SURVEY_SHOWN).where(SURVEY.c.seq == seq)
    found = surveys_of(connection, connection.execute(shown).mappings().all())
    if not found:
        raise LotStoreError(DAMAGED)
    return found[0]


_LOOK: Final = (
    OBSERVATION.c.state, OBSERVATION.c.taken_probability, OBSERVATION.c.looked_at, OBSERVATION.c.picture_count,
)  # fmt: skip


_LABEL_THEN: Final = func.coalesce(
    select(FORMER.c.label)
    .where(FORMER.c.stall == STALL.c.key, FORMER.c.lot == SURVEY.c.lot, FORMER.c.ends > SURVEY.c.layout)
    .order_by(FORMER.c.ends)
    .limit(1)
    .scalar_subquery(),
    STALL.c.label,
).label("label")
"""The label that a stall has in the layout of a survey."""


def changes(connection: Connection, asked: Asked, lot_id: str | None = None) -> ChangeList:
    """Return the changes that persons made, the newest first; None: those of every lot. Raises LotInputError."""
    is_of = true() if lot_id is None else CHANGE.c.lot == lot_id
    is_asked = (CHANGE.c.edit.is_(None), is_of, *asked.of, *behind(CHANGE.c.seq, replace(asked, newest_first=True)))
    in_order = select(*CHANGE_SHOWN).where(*is_asked).order_by(CHANGE.c.seq.desc())
    return part_of(
        ChangeList, connection, in_order, asked, lambda row: change_of(connection, row), lambda row: str(row.seq)
    )  # fmt: skip


def stalls(
    connection: Connection, lot_id: str, asked: Asked, *, row: str | None = None, kind: str | None = None,
    state: str | None = None,
) -> StallList:  # fmt: skip
    """Return the stalls of a lot's plan with the last look at each, in the order of the store.

    Args:
        connection: The store.
        lot_id: The lot.
        asked: Which part.
        row: Name of a row.
        kind: Kind of the stalls, "" for normal ones.
        state: State at the last look.

    Raises:
        NotFoundError: There is no such lot.
        LotInputError: The place is not in this list.
    """
    lot_row(connection, lot_id)
    conditions = [in_plan(STALL.c, lot_id), *behind(STALL.c.key, asked)]
    if row is not None:
        conditions.append(is_of_row(STALL.c.label, row))
    if kind is not None:
        conditions.append(STALL.c.kind == kind)
    if state is not None:
        conditions.append(OBSERVATION.c.state == state)
    rows = _with_look(connection, *conditions).order_by(STALL.c.key)
    found = _rows(connection, rows, asked)
    placed = _placed(connection, lot_id, found)
    pairs = zip(placed, found, strict=True)
    items = readable(lambda pair: ListedStall(**pair[0], **_look_of(pair[1])), pairs)
    return _cut(StallList, items, found, asked, _key_of)


def stall(connection: Connection, stall_id: str) -> Stall:
    """Return a stall by its id, of any layout; none on private ground. Raises NotFoundError."""
    found = connection.execute(_with_look(connection, STALL.c.id == stall_id)).one_or_none()
    if found is None or found.key in hidden_stalls(connection, [found.lot]):
        raise NotFoundError("stall: there is none with this id; read the stalls of the lot again")
    (shown,) = _placed(connection, found.lot, [found])
    return Stall(lot=found.lot, begins=found.begins, ends=found.ends, **shown, **_look_of(found))


def _with_look(connection: Connection, *conditions: ColumnElement[bool]) -> Select[Any]:
    columns = (*(STALL.c[name] for name in ("key", "id", "lot", "begins", "ends", *LASTING)), SURVEY.c.id.label("by"))
    joined = STALL.outerjoin(OBSERVATION, is_last_look(connection)).outerjoin(
        SURVEY, SURVEY.c.seq == OBSERVATION.c.survey
    )
    return select(*columns, *_LOOK).select_from(joined).where(*conditions)


def _look_of(row: Row[Any]) -> Found:
    return {
        "state": row.state,
        "taken_probability": row.taken_probability,
        "observed": None if row.looked_at is None else moment(row.looked_at),
        "survey": row.by,
    }


def stalls_of_layout(connection: Connection, lot_id: str, version: int, asked: Asked) -> PlacedStallList:
    """Return the stalls of a version of a lot's layout as they were in it. Raises NotFoundError, LotInputError."""
    lot_row(connection, lot_id)
    is_there = select(LAYOUT.c.version).where(LAYOUT.c.lot == lot_id, LAYOUT.c.version == version)
    if connection.execute(is_there).scalar() is None:
        raise NotFoundError(f"layout: there is no version {version}; read the list of the layouts again")
    columns = (STALL.c[name] for name in ("key", "id", *LASTING))
    rows = select(*columns).where(in_plan(STALL.c, lot_id, version), *behind(STALL.c.key, asked))
    found = _rows(connection, rows.order_by(STALL.c.key), asked)
    among = {"among": json.dumps([row.key for row in found])}
    is_former = and_(FORMER.c.lot == lot_id, FORMER.c.ends > version, is_among(FORMER.c.stall))
    former = connection.execute(select(FORMER).where(is_former).order_by(FORMER.c.ends.desc()), among)
    were = {row.stall: row for row in former}  # that of the smallest `ends` is last
    items = _placed(connection, lot_id, [were.get(row.key, row) for row in found])
    named = readable(lambda pair: PlacedStall(**pair[0] | {"id": pair[1].id}), zip(items, found, strict=True))
    return _cut(PlacedStallList, named, found, asked, _key_of)


def _placed(connection: Connection, lot_id: str, rows: Sequence[Row[Any]]) -> list[Found]:
    """Return stalls with their places on Earth; a former one has its key for an id."""
    if not rows:
        return []
    places = places_on_earth(datum_of(connection, lot_id), [(row.north, row.east) for row in rows])
    return [
        {
            "id": getattr(row, "id", None),
            **{name: getattr(row, name) for name in LASTING},
            "row": None if (parts := parts_of(row.label)) is None else parts[0],
            "latitude": latitude,
            "longitude": longitude,
        }
        for row, (latitude, longitude) in zip(rows, places, strict=True)
    ]


def places_on_earth(datum: tuple[float, float], places: Sequence[Sequence[float]]) -> list[list[float]]:
    """Return places (north, east) of a lot's frame as [latitude, longitude]."""
    found: list[list[float]] = np.round(on_earth(datum, np.array(places, np.float64).reshape(-1, 2)), _DEGREES).tolist()
    return found


def observations(
    connection: Connection, asked: Asked, *, lot_id: str | None = None, survey_id: str | None = None,
    stall_id: str | None = None,
) -> ObservationList:  # fmt: skip
    """Return the looks of surveys at stalls, survey by survey: of a lot, of a survey, of a stall, or of two of these.

    Raises NotFoundError, LotInputError.
    """
    conditions = list(asked.of)
    if lot_id is not None:
        lot_row(connection, lot_id)
        conditions.append(SURVEY.c.lot == lot_id)
    if survey_id is not None:
        conditions.append(SURVEY.c.seq == survey_row(connection, survey_id).key[0])
    if stall_id is not None:
        key = connection.execute(select(STALL.c.key).where(STALL.c.id == stall_id)).scalar()
        if key is None:
            raise NotFoundError("stall: there is none with this id; read the stalls of the lot again")
        conditions.append(OBSERVATION.c.stall == key)
    if hidden := hidden_stalls(connection):
        conditions.append(~is_among(OBSERVATION.c.stall, hidden))
    if asked.after is not None:
        conditions.append(_behind_look(asked))
    joined = SURVEY.join(OBSERVATION, OBSERVATION.c.survey == SURVEY.c.seq).join(
        STALL, STALL.c.key == OBSERVATION.c.stall
    )
    columns = (SURVEY.c.seq, SURVEY.c.id.label("by"), STALL.c.key, STALL.c.id, _LABEL_THEN, *_LOOK)
    survey_order = SURVEY.c.seq.desc() if asked.newest_first else SURVEY.c.seq
    rows = select(*columns).select_from(joined).where(*conditions).order_by(survey_order, OBSERVATION.c.stall)

    def shown(row: Row[Any]) -> Observation:
        return Observation(
            survey=row.by, stall=row.id, label=row.label, state=row.state,
            taken_probability=row.taken_probability, observed=moment(row.looked_at), picture_count=row.picture_count,
        )  # fmt: skip

    return part_of(ObservationList, connection, rows, asked, shown, lambda row: f"{row.seq}.{row.key}")


def _behind_look(asked: Asked) -> ColumnElement[bool]:
    seq, key = _numbers(asked.after or "", 2)
    is_later = SURVEY.c.seq < seq if asked.newest_first else SURVEY.c.seq > seq
    is_from = SURVEY.c.seq <= seq if asked.newest_first else SURVEY.c.seq >= seq  # the index knows where to begin
    return and_(is_from, is_later | (OBSERVATION.c.stall > key))


def behind(column: ColumnElement[int], asked: Asked) -> list[ColumnElement[bool]]:
    """Return the conditions of rows behind the place that is asked for, by a number. Raises LotInputError."""
    if asked.after is None:
        return []
    (number,) = _numbers(asked.after, 1)
    return [column < number if asked.newest_first else column > number]


def _numbers(text: str, count: int) -> list[int]:
    parts = text.split(".")
    if len(parts) != count or not all(p.isascii() and p.isdecimal() and len(p) <= _LONGEST_NUMBER for p in parts):
        raise _no_place()
    return [int(part) for part in parts]


def _no_place() -> LotInputError:
    return LotInputError("after", "is no place in this list: write `next` of the part before, or leave it out")


def _rows(connection: Connection, rows: Select[Any], asked: Asked) -> Sequence[Row[Any]]:
    """Return the rows of a part, and one more where another part follows."""
    return connection.execute(rows.limit(asked.limit + 1)).all()


def part_of(
    model: type[P], connection: Connection, rows: Select[Any], asked: Asked, shown: Callable[[Row[Any]], object],
    place: Callable[[Row[Any]], str],
) -> P:  # fmt: skip
    """Return the part of a list that is asked for.

    Args:
        model: Of the list.
        connection: The store.
        rows: All rows behind the place that is asked for, in their order.
        asked: Which part.
        shown: Makes an item of a row; a damaged one is passed over.
        place: Says the place behind a row.
    """
    found = _rows(connection, rows, asked)
    return _cut(model, readable(shown, found[: asked.limit]), found, asked, place)


def _cut(
    model: type[P], items: Sequence[object], rows: Sequence[Row[Any]], asked: Asked,
    place: Callable[[Row[Any]], str],
) -> P:  # fmt: skip
    """Return the items that were asked for, with the place behind the last one where another follows."""
    following = place(rows[asked.limit - 1]) if len(rows) > asked.limit else None
    return model.model_validate({"items": items[: asked.limit], "next": following})


def _key_of(row: Row[Any]) -> str:
    return str(row.key)
