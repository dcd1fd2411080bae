"""Sections of a plan: drawn, changed and removed within an edit, and through merges, splits and pins of lots."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from hawk.lots import commands, queries
from hawk.lots.plan.geometry import ShapeError
from hawk.lots.plan.sections import axis_of, capacity_of, strip
from hawk.lots.values import LotInputError
from hawk.results.survey_map import to_global
from tests.unit.lots.plan.plans import NOW, Person, drawn_lot
from tests.unit.lots.surveys import DATUM

KERB: dict[str, Any] = {"line": [[20.0, 0.0], [20.0, 56.0]], "side": "right", "width": 2.2, "kind": "parallel"}
STRIPS = Path(__file__).parents[4] / "hawk" / "web" / "page" / "test" / "strips.json"
SQUARE = [[30.0, 0.0], [30.0, 20.0], [40.0, 20.0], [40.0, 0.0]]


@pytest.fixture
def ann(tmp_path: Path) -> Iterator[Person]:
    person = Person.at_work(tmp_path / "lots.db")
    yield person
    person.store.close()


def drawn(person: Person, name: str = "Elm Street", **more: Any) -> dict[str, Any]:
    done = person.do("draw_section", name=name, **{**KERB, **more})
    return next(each for each in done["sections"] if each["name"] == name)


def test_a_strip_lies_on_the_side_of_its_line_and_has_the_places_of_its_length(ann: Person) -> None:
    """One goes east along the line: its right side is south of it."""
    found = drawn(ann)
    corners = np.array(found["outline"])
    assert corners.min(axis=0).tolist() == pytest.approx([17.8, 0.0])
    assert corners.max(axis=0).tolist() == pytest.approx([20.0, 56.0])
    assert (found["length_m"], found["capacity"], found["is_capacity_given"], found["note"]) == (56.0, 10, False, "")
    left = drawn(ann, "Elm Street north", side="left", kind="across")
    assert (min(north for north, _ in left["outline"]), left["capacity"]) == (20.0, 22)
    assert drawn(ann, "Long cars", place_m=7.0, width=3.0)["capacity"] == 8


def test_what_lies_a_kilometre_off_the_lot_is_refused_with_the_distance_and_what_goes_on_from_it_is_not(
    ann: Person,
) -> None:
    drawn(ann)
    before = ann.plan()
    far = [[2000.0, 0.0], [2000.0, 56.0]]
    area = [[1997.8, 0.0], [1997.8, 56.0], [2027.8, 0.0]]
    stall = {"north": 1997.8, "east": 30.0, "angle": 0.0, "width": 2.0, "length": 5.0}
    asked: tuple[tuple[str, str, str, dict[str, Any]], ...] = (
        ("draw_section", "Far", "line", {"name": "Far", **KERB, "line": far}),
        ("draw_section", "Far", "outline", {"name": "Far", "outline": area}),
        ("add_stall", "the new stall", "north", stall),
    )
    for do, name, field, values in asked:
        with pytest.raises(LotInputError) as refused:
            ann.do(do, **values)
        assert refused.value.field == field
        assert f"{name} would be 1978 m off the rest of the lot: 1000 m is the most. Draw it" in str(refused.value)
    assert ann.plan() == before
    for number, north in enumerate((900.0, 1800.0, 2500.0)):
        drawn(ann, f"Street {number}", line=[[north, 0.0], [north, 56.0]])
    drawn(ann, "Far", line=far)


def test_the_first_part_of_an_empty_lot_says_where_the_lot_is(ann: Person) -> None:
    ann.do("remove", all=True)
    drawn(ann, "First", line=[[1500.0, 0.0], [1500.0, 56.0]])
    with pytest.raises(LotInputError, match="Second would be 1498 m off the rest of the lot: 1000 m is the most"):
        drawn(ann, "Second", line=[[0.0, 0.0], [0.0, 56.0]])


def test_an_area_has_no_capacity_until_a_person_gives_one(ann: Person) -> None:
    done = ann.do("draw_section", name="Yard", outline=SQUARE, note=" permit  K2 ")
    (yard,) = done["sections"]
    assert (yard["length_m"], yard["capacity"], yard["is_capacity_given"], yard["note"]) == (
        20,
        None,
        False,
        "permit K2",
    )
    (given_one,) = ann.do("change_section", section=yard["id"], capacity=12)["sections"]
    assert (given_one["id"], given_one["capacity"], given_one["is_capacity_given"]) == (yard["id"], 12, True)
    (kept,) = ann.do("change_section", section=yard["id"], kind="across", name="Yard 2")["sections"]
    assert (kept["name"], kept["capacity"], kept["note"]) == ("Yard 2", 12, "permit K2")
    (proposed,) = ann.do("change_section", section=yard["id"], capacity=None)["sections"]
    assert (proposed["capacity"], proposed["is_capacity_given"]) == (8, False)


def test_two_sections_of_a_plan_have_no_name_in_common(ann: Person) -> None:
    drawn(ann)
    other = drawn(ann, "Oak Street")
    with pytest.raises(LotInputError, match="name: Elm Street is another section's"):
        drawn(ann)
    with pytest.raises(LotInputError, match="name: Elm Street is another section's"):
        ann.do("change_section", section=other["id"], name="Elm Street")


def test_each_layout_has_its_own_sections_and_a_changed_one_keeps_its_id(ann: Person) -> None:
    first = drawn(ann)
    ann.close()
    ann.open()
    (second,) = ann.do("change_section", section=first["id"], capacity=7)["sections"]
    closed = ann.close()
    ann.open()
    ann.do("remove_section", section=first["id"])
    assert ann.plan()["sections"] == []
    assert ann.plan(layout=2)["sections"] == [first]
    assert ann.plan(layout=3)["sections"] == [second]
    ann.undo()
    ann.close()
    ann.undo_change(closed["seq"])
    assert ann.plan()["sections"] == [first]


def test_who_follows_a_plan_reads_its_sections_with_each_change(ann: Person) -> None:
    before = ann.plan()["revision"]
    first = drawn(ann)
    since = ann.plan(since=before)
    assert (since["whole"], since["stalls"], since["sections"]) == (False, [], [first])


@pytest.mark.slow
def test_a_merge_brings_sections_and_a_split_and_a_pin_take_them_along(ann: Person) -> None:
    drawn(ann)
    ann.close()
    with ann.store.writing() as connection:
        other = drawn_lot(connection, 10)
        connection.exec_driver_sql(
            "UPDATE lot SET longitude = 5.002, outline = ? WHERE id = ?", (_ground(130, 0), other)
        )
        connection.exec_driver_sql("UPDATE lot SET outline = ? WHERE id = ?", (_ground(0, 0), ann.lot))
    bob = Person(ann.store, other)
    bob.open()
    theirs = drawn(bob)
    bob.close()
    with ann.store.writing() as connection:
        merged = commands.merge(connection, ann.lot, other, "Ann", NOW)
    mine, brought = ann.plan()["sections"]
    assert (mine["name"], brought["name"], brought["id"]) == ("Elm Street", "Elm Street 2", theirs["id"])
    off = np.array(brought["outline"]) - np.array(theirs["outline"])
    assert off.mean(axis=0).tolist() == pytest.approx([0.0, 137.2], abs=0.2)
    with ann.store.writing() as connection:
        part = to_global(DATUM, np.array([[-5, 130], [60, 130], [60, 260], [-5, 260.0]])).tolist()
        split = commands.split(connection, ann.lot, {"name": "East", "outline": part}, "Ann", NOW)
    assert [each["id"] for each in ann.plan()["sections"]] == [mine["id"]]
    ann.undo_change(split.seq)
    ann.undo_change(merged.seq)
    assert [each["name"] for each in ann.plan()["sections"]] == ["Elm Street"]
    with ann.store.reading() as connection:
        assert [each.name for each in queries.plan(connection, other).sections] == ["Elm Street"]
    _pin(ann, mine["outline"])


def _ground(east: float, north: float) -> str:
    ring = to_global(DATUM, np.array([[north - 30, east - 5], [north + 60, east - 5], [north + 60, east + 60.0]]))
    return f'{{"polygons":[{[[float(a), float(b)] for a, b in ring]}],"holes":[]}}'


def _pin(person: Person, before: list[list[float]]) -> None:
    """Pin the lot by two points 100 m apart, the one 5 m off across: it turns, and its sections with it."""
    here = to_global(DATUM, np.array([[0.0, 0.0], [0.0, 100.0]]))
    there = to_global(DATUM, np.array([[0.0, 0.0], [5.0, 99.87]]))
    points = [{"from": list(map(float, a)), "to": list(map(float, b))} for a, b in zip(here, there, strict=True)]
    with person.store.writing() as connection:
        commands.pin(connection, person.lot, {"points": points}, "Ann", NOW)
    turned = person.plan()["sections"][0]["outline"]
    (_, one), (_, other) = (_course(ring) for ring in (before, turned))
    assert math.degrees(other - one) == pytest.approx(-2.87, abs=0.05)


def _course(ring: list[list[float]]) -> tuple[float, float]:
    (a, b), (c, d) = axis_of([(north, east) for north, east in ring])
    return math.dist((a, b), (c, d)), math.atan2(d - b, c - a)


def test_a_section_whose_ring_is_damaged_is_shown_without_it_and_refuses_a_change(
    ann: Person, caplog: pytest.LogCaptureFixture
) -> None:
    first = drawn(ann)
    with ann.store.writing() as connection:
        connection.exec_driver_sql("UPDATE section SET outline = '[[1, 2'")
    assert ann.plan()["sections"][0]["outline"] == []
    assert "an outline in the store of lots is damaged" in caplog.text
    with pytest.raises(LotInputError, match="section: is damaged on the disk"):
        ann.do("change_section", section=first["id"], capacity=3)
    assert len(ann.do("remove", stalls=ann.ids("A 1"))["sections"]) == 1  # the rest of the plan is edited on


@pytest.mark.parametrize("each", json.loads(STRIPS.read_text("utf-8")))
def test_a_strip_is_the_one_that_the_page_draws(each: dict[str, Any]) -> None:
    """The page's test reads the same file."""
    ring = shapely.Polygon(strip(each["line"], each["width"], each["side"]))
    assert ring.symmetric_difference(shapely.Polygon(each["ring"])).area == pytest.approx(0.0, abs=1e-4)


@given(
    start=st.tuples(st.floats(-500, 500), st.floats(-500, 500)),
    course=st.floats(0, 2 * math.pi),
    length=st.floats(2, 300),
    bend=st.floats(-1.2, 1.2),
    width=st.floats(1.0, 8.0),
    side=st.sampled_from(["left", "right"]),
)
def test_a_strip_has_its_width_and_lies_on_its_side(
    start: tuple[float, float], course: float, length: float, bend: float, width: float, side: str
) -> None:
    def on(place: tuple[float, float], by: float) -> tuple[float, float]:
        return place[0] + length * math.cos(by), place[1] + length * math.sin(by)

    middle = on(start, course)
    line = [start, middle, on(middle, course + bend)]
    try:
        ring = strip(line, width, side)
    except ShapeError:
        assert length < 2 * width  # the bend has no room for it
        return
    area = shapely.Polygon(ring)
    assert area.is_valid
    off = width * length * 2
    inner = width**2 * math.tan(abs(bend) / 2)
    assert off - inner - 1e-3 <= area.area <= off + inner + 1e-3
    across = course + (math.pi / 2 if side == "right" else -math.pi / 2)
    near = start[0] + length / 2 * math.cos(course), start[1] + length / 2 * math.sin(course)
    inside = near[0] + width / 2 * math.cos(across), near[1] + width / 2 * math.sin(across)
    if length > 4 * width:
        assert area.contains(shapely.Point(inside))


@given(st.sampled_from(["parallel", "across"]), st.floats(0.1, 5000))
def test_a_proposed_capacity_is_what_the_length_holds(kind: Any, length: float) -> None:
    each = {"parallel": 5.5, "across": 2.5}[kind]
    found = capacity_of(kind, length)
    assert found is not None
    assert found == 1 or found * each <= length + 1e-3 < (found + 1) * each + 2e-3
    assert capacity_of("", length) is None
