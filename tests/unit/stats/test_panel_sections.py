"""A lot of sections alone, without a stall: its surveys count, are compared, asked about and reported."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from hawk.exports.records import read_survey, survey_of, surveys_of
from hawk.lots import lists
from hawk.lots.ingest import save
from hawk.lots.plan_files.formats import read_plan
from hawk.lots.plan_import import transfer
from hawk.lots.plan_import.choices import asked_of as chosen_of
from hawk.lots.plan_import.previews import preview
from hawk.lots.storage.database import Database
from hawk.lots.survey.pictures import PictureFolder
from hawk.report.document import document
from hawk.report.options import Form, Wanted
from hawk.report.queries import read_report
from hawk.report.workbook import sheets
from hawk.stats import queries
from hawk.stats.period import period_of_lot
from hawk.stats.use_query import asked_of
from tests.unit.lots.plan.plans import FAST, Person
from tests.unit.lots.plan_files.files import degrees, feature, geojson
from tests.unit.lots.survey.test_section_looks import KERB
from tests.unit.stats.test_section_use import MONDAY, flown_at

PARKED = ((3.0, 20.0, 30.0), (3.0, 9.0, 14.0, 20.0, 30.0, 38.0), ())


@pytest.fixture(scope="module")
def street(tmp_path_factory: pytest.TempPathFactory) -> Person:
    """A lot made of a file with one kerb, and three surveys that found vehicles and no stall."""
    store = Database(tmp_path_factory.mktemp("street") / "lots.db", FAST)
    line = [(north, east) for north, east in KERB["line"]]
    kerb = feature(degrees(line), "LineString", name="Elm", side="right", kind="parallel", capacity=8)
    chosen = chosen_of({}, ())
    with store.writing() as connection:
        found = preview(connection, None, read_plan(geojson([kerb]), chosen.file), chosen, None)
        lot = transfer.begin(connection, found, {"name": "Elm Street"}, "Ann", MONDAY - 1e6).lot
    for number, easts in enumerate(PARKED):
        with store.writing() as connection:
            flown = flown_at(number, MONDAY + 3600 * number, easts)
            saved = save(connection, replace(flown, stalls=(), outline=flown.seen_ground))
        assert saved.lot == lot
    return Person(store, str(lot))


@pytest.mark.slow
def test_its_surveys_count_by_their_looks_at_sections(street: Person) -> None:
    with street.store.reading() as connection:
        found = queries.surveys_use(connection, street.lot, period_of_lot(connection, street.lot))
        figures = queries.statistics(connection, street.lot, period_of_lot(connection, street.lot), "section")
    assert [(each.left_out, each.left_out_code, each.occupancy.value) for each in found.surveys] == [("", "", None)] * 3
    assert [(each.name, each.surveys) for each in figures.parts] == [("Elm", 3)]


def test_it_is_listed_with_the_number_of_its_sections(street: Person) -> None:
    with street.store.reading() as connection:
        (lot,) = lists.lots(connection, lists.Asked(10)).items
    assert (lot.stalls, lot.sections, lot.survey_count) == (0, 1, 3)


def test_two_of_its_surveys_are_compared(street: Person) -> None:
    with street.store.reading() as connection:
        listed = queries.surveys_use(connection, street.lot, period_of_lot(connection, street.lot)).surveys
        found = queries.changes(connection, street.lot, listed[2].id, listed[1].id)
    (elm,) = found.sections
    assert elm.before is not None
    assert elm.after is not None
    assert (found.compared, elm.capacity, elm.before.parked, elm.after.parked) == (0, 8, 3, 6)


def test_a_question_about_all_of_it_is_about_all_sections(street: Person) -> None:
    with street.store.reading() as connection:
        found = queries.ask(connection, street.lot, period_of_lot(connection, street.lot), asked_of())
        one = queries.ask(connection, street.lot, period_of_lot(connection, street.lot), asked_of(sections=["Elm"]))
    assert (found.unit, found.places) == ("places", 8)
    assert found.accumulation.value == pytest.approx(3.0)
    assert found == one


def test_its_stalls_are_none_and_its_report_has_the_sections(street: Person, tmp_path: Path) -> None:
    with street.store.reading() as connection:
        heat = queries.stalls_use(connection, street.lot, period_of_lot(connection, street.lot))
        report = read_report(connection, PictureFolder(tmp_path), Wanted(street.lot, asked_of()), MONDAY + 1e5)
    assert (heat.ids, heat.surveys_in_period) == ([], 3)
    assert report.sections is not None
    assert report.sections.use is not None
    assert report.sections.use.accumulation.value == pytest.approx(3.0)
    assert json.dumps([each.name for each in report.sections.sections]) == '["Elm"]'
    assert report.missing == ()
    text = document(report, Form())
    assert "<td>Elm</td>" in text
    assert "Sections, weekday by hour" in text
    assert sheets(report, "en")


def test_the_newest_survey_is_exported_with_its_sections(street: Person) -> None:
    with street.store.reading() as connection:
        found = read_survey(connection, survey_of(connection, street.lot))
        assert len(surveys_of(connection, street.lot)) == 3
    assert [(each.section.name, each.look.parked) for each in found.sections] == [("Elm", 0)]
    assert found.stalls == ()


def test_a_lot_that_gets_stalls_is_counted_by_these(street: Person, tmp_path: Path) -> None:
    """Surveys that are not registered on them are left out, as before."""
    street.open()
    street.do("add_stall", north=0.0, east=0.0, angle=0.0, width=2.5, length=5.0)
    with street.store.reading() as connection:
        found = queries.surveys_use(connection, street.lot, period_of_lot(connection, street.lot))
    street.undo()
    assert {each.left_out_code for each in found.surveys} == {"unregistered"}
