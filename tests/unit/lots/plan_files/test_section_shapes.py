"""Sections of drawn files as rings in metres, in one file with stalls or alone."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Polygon

from hawk.lots.plan.sections import strip
from hawk.lots.plan_files.child import packed, unpacked
from hawk.lots.plan_files.values import FileSection, PlanFile
from hawk.lots.registration.frames import frame_of
from hawk.lots.values import LotInputError
from tests.examples import examples
from tests.unit.lots.plan_files.files import (
    Json,
    degrees,
    feature,
    geojson,
    geopackage,
    left_out,
    numbered,
    osm,
    outline,
    plan,
    row,
)

KERB = [(10.0, 0.0), (10.0, 44.0)]
YARD = [(20.0, 0.0), (20.0, 20.0), (40.0, 20.0), (40.0, 0.0), (20.0, 0.0)]
PARKING = {"amenity": "parking"}


def kerb(**facts: object) -> Json:
    return feature(degrees(KERB), "LineString", **{"name": "Elm", "side": "right", **facts})


def ground(found: PlanFile, section: FileSection) -> Polygon:
    """Return a section's ground about the datum of the drawing."""
    assert found.datum is not None
    return Polygon(frame_of((52.0, 5.0), found.datum).of(np.array(section.ring)))


def road(number: int, line: list[tuple[float, float]], **tags: str) -> str:
    """Return the nodes of a line (north, east) and the element that joins them."""
    closed = outline(number, [*line, line[0]], **tags)
    return closed.replace(f'<nd ref="{number * 10}"/>', "", 1).replace(
        f'<nd ref="{number * 10}"/>', "", 1
    ).replace(f'<way id="{number}">', f'<way id="{number}"><nd ref="{number * 10}"/>')  # fmt: skip


def test_a_line_becomes_the_strip_that_the_page_draws() -> None:
    found = plan(geojson([kerb(width=2.0, kind="parallel", capacity=8)]))
    (section,) = found.sections
    assert section.length_m == pytest.approx(44.0, abs=0.01)
    assert section.facts.capacity == 8
    drawn = shapely.Polygon(strip(KERB, 2.0, "right"))
    assert ground(found, section).symmetric_difference(drawn).area < 0.1
    assert found.stalls == ()


def test_stalls_and_sections_come_in_one_file() -> None:
    yard = feature([degrees(YARD)], name="Yard", capacity=30)
    found = plan(geojson([*numbered(3), yard, kerb(metres=40)]))
    assert len(found.stalls) == 3
    assert [(each.name, each.facts.title, each.length_m) for each in found.sections] == [
        ("features[3]", "Yard", pytest.approx(20.0, abs=0.01)), ("features[4]", "Elm", 40.0),
    ]  # fmt: skip
    assert found.left_out_count == 0
    assert unpacked(packed(found)) == found


def test_a_car_park_with_stalls_is_no_section_and_one_without_is() -> None:
    around = [(-10.0, -5.0), (-10.0, 20.0), (10.0, 20.0), (10.0, -5.0), (-10.0, -5.0)]
    found = plan(
        osm(
            *(outline(k, ring, amenity="parking_space") for k, ring in enumerate(row(3), 1)),
            outline(8, around, **PARKING, name="Hall"),
            outline(9, YARD, **PARKING, name="Yard", capacity="30", access="customers"),
        )
    )
    assert len(found.stalls) == 3
    (yard,) = found.sections
    assert (yard.name, yard.facts.title, yard.facts.capacity, yard.facts.note) == (
        "way 9", "Yard", 30, "access customers",
    )  # fmt: skip
    assert left_out(found) == ["way 8: amenity: is a car park with stalls in this file, which are counted instead"]


def test_a_road_of_openstreetmap_has_a_strip_on_each_side() -> None:
    tags = {"highway": "residential", "name": "Elm", "width": "9", "parking__both": "lane"}
    found = plan(osm(road(7, KERB, **tags, parking__both__orientation="parallel")))
    left, right = found.sections
    assert [each.facts.title for each in found.sections] == ["Elm (left)", "Elm (right)"]
    for section, edge in ((left, 12.0), (right, 8.0)):  # the middle of the road is at 10 m, the parking 2 to 4.5 m off
        north, _ = ground(found, section).centroid.coords[0]
        assert north == pytest.approx(edge + (1.25 if section is left else -1.25), abs=0.02)
    assert left_out(found) == []


def test_roads_without_a_width_are_said_once() -> None:
    tags = {"highway": "residential", "parking__both": "lane"}
    found = plan(osm(road(7, KERB, **tags), road(8, [(90.0, 0.0), (90.0, 30.0)], **tags)))
    assert len(found.sections) == 4
    assert [each.split(",")[0] for each in found.assumed] == ["roads: width: is missing of 4 sides"]
    assert left_out(found) == []
    assert unpacked(packed(found)) == found


def test_the_lines_of_a_geopackage_are_read_where_they_have_a_side(tmp_path: Path) -> None:
    shape = LineString(degrees(KERB))
    data = geopackage(tmp_path, [(shape, "left"), (shape, "")], "LINESTRING", table="kerbs", column="side")
    found = plan(data)
    assert [each.name for each in found.sections] == ["kerbs, row 1"]
    assert left_out(found) == ["kerbs, row 2: side: is missing: write left, right or both, as one goes along the line"]
    assert found.layers == (("kerbs", 1),)
    with pytest.raises(LotInputError, match=r"has no layer of polygons, but rivers \(LINESTRING\)"):
        plan(geopackage(tmp_path, [(shape, "Rhine")], "LINESTRING", table="rivers", column="name"))


BOWTIE = [YARD[0], YARD[2], YARD[1], YARD[3], YARD[0]]


@pytest.mark.fault(
    "a file has sections that cannot be drawn", "each is left out by its number and field; the others are imported"
)
@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (feature([degrees(BOWTIE)], capacity=9), "outline: crosses or touches itself"),
        (feature([degrees([(0, 0), (0, 0.5), (0.5, 0), (0, 0)])], capacity=9), "outline: has 0.1"),
        (feature([degrees(KERB)], capacity=9), "geometry: has 2 corners: draw the outline of the section"),
        (feature(degrees([KERB[0], KERB[0]]), "LineString", side="left"), "geometry: has no length: draw the line"),
        (feature(degrees([(0, 0), (0, 9), (9, 9), (-9, 4)]), "LineString", side="left"), "line: crosses itself"),
        (feature(degrees(KERB)[:1], "LineString", side="left"), "geometry.coordinates: holds no line"),
        (feature([degrees(KERB)] * 2, "MultiLineString", side="left"), "geometry: is a MultiLineString of 2 parts"),
        (feature([[5.0, 52.0], [None, 52.1]], "LineString", side="left"), "geometry.coordinates[1]: must be"),
        (feature([degrees(YARD), degrees(YARD)], capacity=9), "has a hole"),
        (kerb(side=None), "side: is missing"),
        (feature([[[8.0, 52.0], [8.1, 52.0], [8.1, 52.1]]], capacity=9), "is more than 20 km from the others"),
        (feature(degrees([(k % 2, k / 9) for k in range(1100)]), "LineString", side="left"), "1000 are the most"),
        (feature([degrees(YARD)], section_id="e"), "id: e is there twice: the first one is read"),
    ],
)
def test_a_section_that_cannot_be_drawn_is_left_out_by_its_number(bad: Json, words: str) -> None:
    good = feature([degrees(YARD)], name="Yard", section_id="e")
    found = plan(geojson([*numbered(4), good, bad]))
    assert [each.facts.title for each in found.sections] == ["Yard"]
    assert left_out(found)[0].startswith("features[5]: ")
    assert words in left_out(found)[0]


def test_more_sections_than_a_survey_can_count_are_refused() -> None:
    with pytest.raises(LotInputError, match="file: has 2001 sections, 2000 are the most: import parts of it"):
        plan(geojson([kerb(side="right")] * 2001))


def test_a_road_that_bends_more_than_it_is_wide_is_left_out() -> None:
    bent = [(0.0, 0.0), (0.0, 30.0), (1.0, 30.0), (1.0, 0.5)]
    found = plan(osm(outline(1, row(1)[0], amenity="parking_space"), road(7, bent, parking__left="lane", width="9")))
    assert len(found.stalls) == 1
    assert "way 7: " in left_out(found)[0]


@settings(max_examples=examples(60), deadline=None)
@given(
    length=st.floats(5, 200), course=st.floats(0, 2 * math.pi), width=st.floats(1, 10),
    side=st.sampled_from(["left", "right"]),
)  # fmt: skip
def test_any_straight_kerb_has_the_area_of_its_length_and_width(
    length: float, course: float, width: float, side: str
) -> None:
    line = [(0.0, 0.0), (length * math.cos(course), length * math.sin(course))]
    data = geojson([feature(degrees(line), "LineString", side=side, width=width)])
    (section,) = plan(data).sections
    assert Polygon(section.ring).area == pytest.approx(length * width, rel=2e-3)
    assert section.length_m == pytest.approx(length, rel=2e-3)


numbers = st.one_of(st.floats(), st.integers(), st.none(), st.text(max_size=3), st.booleans())
facts = st.dictionaries(
    st.sampled_from(["side", "capacity", "width", "kind", "note", "name", "length", "parking:left", "section_id"]),
    numbers,
)


@settings(max_examples=examples(150), deadline=None)
@given(facts=facts, is_line=st.booleans())
def test_any_properties_are_read_left_out_or_refused(facts: Json, is_line: bool) -> None:
    """No other error comes of them."""
    bad = feature(degrees(KERB), "LineString", **facts) if is_line else feature([degrees(YARD)], **facts)
    found = plan(geojson([*numbered(1), json.loads(json.dumps(bad))]))
    assert unpacked(packed(found)) == found
