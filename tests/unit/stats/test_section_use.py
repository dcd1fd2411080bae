"""Use of sections: parked of the places with its interval, by hour and weekday, never mixed with stalls."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hawk.lots.ingest import save
from hawk.lots.storage.database import Database
from hawk.lots.values import FinishedSurvey, LotInputError
from hawk.stats import queries, serialize
from hawk.stats.aggregates import cds_aggregates
from hawk.stats.hour_use import AskedUse
from hawk.stats.panel import read_panel
from hawk.stats.period import period_of_lot
from hawk.stats.section_use import UNSEEN_SECTION, read_sections
from hawk.stats.use_query import asked_of
from tests.unit.lots.plan.plans import FAST, Person
from tests.unit.lots.survey.test_section_looks import KERB, with_cars
from tests.unit.lots.surveys import later, survey
from tests.unit.stats.test_panel import register

MONDAY = 1_794_823_200.0
"""A Monday, 2026-11-16 at 10:00 UTC: 11:00 by the lot's clock."""
FLOWN = (
    (0, (3.0, 20.0, 30.0)), (2, (3.0, 9.0, 20.0, 30.0, 38.0)), (24, (9.0,)), (26, ()),
    (7 * 24, (3.0, 20.0, 30.0, 38.0)),
)  # fmt: skip
"""Hours after that, and where vehicles stand along the kerb, metres east."""
ACROSS: dict[str, Any] = {"outline": [[11.9, 0.0], [11.9, 15.0], [9.6, 15.0], [9.6, 0.0]]}


def flown_at(number: int, at: float, easts: tuple[float, ...]) -> FinishedSurvey:
    """Return a survey whose looks are of a moment, with vehicles along the kerb."""
    given = with_cars(survey(), easts)
    stalls = tuple(replace(each, looked_at=at) for each in given.stalls)
    vehicles = tuple(replace(each, looked_at=at) for each in given.vehicles or ())
    return replace(later(given, number), began=at - 600, ended=at, stalls=stalls, vehicles=vehicles)


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """A store's file of a lot with these surveys, and a section along the kerb; no test changes it."""
    file = tmp_path_factory.mktemp("street") / "lots.db"
    store = Database(file, FAST)
    for number, (hours, easts) in enumerate(FLOWN):
        with store.writing() as connection:
            saved = save(connection, flown_at(number, MONDAY + 3600 * hours, easts), register)
    person = Person(store, str(saved.lot))
    person.open()
    person.do("draw_section", name="Elm Street", capacity=4, **KERB)
    person.close()
    store.close()
    return file, str(saved.lot)


@pytest.fixture
def ann(tmp_path: Path, flown: tuple[Path, str]) -> Iterator[Person]:
    store = Database(Path(shutil.copy(flown[0], tmp_path / "lots.db")), FAST)
    person = Person(store, flown[1])
    person.open()
    yield person
    store.close()


def ask(person: Person, **asked: Any) -> AskedUse:
    with person.store.reading() as connection:
        during = period_of_lot(connection, person.lot)
        return queries.ask(connection, person.lot, during, asked_of(**{"sections": ["Elm Street"], **asked}))


@pytest.mark.slow
def test_a_section_is_asked_by_hour_and_weekday(ann: Person) -> None:
    found = ask(ann, weekday="mon", hour="11-12")
    assert (found.unit, found.places, found.stalls) == ("places", 4, 0)
    assert (found.hours, found.days, found.accumulation.surveys) == (2, 2, 2)
    assert found.accumulation.value == 3.5
    assert found.occupancy.value == 3.5 / 4
    assert (found.accumulation.low or 0.0) <= 3.5 < (found.accumulation.high or 0.0)
    by_cell = {(cell.weekday, cell.hour): cell for cell in found.cells if cell.days}
    assert {key: cell.accumulation.value for key, cell in by_cell.items()} == {
        ("Monday", 11): 3.5, ("Monday", 13): 5.0, ("Tuesday", 11): 1.0, ("Tuesday", 13): 0.0,
    }  # fmt: skip
    assert by_cell["Monday", 13].occupancy.value == 1.25, "more are parked than there are places"
    assert [each.accumulation.value for each in found.surveys] == [3.0, 4.0]


def test_means_of_many_looks_are_no_surer_than_the_looks(ann: Person) -> None:
    with ann.store.reading() as connection:
        rows = connection.exec_driver_sql("SELECT least, most FROM section_look").all()
    found = ask(ann).accumulation
    # five looks in five hours: ends are the means of the ends
    assert found.low == pytest.approx(sum(least for least, _ in rows) / 5)
    assert found.high == pytest.approx(sum(most for _, most in rows) / 5)


def test_without_places_there_is_the_number_alone(ann: Person) -> None:
    ann.do("draw_section", name="Yard", **ACROSS)
    found = ask(ann, sections=["Yard"], weekday="mon")
    assert (found.unit, found.places, found.occupancy.value) == ("vehicles", None, None)
    assert found.accumulation.value == pytest.approx((1 + 2 + 1) / 3)
    assert found.fullest is not None
    assert (found.fullest.hour, found.fullest.accumulation.value) == (13, 2.0)
    both = ask(ann, sections=["Elm Street", "Yard"], weekday="mon")
    assert both.unit == "vehicles"
    assert both.accumulation.value == pytest.approx(4 + 4 / 3)
    assert "vehicles are parked; nobody said how many places" in serialize.asked_text(both)


def test_sections_are_not_counted_with_stalls(ann: Person) -> None:
    with pytest.raises(LotInputError, match="ask for one or the other") as refused:
        ask(ann, rows=["A"])
    assert refused.value.field == "section"
    with pytest.raises(LotInputError, match="none that is called 'Oak'; there is Elm Street"):
        ask(ann, sections=["Oak"])


def test_a_survey_that_did_not_see_all_of_them_is_named(ann: Person) -> None:
    ann.do("draw_section", name="Far", outline=[[900.0, 0.0], [900.0, 20.0], [920.0, 20.0]], capacity=9)
    found = ask(ann, sections=["Elm Street", "Far"])
    assert (found.hours, found.accumulation.value) == (0, None)
    assert {each.why for each in found.left_out} == {UNSEEN_SECTION}
    assert "nobody flew" in serialize.asked_text(found)


def test_two_surveys_are_compared_by_section_with_both_intervals(ann: Person) -> None:
    ann.do("draw_section", name="Far", outline=[[900.0, 0.0], [900.0, 20.0], [920.0, 20.0]], capacity=9)
    with ann.store.reading() as connection:
        during = period_of_lot(connection, ann.lot)
        ids = [each.id for each in read_sections(connection, ann.lot, during).surveys]
        full, empty = (
            queries.changes(connection, ann.lot, ids[1], ids[3]),
            queries.changes(connection, ann.lot, *ids[:2]),
        )
    (elm,) = full.sections
    assert elm.before is not None
    assert elm.after is not None
    assert (elm.name, elm.capacity, elm.before.parked, elm.after.parked, elm.is_changed) == (
        "Elm Street",
        4,
        5,
        0,
        True,
    )
    (elm,) = empty.sections
    assert elm.is_changed is False, "3 and 5 vehicles may be as many: the intervals meet"


def test_figures_by_section_say_their_unit(ann: Person) -> None:
    ann.do("draw_section", name="Yard", **ACROSS)
    with ann.store.reading() as connection:
        found = queries.statistics(connection, ann.lot, period_of_lot(connection, ann.lot), "section")
    assert found.whole is not None
    assert found.whole.unit == "stalls"
    elm, yard = found.parts
    assert (elm.name, elm.unit, elm.capacity, elm.surveys, elm.hours) == ("Elm Street", "places", 4, 5, 5)
    assert elm.occupancy.value == pytest.approx((3 + 5 + 1 + 0 + 4) / 5 / 4)
    assert elm.peak is not None
    assert elm.peak.begin == "2026-11-16T13:00"
    assert elm.above["0.90"].value == pytest.approx(2 / 5)
    assert (yard.unit, yard.capacity, yard.occupancy.value, yard.turnover.pairs) == ("vehicles", None, None, 0)
    text = serialize.figures_text(found)
    assert "Elm Street  4" in text
    assert "vehicles counted" in text
    with ann.store.reading() as connection:
        during = period_of_lot(connection, ann.lot)
        lines = cds_aggregates(read_panel(connection, ann.lot, during), read_sections(connection, ann.lot, during))
    by_zone = [line.split(",") for line in lines.splitlines()[1:]]
    elm_id = ann.plan()["sections"][0]["id"]
    assert {line[1] for line in by_zone} == {ann.lot, elm_id}, "a section without places has no share"
    assert ["zone", elm_id, "occupancy_percent", "2026-11-16", "13", "1.25"] in by_zone
    assert serialize.figures_csv(found).count("\n") == 3
