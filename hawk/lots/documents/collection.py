"""Documents of surveys taken into the store of a centre: a union of sets by ids, in any order, any number of times.

Of a survey, and of a lot, the newest state counts: that of the greater number, of two alike that of the greater digest.
The moment at which a document comes decides nothing. What a person here has said of a lot's plan, or of the place of a
survey, stays.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, RowMapping, delete, insert, select, update

from hawk.lots.documents import plan_rows
from hawk.lots.documents.arrival import Outcome
from hawk.lots.documents.lot_document import LotDocument, LotPart
from hawk.lots.documents.lot_states import LotArrival, collect_lot, newness, outer_first
from hawk.lots.documents.parts import Ground, digest_of
from hawk.lots.documents.survey_document import SurveyDocument
from hawk.lots.ingest import register_survey, survey_columns
from hawk.lots.operations import PLACE
from hawk.lots.registration.survey_place import Doubt
from hawk.lots.storage.digests import check_whole
from hawk.lots.storage.erasure import erased_id
from hawk.lots.storage.schema import DOCUMENT, ERASED, LOT, OBSERVATION, SECTION_LOOK, SURVEY
from hawk.lots.survey.observations import keep_looks
from hawk.lots.survey.source import PictureSource, SourceKind, SurveyKind
from hawk.lots.values import (
    Detection,
    ErasedError,
    FinishedSurvey,
    OtherDroneError,
    Placed,
    PossiblePlace,
    Register,
)
from hawk.model.poses import GlobalPose


@dataclass(frozen=True, slots=True)
class DocumentOutcome:
    """Outcome. ``state``: the newest one here; ``has_newer_picture``: the document has one that is to be kept.

    ``keeps_plan``: a lot's plan is another one here: a person has changed it, or it is another drone's. ``outcome``:
    what became of the document.
    """

    seq: int
    survey: str
    lot: str | None
    state: int
    has_newer_picture: bool
    keeps_plan: bool
    outcome: Outcome


def collect(
    connection: Connection, document: SurveyDocument, writer: str, register: Register | None = None
) -> DocumentOutcome:
    """Take a document in.

    Args:
        connection: One that writes.
        document: The survey with its lot.
        writer: Name of the drone whose token sends it.
        register: Finds its stalls among those of a lot that a person here has merged its lot into.

    Raises OtherDroneError, ErasedError, and LotStoreError for a survey or lot that is damaged here.
    """
    _check_not_erased(connection, {document.survey.id: "survey.id", **_fields_of(document.lots)})
    finished = _finished(document, writer)
    row = _check_writer(connection, finished, document.survey.id, writer)
    lots = [collect_lot(connection, each, writer) for each in outer_first(document.lots)]
    state, digest = document.survey.state, digest_of(document.model_copy(update={"lots": (), "mosaic": ()}))
    known = None if row is None else _document_row(connection, int(row["seq"]))
    is_new = newness((state, digest), None if known is None else (known["state"], known["digest"]))
    if known is None or is_new is Outcome.TAKEN:
        seq = _collect_survey(connection, document, finished, row, register)
        order = {"writer": writer, "state": state, "digest": digest}
        connection.execute(update(DOCUMENT).where(DOCUMENT.c.survey == seq).values(**order))
    else:
        seq = int(known["survey"])
    found = _document_row(connection, seq)
    assert found is not None  # noqa: S101 - it was written
    lot = connection.execute(select(SURVEY.c.lot).where(SURVEY.c.seq == seq)).scalar()
    has_newer_picture = bool(document.mosaic) and found["picture"] < state
    keeps_plan, outcome = _plans(lots, is_new)
    return DocumentOutcome(
        seq, document.survey.id, lot, int(found["state"]), has_newer_picture, keeps_plan, outcome
    )  # fmt: skip


def note_picture(connection: Connection, seq: int, state: int) -> None:
    """Note that the picture of a document is kept. ``seq``: number of the survey."""
    connection.execute(update(DOCUMENT).where(DOCUMENT.c.survey == seq).values(picture=state))


@dataclass(frozen=True, slots=True)
class LotOutcome:
    """Outcome. ``state``: of the document. ``keeps_plan``, ``outcome``: as of `DocumentOutcome`."""

    state: int
    keeps_plan: bool
    outcome: Outcome


def collect_lots(connection: Connection, document: LotDocument, writer: str) -> LotOutcome:
    """Take lots in. ``writer``: name of the drone whose token sends them.

    Raises ErasedError, and LotStoreError for a lot that is damaged here.
    """
    _check_not_erased(connection, _fields_of(document.lots))
    found = [collect_lot(connection, each, writer) for each in outer_first(document.lots)]
    is_new = min((each.outcome for each in found), key=list(Outcome).index, default=Outcome.KNOWN)
    return LotOutcome(document.state, *_plans(found, is_new))


def _plans(lots: Sequence[LotArrival], outcome: Outcome) -> tuple[bool, Outcome]:
    """Return whether a lot's plan is another one here, and the outcome of a document with these lots."""
    found = [each.outcome for each in lots]
    first = next((each for each in (Outcome.WAITS, Outcome.TAKEN) if each in found), outcome)
    return not all(each.is_current for each in lots), first


def _fields_of(lots: Iterable[LotPart]) -> dict[str, str]:
    return {lot.id: f"lots[{number}].id" for number, lot in enumerate(lots)}


def is_erased(connection: Connection, named: str) -> bool:
    """Return whether a survey or lot was erased here."""
    return connection.execute(select(ERASED.c.id).where(ERASED.c.id == erased_id(named))).first() is not None


def _check_not_erased(connection: Connection, names: Mapping[str, str]) -> None:
    """Refuse ids that were erased here. ``names``: each with its field."""
    for named, field in names.items():
        if is_erased(connection, named):
            raise ErasedError(f"{field}: it was erased here, and does not come back: erase it on the drone, too")


def _check_writer(connection: Connection, finished: FinishedSurvey, named: str, writer: str) -> RowMapping | None:
    """Return the survey with the id ``named`` as it is here, None for a new one. Raises OtherDroneError."""
    asked = select(SURVEY).where((SURVEY.c.id == named) | (SURVEY.c.origin == finished.origin))
    rows = connection.execute(asked).mappings().all()
    if not rows:
        return None
    for row in rows:
        known = _document_row(connection, int(row["seq"]))
        if known is None or known["writer"] != writer:
            raise OtherDroneError("survey.id: this survey is another's: a drone sends its own surveys alone")
        if row["id"] != named or row["origin"] != finished.origin:
            words = "this flight was sent as another survey: send each with the id that it has"
            raise OtherDroneError(f"survey.id: {words}")
    check_whole(connection, "survey", rows[0]["seq"], "survey")
    return rows[0]


def _document_row(connection: Connection, seq: int) -> RowMapping | None:
    return connection.execute(select(DOCUMENT).where(DOCUMENT.c.survey == seq)).mappings().first()


def _finished(document: SurveyDocument, writer: str) -> FinishedSurvey:
    """Return the survey as those that land here are, but for its name: two drones may begin a journal in one second."""
    survey = document.survey
    pictures = None
    if survey.kind is SurveyKind.PICTURE:
        pictures = PictureSource(SourceKind(survey.source), survey.source_name, survey.limits)
    seen = Ground() if survey.seen_ground is None else survey.seen_ground
    return FinishedSurvey(
        name=f"{writer}: {survey.name}",
        datum=GlobalPose(survey.latitude, survey.longitude, 0.0),
        began=survey.began,
        ended=survey.ended,
        time_is_sure=survey.time_is_sure,
        outline=plan_rows.outline_of(survey.outline),
        stalls=tuple(Detection(**dict(each)) for each in document.stalls),
        program=survey.program,
        simulated=survey.simulated,
        accuracy=survey.accuracy,
        pictures=pictures,
        seen_ground=plan_rows.outline_of(seen),
    )


def _collect_survey(
    connection: Connection, document: SurveyDocument, finished: FinishedSurvey, row: RowMapping | None,
    register: Register | None,
) -> int:  # fmt: skip
    """Write a survey with its looks, and return its number. The place that a person here has said stays."""
    into = _merged_here(connection, document.survey.lot)
    values, place = _columns(finished, document), _place(document, into)
    if row is None:
        named = {"id": document.survey.id, "landing": document.survey.landing}
        inserted = connection.execute(insert(SURVEY).values(**{**values, **place, **named}))
        seq = int(inserted.inserted_primary_key[0])  # type: ignore[index]
        blank = {"writer": "", "state": 0, "digest": "", "place": "", "loose": "[]", "picture": 0}
        connection.execute(insert(DOCUMENT).values(survey=seq, **blank))
    else:
        seq = int(row["seq"])
        known = _document_row(connection, seq)
        is_as_sent = known is not None and _place_text(row) == known["place"]
        connection.execute(update(SURVEY).where(SURVEY.c.seq == seq).values(**values | (place if is_as_sent else {})))
        if not is_as_sent:
            return seq
    connection.execute(delete(OBSERVATION).where(OBSERVATION.c.survey == seq))
    connection.execute(delete(SECTION_LOOK).where(SECTION_LOOK.c.survey == seq))
    loose: list[dict[str, Any]] = []
    if into is None:
        loose = _collect_looks(connection, seq, document)
    elif register is not None:
        register_survey(connection, into, seq, finished, register, None)
    keep_looks(connection, [seq])
    there = connection.execute(select(SURVEY).where(SURVEY.c.seq == seq)).mappings().one()
    kept = {"place": _place_text(there), "loose": plan_rows.loose_text(loose)}
    connection.execute(update(DOCUMENT).where(DOCUMENT.c.survey == seq).values(**kept))
    return seq


def _columns(finished: FinishedSurvey, document: SurveyDocument) -> dict[str, Any]:
    """Return the columns of a survey that say nothing of its place."""
    survey = document.survey
    found = survey_columns(finished, None, survey.placed, (), is_sure=survey.time_is_sure)
    return {name: value for name, value in found.items() if name not in PLACE}


def _place(document: SurveyDocument, into: str | None) -> dict[str, Any]:
    """Return the columns of a survey that say where it lies; ``into``: as of `_merged_here`."""
    survey, nowhere = document.survey, dict.fromkeys(PLACE)
    if into is not None:
        return nowhere | {"lot": into, "placed": Placed.UNREGISTERED.value, "candidates": "[]"}
    doubt = None
    if survey.doubt is not None:
        places = tuple(PossiblePlace(**each.model_dump()) for each in survey.doubt.places)
        doubt = Doubt(survey.doubt.why, places, survey.doubt.chosen).json()
    place = {} if survey.place is None else survey.place.model_dump()
    said = {"lot": survey.lot, "layout": survey.layout, "placed": survey.placed.value, "doubt": doubt}
    return {**nowhere, **place, **said, "candidates": json.dumps(survey.candidates)}


def _place_text(row: RowMapping) -> str:
    return json.dumps([row[name] for name in PLACE])


def _merged_here(connection: Connection, lot: str | None) -> str | None:
    """Return the lot that a person here has made a lot part of; None where nobody has."""
    into = connection.execute(select(LOT.c.merged_into).where(LOT.c.id == lot)).scalar()
    if into is None or lot is None or not plan_rows.is_merged_here(connection, lot):
        return None
    return _merged_here(connection, into) or into


def _collect_looks(connection: Connection, seq: int, document: SurveyDocument) -> list[dict[str, Any]]:
    """Write what a survey saw of stalls and sections; return its looks at stalls that no plan here has."""
    keys = plan_rows.keys_of(connection, [each.stall for each in document.looks])
    looks = [dict(each) for each in document.looks]
    plan_rows.observe(connection, seq, [look for look in looks if look["stall"] in keys], keys)
    if document.sections:
        connection.execute(insert(SECTION_LOOK), [{"survey": seq, **each.model_dump()} for each in document.sections])
    return [look for look in looks if look["stall"] not in keys]
