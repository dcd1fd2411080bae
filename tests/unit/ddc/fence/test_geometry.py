from __future__ import annotations

import itertools
import json
import math
from pathlib import Path

import pytest
import shapely
from hypothesis import example, given
from hypothesis import strategies as st

from hawk.ddc.fence.geojson import read_fence
from hawk.ddc.fence.geometry import (
    FenceError,
    check_fence_ring,
    circle,
    contains,
    extent,
    inside_point,
    last_inside,
    leads_inside,
    outside_by,
    path_is_inside,
    polygon_fence,
    ring_from_map,
    ring_to_map,
    sees_all,
    to_map,
)
from hawk.model.poses import GlobalPose, MapPoint

SQUARE = ((0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0))
FENCE = polygon_fence(SQUARE, 5, 100, 3)
L_SHAPE = polygon_fence(((0, 0), (100, 0), (100, 40), (40, 40), (40, 100), (0, 100)), 5, 100, 3)
DATUM = GlobalPose(43.2609, -79.9192, 100.0)
coordinate = st.floats(-300, 300)


def write(path: Path, content: object) -> Path:
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


def test_ours_lies_inside_the_autopilots_by_the_margins() -> None:
    assert sorted(FENCE.polygon) == [(5, 5), (5, 95), (95, 5), (95, 95)]
    assert FENCE.autopilot_polygon == SQUARE
    assert (FENCE.ceiling, FENCE.autopilot_ceiling) == (97, 100)
    assert extent(FENCE) == (90, 90)


@pytest.mark.parametrize(
    ("north", "east", "inside"),
    [(50, 50, True), (5, 50, True), (4.9, 50, False), (200, 50, False), (math.nan, 50, False), (math.inf, 50, False)],
)
def test_contains(north: float, east: float, inside: bool) -> None:
    assert contains(FENCE, MapPoint(north, east)) is inside


def test_outside_by() -> None:
    assert outside_by(FENCE, MapPoint(50, 50)) == 0
    assert outside_by(FENCE, MapPoint(-5, 50)) == pytest.approx(10)


def test_the_whole_straight_path_is_checked() -> None:
    corner, other = MapPoint(90, 20), MapPoint(20, 90)
    assert contains(L_SHAPE, corner)
    assert contains(L_SHAPE, other)
    assert not path_is_inside(L_SHAPE, corner, other)
    assert path_is_inside(L_SHAPE, corner, MapPoint(20, 20))
    assert path_is_inside(L_SHAPE, corner, corner)
    assert not path_is_inside(L_SHAPE, MapPoint(math.nan, 0), corner)


@given(coordinate, coordinate)
@example(34.0, 34.0)  # beside the corner that points inwards
def test_the_recovery_place_is_two_metres_inside_and_nearest(north: float, east: float) -> None:
    place = MapPoint(north, east)
    back = inside_point(L_SHAPE, place)
    edge = min(outside_by_ring(back), 1e9)
    assert contains(L_SHAPE, back)
    assert edge >= 2 - 1e-6
    if contains(L_SHAPE, place) and outside_by_ring(place) >= 2:
        assert back == place


def outside_by_ring(place: MapPoint) -> float:
    """Distance from our fence's edge."""
    corners = [*L_SHAPE.polygon, L_SHAPE.polygon[0]]
    return min(to_segment(place, a, b) for a, b in itertools.pairwise(corners))


def to_segment(place: MapPoint, a: tuple[float, float], b: tuple[float, float]) -> float:
    dn, de = b[0] - a[0], b[1] - a[1]
    share = ((place.north - a[0]) * dn + (place.east - a[1]) * de) / (dn * dn + de * de)
    share = min(1.0, max(0.0, share))
    return math.hypot(place.north - a[0] - share * dn, place.east - a[1] - share * de)


def test_a_fence_too_narrow_for_the_recovery_depth_still_has_a_middle() -> None:
    narrow = polygon_fence(((0, 0), (100, 0), (100, 13), (0, 13)), 5, 100, 3)
    assert contains(narrow, inside_point(narrow, MapPoint(50, 80)))


@pytest.mark.parametrize(
    "ring",
    [
        ((0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0)),
        ((0.0, 0.0), (60.0, 0.0), (60.0, 28.0), (100.0, 28.0), (100.0, 0.0), (160.0, 0.0), (160.0, 60.0), (100.0, 60.0),
         (100.0, 33.0), (60.0, 33.0), (60.0, 60.0), (0.0, 60.0)),
    ],
    ids=["nothing left", "two pieces"],
)  # fmt: skip
def test_a_fence_that_is_not_whole_inside_its_margin_is_refused(ring: tuple[tuple[float, float], ...]) -> None:
    with pytest.raises(FenceError, match="too narrow"):
        polygon_fence(ring, 5, 100, 3)


def test_a_circle_has_its_radius() -> None:
    corners = circle(MapPoint(10, -20), 150)
    assert len(corners) <= 70
    assert all(math.hypot(n - 10, e + 20) == pytest.approx(150) for n, e in corners)


def test_geodesy_agrees_with_a_degree_of_latitude() -> None:
    place = to_map(DATUM, DATUM.latitude + 0.001, DATUM.longitude)
    assert place.north == pytest.approx(111.1, abs=0.3)
    assert place.east == pytest.approx(0, abs=1e-6)


@given(coordinate, coordinate, coordinate, coordinate)
def test_a_path_that_leads_inside_never_leaves_again(
    north: float, east: float, to_north: float, to_east: float
) -> None:
    start, end = MapPoint(north, east), MapPoint(to_north, to_east)
    shares = [k / 200 for k in range(201)]
    along = [contains(L_SHAPE, MapPoint(north + (to_north - north) * k, east + (to_east - east) * k)) for k in shares]
    if leads_inside(L_SHAPE, start, end):
        assert along[-1]
        assert along == sorted(along), "outside first, then inside to the end"
    if contains(L_SHAPE, start):
        assert leads_inside(L_SHAPE, start, end) == path_is_inside(L_SHAPE, start, end)


def test_a_path_from_outside_through_one_arm_into_the_other_does_not_lead_inside() -> None:
    corner, other = MapPoint(90, 20), MapPoint(20, 90)
    assert not leads_inside(L_SHAPE, MapPoint(120, -10), other)
    assert not leads_inside(L_SHAPE, corner, other)
    assert leads_inside(L_SHAPE, MapPoint(120, 20), corner)
    assert not leads_inside(L_SHAPE, MapPoint(math.nan, 20), corner)


@given(coordinate, coordinate)
def test_a_stop_beyond_the_edge_is_taken_back_on_this_side_of_it(north: float, east: float) -> None:
    start, end = MapPoint(90, 20), MapPoint(north, east)
    stop = last_inside(L_SHAPE, start, end)
    assert path_is_inside(L_SHAPE, start, stop)
    assert start.distance(stop) <= start.distance(end) + 1e-6


def test_from_where_everything_is_seen() -> None:
    assert sees_all(FENCE, MapPoint(10, 10))
    assert sees_all(L_SHAPE, MapPoint(20, 20))
    assert not sees_all(L_SHAPE, MapPoint(90, 20))
    assert not sees_all(FENCE, MapPoint(200, 10))


@given(st.lists(st.tuples(coordinate, coordinate), min_size=3, max_size=8))
def test_an_outline_is_taken_only_when_it_is_a_simple_polygon(corners: list[tuple[float, float]]) -> None:
    ring = tuple(corners)
    refusal = ""
    try:
        check_fence_ring(ring)
    except FenceError as error:
        refusal = str(error)
    shape = shapely.Polygon(ring)
    assert not refusal or (refusal.startswith("Corners: ") and refusal.count(": ") >= 2), "field and remedy"
    assert refusal or (shape.is_valid and shape.area >= 399)


@pytest.mark.nightly
@given(st.floats(-80, 80), st.floats(-180, 180), st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=5))
def test_corners_come_back_from_wgs_84(latitude: float, longitude: float, corners: list[tuple[float, float]]) -> None:
    datum = GlobalPose(latitude, longitude, 0.0)
    ring = tuple(corners)
    back = ring_to_map(datum, ring_from_map(datum, ring))
    assert all(math.dist(a, b) < 0.02 for a, b in zip(ring, back, strict=True))


RING = [[-79.92, 43.26], [-79.91, 43.26], [-79.91, 43.27], [-79.92, 43.26]]


@pytest.mark.parametrize(
    "content",
    [
        {"type": "Polygon", "coordinates": [RING]},
        {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [RING]}},
        {"type": "FeatureCollection", "features": [{"geometry": {"type": "Polygon", "coordinates": [RING]}}]},
    ],
    ids=["geometry", "feature", "collection"],
)
def test_geojson_is_read_with_latitude_first(tmp_path: Path, content: object) -> None:
    assert read_fence(write(tmp_path / "f.geojson", content)).ring == (
        (43.26, -79.92),
        (43.26, -79.91),
        (43.27, -79.91),
    )


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ([], "exactly one Polygon"),
        ({"type": "Point", "coordinates": [0, 0]}, "exactly one Polygon"),
        ({"features": [{}, {}]}, "exactly one Polygon"),
        ({"type": "Polygon"}, "hold no ring"),
        ({"type": "Polygon", "coordinates": [RING[:2]]}, "2 corners"),
        ({"type": "Polygon", "coordinates": [[["a", 1], *RING]]}, r"\[0\]\[0\]: must be"),
        ({"type": "Polygon", "coordinates": [[[True, 1], *RING]]}, r"\[0\]\[0\]: must be"),
        ({"type": "Polygon", "coordinates": [[[43.26, -179.9], *RING]]}, "not degrees"),
        ({"type": "Polygon", "coordinates": [[[0, 0], [1, 1], [1, 0], [0, 1]]]}, "cross"),
        ({"type": "Polygon", "coordinates": [[[k * 1e-3, k * k * 1e-6] for k in range(80)]]}, "80 corners"),
    ],
)
def test_a_bad_fence_file_is_named_with_what_is_wrong(tmp_path: Path, content: object, words: str) -> None:
    path = write(tmp_path / "f.geojson", content)
    with pytest.raises(FenceError, match=words) as caught:
        read_fence(path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize("data", [b"{", b"\xff\xfe\x00", None], ids=["not json", "not text", "absent"])
def test_a_file_that_cannot_be_read(tmp_path: Path, data: bytes | None) -> None:
    path = tmp_path / "f.geojson"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(FenceError, match="cannot be read"):
        read_fence(path)
