"""Plans as GeoJSON: labels, kinds, systems of coordinates, and features that are no stalls."""

from __future__ import annotations

import json
import math

import numpy as np
import pyproj
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.lots.values import LotInputError
from hawk.model.lot_map import Stall, StallState
from hawk.results.stall_files import map_geojson
from hawk.results.survey_map import Made, SurveyMap
from tests.examples import examples
from tests.unit.lots.plan_files.files import (
    DATUM,
    degrees,
    feature,
    geojson,
    labels,
    left_out,
    numbered,
    plan,
    row,
)

A_ROW = row(3)


def test_outlines_are_stalls_with_the_owners_labels() -> None:
    found = plan(geojson(numbered(3)))
    assert labels(found) == ["P1", "P2", "P3"]
    assert found.datum == pytest.approx((52.0, 5.0), abs=1e-4)
    first, second = found.shapes()[:2]
    assert second[:2] - first[:2] == pytest.approx([0.0, 2.5], abs=1e-3)
    assert first[2] % math.pi == pytest.approx(0.0, abs=1e-3) or first[2] == pytest.approx(math.pi, abs=1e-3)
    assert first[3:] == pytest.approx([2.5, 5.0], abs=1e-3)


@pytest.mark.parametrize(
    ("properties", "label", "kind"),
    [
        ({"ref": 12}, "12", None),
        ({"ref": 12.0, "parking_space": "disabled"}, "12", "disabled"),
        ({"NR": "  A   7 "}, "A 7", None),
        ({"name": "Ü 1", "kind": "electric"}, "Ü 1", "charging"),
        ({"capacity:disabled": "yes"}, "", "disabled"),
        ({"capacity:disabled": "no", "parking_space": "normal"}, "", ""),
        ({"label": "<b>12</b>"}, "<b>12</b>", None),
        ({"label": None, "ref": "7"}, "7", None),
    ],
)
def test_labels_and_kinds_are_those_of_the_properties(
    properties: dict[str, object], label: str, kind: str | None
) -> None:
    (stall,) = plan(geojson([feature([degrees(A_ROW[0])], **properties)])).stalls
    assert (stall.label, stall.kind) == (label, kind)


def test_the_property_with_the_labels_is_named() -> None:
    (stall,) = plan(geojson(numbered(1, bay="North 9")), label="Bay").stalls
    assert stall.label == "North 9"


@pytest.mark.parametrize(
    ("properties", "words"),
    [
        ({"ref": "x" * 21}, "label: xxxxxxxxxxxxxxxxxxxx… has 21 characters, 20 are the most: shorten it"),
        ({"ref": "a\u0000b"}, "label: holds characters that cannot be shown"),
        ({"parking_space": "boat"}, "parking_space: boat is no kind: write one of disabled"),
    ],
)
def test_a_label_or_kind_that_cannot_be_used_is_named_and_the_stall_kept(
    properties: dict[str, object], words: str
) -> None:
    found = plan(geojson([feature([degrees(A_ROW[0])], **properties)]))
    assert labels(found) == [""]
    assert words in left_out(found)[0]


def nan_in(ring: list[list[float]]) -> list[list[float]]:
    return [[math.nan, 52.0], *ring[1:]]


CROSSED = [A_ROW[1][0], A_ROW[1][2], A_ROW[1][1], A_ROW[1][3], A_ROW[1][0]]


@pytest.mark.fault(
    "an imported plan has NaN, points, holes, or stalls that cross themselves or overlap",
    "each is left out by its number and field; the others are imported",
)
@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (feature([nan_in(degrees(A_ROW[1]))]), "geometry.coordinates[0][0]: must be [longitude, latitude]"),
        (feature([[["5", "52"]]]), "geometry.coordinates[0][0]: must be"),
        (feature([[5.0]]), "geometry.coordinates[0][0]: must be"),
        (feature([]), "holds no ring"),
        (feature([degrees(CROSSED)]), "crosses itself"),
        (feature([degrees(A_ROW[0])], label="twice"), "overlaps features[0] by 100%: 10% is the most"),
        (feature([degrees(A_ROW[1]), degrees(A_ROW[1])]), "has a hole"),
        (feature([5.0, 52.0], "Point", capacity=12), "is a Point: draw one outline"),
        (feature([[degrees(ring)] for ring in A_ROW[1:]], "MultiPolygon"), "is a MultiPolygon of 2 parts"),
        (feature([degrees(A_ROW[1])], amenity="bench"), "is bench, no parking_space"),
        (feature([degrees([(n * 20, e * 20) for n, e in A_ROW[1]])]), "a stall is 0.5 to 10 m wide"),
        (feature([degrees([(9, 0), (9, 5), (14, 0), (9, 0)])]), "fills 50% of the least rectangle about it"),
        ({"type": "Feature", "geometry": None}, "geometry: is missing"),
        ("no feature", "geometry: is missing"),
    ],
)
def test_a_feature_that_is_no_stall_is_left_out_by_its_number(bad: object, words: str) -> None:
    found = plan(geojson([*numbered(1), bad]))  # type: ignore[list-item]
    assert labels(found) == ["P1"]
    assert found.left_out_count == 1
    assert left_out(found)[0].startswith("features[1]: ")
    assert words in left_out(found)[0]


def test_a_file_without_any_stall_is_refused_with_its_first_feature() -> None:
    with pytest.raises(LotInputError, match=r"no section, 1 features are none\. The first, features\[0\]: .*Point"):
        plan(geojson([feature([5.0, 52.0], "Point")]))
    with pytest.raises(LotInputError, match="holds no stall and no section: draw each stall as a closed outline"):
        plan(geojson([]))


@pytest.mark.fault(
    "a file with a plan is cut, damaged or of another kind", "it is refused with the remedy, and nothing is written"
)
@pytest.mark.parametrize(
    ("data", "words"),
    [
        (geojson(numbered(2))[:-40], "is no whole JSON"),
        (b"[1, 2]", "is JSON, but no GeoJSON"),
        (b'{"type": "Topology"}', "is no GeoJSON of type FeatureCollection"),
        (b'{"elements": []}', r"ask for \[out:xml\]"),
        (b"[" * 100_000, "is no whole JSON"),
        (b'{"type": "\xff\xfe"}', "is no text in UTF-8"),
    ],
)
def test_what_is_no_geojson_is_refused_with_the_remedy(data: bytes, words: str) -> None:
    with pytest.raises(LotInputError, match=words):
        plan(data)


def projected(crs: str) -> list[object]:
    there = pyproj.Transformer.from_crs("EPSG:4326", crs, always_xy=True)
    rings = [[list(there.transform(corner[0], corner[1])) for corner in degrees(ring)] for ring in A_ROW]
    return [feature([ring], label=f"P{k}") for k, ring in enumerate(rings, 1)]


@pytest.mark.slow
@pytest.mark.fault("a GeoJSON is in a projected system of coordinates")
@pytest.mark.parametrize("crs", ["EPSG:32631", "EPSG:28992", "EPSG:3857"])
@pytest.mark.parametrize("is_in_file", [True, False])
def test_a_named_system_of_coordinates_is_read(crs: str, is_in_file: bool) -> None:
    urn = {"type": "name", "properties": {"name": crs.replace("EPSG:", "urn:ogc:def:crs:EPSG::")}}
    data = geojson(projected(crs), **({"crs": urn} if is_in_file else {}))  # type: ignore[arg-type]
    found = plan(data, **({} if is_in_file else {"crs": crs}))
    assert found.crs == crs
    assert found.datum == pytest.approx((52.0, 5.0), abs=1e-4)
    assert found.shapes()[:, 3:] == pytest.approx(np.tile([2.5, 5.0], (3, 1)), abs=0.01)


@pytest.mark.fault(
    "a GeoJSON is in a projected system of coordinates",
    "it is read where the system is named, else refused with the remedy",
)
def test_coordinates_that_are_no_degrees_are_refused_unless_their_system_is_named() -> None:
    with pytest.raises(LotInputError, match=r"crs: the coordinates are no degrees \(\d+, 5.*EPSG:25832"):
        plan(geojson(projected("EPSG:32631")))  # type: ignore[arg-type]


def test_latitude_before_longitude_is_called_exchanged() -> None:
    ring = [[49.25 + north * 1e-5, -122.95 + east * 1e-5] for east, north in ((0, 0), (3, 0), (3, 5), (0, 5), (0, 0))]
    with pytest.raises(LotInputError, match=r"crs: latitude and longitude are exchanged .*: write longitude first"):
        plan(geojson([feature([ring])]))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("crs", "words"),
    [
        ({"type": "name", "properties": {"name": "EPSG:99999"}}, "crs: EPSG:99999 is no system that is known"),
        ({"type": "name", "properties": {"name": "our own grid"}}, "crs: our own grid is no system"),
        ({"type": "link"}, "crs: of the file is not named"),
    ],
)
def test_a_system_that_is_not_known_is_refused_by_its_name(crs: object, words: str) -> None:
    with pytest.raises(LotInputError, match=words):
        plan(geojson(numbered(1), crs=crs))


def test_wgs_84_by_its_names_needs_no_projection(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pyproj", None)
    for name in ("urn:ogc:def:crs:OGC:1.3:CRS84", "EPSG:4326", "urn:ogc:def:crs:EPSG::4326"):
        assert labels(plan(geojson(numbered(1), crs={"properties": {"name": name}}))) == ["P1"]
    with pytest.raises(LotInputError, match=r'hawk-drone\[plans\]", or save'):
        plan(geojson(numbered(1)), crs="EPSG:25832")


@pytest.mark.slow
@settings(max_examples=examples(60), deadline=None)
@given(
    north=st.floats(-80, 80), east=st.floats(-80, 80), angle=st.floats(0, math.pi),
    width=st.floats(1.0, 4.0), extra=st.floats(0.5, 8.0), start=st.integers(0, 3), is_turned=st.booleans(),
)  # fmt: skip
def test_any_rectangle_comes_back_as_it_was_drawn(
    north: float, east: float, angle: float, width: float, extra: float, start: int, is_turned: bool
) -> None:
    """Whatever its first corner and the sense of its ring."""
    stall = Stall(1, north, east, angle, width, width + extra, 0.5, StallState.UNKNOWN, 1.0, 1, 0.0, 0)
    corners = [*map(tuple, stall.corners().tolist())]
    corners = corners[start:] + corners[:start]
    ring = [*corners, corners[0]][:: -1 if is_turned else 1]
    found = plan(geojson([feature([degrees(ring)])]))
    (shape,) = found.shapes()
    assert found.datum is not None
    assert shape[3:] == pytest.approx([width, width + extra], abs=2e-3)
    assert math.sin(shape[2] - angle) == pytest.approx(0.0, abs=2e-3)


numbers = st.one_of(st.floats(), st.integers(), st.none(), st.text(max_size=3))
geometries = st.recursive(numbers, lambda inner: st.lists(inner, max_size=5), max_leaves=30)


@pytest.mark.slow
@settings(max_examples=examples(200), deadline=None)
@given(kind=st.sampled_from(["Polygon", "MultiPolygon", "Point", "", None]), coordinates=geometries)
def test_any_geometry_is_read_left_out_or_refused(kind: str, coordinates: object) -> None:
    """No other error comes of it."""
    found = plan(geojson([*numbered(1), feature(coordinates, kind)]))
    assert len(found.stalls) + found.left_out_count == 2
    assert np.isfinite(found.shapes()).all()


def test_the_stalls_of_a_flight_come_back_with_their_labels() -> None:
    def stall(number: int, north: float, east: float) -> Stall:
        return Stall(number, north, east, 0.0, 2.5, 5.0, 0.1, StallState.FREE, 0.9, 3, 1.0, 1)

    flown = {k + 1: stall(k + 1, -9.0 * (k // 4), 2.5 * (k % 4)) for k in range(8)}
    text = map_geojson(SurveyMap(DATUM, flown, {}), Made())
    found = plan(text)
    assert labels(found) == [each["properties"]["ref"] for each in json.loads(text)["features"]]
    assert "A 1" in labels(found)
    assert found.left_out_count == 0


def test_the_json_of_a_lot_comes_back_with_its_labels_and_kinds() -> None:
    shape = {"north": 3.0, "east": 4.0, "angle": 0.5, "width": 2.4, "length": 5.1}
    stalls = [{"label": "B 12", "kind": "staff", **shape}, {"label": "B 13", "kind": "", **shape, "north": math.inf}]
    found = plan(json.dumps({"datum": [52.0, 5.0], "stalls": stalls, "sections": [{"name": "Elm Street"}, 7]}).encode())
    (stall,) = found.stalls
    assert (stall.label, stall.kind) == ("B 12", "staff")
    assert (stall.width, stall.length, stall.angle) == pytest.approx((2.4, 5.1, 0.5), abs=1e-3)
    assert left_out(found) == [
        "stalls[1]: north: must be a finite number",
        "sections[0]: outline: must be corners, [north, east], metres about the datum",
        "sections[1]: outline: must be corners, [north, east], metres about the datum",
    ]
