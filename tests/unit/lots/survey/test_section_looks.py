"""Looks of surveys at sections: made with a survey, again with its place or a section, and gone with either."""

from __future__ import annotations

import math
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hawk.lots import commands, queries
from hawk.lots.ingest import save
from hawk.lots.lists import Asked
from hawk.lots.sections import lists as section_lists
from hawk.lots.sections.vehicle_counts import vehicle_counts
from hawk.lots.storage.backup import restore, verify
from hawk.lots.storage.database import Database, copy
from hawk.lots.storage.erasure import emptied, erase_rows, found_lot, found_survey
from hawk.lots.storage.tables import unpack_vehicles
from hawk.lots.values import FinishedSurvey, Placed, VehicleDetection
from hawk.model.lot_map import StallState
from hawk.model.vehicles import VehicleKind
from tests.unit.lots.plan.plans import FAST, NOW, Person
from tests.unit.lots.surveys import BEGAN, later, survey

Json = dict[str, Any]
KERB: Json = {"line": [[12.0, 0.0], [12.0, 44.0]], "side": "right", "width": 2.5, "kind": "parallel"}
"""North of the rows of stalls, within what a survey sees."""


def vehicle(number: int, north: float, east: float, p: float = 0.97) -> VehicleDetection:
    return VehicleDetection(
        number, VehicleKind.CAR, north, east, math.pi / 2, 1.8, 4.5, p, 5, 60.0, BEGAN + 300 + number
    )


def with_cars(flown: FinishedSurvey, easts: Sequence[float]) -> FinishedSurvey:
    return replace(flown, vehicles=tuple(vehicle(n, 10.8, east) for n, east in enumerate(easts, 1)))


@pytest.fixture
def ann(tmp_path: Path) -> Iterator[Person]:
    store = Database(tmp_path / "lots.db", FAST)
    with store.writing() as connection:
        saved = save(connection, with_cars(survey(), [3.0, 20.0, 30.0]))
    assert (saved.placed, saved.lot is not None) == (Placed.FIRST, True)
    person = Person(store, str(saved.lot))
    person.open()
    yield person
    store.close()


def drawn(person: Person, **more: Any) -> str:
    return str(person.do("draw_section", name="Elm Street", **{**KERB, **more})["sections"][0]["id"])


def looks(person: Person) -> list[Json]:
    """Return the looks of all surveys, the first survey's first."""
    found = []
    with person.store.reading() as connection:
        for (each,) in connection.exec_driver_sql("SELECT id FROM survey ORDER BY seq").all():
            found += section_lists.looks(connection, each, Asked()).model_dump(mode="json")["items"]
    return found


def newest(person: Person) -> Json | None:
    with person.store.reading() as connection:
        (section,) = section_lists.sections(connection, person.lot, Asked()).model_dump(mode="json")["items"]
    look: Json | None = section["look"]
    return look


def test_a_section_that_is_drawn_counts_the_vehicles_of_the_surveys_before(ann: Person) -> None:
    section = drawn(ann)
    (look,) = looks(ann)
    assert {name: look[name] for name in ("section", "source", "parked", "capacity", "occupancy", "room")} == {
        "section": section, "source": "vehicles", "parked": 3, "capacity": 8, "occupancy": 0.375, "room": 4,
    }  # fmt: skip
    assert look["least"] <= 3 <= look["most"] <= 6
    assert (look["seen_share"], look["hidden_share"], look["observed"][:19]) == (1.0, 0.0, "2026-02-02T02:45:03")
    assert newest(ann) == look


def test_more_than_the_capacity_is_shown_and_without_one_the_count_alone(ann: Person) -> None:
    section = drawn(ann, capacity=2)
    assert looks(ann)[0]["occupancy"] == 1.5
    ann.do("change_section", section=section, kind="", capacity=None)
    (look,) = looks(ann)
    assert (look["parked"], look["capacity"], look["occupancy"], look["room"]) == (3, None, None, None)


def test_a_later_survey_is_counted_when_it_is_saved_and_the_newest_look_is_shown(ann: Person) -> None:
    drawn(ann)
    with ann.store.writing() as connection:
        seq = connection.exec_driver_sql("SELECT seq FROM survey").scalar_one()
        again = with_cars(later(survey(), 2), [3.0])
        saved = save(connection, again)
        assert (saved.placed, saved.seq != seq) == (Placed.UNREGISTERED, True)  # nothing says where it lies
    assert len(looks(ann)) == 1
    with ann.store.writing() as connection:
        connection.exec_driver_sql(
            "UPDATE survey SET placed = 'first', north = 0, east = 0, turn = 0, layout = 1 WHERE seq = ?", (saved.seq,)
        )
        save(connection, again)  # the same survey lands again, after a battery swap
    assert [each["parked"] for each in looks(ann)] == [3, 1]
    shown = newest(ann)
    assert shown is not None
    assert shown["parked"] == 1


def test_undo_takes_looks_back_and_redo_makes_them_again(ann: Person) -> None:
    section = drawn(ann)
    before = looks(ann)
    ann.do("remove_section", section=section)
    assert looks(ann) == []
    ann.undo()
    assert looks(ann) == before
    ann.undo()
    assert looks(ann) == []
    ann.redo()
    assert looks(ann) == before


def test_another_name_keeps_the_looks_and_another_capacity_counts_again(
    ann: Person, caplog: pytest.LogCaptureFixture
) -> None:
    """The survey's vehicles are damaged meanwhile: who counts again passes it over."""
    section = drawn(ann)
    with ann.store.writing() as connection:
        connection.exec_driver_sql("UPDATE survey SET vehicles = x'00'")
    ann.do("change_section", section=section, name="Oak Street", note="permit")
    assert [(each["name"], each["parked"]) for each in looks(ann)] == [("Oak Street", 3)]
    ann.undo()
    assert [(each["name"], each["parked"]) for each in looks(ann)] == [("Elm Street", 3)]
    assert "the vehicles of a survey cannot be read" not in caplog.text
    ann.do("change_section", section=section, capacity=4)
    assert looks(ann) == []
    assert "the vehicles of a survey cannot be read" in caplog.text


def test_a_section_that_was_renamed_and_removed_has_its_looks_after_the_undo_of_the_edit(ann: Person) -> None:
    section = drawn(ann)
    ann.close()
    before = looks(ann)
    ann.open()
    ann.do("change_section", section=section, note="permit")
    ann.do("remove_section", section=section)
    changed = ann.close()
    assert looks(ann) == []
    ann.undo_change(changed["seq"])
    assert looks(ann) == before
    ann.open()
    ann.do("draw_section", **{**KERB, "name": "Oak Street"})
    ann.do("change_section", section=section, note="loading")
    ann.undo_change(ann.close()["seq"])
    assert looks(ann) == before


def test_a_survey_that_is_deleted_has_no_look_until_that_is_undone(ann: Person) -> None:
    drawn(ann)
    ann.close()
    before = looks(ann)
    with ann.store.writing() as connection:
        done = commands.delete(connection, before[0]["survey"], "Ann", NOW)
    assert newest(ann) is None
    ann.undo_change(done.seq)
    assert looks(ann) == before


@pytest.mark.slow
def test_a_network_that_knows_no_vehicles_counts_taken_stalls(tmp_path: Path) -> None:
    """Row A: 20 stalls from west to east; the section holds the first four middles."""
    store = Database(tmp_path / "lots.db", FAST)
    states = [StallState.TAKEN, StallState.UNKNOWN, StallState.TAKEN, StallState.FREE]
    flown = survey()
    stalls = tuple(
        replace(each, state=states[n], taken_probability=0.9, north=0.0, east=2.5 * n, angle=0.0)
        for n, each in enumerate(flown.stalls[:4])
    )
    with store.writing() as connection:
        saved = save(connection, replace(flown, stalls=(*stalls, *flown.stalls[4:])))
    person = Person(store, str(saved.lot))
    person.open()
    ring = [[-2.5, -1.25], [-2.5, 8.75], [2.5, 8.75], [2.5, -1.25]]
    person.do("draw_section", name="Row A", outline=ring, kind="across")
    (look,) = looks(person)
    assert (look["source"], look["parked"], look["capacity"], look["hidden_share"]) == ("stalls", 2, 4, 0.25)
    assert look["room"] == 2
    store.close()


def test_a_section_that_no_survey_saw_has_no_look(ann: Person) -> None:
    drawn(ann, line=[[500.0, 0.0], [500.0, 44.0]])
    assert looks(ann) == []
    assert newest(ann) is None


def test_vehicles_are_counted_by_their_ground_and_none_is_shown(ann: Person) -> None:
    """Three stand at the kerb, one on the first stall, one in the aisle between the rows, one far off."""
    drawn(ann)
    with ann.store.writing() as connection:
        cars = [vehicle(n, 10.8, east) for n, east in enumerate([3.0, 20.0, 30.0], 1)]
        first = ann.stalls()["A 1"]
        cars.append(replace(vehicle(4, first["north"], first["east"]), angle=0.0))
        cars += [vehicle(5, -4.6, 20.0), vehicle(6, 300.0, 0.0)]
        saved = save(connection, replace(survey(), vehicles=tuple(cars)))
    with ann.store.reading() as connection:
        found = vehicle_counts(connection, saved.survey)
    assert (found.vehicles, found.on_stalls, found.in_sections, found.beside, found.elsewhere) == (6, 1, 3, 1, 1)
    with ann.store.writing() as connection:
        unknown = save(connection, survey())
    with ann.store.reading() as connection:
        assert vehicle_counts(connection, unknown.survey).model_dump(exclude={"survey"}, exclude_none=True) == {}


@pytest.mark.parametrize("ring", ["[[0,0],[20,20],[20,0],[0,20]]", "[[0,0],[0,1],[0,2]]"])
def test_a_ring_on_the_disk_that_is_no_area_stops_no_save(ann: Person, ring: str) -> None:
    drawn(ann)
    ann.close()
    with ann.store.writing() as connection:
        connection.exec_driver_sql("UPDATE section SET outline = ?", (ring,))
    with ann.store.writing() as connection:
        saved = save(connection, with_cars(survey(), [3.0]))
    assert saved.lot == ann.lot
    assert looks(ann) == []


@pytest.mark.fault("a section's ring, or a survey's vehicles, are damaged on the disk", "passed over; all others count")
def test_what_is_damaged_is_passed_over(ann: Person, caplog: pytest.LogCaptureFixture) -> None:
    drawn(ann)
    with ann.store.writing() as connection:
        connection.exec_driver_sql("UPDATE section SET outline = '[[1'")
    other = ann.do("draw_section", name="Oak Street", **KERB)
    assert {each["name"] for each in looks(ann)} == {"Elm Street", "Oak Street"}
    with ann.store.writing() as connection:
        connection.exec_driver_sql("UPDATE survey SET vehicles = x'00'")
    section = next(each["id"] for each in other["sections"] if each["name"] == "Oak Street")
    ann.do("change_section", section=section, capacity=3)
    assert "the vehicles of a survey cannot be read" in caplog.text
    assert {each["name"] for each in looks(ann)} == {"Elm Street"}


def test_a_lot_without_stalls_is_counted_where_the_receiver_says_that_a_survey_lies(ann: Person) -> None:
    drawn(ann)
    ann.do("remove", all=True)
    ann.close()
    with ann.store.writing() as connection:
        saved = save(connection, with_cars(replace(later(survey(), 2), stalls=()), [3.0, 9.0]))
    assert (saved.lot, saved.placed) == (ann.lot, Placed.UNREGISTERED)
    assert [each["parked"] for each in looks(ann)] == [3, 2]


def test_vehicles_and_looks_go_with_their_survey_and_sections_with_their_lot(ann: Person) -> None:
    section = drawn(ann)
    ann.close()
    ann.store.close()
    path = ann.store.path
    with emptied(path) as store:
        (name,) = store.execute("SELECT id FROM survey").fetchone()
        erase_rows(store, found_survey(store, name))
    with closing(sqlite3.connect(path)) as store:
        assert store.execute("SELECT count(*) FROM section_look").fetchone() == (0,)
        assert store.execute("SELECT count(*) FROM section").fetchone() == (1,)
    with emptied(path) as store:
        erase_rows(store, found_lot(store, ann.lot))
    assert section.encode() not in path.read_bytes()
    assert "whole, lots 0, surveys 0" in verify(path)


def test_a_backup_has_sections_vehicles_and_looks(ann: Person, tmp_path: Path) -> None:
    drawn(ann)
    before, plan = looks(ann), ann.plan()["sections"]
    ann.store.close()
    copy(ann.store.path, tmp_path / "backup.lots")
    with closing(sqlite3.connect(ann.store.path)) as store, store:
        store.execute("DELETE FROM section_look")
    restore(ann.store.path, tmp_path / "backup.lots")
    ann.store = Database(ann.store.path, FAST)
    assert (looks(ann), ann.plan()["sections"]) == (before, plan)
    with ann.store.reading() as connection:
        packed = connection.exec_driver_sql("SELECT vehicles FROM survey").scalar_one()
        row = queries.survey_row(connection, before[0]["survey"])
    found = unpack_vehicles(packed)
    assert found is not None
    assert [each.east for each in found] == [3.0, 20.0, 30.0]
    assert row["vehicles"] == packed
