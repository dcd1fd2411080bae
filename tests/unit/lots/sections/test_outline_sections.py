"""Lots that a file gives an outline and a capacity, and that have no stall: each is a lot with a section."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.lots.ingest import save
from hawk.lots.sections.lists import sections_with_looks
from hawk.lots.sections.outline_sections import outline_sections
from hawk.lots.storage.database import Database
from hawk.lots.values import FinishedSurvey, Placed, VehicleDetection
from hawk.model.plans import Outline
from hawk.model.vehicles import VehicleKind
from tests.unit.lots.plan.plans import FAST
from tests.unit.lots.surveys import BEGAN, box, later, survey

YARD = box(0.0, 0.0, 20.0, 30.0)


def yard(capacity: int | None = 24, outline: Outline = YARD, cars: int = 3) -> FinishedSurvey:
    found = tuple(
        VehicleDetection(n, VehicleKind.CAR, 5.0, 4.0 * n, math.pi / 2, 1.8, 4.5, 0.97, 5, 60.0, BEGAN + n)
        for n in range(1, cars + 1)
    )
    ground = box(-5.0, -5.0, 80.0, 90.0)
    return replace(
        survey(stalls=0), outline=outline, seen_ground=ground, vehicles=found, capacity=capacity, title="Yard"
    )


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Database]:
    made = Database(tmp_path / "lots.db", FAST)
    yield made
    made.close()


def test_an_outline_with_a_capacity_is_a_lot_whose_section_counts_its_vehicles(store: Database) -> None:
    with store.writing() as connection:
        first = save(connection, yard())
    assert (first.placed, first.lot_name) == (Placed.FIRST, "Yard")
    with store.writing() as connection:
        again = save(connection, replace(later(yard(cars=1), 2), title="Another"))
        save(connection, yard())  # the same pictures, mapped again
    assert again.lot == first.lot
    with store.reading() as connection:
        (section,) = sections_with_looks(connection, str(first.lot))
        counts = connection.exec_driver_sql("SELECT parked FROM section_look ORDER BY survey").scalars().all()
    assert (section.name, section.capacity, section.is_capacity_given, section.kind) == ("Yard", 24, True, "")
    assert section.look is not None
    assert (counts, section.look.parked, section.look.capacity, section.look.seen_share) == ([3, 1], 1, 24, 1.0)


def test_stalls_make_no_section_and_nothing_without_stalls_and_capacity_is_no_lot(store: Database) -> None:
    with store.writing() as connection:
        assert save(connection, yard(capacity=None)).placed is Placed.NOTHING
        with_stalls = save(connection, replace(later(survey(), 2), capacity=40))
    assert with_stalls.placed is Placed.FIRST
    with store.reading() as connection:
        assert sections_with_looks(connection, str(with_stalls.lot)) == []


def test_the_places_of_an_outline_in_parts_go_by_area_and_each_part_says_the_whole() -> None:
    parts = Outline((*box(0, 0, 10, 10).polygons, *box(0, 40, 10, 30).polygons))
    large, small = outline_sections(yard(40, parts), "Yard")
    assert [(each.name, each.capacity, each.note) for each in (large, small)] == [
        ("Yard 1", 30, "40 places in all"), ("Yard 2", 10, "40 places in all"),
    ]  # fmt: skip
    sliver = Outline((*parts.polygons, *box(60, 0, 1, 1).polygons))
    assert outline_sections(yard(4, sliver), "Yard")[-1].capacity is None


@given(st.integers(1, 3000), st.lists(st.floats(3.0, 60.0), min_size=1, max_size=5))
def test_no_place_is_lost_but_by_rounding(capacity: int, sides: list[float]) -> None:
    rings = [box(0.0, 100.0 * n, 5.0, side).polygons[0] for n, side in enumerate(sides)]
    found = outline_sections(yard(capacity, Outline(tuple(rings))), "Yard")
    assert len({each.name for each in found}) == len(sides)
    assert abs(sum(each.capacity or 0 for each in found) - capacity) <= len(sides) / 2
