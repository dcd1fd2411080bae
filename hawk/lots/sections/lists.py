"""Sections of lots with what surveys saw of them, as parts of lists (`hawk.lots.lists`)."""

from __future__ import annotations

from functools import partial
from typing import Any, Final

from sqlalchemy import Connection, Row, select, true

from hawk.lots.answers import ListedSection, SectionList, SectionLook, SectionLookList, SeenSections
from hawk.lots.lists import Asked, part_of, places_on_earth
from hawk.lots.plan.queries import in_plan, sections_of
from hawk.lots.plan.values import PlanSection
from hawk.lots.queries import lot_row, survey_row
from hawk.lots.registration.survey_place import datum_of
from hawk.lots.storage.outlines import ring_of
from hawk.lots.storage.rows import readable
from hawk.lots.storage.schema import SECTION, SECTION_LOOK, SURVEY
from hawk.lots.survey.order import newest_first
from hawk.lots.values import moment

_SAID: Final = ("id", "name", "kind", "length_m", "capacity", "is_capacity_given", "note")
_COUNTED: Final = ("source", "parked", "least", "most", "room", "hidden_share", "seen_share")
_LOOK: Final = (
    *(SECTION_LOOK.c[name] for name in ("section", "looked_at", *_COUNTED)), SECTION.c.name, SECTION.c.capacity,
    SURVEY.c.id.label("by"),
)  # fmt: skip
_LOOKS: Final = (
    select(*_LOOK)
    .join(SURVEY, SURVEY.c.seq == SECTION_LOOK.c.survey)
    .join(SECTION, (SECTION.c.id == SECTION_LOOK.c.section) & SECTION.c.ends.is_(None))
)


def sections(connection: Connection, lot_id: str, asked: Asked) -> SectionList:
    """Return the sections of a lot's plan with the newest look at each, by their ids.

    Raises NotFoundError, LotInputError.
    """
    lot_row(connection, lot_id)
    is_behind = true() if asked.after is None else SECTION.c.id > asked.after
    rows = select(SECTION).where(in_plan(SECTION.c, lot_id), is_behind).order_by(SECTION.c.id)
    shown = partial(_with_newest, connection, datum_of(connection, lot_id))
    return part_of(SectionList, connection, rows, asked, shown, lambda row: str(row.id))


def sections_with_looks(connection: Connection, lot: str) -> list[ListedSection]:
    """Return the sections of a lot's plan with the newest look at each, by their ids, without damaged ones."""
    rows = connection.execute(select(SECTION).where(in_plan(SECTION.c, lot)).order_by(SECTION.c.id)).all()
    found = readable(partial(_with_newest, connection, datum_of(connection, lot)), rows)
    return [each for each in found if each.outline]


def sections_seen(connection: Connection, lot: str, survey_id: str) -> SeenSections:
    """Return the sections of a lot's plan with what a survey of it saw of each, without damaged ones.

    Raises NotFoundError.
    """
    survey = survey_row(connection, survey_id)
    datum = datum_of(connection, lot)
    looks = {row.section: row for row in connection.execute(_LOOKS.where(SECTION_LOOK.c.survey == survey.key[0]))}
    rows = connection.execute(select(SECTION).where(in_plan(SECTION.c, lot)).order_by(SECTION.c.name)).all()
    found = readable(lambda row: _listed(datum, row, looks.get(row.id)), rows)
    return SeenSections(survey=survey_id, sections=[each for each in found if each.outline])


def _with_newest(connection: Connection, datum: tuple[float, float], row: Row[Any]) -> ListedSection:
    newest = _LOOKS.where(SECTION_LOOK.c.section == row.id, SURVEY.c.lot == row.lot).order_by(*newest_first())
    return _listed(datum, row, connection.execute(newest.limit(1)).first())


def _listed(datum: tuple[float, float], row: Row[Any], look: Row[Any] | None) -> ListedSection:
    ring = ring_of(row.outline)
    return ListedSection(
        **{name: row._mapping[name] for name in _SAID}, outline=ring, ground=places_on_earth(datum, ring),
        look=None if look is None else _shown(look),
    )  # fmt: skip


def looks(connection: Connection, survey_id: str, asked: Asked) -> SectionLookList:
    """Return what a survey saw of the sections of its lot, by their ids. Raises NotFoundError, LotInputError."""
    seq = survey_row(connection, survey_id).key[0]
    is_behind = true() if asked.after is None else SECTION_LOOK.c.section > asked.after
    rows = _LOOKS.where(SECTION_LOOK.c.survey == seq, is_behind).order_by(SECTION_LOOK.c.section)
    return part_of(SectionLookList, connection, rows, asked, _shown, lambda row: str(row.section))


def seen_by(connection: Connection, seq: int) -> list[tuple[PlanSection, SectionLook]]:
    """Return the sections that a survey, by its number, looked at, by their names, with its looks."""
    rows = connection.execute(_LOOKS.where(SECTION_LOOK.c.survey == seq)).all()
    looks = {row.section: _shown(row) for row in rows}
    lot = connection.execute(select(SURVEY.c.lot).where(SURVEY.c.seq == seq)).scalar_one()
    return [(each, looks[each.id]) for each in sections_of(connection, lot) if each.id in looks and each.outline]


def _shown(row: Row[Any]) -> SectionLook:
    return SectionLook(
        survey=row.by, section=row.section, name=row.name, observed=moment(row.looked_at), capacity=row.capacity,
        occupancy=None if row.capacity is None else round(row.parked / row.capacity, 4),
        **{name: row._mapping[name] for name in _COUNTED},
    )  # fmt: skip
