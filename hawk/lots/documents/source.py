"""Documents made from the store, in one read transaction: a survey as it is now, with its lot's plan."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from datetime import datetime
from operator import attrgetter
from typing import Any, Final, TypeVar

from pydantic import ValidationError
from sqlalchemy import ColumnElement, Connection, RowMapping, Select, Table, func, select, true

from hawk.formats.validation import first_wrong
from hawk.lots.documents.lot_document import FORMAT as LOT_FORMAT
from hawk.lots.documents.lot_document import (
    MOST_DUE,
    MOST_SCHEDULED,
    LotBase,
    LotDocument,
    LotDue,
    LotPart,
    kept_lot,
    plan_digest,
)
from hawk.lots.documents.lot_document import VERSION as LOT_VERSION
from hawk.lots.documents.parts import Ground, Part
from hawk.lots.documents.survey_document import FORMAT, VERSION, SurveyDocument
from hawk.lots.known_lot import newest_survey
from hawk.lots.names import schedule_names
from hawk.lots.plan.versions import revision_of
from hawk.lots.registration.survey_place import Doubt
from hawk.lots.storage.digests import check_whole
from hawk.lots.storage.outlines import outline_to_change, ring_of, unpack_outline
from hawk.lots.storage.rows import is_among
from hawk.lots.storage.schema import (
    DOCUMENT,
    FORMER,
    LAYOUT,
    LOT,
    LOT_DOCUMENT,
    OBSERVATION,
    OUTBOX,
    PIN,
    SECTION,
    SECTION_LOOK,
    STALL,
    SURVEY,
    ZONE,
)
from hawk.lots.storage.states import LOT_STATE, SURVEY_STATE
from hawk.lots.storage.tables import unpack_stalls
from hawk.lots.values import Detection, LotStoreError, NotFoundError
from hawk.model.lot_map import TileKey
from hawk.model.plans import Outline

P = TypeVar("P", bound=Part)
DUE_DAYS: Final = 30
"""Days for which a drone knows what is due at its desk."""
MomentsDue = Callable[[str, str, float | None, int], Sequence[datetime]]
"""Returns when surveys of a lot are due: its id and name, the end of its newest survey, within how many days."""
_OF_SURVEY: Final = (
    "id", "kind", "source", "source_name", "program", "simulated", "began", "ended", "time_is_sure", "latitude",
    "longitude", "accuracy", "placed", "lot", "layout",
)  # fmt: skip
_OF_LOT: Final = ("id", "name", "latitude", "longitude", "datum_is_pinned", "made", "time_zone", "merged_into")
_OF_LAYOUT: Final = ("version", "valid_from", "why", "who")
_SHAPE: Final = (
    "label", "north", "east", "angle", "width", "length", "kind", "is_confirmed", "is_named",
)  # fmt: skip
_OF_STALL: Final = ("id", *_SHAPE, "begins", "ends")
_OF_ZONE: Final = ("id", "name", "kind", "begins", "ends")
_OF_SECTION: Final = (
    "id", "name", "kind", "length_m", "capacity", "is_capacity_given", "note", "begins", "ends",
)  # fmt: skip
_OF_COUNT: Final = (
    "section", "looked_at", "source", "parked", "least", "most", "hidden_share", "seen_share", "room",
)  # fmt: skip


def document_of(connection: Connection, survey: str, mosaic: Mapping[TileKey, bytes]) -> SurveyDocument:
    """Return the document of a survey by its id; ``mosaic``: the tiles of its picture, JPEG.

    Raises NotFoundError, and LotStoreError for a survey or lot that is damaged, or that no document can say.
    """
    row = connection.execute(select(SURVEY).where(SURVEY.c.id == survey)).mappings().first()
    if row is None:
        raise NotFoundError("survey: there is no survey with this id; reload the list")
    check_whole(connection, "survey", row["seq"], "survey")
    found = [dict(zip(_FOUND, _found(stall), strict=True)) for stall in unpack_stalls(row["stalls"])]
    looks = select(STALL.c.id.label("stall"), *_columns(OBSERVATION, _LOOKED)).join(
        STALL, STALL.c.key == OBSERVATION.c.stall
    )
    of_survey = looks.where(OBSERVATION.c.survey == row["seq"]).order_by(STALL.c.id)
    counts = select(*_columns(SECTION_LOOK, _OF_COUNT)).where(SECTION_LOOK.c.survey == row["seq"])
    parts = {
        "format": FORMAT,
        "version": VERSION,
        "survey": _survey(connection, row),
        "stalls": found,
        "looks": _dicts(connection, of_survey),
        "sections": _dicts(connection, counts.order_by(SECTION_LOOK.c.section)),
        "lots": [sent_lot(connection, each) for each in sorted(_lots_about(connection, row))],
        "mosaic": [
            {"row": key[0], "column": key[1], "jpeg": base64.b64encode(data)} for key, data in sorted(mosaic.items())
        ],
    }
    return _made(SurveyDocument, parts)


_FOUND: Final = tuple(each.name for each in fields(Detection))
_found: Final = attrgetter(*_FOUND)
_LOOKED: Final = ("looked_at", "taken_probability", "state", "picture_count")


def _lots_about(connection: Connection, row: RowMapping) -> set[str]:
    """Return the lot of a survey, those whose stalls it looked at, and all that became part of them, or they of."""
    looked = select(STALL.c.lot).distinct().join(OBSERVATION, OBSERVATION.c.stall == STALL.c.key)
    return _with_parts(
        connection, {row["lot"], *connection.execute(looked.where(OBSERVATION.c.survey == row["seq"])).scalars()}
    )


def _with_parts(connection: Connection, lots: Iterable[str | None]) -> set[str]:
    """Return lots with all that became part of them, or they of."""
    about = {each for each in lots if each is not None}
    found: set[str] = set()
    while about - found:
        found |= about
        among = {"among": json.dumps([*found])}
        for one, other in ((LOT.c.id, LOT.c.merged_into), (LOT.c.merged_into, LOT.c.id)):
            about |= {*connection.execute(select(one).where(is_among(other)), among).scalars()} - {None}
    return found


def _survey(connection: Connection, row: RowMapping) -> dict[str, Any]:
    doubt = Doubt.read(row["doubt"])
    place = None if row["north"] is None else {name: row[name] for name in ("north", "east", "turn")}
    seen = None if row["seen_ground"] is None else _ground(unpack_outline(row["seen_ground"]))
    return {
        **{name: row[name] for name in _OF_SURVEY},
        "name": str(row["origin"]).rsplit(" ", 2)[0],
        "state": _state(connection, SURVEY_STATE, row["id"]),
        "landing": row["seq"],
        "limits": json.loads(row["limits"]),
        "outline": _ground(outline_to_change(row["outline"])),
        "seen_ground": seen,
        "place": place,
        "candidates": json.loads(row["candidates"]),
        "doubt": None if doubt is None else asdict(doubt),
    }


def document_of_lot(connection: Connection, lot: str) -> LotDocument | None:
    """Return the document by which a lot's state is sent to a desk; None where the desk has given it so, and for one
    that is gone. Raises LotStoreError for a lot that is damaged, or that no document can say.
    """
    if connection.execute(select(LOT.c.id).where(LOT.c.id == lot)).first() is None:
        return None
    part = lot_part(connection, lot)
    if (came := came_from_desk(connection, lot)) is not None and not came.is_changed(connection, part):
        return None
    lots = tuple(sent_lot(connection, each) for each in sorted(_with_parts(connection, [lot])))
    return LotDocument(format=LOT_FORMAT, version=LOT_VERSION, state=part.state, lots=lots)


def changed_lots(connection: Connection, after: int, limit: int, writer: str | None) -> LotDocument:
    """Return the lots with newer states than a number, in their order.

    Args:
        connection: One that reads.
        after: The number, of an earlier document.
        limit: The most lots; those that became part of them are beside.
        writer: Drone that has sent a survey of them, or their plans; None: all lots.
    """
    asked = select(OUTBOX.c.seq, OUTBOX.c.body).where(OUTBOX.c.kind == LOT_STATE, OUTBOX.c.seq > after)
    asked = asked.where(OUTBOX.c.body.in_(select(LOT.c.id)), _is_of(OUTBOX.c.body, writer))
    rows = connection.execute(asked.order_by(OUTBOX.c.seq).limit(limit)).all()
    newest = select(func.max(OUTBOX.c.seq)).where(OUTBOX.c.kind == LOT_STATE)
    reached = min(after, connection.execute(newest).scalar() or 0)
    lots = []
    for lot in sorted(_with_parts(connection, [row.body for row in rows])):
        part = lot_part(connection, lot)
        lots.append(part.model_copy(update={"base": LotBase.of(part)}))
    state = rows[-1].seq if rows else reached
    return LotDocument(format=LOT_FORMAT, version=LOT_VERSION, state=state, lots=tuple(lots))


def lots_due(connection: Connection, moments_of: MomentsDue, writer: str | None) -> tuple[LotDue, ...]:
    """Return when surveys of lots are due in the next `DUE_DAYS`; a lot that is in no schedule is left out.

    ``writer``: as of `changed_lots`.
    """
    lots = select(LOT.c.id, LOT.c.name).where(LOT.c.merged_into.is_(None), _is_of(LOT.c.id, writer))
    found: list[LotDue] = []
    rows = connection.execute(lots.order_by(LOT.c.made, LOT.c.id)).all()
    called = schedule_names(connection, [row.name for row in rows])
    for lot, name in ((row.id, called[row.name]) for row in rows):
        if not moments_of(lot, name, None, DUE_DAYS) or len(found) == MOST_SCHEDULED:
            continue
        newest = newest_survey(connection, lot)
        last = None if newest is None else newest[2]
        moments = tuple(moment.timestamp() for moment in moments_of(lot, name, last, DUE_DAYS)[:MOST_DUE])
        found.append(LotDue(lot=lot, last=last, moments=moments))
    return tuple(found)


def _is_of(lot: ColumnElement[str], writer: str | None) -> ColumnElement[bool]:
    """Return whether a drone has sent a survey of a lot, or its plan; True for all lots without a drone."""
    if writer is None:
        return true()
    of_survey = select(SURVEY.c.lot).join(DOCUMENT, DOCUMENT.c.survey == SURVEY.c.seq)
    seen = of_survey.where(DOCUMENT.c.writer == writer, SURVEY.c.lot.is_not(None))
    sent = select(LOT_DOCUMENT.c.lot).where(LOT_DOCUMENT.c.writer == writer)
    return lot.in_(seen) | lot.in_(sent)


@dataclass(frozen=True, slots=True)
class GivenLot:
    """A lot as the desk gave it. ``plan``, ``revision``: digest and revision of the plan here, when it had that."""

    state: int
    digest: str
    plan: str
    revision: int
    part: LotPart

    def is_changed(self, connection: Connection, here: LotPart) -> bool:
        """Return whether the lot was changed here since, also where the change was undone."""
        is_named = (here.name, here.time_zone) == (self.part.name, self.part.time_zone)
        return not is_named or plan_digest(here) != self.plan or revision_of(connection, here.id) != self.revision


def came_from_desk(connection: Connection, lot: str) -> GivenLot | None:
    """Return a lot as the desk gave it that this store is sent to; None where it did not."""
    names = (LOT_DOCUMENT.c[name] for name in ("state", "digest", "plan", "decided", "body"))
    row = connection.execute(select(*names).where(LOT_DOCUMENT.c.lot == lot, LOT_DOCUMENT.c.writer == "")).first()
    if row is None:
        return None
    return GivenLot(row.state, row.digest, row.plan, row.decided, kept_lot(row.body))


def sent_lot(connection: Connection, lot: str) -> LotPart:
    """Return a lot as it is sent to a desk: with the plan that the desk gave, where nobody here has changed that.

    Raises LotStoreError.
    """
    part = lot_part(connection, lot)
    came = came_from_desk(connection, lot)
    if came is None:
        return part
    if plan_digest(part) == came.plan:
        said = {"state": part.state, "name": part.name, "time_zone": part.time_zone}
        return came.part.model_copy(update=said)
    return part.model_copy(update={"base": came.part.base})


def lot_part(connection: Connection, lot: str) -> LotPart:
    """Return a lot with its plan. Raises LotStoreError for one that is damaged, or that no document can say."""
    check_whole(connection, "lot", lot, "lot")
    row = connection.execute(select(LOT).where(LOT.c.id == lot)).mappings().one()
    former = select(STALL.c.id.label("stall"), *_columns(FORMER, (*_SHAPE, "ends"))).join(
        STALL, STALL.c.key == FORMER.c.stall
    )
    of_lot = former.where(FORMER.c.lot == lot, STALL.c.lot == lot).order_by(STALL.c.id, FORMER.c.ends)
    parts = {
        **{name: row[name] for name in _OF_LOT},
        "state": _state(connection, LOT_STATE, lot),
        "outline": _ground(outline_to_change(row["outline"])),
        "turn": connection.execute(select(PIN.c.turn).where(PIN.c.lot == lot)).scalar() or 0.0,
        "layouts": _rows(connection, LAYOUT, _OF_LAYOUT, lot, "version"),
        "stalls": _rows(connection, STALL, _OF_STALL, lot, "id"),
        "former": _dicts(connection, of_lot),
        "zones": _areas(connection, ZONE, _OF_ZONE, lot),
        "sections": _areas(connection, SECTION, _OF_SECTION, lot),
    }
    return _made(LotPart, parts)


def _rows(connection: Connection, table: Table, names: tuple[str, ...], lot: str, order: str) -> list[dict[str, Any]]:
    asked = select(*_columns(table, names)).where(table.c.lot == lot).order_by(table.c[order])
    return _dicts(connection, asked)


def _areas(connection: Connection, table: Table, names: tuple[str, ...], lot: str) -> list[dict[str, Any]]:
    """Return zones or sections; one whose outline is damaged is left out."""
    asked = select(*_columns(table, (*names, "outline"))).where(table.c.lot == lot).order_by(table.c.id, table.c.begins)
    rows = [{**row, "outline": ring_of(row["outline"])} for row in _dicts(connection, asked)]
    return [row for row in rows if row["outline"]]


def _dicts(connection: Connection, asked: Select[Any]) -> list[dict[str, Any]]:
    """Return rows by the names of their columns, in half the time of `Result.mappings`."""
    rows = connection.execute(asked)
    names = tuple(rows.keys())
    return [dict(zip(names, row, strict=True)) for row in rows]


def _columns(table: Table, names: tuple[str, ...]) -> list[Any]:
    return [table.c[name] for name in names]


def _ground(outline: Outline) -> Ground:
    return Ground(polygons=outline.polygons, holes=outline.holes)


def _state(connection: Connection, kind: str, named: str) -> int:
    """Return the number of a survey's or lot's state; 0 before it was given one."""
    asked = select(OUTBOX.c.seq).where(OUTBOX.c.kind == kind, OUTBOX.c.body == named)
    return int(connection.execute(asked).scalar() or 0)


def _made(form: type[P], parts: Mapping[str, Any]) -> P:
    try:
        return form.model_validate(parts)
    except ValidationError as error:
        raise LotStoreError(f"survey: no document can be made of it: {first_wrong(error)}") from error
