"""Private ground of a plan: no picture that is stored or shown has it, and no vehicle there is counted."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Sequence
from datetime import UTC
from pathlib import Path

import numpy as np
import pytest

from hawk.exports.records import read_survey
from hawk.lots import lists
from hawk.lots.ingest import save
from hawk.lots.known_lot import private_ground
from hawk.lots.lists import Asked
from hawk.lots.plan.queries import all_stalls, private_zones
from hawk.lots.registration.georeference import about
from hawk.lots.sections.vehicle_counts import vehicle_counts
from hawk.lots.storage.database import Database
from hawk.lots.survey.pictures import PictureFolder, without
from hawk.lots.survey.private_ground import ERROR_M, PLACED_M, hidden_in
from hawk.lots.values import NotFoundError, Placed
from hawk.model.lot_map import CELL_M, TILE_CELLS
from hawk.model.tile_picture import decode_picture
from hawk.stats.panel import Period, read_panel
from tests.unit.lots.plan.plans import FAST, Person
from tests.unit.lots.survey.test_pictures import image_of, tile
from tests.unit.lots.survey.test_section_looks import KERB, looks, with_cars
from tests.unit.lots.surveys import DATUM, later, survey

GARDEN = [[9.0, 2.0], [9.0, 8.0], [13.0, 8.0], [13.0, 2.0]]
"""Over the first car at the kerb."""


@pytest.fixture
def ann(tmp_path: Path) -> Iterator[Person]:
    store = Database(tmp_path / "lots.db", FAST)
    with store.writing() as connection:
        saved = save(connection, with_cars(survey(), [5.0, 20.0, 30.0]))
    person = Person(store, str(saved.lot))
    person.open()
    yield person
    store.close()


TWO_STALLS = [[-2.0, -1.0], [-2.0, 3.0], [2.0, 3.0], [2.0, -1.0]]
"""Over the middles of the first two stalls of the first row."""
EVER = Period(None, None, UTC, "UTC")


def forbid(person: Person, outline: Sequence[Sequence[float]] = GARDEN) -> None:
    person.do("forbid", outline=outline, name="Garden", private=True)


def numbers(person: Person) -> dict[str, int]:
    """Return how many stalls each reader of states has of the first survey."""
    survey = survey_id(person)
    with person.store.reading() as connection:
        (listed,) = lists.surveys(connection, Asked(), lot_id=person.lot).items
        (newest,) = lists.lots(connection, Asked()).items
        assert newest.last_survey is not None
        return {
            "file": len(read_survey(connection, survey).stalls),
            "looks": len(lists.observations(connection, Asked(), survey_id=survey).items),
            "looks at the lot": len(lists.observations(connection, Asked(), lot_id=person.lot).items),
            "figures": read_panel(connection, person.lot, EVER).state.shape[1],
            "survey": listed.free + listed.taken + listed.unknown,
            "lot": newest.last_survey.free + newest.last_survey.taken + newest.last_survey.unknown,
        }


def survey_id(person: Person, number: int = 1) -> str:
    with person.store.reading() as connection:
        (found,) = connection.exec_driver_sql("SELECT id FROM survey WHERE seq = ?", (number,)).one()
    return str(found)


def test_private_ground_is_a_zone_without_stalls_of_its_own_kind(ann: Person) -> None:
    forbid(ann)
    ann.do("forbid", outline=[[-2.0, 0.0], [-2.0, 3.0], [2.0, 3.0]], name="Works")
    with ann.store.reading() as connection:
        zones = {each.name: each for each in lists.zones(connection, ann.lot, Asked()).items}
        assert [len(ring) for ring in private_zones(connection, ann.lot)] == [4]
    assert {name: (each.kind, each.has_stalls, each.is_private) for name, each in zones.items()} == {
        "Garden": ("", False, True), "Works": ("", False, False),
    }  # fmt: skip


def test_vehicles_there_are_counted_nowhere_and_again_when_the_area_goes(ann: Person) -> None:
    ann.do("draw_section", name="Elm Street", **KERB)
    assert [each["parked"] for each in looks(ann)] == [3]
    forbid(ann)
    assert [each["parked"] for each in looks(ann)] == [2]
    with ann.store.reading() as connection:
        assert vehicle_counts(connection, survey_id(ann)).vehicles == 2
    ann.undo()
    assert [each["parked"] for each in looks(ann)] == [3]


def test_the_rings_of_a_survey_are_wider_where_only_the_receiver_places_it(ann: Person) -> None:
    forbid(ann)
    with ann.store.writing() as connection:
        again = save(connection, later(survey(), 2))
    assert again.placed is Placed.UNREGISTERED
    with ann.store.reading() as connection:
        (near,), (far,) = (hidden_in(connection, survey_id(ann, number)) for number in (1, 2))
        (flown,) = private_ground(connection, ann.lot, (DATUM.latitude, DATUM.longitude))
        assert hidden_in(connection, "no-survey") == ()
    for ring, wider in ((near, PLACED_M), (far, ERROR_M), (flown, ERROR_M)):
        assert np.min(ring, axis=0) == pytest.approx([9.0 - wider, 2.0 - wider], abs=0.02)
        assert np.max(ring, axis=0) == pytest.approx([13.0 + wider, 8.0 + wider], abs=0.02)


def test_a_survey_that_may_be_of_several_lots_hides_the_private_ground_of_each(ann: Person) -> None:
    forbid(ann)
    with ann.store.writing() as connection:
        connection.exec_driver_sql("UPDATE survey SET candidates = json_array(lot), lot = NULL, placed = 'undecided'")
        assert len(hidden_in(connection, survey_id(ann))) == 1


def test_more_stalls_there_than_sqlite_takes_values_of_a_question_are_hidden_too(ann: Person) -> None:
    forbid(ann, [[-100.0, -100.0], [-100.0, 100.0], [100.0, 100.0], [100.0, -100.0]])
    with ann.store.reading() as connection:
        driver = connection.connection.driver_connection
        assert driver is not None
        most = driver.setlimit(sqlite3.SQLITE_LIMIT_VARIABLE_NUMBER, 30)
        found = lists.observations(connection, Asked(), survey_id=survey_id(ann)).items
        driver.setlimit(sqlite3.SQLITE_LIMIT_VARIABLE_NUMBER, most)
    assert found == []


def test_states_of_earlier_surveys_there_are_neither_shown_nor_counted(ann: Person) -> None:
    assert set(numbers(ann).values()) == {40}
    with ann.store.reading() as connection:
        first = next(each.id for each in all_stalls(connection, ann.lot) if each.key == 1)
        assert lists.stall(connection, first).state is not None
    forbid(ann, TWO_STALLS)
    assert numbers(ann) == dict.fromkeys(numbers(ann), 38)
    with ann.store.reading() as connection:
        assert lists.observations(connection, Asked(), stall_id=first).items == []
        with pytest.raises(NotFoundError, match="read the stalls of the lot again"):
            lists.stall(connection, first)
    ann.undo()
    assert set(numbers(ann).values()) == {40}


def test_an_area_that_is_erased_gives_the_states_back_and_no_stall(ann: Person) -> None:
    forbid(ann, TWO_STALLS)
    ann.do("allow", zone=ann.plan()["zones"][0]["id"])
    assert numbers(ann) == dict.fromkeys(numbers(ann), 40)


def test_what_a_survey_without_a_place_found_there_is_not_shown(ann: Person) -> None:
    forbid(ann, TWO_STALLS)
    with ann.store.writing() as connection:
        save(connection, later(survey(), 2))
    with ann.store.reading() as connection:
        shown = read_survey(connection, survey_id(ann, 2))
    middle = np.array([stall.place for stall in shown.stalls])
    assert shown.layout is None
    assert 30 <= len(shown.stalls) < 38, "wider by the error of a receiver"
    assert (np.abs(about((DATUM.latitude, DATUM.longitude), middle)[:, :2] - [0.0, 1.0]) > [4.9, 6.9]).any(axis=1).all()


def test_a_picture_leaves_the_ground_out_wherever_it_is_read(tmp_path: Path) -> None:
    folder, key = PictureFolder(tmp_path), (-1, 0)
    ring = tuple((float(north), float(east)) for north, east in GARDEN)
    row, column = round((25.6 - 11.0) / CELL_M), round(5.0 / CELL_M)
    folder.write("old", {key: tile(200), (0, 0): tile(90)})
    folder.write("new", {key: tile(200), (0, 0): tile(90)}, [ring])
    shown = [
        folder.read("old", [ring])[key],
        folder.tile("old", key, [ring]),
        folder.read("new")[key],
        folder.tile("new", key),
    ]
    for data in shown:
        assert data is not None
        pixels, seen = decode_picture(data)
        assert seen[row, column] == 0
        assert seen[row, column + 60] == 255
        assert not seen[row - 15 : row + 15, column - 25 : column + 25].any()
        assert not pixels[seen == 0].max() > 205, "no colour of it is left below the mask"
    for whole in (folder.whole("old", [ring]), folder.whole("new")):
        image = image_of(whole)
        assert image.shape == (2 * TILE_CELLS, TILE_CELLS, 4)
        assert image[row, column, 3] == 0
        assert image[row, column + 60, 3] == 255
    assert folder.tile("old", (0, 0), [ring]) == tile(90).data, "a tile beside it stays as it is"
    assert folder.tile("old", key) == tile(200).data, "and the file itself, which an older plan may show"


def test_a_tile_that_cannot_be_read_is_not_shown_where_it_may_be_private() -> None:
    ring = tuple((float(north), float(east)) for north, east in GARDEN)
    assert without(b"no picture", (-1, 0), [ring]) == b""
    assert without(b"no picture", (9, 9), [ring]) == b"no picture"


def test_the_plan_says_which_areas_are_private(ann: Person) -> None:
    forbid(ann)
    assert [each["kind"] for each in ann.plan()["zones"]] == ["private_ground"]
