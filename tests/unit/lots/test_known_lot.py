"""The lot that a drone stands at: the nearest one within reach, to the metre, and who changed its plan last."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from sqlalchemy import insert, update

from hawk.exports.lot_places import lot_places
from hawk.lots import commands, lists
from hawk.lots.documents.source import lots_due
from hawk.lots.ingest import save
from hawk.lots.known_lot import NEAR_M, PLACE_M, known_lot, last_author, lots_ahead, lots_flown, newest_survey
from hawk.lots.plan.queries import sections_of
from hawk.lots.storage.database import Database
from hawk.lots.storage.outlines import outline_json
from hawk.lots.storage.schema import LAYOUT, LOT
from hawk.model.known_lot import AGAIN_M, KnownStall
from hawk.results.survey_map import to_global
from tests.unit.lots.plan.plans import FAST, NOW, Person
from tests.unit.lots.surveys import DATUM, box, later, survey


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Database:
    """Return a store of two lots, 20 m by 20 m, the second one 100 m north of the first, and one without ground."""
    made = Database(tmp_path_factory.mktemp("store") / "lots.db", FAST)
    with made.writing() as connection:
        for name, outline in (("A", box(0, 0, 20, 20)), ("B", box(120, 0, 20, 20)), ("C", None)):
            ground = '{"polygons": [], "holes": []}' if outline is None else outline_json(outline)
            place = {"latitude": DATUM.latitude, "longitude": DATUM.longitude, "datum_is_pinned": True}
            connection.execute(insert(LOT).values(id=name * 4, name=name, outline=ground, made=ord(name), **place))
            connection.execute(insert(LAYOUT).values(lot=name * 4, version=ord(name), valid_from=0.0, why="", who=""))
    return made


def at(north: float, east: float = 10.0) -> tuple[float, float]:
    ((latitude, longitude),) = to_global(DATUM, np.array([(north, east)])).tolist()
    return latitude, longitude


@pytest.mark.parametrize(
    ("north", "again", "name"),
    [
        (10.0, "", "A"),
        (-NEAR_M + 0.5, "", "A"),
        (-NEAR_M - 0.5, "", None),
        (69.5, "", "A"),
        (70.5, "", "B"),
        (200.5, "", None),
        (199.5, "", "B"),
        (130.0, "AAAA", "A"),
        (900.0, "BBBB", "B"),
        (10.0, "none", "A"),
    ],
)
def test_the_nearest_lot_within_reach_is_the_one(store: Database, north: float, again: str, name: str | None) -> None:
    with store.reading() as connection:
        found = lots_flown(connection, at(north), [again] if again else [])
    assert found == ([] if name is None else [((name * 4, ord(name), 0), name)])


def test_reach_is_the_same_to_all_sides(store: Database) -> None:
    with store.reading() as connection:
        found = [bool(lots_flown(connection, at(10.0, east))) for east in (-60.5, -59.5, 79.5, 80.5)]
    assert found == [False, True, True, False]


def test_lots_ahead_have_their_distance_and_near_by_their_outline(store: Database) -> None:
    with store.reading() as connection:
        for north, aways in ((10.0, (0.0, 110.0)), (-AGAIN_M + 0.5, (299.5, 419.5)), (-AGAIN_M - 0.5, (300.5, 420.5))):
            found = lots_ahead(connection, at(north))
            assert [each.name for each in found] == ["A", "B"]
            assert [each.away_m for each in found] == pytest.approx(aways, abs=0.05)
            assert [bool(each.outline.polygons) for each in found] == [away <= AGAIN_M for away in aways]


def test_a_name_that_two_lots_have_makes_neither_due(store: Database) -> None:
    asked: list[str] = []

    def due(lot: str, name: str, *_: object) -> Any:
        asked.append(name)

    lots = [("AAAA", "same"), ("BBBB", "B"), ("CCCC", "same")]
    with store.writing() as connection:
        for lot, name in lots:
            connection.execute(update(LOT).where(LOT.c.id == lot).values(name=name))
        for read in (
            lambda: lists.lots(connection, lists.Asked(), due),
            lambda: lot_places(connection, due),
            lambda: lots_ahead(connection, None, due),
            lambda: lots_due(connection, due, None),
        ):
            asked.clear()
            read()
            assert {*asked} == {"", "B"}
        assert newest_survey(connection, "same") is None
        for lot, _ in lots:
            connection.execute(update(LOT).where(LOT.c.id == lot).values(name=lot[0]))


def test_the_newest_survey_of_a_lot_by_its_id_or_name(tmp_path: Path) -> None:
    store = Database(tmp_path / "lots.db", FAST)
    with store.writing() as connection:
        saved = save(connection, survey(stalls=6))
        last = later(survey(stalls=6), 2)
        save(connection, last)
        assert saved.lot is not None
        commands.rename(connection, saved.lot, "North", "operator", NOW)
        assert (
            newest_survey(connection, "North")
            == newest_survey(connection, saved.lot)
            == (saved.lot, "North", last.ended)
        )
        assert newest_survey(connection, "South") is None
        unsure = replace(later(survey(stalls=6), 3), began=0.0, ended=40.0, time_is_sure=False)
        save(connection, unsure)
        assert newest_survey(connection, "North") == (saved.lot, "North", last.ended), (
            "a clock that is wrong says nothing"
        )


def test_the_last_author_is_named_until_another_change_is_made(tmp_path: Path) -> None:
    ann = Person.at_work(tmp_path / "lots.db", 3)
    with ann.store.reading() as connection:
        assert last_author(connection, ann.lot) == "Ann"
    ann.do("confirm", all=True)
    ann.close()
    with ann.store.writing() as connection:
        assert last_author(connection, ann.lot) == "Ann"
        commands.rename(connection, ann.lot, "North", "operator", NOW - 1)
        assert last_author(connection, ann.lot) == "Ann"
        commands.rename(connection, ann.lot, "South", "operator", NOW + 1)
        assert last_author(connection, ann.lot) == ""
    ann.store.close()


def test_a_plan_is_given_in_the_frame_of_the_flight(tmp_path: Path) -> None:
    ann = Person.at_work(tmp_path / "lots.db", 3)
    ann.do("confirm", stalls=ann.ids("A 2"))
    with ann.store.reading() as connection:
        known = known_lot(connection, ann.lot, at(-10.0, 4.0))
    found = {stall.label: (round(stall.north, 2), round(stall.east, 2), stall.is_confirmed) for stall in known.stalls}
    assert found == {"A 1": (10.0, -4.0, False), "A 2": (10.0, -1.5, True), "A 3": (10.0, 1.0, False)}
    assert [(stall.width, stall.length) for stall in known.stalls] == [(2.5, 5.0)] * 3
    ann.store.close()


@pytest.mark.parametrize(
    "line", [[[-12.0, 2.0], [-12.0, 24.0]], [[-12.0, 2.0], [-12.0, 14.0], [-24.0, 20.0]]], ids=["straight", "bent"]
)
def test_the_places_of_a_section_cover_it_and_none_is_larger_than_a_stall(
    tmp_path: Path, line: list[list[float]]
) -> None:
    ann = Person.at_work(tmp_path / "lots.db", 3)
    ann.do("draw_section", name="Elm", line=line, side="right", width=2.5, kind="parallel")
    with ann.store.reading() as connection:
        here, moved = (known_lot(connection, ann.lot, at(*place)) for place in ((0.0, 0.0), (-10.0, 4.0)))
        (section,) = sections_of(connection, ann.lot)
    ann.store.close()
    covered = shapely.union_all([quad_of(place) for place in here.section_places])
    assert covered.buffer(0.01).covers(shapely.Polygon(section.outline))
    assert all(0.0 < place.width <= PLACE_M >= place.length > 0.0 for place in here.section_places)
    assert all(place.id.startswith(section.id) for place in here.section_places)
    off = [(b.north - a.north, b.east - a.east) for a, b in zip(here.section_places, moved.section_places, strict=True)]
    assert np.allclose(off, (10.0, -4.0), atol=0.02)


def quad_of(place: KnownStall) -> shapely.Polygon:
    c, s = math.cos(place.angle), math.sin(place.angle)
    sides = [(a * place.length / 2, b * place.width / 2) for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
    return shapely.Polygon([(place.north + a * c - b * s, place.east + a * s + b * c) for a, b in sides])
