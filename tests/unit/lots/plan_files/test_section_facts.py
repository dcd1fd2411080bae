"""Sections by the properties of features: the owners' own, hawk's, and OpenStreetMap's."""

from __future__ import annotations

import numpy as np
import pytest

from hawk.lots.plan_files.section_facts import DRIVEN_M, SLANTED_M, Roads, area_facts, is_area, is_line, line_facts
from hawk.lots.plan_files.values import Facts, Notes, SectionFacts, Strip


def area(**facts: object) -> tuple[SectionFacts | None, list[str]]:
    notes = Notes()
    return area_facts(facts, "features[4]", notes), [each.reason for each in notes.left_out]


def line(facts: Facts) -> tuple[list[SectionFacts], list[str]]:
    notes = Notes()
    return line_facts(facts, "road 7", notes, Roads()), [f"{each.name}: {each.reason}" for each in notes.left_out]


@pytest.mark.parametrize(
    ("facts", "layer", "is_section"),
    [
        ({"amenity": "parking"}, "", True),
        ({"amenity": "parking_space", "capacity": 12}, "", False),
        ({"Capacity": 12}, "", True),
        ({"places": "12"}, "", True),
        ({"capacity": 1}, "", False),  # a stall that says so
        ({"capacity": "many"}, "", False),
        ({"kind": "parallel"}, "", True),
        ({"kind": "disabled"}, "", False),
        ({"ref": "12"}, "Sections", True),
        ({"capacity_given": False}, "", True),
        ({"section_id": "e"}, "", True),
        ({}, "", False),
    ],
)
def test_a_polygon_is_a_section_where_its_properties_say_so(facts: Facts, layer: str, is_section: bool) -> None:
    assert is_area(facts, layer) is is_section


def test_a_line_is_one_of_a_section_by_its_side_or_its_road() -> None:
    assert is_line({"SIDE": "left"})
    assert is_line({"parking:both": "lane"})
    assert is_line({"parking:lane:left": "parallel"})
    assert not is_line({"highway": "residential", "parking:condition:left": "free"})


def test_the_names_of_properties_are_read_in_any_case() -> None:
    found, notes = area(NAME="Kerb  1", Places=12.0, Metres="66 m", KIND="Perpendicular", Note="permit K2")
    assert found == SectionFacts("Kerb 1", "", "across", 12, True, 66.0, None, "permit K2")
    assert notes == []


@pytest.mark.parametrize(
    ("facts", "words"),
    [
        ({"capacity": "a lot"}, "capacity: a lot is no number of places: write a whole number, 1 to 10000"),
        ({"capacity": 0}, "capacity: 0 is no number of places"),
        ({"capacity": 2.5}, "capacity: 2.5 is no number of places"),
        ({"metres": "-3"}, "metres: -3 cannot be: write metres, 0 to 20000"),
        ({"name": "x" * 81}, "name: has 81 characters, 80 are the most: shorten it"),
        ({"name": "a\u0000b"}, "name: holds characters that cannot be shown"),
        ({"note": "x" * 201}, "note: has 201 characters, 200 are the most"),
    ],
)
def test_a_property_that_cannot_be_used_is_named_with_its_remedy_and_the_section_kept(facts: Facts, words: str) -> None:
    found, (reason,) = area(amenity="parking", **facts)
    assert words in reason
    assert found is not None
    assert (found.capacity, found.metres) == (None, None)


def test_a_kind_that_no_section_has_is_a_word_about_it() -> None:
    """Permit, loading, disabled: nothing of it is lost."""
    found, notes = area(amenity="parking", kind="loading", access="private", **{"capacity:disabled": "2"})
    assert found is not None
    assert (found.kind, found.note, found.is_lot, notes) == (None, "loading, access private, disabled 2", True, [])


def test_a_car_park_below_the_ground_is_left_out() -> None:
    found, notes = area(amenity="parking", parking="underground", capacity="300")
    assert found is None
    assert notes == ["parking: is underground, which is not seen from above: leave it out"]


def test_a_line_is_a_strip_of_its_side_and_width() -> None:
    (found,), notes = line({"name": "Elm", "side": "Left", "width": "2,2", "capacity": 8, "kind": "parallel"})
    assert (found.title, found.capacity, found.strip, notes) == ("Elm", 8, Strip("left", 2.2), [])
    (across,), _ = line({"side": "right", "kind": "across"})
    assert across.strip == Strip("right", 5.0)
    both, notes = line({"name": "Elm", "side": "both", "capacity": 8})
    assert [(each.title, each.capacity, each.strip) for each in both] == [
        ("Elm (left)", None, Strip("left", 2.5)), ("Elm (right)", None, Strip("right", 2.5)),
    ]  # fmt: skip
    assert notes == ["road 7: capacity: is of both sides together: draw a line for each side, with its own"]


@pytest.mark.parametrize(
    ("facts", "words"),
    [
        ({"capacity": 8}, "side: is missing: write left, right or both, as one goes along the line"),
        ({"side": "north"}, "side: is north: write left, right or both"),
    ],
)
def test_a_line_without_a_side_is_left_out_with_the_remedy(facts: Facts, words: str) -> None:
    found, (note,) = line(facts)
    assert found == []
    assert note.startswith(f"road 7: {words}")


ROAD = {"highway": "residential", "name": "Elm Street", "width": "9"}


@pytest.mark.parametrize(
    ("tags", "kind", "near", "width"),
    [
        ({"parking:left": "lane", "parking:left:orientation": "parallel"}, "parallel", 2.0, 2.5),
        ({"parking:both": "no", "parking:left": "lane", "parking:left:width": "2"}, None, 2.5, 2.0),
        ({"parking:left": "street_side", "parking:left:orientation": "perpendicular"}, "across", 4.5, 5.0),
        ({"parking:left": "half_on_kerb", "parking:both:orientation": "parallel"}, "parallel", 3.25, 2.5),
        ({"parking:left": "on_kerb", "width": ""}, None, DRIVEN_M[0] / 2, 2.5),
        ({"parking:left": "lane", "width": "", "oneway": "yes"}, None, DRIVEN_M[1] / 2, 2.5),
        ({"parking:lane:left": "perpendicular", "parking:lane:right": "no_stopping"}, "across", 0.0, 5.0),
        ({"parking:lane:left": "parallel", "parking:lane:left:parallel": "on_kerb"}, "parallel", 4.5, 2.5),
    ],
)
def test_a_road_has_its_vehicles_at_its_kerb(tags: Facts, kind: str | None, near: float, width: float) -> None:
    (found,), _ = line({**ROAD, **tags})
    assert found.title == "Elm Street (left)"
    assert found.kind == kind
    assert found.strip is not None
    assert found.strip.side == "left"
    assert (found.strip.near, found.strip.width) == pytest.approx((near, width))


def test_the_sides_of_a_road_have_what_the_map_says_of_each() -> None:
    (left, right), notes = line(
        ROAD
        | {"parking:both": "lane", "parking:both:orientation": "parallel", "parking:left:orientation": "diagonal"}
        | {"parking:right:capacity": "7", "parking:right:restriction": "loading_only", "parking:right:access": "permit"}
    )
    assert (left.kind, left.place_m, left.capacity, left.note) == ("across", SLANTED_M, None, None)
    assert (right.title, right.kind, right.capacity) == ("Elm Street (right)", "parallel", 7)
    assert right.note == "restriction loading_only, access permit"
    assert notes == []


@pytest.mark.parametrize(
    ("tags", "words"),
    [
        ({"parking:left": "somewhere"}, "parking:left: somewhere is not known: write one of lane, yes"),
        ({"parking:left": "lane", "parking:left:restriction": "no_parking"}, "parking:left:restriction: is no_parking"),
        ({"parking:lane:left": "no_stopping"}, "parking:left:restriction: is no_stopping"),
        ({"parking:left": "lane", "parking:left:capacity": "x"}, "capacity: x is no number of places"),
        ({"parking:left": "lane", "parking:left:width": "200"}, "width: 200 cannot be: write metres, 1 to 40"),
    ],
)
def test_a_side_that_cannot_be_read_is_named(tags: Facts, words: str) -> None:
    _, notes = line({**ROAD, **tags})
    assert words in notes[0]
    assert notes[0].startswith("road 7")


@pytest.mark.parametrize("value", ["no", "separate"])
def test_a_side_without_places_of_its_own_is_no_section(value: str) -> None:
    assert line({**ROAD, "parking:both": value}) == ([], [])


def test_the_parts_of_a_street_have_names_of_their_own() -> None:
    roads, notes = Roads(), Notes()
    titles = [
        each.title
        for _ in range(2)
        for each in line_facts({"name": "Elm", "parking:both": "lane"}, "road 1", notes, roads)
    ]
    assert titles == ["Elm (left)", "Elm (right)", "Elm (left) 2", "Elm (right) 2"]
    assert roads.without_width == 4


def test_values_of_other_types_are_no_properties() -> None:
    found, notes = area(amenity="parking", capacity=[12], name={"en": "x"}, metres=np.nan)
    assert found == SectionFacts(is_lot=True)
    assert notes == []
