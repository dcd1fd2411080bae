"""Sections of a lot on the map of a flight: their places there, and counts that are those of the stored survey."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Connection

from hawk.lots.ingest import save
from hawk.lots.known_lot import known_lot, lots_ahead
from hawk.lots.plan.queries import all_stalls
from hawk.lots.registration.frames import Move
from hawk.lots.sections import lists as section_lists
from hawk.lots.sections.flown_sections import flown_sections
from hawk.lots.storage.database import Database
from hawk.lots.storage.outlines import outline_json
from hawk.lots.survey.landing import LandingFacts, finished
from hawk.model.known_lot import FlownSection
from hawk.model.lot_map import TILE_CELLS, Cell, EncodedTile, OccupancyMap, Stall, StallState
from hawk.model.vehicles import MapVehicle, VehicleKind
from hawk.results.survey_map import to_global
from tests.unit.lots.plan.plans import FAST, Person, drawn_lot
from tests.unit.lots.surveys import BEGAN, DATUM, box

HERE = (DATUM.latitude, DATUM.longitude)
KERB: dict[str, Any] = {"line": [[-12.0, 2.0], [-12.0, 24.0]], "side": "right", "width": 2.5, "kind": "parallel"}


def vehicle(number: int, north: float, east: float) -> MapVehicle:
    return MapVehicle(number, VehicleKind.CAR, north, east, math.pi / 2, 1.8, 4.5, 0.97, 5, 60.0, 90.0, number)


def flown(easts: tuple[float, ...] = (4.5, 10.0), seen_columns: int = TILE_CELLS) -> OccupancyMap:
    """One tile of lot, seen from its west edge on, with cars along the kerb."""
    cells = np.full((TILE_CELLS, TILE_CELLS), Cell.LOT, np.uint8)
    cells[:, seen_columns:] = Cell.UNKNOWN
    tiles = {(0, 0): EncodedTile(1, zlib.compress(cells.tobytes()))}
    cars = {number: vehicle(number, -13.2, east) for number, east in enumerate(easts, 1)}
    return OccupancyMap(tiles=tiles, vehicles=cars, version=3, map_id="000001-x")


def landed(current: OccupancyMap) -> LandingFacts:
    return LandingFacts(
        name="000001-x", datum=DATUM, current=current, outline=None, seconds=100.0, utc=BEGAN, time_is_sure=True,
        program="0.3.0",
    )  # fmt: skip


def make_lot(connection: Connection) -> str:
    """Store a lot without stalls on the ground of the flight."""
    lot = drawn_lot(connection, 0)
    ground = outline_json(box(-24.0, 1.0, 23.0, 24.0))
    connection.exec_driver_sql("UPDATE lot SET outline = ? WHERE id = ?", (ground, lot))
    return lot


@pytest.fixture
def ann(tmp_path: Path) -> Iterator[Person]:
    store = Database(tmp_path / "lots.db", FAST)
    with store.writing() as connection:
        person = Person(store, make_lot(connection))
    person.open()
    person.do("draw_section", name="Elm Street", **KERB)
    yield person
    store.close()


def sections(person: Person, current: OccupancyMap, datum: tuple[float, float] = HERE) -> tuple[FlownSection, ...]:
    with person.store.reading() as connection:
        return flown_sections(connection, person.lot, datum, current)


def test_the_count_in_flight_is_that_of_the_stored_survey(ann: Person) -> None:
    (live,) = sections(ann, flown())
    with ann.store.writing() as connection:
        assert save(connection, finished(landed(flown()))).lot == ann.lot
    with ann.store.reading() as connection:
        (stored,) = section_lists.sections_with_looks(connection, ann.lot)
    assert (live.id, live.name, live.capacity) == (stored.id, "Elm Street", stored.capacity)
    assert live.count is not None
    assert stored.look is not None
    assert live.count.parked == 2
    for name in ("parked", "least", "most", "room", "seen_share", "hidden_share"):
        assert getattr(live.count, name) == getattr(stored.look, name), name


def test_ground_that_is_not_seen_yet_widens_the_interval_and_then_there_is_no_count(ann: Person) -> None:
    (whole,), (half,), (none,) = (sections(ann, flown(seen_columns=columns)) for columns in (256, 130, 10))
    assert whole.count is not None
    assert half.count is not None
    assert whole.count.seen_share == 1.0
    assert half.count.seen_share == pytest.approx(0.5, abs=0.03)
    assert half.count.most > whole.count.most
    assert half.count.room is None
    assert none.count is None


def test_without_a_map_the_sections_are_there_and_not_counted(ann: Person) -> None:
    (section,) = sections(ann, OccupancyMap())
    assert (section.name, section.count) == ("Elm Street", None)


def test_the_section_lies_where_the_receiver_places_the_lot(ann: Person) -> None:
    ((latitude, longitude),) = to_global(DATUM, np.array([[30.0, -7.0]])).tolist()
    (before,), (after,) = sections(ann, flown()), sections(ann, OccupancyMap(), (latitude, longitude))
    moved = np.array(after.outline) - np.array(before.outline)
    assert moved == pytest.approx(np.tile([-30.0, 7.0], (len(moved), 1)), abs=0.02)


def test_a_lot_with_stalls_has_its_sections_where_the_flight_found_its_stalls(tmp_path: Path) -> None:
    person = Person.at_work(tmp_path / "lots.db", stalls=10)
    person.do("draw_section", name="Elm Street", **KERB)
    drift = Move(1.5, -2.0, math.radians(2.0))
    with person.store.reading() as connection:
        plan = all_stalls(connection, person.lot)
    places = drift.back(np.array([(each.north, each.east) for each in plan])).tolist()
    found = {
        number: Stall(number, north, east, 0.0, 2.5, 5.0, 0.1, StallState.FREE, 0.9, 3, 90.0, 1, known=each.id)
        for number, (each, (north, east)) in enumerate(zip(plan, places, strict=True), 1)
    }
    current = replace(flown(()), stalls=found)
    (placed,) = sections(person, current)
    still = {number: replace(found[number], north=each.north, east=each.east) for number, each in enumerate(plan, 1)}
    (at_lot,) = sections(person, replace(current, stalls=still))
    assert np.array(placed.outline) == pytest.approx(drift.back(np.array(at_lot.outline)), abs=0.03)
    assert sections(person, replace(current, stalls={1: found[1]})) == ()  # one stall fixes no turn
    person.store.close()


def test_a_section_whose_ring_is_damaged_is_passed_over(ann: Person) -> None:
    with ann.store.writing() as connection:
        connection.exec_driver_sql("UPDATE section SET outline = '[[0,0],[9,9],[0,9],[9,0]]'")
    assert sections(ann, flown()) == ()


def test_taken_stalls_are_counted_where_no_network_knows_vehicles(ann: Person) -> None:
    taken = Stall(1, -13.2, 8.0, math.pi / 2, 2.5, 5.0, 0.9, StallState.TAKEN, 0.95, 12, 40.0, 3)
    (section,) = sections(ann, replace(flown(()), vehicles=None, stalls={1: taken, 2: replace(taken, id=2, seen=0)}))
    assert section.count is not None
    assert section.count.parked == 1


def test_a_lot_of_sections_alone_can_be_surveyed_again(ann: Person) -> None:
    with ann.store.reading() as connection:
        (ahead,) = lots_ahead(connection, HERE)
        known = known_lot(connection, ann.lot, HERE)
    assert (ahead.stalls, ahead.sections, ahead.has_plan) == (0, 1, True)
    assert (known.stalls, len(known.section_places) > 0) == ((), True)


def test_tiles_far_from_a_section_are_not_unpacked(ann: Person) -> None:
    broken = {**flown().tiles, (40, 40): EncodedTile(1, b"not zlib")}
    (section,) = sections(ann, replace(flown(), tiles=broken))
    assert section.count is not None
