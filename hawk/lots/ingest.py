"""Saves a survey that has ended, in the transaction of a connection: lot, layout, stalls and observations.

The same survey saved again, after a battery swap, replaces what it saved before. It never takes an id or a label from
a stall.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from sqlalchemy import Connection, RowMapping, delete, func, insert, select, update

from hawk.lots.labels import lasting_labels
from hawk.lots.plan.queries import all_stalls
from hawk.lots.plan.values import SHAPE
from hawk.lots.plan.versions import newest_layout, read_again
from hawk.lots.registration.frames import Move
from hawk.lots.registration.lot_match import Answer, Parcel, which_lot
from hawk.lots.registration.survey_place import Doubt, Findings, placed_by, registered
from hawk.lots.sections.outline_sections import add_outline_sections
from hawk.lots.storage.digests import is_damaged
from hawk.lots.storage.outlines import outline_json, outline_of, pack_outline
from hawk.lots.storage.schema import LAYOUT, LOT, OBSERVATION, OUTBOX, STALL, SURVEY
from hawk.lots.storage.tables import pack_stalls, pack_vehicles
from hawk.lots.survey import section_looks
from hawk.lots.survey.moments import has_been
from hawk.lots.survey.observations import keep_looks
from hawk.lots.survey.order import last_landing, now_of
from hawk.lots.survey.source import SurveyKind, source_columns
from hawk.lots.values import (
    Detection,
    Doubtful,
    FinishedSurvey,
    Placed,
    Register,
    Registration,
    Saved,
    fitting_name,
    free_name,
    new_id,
    utc,
)
from hawk.model.lot_map import StallState

FIRST_FLIGHT: Final = "found by the first survey"
PROGRAM: Final = "hawk"
"""The one who makes a layout that no person made."""


def save(connection: Connection, survey: FinishedSurvey, register: Register | None = None) -> Saved:
    """Save a survey and return where it belongs.

    ``register`` finds its stalls among those of a known lot; without one, and where it is not certain, the survey is
    kept with its stalls, and no stall of the lot is observed.
    """
    before = connection.execute(select(SURVEY).where(SURVEY.c.origin == survey.origin)).mappings().first()
    if before is not None and before["placed"] == Placed.FIRST and survey.kind is SurveyKind.PICTURE:
        survey = _numbered_as_before(connection, before, survey, register)
    lot, placed, candidates = _place(connection, survey, before)
    values = survey_columns(survey, lot, placed, candidates, is_sure=_time_is_sure(connection, survey))
    known, doubt = 0, ""
    if before is None:
        inserted = connection.execute(insert(SURVEY).values(id=new_id(), **values))
        seq = int(inserted.inserted_primary_key[0])  # type: ignore[index]
    else:
        seq = int(before["seq"])
        if survey.kind is SurveyKind.FLOWN:  # another landing of its flight; pictures are mapped again as a whole
            values["began"] = min(survey.began, before["began"])
        connection.execute(update(SURVEY).where(SURVEY.c.seq == seq).values(**values))
        connection.execute(delete(OBSERVATION).where(OBSERVATION.c.survey == seq))
    if lot is not None and is_damaged(connection, "lot", lot):  # the survey is kept; nothing is read of that plan
        placed, register = Placed.UNREGISTERED, None
        connection.execute(update(SURVEY).where(SURVEY.c.seq == seq).values(placed=placed.value))
        doubt = "the lot's plan is damaged on the disk"
    if placed is Placed.FIRST:
        if lot is None:
            lot = make_lot(connection, survey, seq)
            if not survey.stalls:
                add_outline_sections(connection, lot, _name_of(connection, lot), survey)
        extend_layout(connection, lot, seq, survey)
    if placed is Placed.UNREGISTERED and lot is not None and register is not None:
        outcome = register_survey(connection, lot, seq, survey, register, before)
        if isinstance(outcome, Registration):
            placed, known = Placed.REGISTERED, len(outcome.same)
        else:
            doubt = outcome.why
    keep_looks(connection, [seq])
    section_looks.renew(connection, [seq])
    where = (seq, _id_of(connection, seq), lot, _name_of(connection, lot), placed, candidates)
    saved = Saved(*where, stalls=len(survey.stalls), known=known, doubt=doubt)
    connection.execute(
        insert(OUTBOX).values(
            kind="survey", body=_message(saved, survey, is_sure=values["time_is_sure"]), made=survey.ended
        )
    )
    return saved


def _place(
    connection: Connection, survey: FinishedSurvey, before: RowMapping | None
) -> tuple[str | None, Placed, tuple[str, ...]]:
    """Return the lot (None for one that is to be made), the relation to it, and the lots to choose from."""
    if before is not None and before["lot"] is not None:
        placed = Placed.FIRST if before["placed"] == Placed.FIRST else Placed.UNREGISTERED
        return before["lot"], placed, ()
    decision = which_lot(survey.outline, lot_places(connection), survey.beside)
    if decision.answer is Answer.KNOWN:
        return decision.lot, Placed.UNREGISTERED, ()
    if decision.answer is Answer.ASK:
        return None, Placed.UNDECIDED, tuple(each.lot for each in decision.candidates)
    is_lot = decision.answer is Answer.NEW and (len(survey.stalls) > 0 or survey.capacity is not None)
    return None, Placed.FIRST if is_lot else Placed.NOTHING, ()


def _numbered_as_before(
    connection: Connection, before: RowMapping, survey: FinishedSurvey, register: Register | None
) -> FinishedSurvey:
    """Return a survey by pictures that replaces the one that made a lot; a stall in its place has its former number.

    A mapping numbers stalls in the order in which it finds them: with more pictures, all of them have other numbers.
    """
    lot, looked = before["lot"], Findings.of(survey)
    if is_damaged(connection, "lot", lot):
        return survey
    outcome = None if register is None else registered(connection, lot, looked, register)
    if not isinstance(outcome, Registration):  # both have the lot's own frame
        outcome = placed_by(connection, lot, looked, Move())
    made = select(STALL.c.id, STALL.c.first_id).where(STALL.c.lot == lot, STALL.c.first_survey == before["seq"])
    numbers = {row.id: int(row.first_id) for row in connection.execute(made)}
    former = {number: numbers[stall] for number, stall in outcome.same.items() if stall in numbers}
    new = itertools.count(1 + max(numbers.values(), default=0))
    return replace(
        survey,
        stalls=tuple(replace(one, id=former[one.id] if one.id in former else next(new)) for one in survey.stalls),
    )


def lot_places(connection: Connection) -> list[Parcel]:
    """Return the outlines of all lots with ground that were not merged into another one."""
    rows = connection.execute(select(LOT.c.id, LOT.c.outline).where(LOT.c.merged_into.is_(None)))
    places = [Parcel(row.id, outline_of(row.outline)) for row in rows]
    return [each for each in places if each.outline.polygons]


def survey_columns(
    survey: FinishedSurvey, lot: str | None, placed: Placed, candidates: tuple[str, ...], *, is_sure: bool
) -> dict[str, Any]:
    """Return the columns of a survey that lies nowhere in its lot yet, without ``seq`` and ``id``."""
    of_lot = [stall for stall in survey.stalls if not stall.is_extra]
    states = [stall.state for stall in of_lot]
    return {
        "origin": survey.origin,
        "lot": lot,
        "layout": None,
        "placed": placed.value,
        "candidates": json.dumps(candidates),
        "began": survey.began,
        "ended": survey.ended,
        "time_is_sure": is_sure,
        "latitude": survey.datum.latitude,
        "longitude": survey.datum.longitude,
        "outline": outline_json(survey.outline),
        "free": states.count(StallState.FREE),
        "taken": states.count(StallState.TAKEN),
        "unknown": states.count(StallState.UNKNOWN),
        "stalls": pack_stalls(survey.stalls),
        "vehicles": pack_vehicles(survey.vehicles),
        "program": survey.program,
        "simulated": survey.simulated,
        "seen_ground": pack_outline(survey.seen_ground) if survey.seen_ground.polygons else None,
        "doubt": None,
        "accuracy": survey.accuracy,
        "blurred": _blurred(of_lot),
        **source_columns(survey.pictures),
        **dict.fromkeys(("north", "east", "turn")),
    }


def _blurred(stalls: Sequence[Detection]) -> int | None:
    """Return how many of these only blurred pictures showed; None where it was not measured."""
    measured = [stall.is_blurred for stall in stalls if stall.is_blurred is not None]
    return sum(measured) if measured else None


def _time_is_sure(connection: Connection, survey: FinishedSurvey) -> bool:
    """Return whether the survey's time can be believed: a landing is not before an earlier one, pictures have been.

    Pictures are stored at any later time, and in any order.
    """
    if survey.kind is SurveyKind.PICTURE:
        return survey.time_is_sure and has_been(survey.ended, now_of(connection))
    newest = last_landing(connection, survey.origin)
    return survey.time_is_sure and (newest is None or survey.ended >= newest)


def make_lot(connection: Connection, survey: FinishedSurvey, seq: int, name: str = "") -> str:
    """Make a lot with an empty first layout for a survey, and return its id. Its datum is the survey's.

    Without a ``name`` it has the survey's title, with a number behind it where another lot has that name already.
    """
    lot = new_id()
    number = connection.execute(select(func.count()).select_from(LOT)).scalar_one() + 1
    place = {"latitude": survey.datum.latitude, "longitude": survey.datum.longitude, "datum_is_pinned": False}
    used = set(connection.execute(select(LOT.c.name)).scalars())
    title = name or free_name(fitting_name(survey.title), used) or f"Lot {number}"
    shown = {"name": title, "outline": outline_json(survey.outline)}
    connection.execute(insert(LOT).values(id=lot, **place, **shown, made=survey.ended))
    layout = {"version": 1, "valid_from": survey.began, "why": FIRST_FLIGHT, "who": PROGRAM}
    connection.execute(insert(LAYOUT).values(lot=lot, **layout))
    connection.execute(update(SURVEY).where(SURVEY.c.seq == seq).values(lot=lot))
    return lot


def extend_layout(connection: Connection, lot: str, seq: int, survey: FinishedSurvey) -> None:
    """Bring a lot's first layout to what the survey that made it found, and store what it saw of each stall.

    A stall that has an id keeps it, and its label. Once the layout has another version, no stall is added or moved.
    """
    version = newest_layout(connection, lot)
    known = {
        row["first_id"]: row
        for row in connection.execute(select(STALL).where(STALL.c.lot == lot, STALL.c.first_survey == seq)).mappings()
    }
    place = {"lot": lot, "layout": version, "north": 0, "east": 0, "turn": 0}
    connection.execute(update(SURVEY).where(SURVEY.c.seq == seq).values(**place))
    if version == 1:
        connection.execute(update(LOT).where(LOT.c.id == lot).values(outline=outline_json(survey.outline)))
        _follow(connection, lot, seq, survey.stalls, known)
        read_again(connection, lot)
    mine = select(STALL.c.first_id, STALL.c.key).where(STALL.c.lot == lot, STALL.c.first_survey == seq)
    keys = {row.first_id: row.key for row in connection.execute(mine)}
    observe(connection, seq, keys, survey.stalls)


def _follow(
    connection: Connection, lot: str, seq: int, stalls: Sequence[Detection], known: Mapping[int, RowMapping]
) -> None:
    """Add stalls that are new, move known ones, and end those that are there no more; confirmed ones stay."""
    ids = {stall.id for stall in stalls}
    for number, row in known.items():
        if number not in ids and not row["is_confirmed"]:
            connection.execute(update(STALL).where(STALL.c.key == row["key"]).values(ends=row["begins"]))
    for stall in stalls:
        former = known.get(stall.id)
        if former is not None and not former["is_confirmed"]:
            connection.execute(update(STALL).where(STALL.c.key == former["key"]).values(ends=None, **shape(stall)))
    kept = {number: str(row["label"]) for number, row in known.items()}
    present = connection.execute(select(STALL.c.label).where(STALL.c.lot == lot, STALL.c.ends.is_(None))).scalars()
    labels = lasting_labels({stall.id: stall.on_map() for stall in stalls}, kept, set(present))
    new = [stall for stall in stalls if stall.id not in known]
    if not new:
        return
    rows = [
        {"id": new_id(), "lot": lot, "label": labels[stall.id], **shape(stall), "kind": "", "is_confirmed": False}
        | {"begins": 1, "ends": None, "first_survey": seq, "first_id": stall.id}
        for stall in new
    ]
    connection.execute(insert(STALL), rows)


def shape(stall: Detection) -> dict[str, float]:
    """Return place and size of a stall as columns of the table of stalls."""
    return dict(zip(SHAPE, stall.shape, strict=True))


def observe(connection: Connection, seq: int, keys: Mapping[int, int], stalls: Sequence[Detection]) -> None:
    """Store what a survey saw of known stalls. ``keys``: id in the survey -> key of the stall."""
    if rows := looks_of(seq, keys, stalls):
        connection.execute(insert(OBSERVATION), rows)


def looks_of(seq: int, keys: Mapping[int, int], stalls: Sequence[Detection]) -> list[dict[str, Any]]:
    """Return the rows of the table of observations: what a survey saw of known stalls. ``keys`` as in `observe`."""
    return [
        {
            "survey": seq,
            "stall": keys[stall.id],
            "looked_at": stall.looked_at,
            "taken_probability": stall.taken_probability,
        }
        | {"state": stall.state.value, "picture_count": stall.picture_count}
        for stall in stalls
        if stall.id in keys
    ]


def register_survey(
    connection: Connection, lot: str, seq: int, survey: FinishedSurvey, register: Register, before: RowMapping | None
) -> Registration | Doubtful:
    """Store the survey's looks at the lot's stalls where it is certain which they are, else the doubt.

    A survey that goes on keeps the place that a person chose, and the one that it has, where the new one is not
    certain.
    """
    looked = Findings.of(survey)
    former = None if before is None or before["lot"] != lot else Doubt.read(before["doubt"])
    if former is not None and former.move is not None:
        outcome: Registration | Doubtful = placed_by(connection, lot, looked, former.move)
        doubt: Doubt | None = former
    else:
        outcome = registered(connection, lot, looked, register)
        doubt = Doubt(outcome.why, outcome.places) if isinstance(outcome, Doubtful) else None
        if doubt is not None and before is not None and before["placed"] == Placed.REGISTERED:
            place = Move.stored(before)
            outcome, doubt = placed_by(connection, lot, looked, place), None
    values: dict[str, Any] = {"doubt": None if doubt is None else doubt.json()}
    if isinstance(outcome, Registration):
        keys = {stall.id: stall.key for stall in all_stalls(connection, lot)}
        observe(connection, seq, {number: keys[same] for number, same in outcome.same.items()}, survey.stalls)
        values |= registered_place(outcome, newest_layout(connection, lot))
    connection.execute(update(SURVEY).where(SURVEY.c.seq == seq).values(**values))
    return outcome


def registered_place(registration: Registration, layout: int) -> dict[str, Any]:
    """Return the columns of a survey that is registered with a version of the layout."""
    place = {"north": registration.north, "east": registration.east, "turn": registration.turn}
    return {**place, "placed": Placed.REGISTERED.value, "layout": layout}


def _id_of(connection: Connection, seq: int) -> str:
    return str(connection.execute(select(SURVEY.c.id).where(SURVEY.c.seq == seq)).scalar_one())


def _name_of(connection: Connection, lot: str | None) -> str:
    return connection.execute(select(LOT.c.name).where(LOT.c.id == lot)).scalar() or ""


def _message(saved: Saved, survey: FinishedSurvey, *, is_sure: bool) -> str:
    facts = {"survey": saved.survey, "lot": saved.lot, "placed": saved.placed.value, "stalls": len(survey.stalls)}
    facts |= {"simulated": survey.simulated, "kind": survey.kind.value}
    return json.dumps(facts | {"ended": utc(survey.ended), "time_is_sure": is_sure})
