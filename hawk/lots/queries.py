"""Lots and surveys as JSON values, and their rows by their ids."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Any, Final

import numpy as np
from sqlalchemy import Connection, RowMapping, select
from sqlalchemy import Row as SqlRow

from hawk.lots import change_log
from hawk.lots.answers import Change, ListedLot, Lot, PlacedShapes, PossiblePlaces, Proposals, Survey
from hawk.lots.change_detection import proposals
from hawk.lots.documents import plan_edits
from hawk.lots.names import schedule_names
from hawk.lots.plan import serialize, versions
from hawk.lots.plan.answers import Plan
from hawk.lots.plan.queries import all_stalls
from hawk.lots.plan.values import shapes_of
from hawk.lots.registration.lot_pair import pairs_of
from hawk.lots.registration.survey_place import (
    Doubt,
    Findings,
    datum_of,
    move_of,
)
from hawk.lots.storage.database import version_of
from hawk.lots.storage.digests import check_whole
from hawk.lots.storage.outlines import outline_of
from hawk.lots.storage.rows import Row, is_among, readable, row_of
from hawk.lots.storage.schema import CHANGE, DOCUMENT, LOT, SURVEY
from hawk.lots.survey.counts import COUNTS, counts_of, found_by
from hawk.lots.survey.last_surveys import last_surveys_of
from hawk.lots.survey.order import is_sure
from hawk.lots.survey.source import SOURCE_COLUMNS, SurveyKind, source_json
from hawk.lots.time_zone import time_zones_of
from hawk.lots.values import (
    LotStoreError,
    NotFoundError,
    Placed,
    journal_of,
    moment,
)

_Shown = Mapping[str, Any] | RowMapping
NextDue = Callable[[str, str, float | None], datetime | None]
"""Returns when the next survey of a lot is due, by its id, its name, "" where another lot has it too, and the time of
its newest survey, Unix seconds; None: there is none."""
_SHOWN: Final = ("id", "seq", "lot", "layout", "placed", "free", "taken", "unknown", "blurred", "simulated", "program")
_MORE: Final = ("latitude", "longitude", "north", "east", "turn", "doubt", "began", "ended", "candidates")
_WRITER: Final = select(DOCUMENT.c.writer).where(DOCUMENT.c.survey == SURVEY.c.seq).correlate(SURVEY).scalar_subquery()
SURVEY_SHOWN: Final = (
    *(SURVEY.c[name] for name in (*_SHOWN, *_MORE, *SOURCE_COLUMNS)), is_sure().label("time_is_sure"),
    _WRITER.label("drone"),
)  # fmt: skip
"""Columns of a survey that are shown."""
_AMONG_SURVEYS: Final = select(*SURVEY_SHOWN).where(is_among(SURVEY.c.seq))


_NO_SURVEY: Final = "survey: there is no survey with this id; reload the list"


def places(connection: Connection, survey_id: str) -> PossiblePlaces:
    """Return where a survey in doubt may lie: the stalls of its lot, and its own at each place, in the lot's frame.

    Raises NotFoundError.
    """
    survey = survey_row(connection, survey_id)
    assert survey.values is not None  # noqa: S101 - it is there
    doubt, lot_id = Doubt.read(survey.values["doubt"]), survey.values["lot"]
    if doubt is None or lot_id is None:
        raise NotFoundError("survey: has no places to choose from; reload the list")
    seen = [stall for stall in Findings.stored(survey.values).stalls if stall.is_witness]
    shown = [np.round(shapes_of(move_of(place).stalls(seen)), 3).tolist() for place in doubt.places]
    known = np.round(shapes_of(all_stalls(connection, lot_id)), 3).tolist()
    placed = [PlacedShapes(stalls=stalls) for stalls in shown]
    return PossiblePlaces(survey=survey_id, lot=lot_id, known=known, places=placed)


def plan(connection: Connection, lot_id: str, since: int | None = None, layout: int | None = None) -> Plan:
    """Return the plan of a lot: all, those stalls that changed since a revision, or that of a layout.

    Raises NotFoundError.
    """
    lot_row(connection, lot_id)
    return (
        serialize.plan(connection, lot_id, since) if layout is None else serialize.plan_of(connection, lot_id, layout)
    )


def proposed(connection: Connection, lot_id: str, within: Collection[str] | None = None) -> Proposals:
    """Return what surveys and drones propose to change of a lot's layout, and the lots on its ground: those of some
    ids; None: of all. Raises NotFoundError.
    """
    lot_row(connection, lot_id)
    found = proposals.proposed(connection, lot_id)
    same = [each for each in pairs_of(connection, lot_id) if within is None or each.lot in within]
    return found.model_copy(update={"drones": plan_edits.proposed(connection, lot_id), "same": same})


def lots_of_surveys(connection: Connection) -> dict[str, dict[str, str]]:
    """Return id, name and time zone of the lot of each survey that has one, and the survey's id: by that id, and by
    the name of its journal.
    """
    lots = {row["id"]: row for row in connection.execute(select(LOT)).mappings()}
    surveys = connection.execute(
        select(SURVEY.c.origin, SURVEY.c.id, SURVEY.c.lot).where(SURVEY.c.lot.is_not(None)).order_by(SURVEY.c.seq)
    ).all()
    of_surveys = [lots[lot] for lot in {lot for _, _, lot in surveys}]
    shown = {
        row["id"]: {"id": row["id"], "name": row["name"], "time_zone": zone}
        for row, zone in zip(of_surveys, time_zones_of(connection, of_surveys), strict=True)
    }
    found = [(origin, survey, {"survey": survey, **shown[lot]}) for origin, survey, lot in surveys]
    return {name: about for origin, survey, about in found for name in (survey, journal_of(origin))}


@dataclass(frozen=True, slots=True)
class SurveyDrone:
    """The drone that sent a survey here: ``name`` of its token, and that of the survey's ``journal`` there."""

    name: str
    journal: str


def journal_of_survey(connection: Connection, survey_id: str) -> str:
    """Return the name of a survey's journal, of this store. Raises NotFoundError."""
    origin = connection.execute(select(SURVEY.c.origin).where(SURVEY.c.id == survey_id)).scalar()
    if origin is None:
        raise NotFoundError(_NO_SURVEY)
    return journal_of(origin)


def flown_by(connection: Connection, survey_id: str) -> SurveyDrone | None:
    """Return who sent a survey that it had flown; None for a survey of this store, or of pictures.

    Raises NotFoundError.
    """
    sent = select(SURVEY.c.origin, SURVEY.c.kind, DOCUMENT.c.writer)
    joined = sent.outerjoin(DOCUMENT, DOCUMENT.c.survey == SURVEY.c.seq).where(SURVEY.c.id == survey_id)
    row = connection.execute(joined).first()
    if row is None:
        raise NotFoundError(_NO_SURVEY)
    if row.writer is None or row.kind != SurveyKind.FLOWN:
        return None
    return SurveyDrone(row.writer, journal_of(row.origin, row.writer))


def deleted_among(connection: Connection, surveys: Collection[str]) -> set[str]:
    """Return which of some surveys, by their ids, were deleted."""
    asked = select(SURVEY.c.id).where(SURVEY.c.id.in_(surveys), SURVEY.c.placed == Placed.DELETED.value)
    return set(connection.scalars(asked))


def is_stored(connection: Connection, survey_id: str) -> bool:
    """Return whether the store has a survey, also one that cannot be read."""
    return connection.execute(select(SURVEY.c.seq).where(SURVEY.c.id == survey_id)).first() is not None


def survey_row(connection: Connection, survey_id: str) -> Row:
    """Return a survey by its id. Raises NotFoundError."""
    found = connection.execute(select(SURVEY.c.seq).where(SURVEY.c.id == survey_id)).scalar()
    check_whole(connection, "survey", found, "survey", version_of(connection))
    if found is None:
        raise NotFoundError("survey: there is none with this id; reload the list")
    return row_of(connection, SURVEY.name, (found,))


def lot_row(connection: Connection, lot_id: str, field: str = "lot") -> Row:
    """Return a lot that was not merged into another one. Raises NotFoundError."""
    known = lot_id if lot_id.isascii() else ""  # SQLite takes no half character
    check_whole(connection, "lot", known, field, version_of(connection))
    found = row_of(connection, LOT.name, (known,))
    if found.values is None or found.values["merged_into"] is not None:
        raise NotFoundError(f"{field}: there is no lot with this id; reload the list")
    return found


def never_due(*_: object) -> None:
    """Without a schedule no survey is due."""


def listed_lots(connection: Connection, rows: Sequence[_Shown], due: NextDue = never_due) -> list[ListedLot]:
    """Return lots of the table with their numbers of stalls, sections and surveys, and the newest survey of each."""
    newest = last_surveys_of(connection, [row["id"] for row in rows])
    counts = {each.survey: {name: getattr(each, name) for name in COUNTS} for each in newest.values()}
    shown = connection.execute(_AMONG_SURVEYS, {"among": json.dumps([*counts])}).mappings().all()
    pairs = ((row, counts[row["seq"]]) for row in shown)
    surveys = {survey.lot: survey for survey in readable(_survey_of, pairs)}
    zones, called = time_zones_of(connection, rows), schedule_names(connection, [row["name"] for row in rows])
    numbered = [(row, zone, newest[row["id"]]) for row, zone in zip(rows, zones, strict=True)]
    return [
        ListedLot(
            id=row["id"], name=row["name"], time_zone=zone, stalls=of.stalls, sections=of.sections,
            survey_count=of.surveys, last_survey=surveys.get(row["id"]),
            due=due(row["id"], called[row["name"]], of.taken_at),
        )
        for row, zone, of in numbered
    ]  # fmt: skip


def whole_lot(connection: Connection, row: _Shown, due: NextDue = never_due) -> Lot:
    """Return a lot of the table with its place on Earth, and who edits its plan."""
    return Lot(
        **dict(listed_lots(connection, [row], due)[0]), datum=list(datum_of(connection, row["id"])),
        datum_is_pinned=row["datum_is_pinned"],
        outline=[[list(corner) for corner in ring] for ring in outline_of(row["outline"]).polygons],
        edit=serialize.shown_edit(connection, row["id"]), revision=versions.revision_of(connection, row["id"]),
    )  # fmt: skip


def surveys_of(connection: Connection, rows: Sequence[_Shown]) -> list[Survey]:
    """Return surveys, rows of `SURVEY_SHOWN`, each with its counts and the lots that it may be of."""
    return readable(_survey_of, zip(rows, counts_of(connection, rows), strict=True))


def _survey_of(counted: tuple[_Shown, Mapping[str, Any]]) -> Survey:
    row, counts = counted
    return Survey(**{**_survey_values(row), **counts})


def _survey_values(row: _Shown) -> dict[str, Any]:
    shown = {name: row[name] for name in _SHOWN}
    doubt = Doubt.read(row["doubt"])
    is_placed = row["north"] is not None
    shown |= {"found": found_by(row), "drone": row["drone"]}
    shown["datum"] = [row["latitude"], row["longitude"]]
    shown["place"] = {name: row[name] for name in ("north", "east", "turn")} if is_placed else None
    shown["doubt"] = None if doubt is None else asdict(doubt)
    shown["candidates"] = json.loads(row["candidates"])
    shown |= {"began": moment(row["began"]), "ended": moment(row["ended"]), "time_is_sure": row["time_is_sure"]}
    return {**shown, **source_json(row)}


CHANGE_SHOWN: Final = tuple(CHANGE.c[name] for name in ("seq", "kind", "lot", "who", "made", "state", "undone"))
"""Columns of a change that are shown."""


def change_of(connection: Connection, row: SqlRow[Any]) -> Change:
    """Return a change, a row of `CHANGE_SHOWN`."""
    return Change(
        seq=row.seq, kind=row.kind, lot=row.lot, surveys=_surveys_changed(connection, row.seq), who=row.who,
        made=moment(row.made), undone=None if row.undone is None else moment(row.undone),
        kept=change_log.why_kept(connection, row.seq, row.state) or None,
    )  # fmt: skip


def _surveys_changed(connection: Connection, seq: int) -> list[str]:
    """Return the ids of the surveys that a change is about; none of a change that is damaged on the disk."""
    try:
        groups = change_log.read(connection, seq)
    except LotStoreError:
        return []
    among = {"among": json.dumps(change_log.rows_touched(groups, SURVEY.name))}
    return [str(each) for each in connection.execute(_THEIR_IDS, among).scalars()]


_THEIR_IDS: Final = select(SURVEY.c.id).where(is_among(SURVEY.c.seq)).order_by(SURVEY.c.seq)
