"""The shortest path inside our fence, compared with a search over every pair of its corners."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.ddc.fence import path as fence_path
from hawk.ddc.fence.geometry import contains, path_is_inside, polygon_fence, shape
from hawk.ddc.fence.path import CUTS_M, SIGHT_ROOM_M, is_in_sight, length, path_inside, prepare, route_inside
from hawk.model.plans import Fence
from hawk.model.poses import MapPoint
from tests.unit.ddc.test_operations_manager_path_back import fences

U_SHAPE = polygon_fence(
    ((100, -60), (100, -20), (20, -20), (20, 20), (100, 20), (100, 60), (-20, 60), (-20, -60)), 5, 100, 3
)
WEST, EAST, FOOT = MapPoint(80.0, -40.0), MapPoint(80.0, 40.0), MapPoint(0.0, 0.0)
HOLED = shapely.Polygon(
    ((0, 0), (200, 0), (200, 100), (0, 100)),
    [((40, 20), (60, 20), (60, 80), (40, 80)), ((100, 1), (120, 1), (120, 70), (100, 70))],
)
share = st.floats(0.0, 1.0)


def inside(ground: shapely.Polygon, north: float, east: float) -> MapPoint:
    """Return the place at these shares of the extent, moved onto the ground."""
    south, west, top, right = ground.bounds
    point = shapely.Point(south + north * (top - south), west + east * (right - west))
    at = shapely.shortest_line(shapely.buffer(ground, -1e-6), point).coords[0]
    return MapPoint(float(at[0]), float(at[1]))


def every_pair(ground: shapely.Geometry, over: shapely.Geometry, start: MapPoint, end: MapPoint) -> float:
    """Return the length of the shortest path over all corners; ``over`` holds the legs from start and end."""
    places = np.vstack([shapely.get_coordinates(ground), [start.north, start.east], [end.north, end.east]])
    count = len(places)
    one, other = np.triu_indices(count, 1)
    lines = shapely.linestrings(np.stack([places[one], places[other]], axis=1))
    joins = other >= count - 2
    seen = np.where(joins, shapely.covers(over, lines), shapely.covers(ground, lines))
    metres = np.full((count, count), math.inf)
    metres[one[seen], other[seen]] = np.linalg.norm(places[one[seen]] - places[other[seen]], axis=1)
    metres = np.minimum(metres, metres.T)
    for k in range(count):
        metres = np.minimum(metres, metres[:, k, None] + metres[None, k, :])
    return float(metres[-2, -1])


def holed(patch: pytest.MonkeyPatch) -> Fence:
    """Return a fence whose ground has two holes."""
    shapely.prepare(HOLED)
    patch.setattr(fence_path, "shape", lambda _: HOLED)
    patch.setattr(fence_path, "contains", lambda _, place: HOLED.covers(shapely.Point(place.north, place.east)))
    patch.setattr(fence_path, "path_is_inside", lambda _, a, b: HOLED.covers(line(a, b)))
    return Fence(tuple(HOLED.exterior.coords)[:-1], (), 1.0, 1.0)


def line(*points: MapPoint) -> shapely.LineString:
    return shapely.LineString([(point.north, point.east) for point in points])


def test_the_path_between_two_arms_turns_two_metres_inside_their_corners() -> None:
    path = path_inside(U_SHAPE, WEST, EAST)
    assert path == (WEST, MapPoint(13.0, -27.0), MapPoint(13.0, 27.0), EAST)
    assert is_in_sight(U_SHAPE, MapPoint(13.0, 27.0), EAST)
    assert path_inside(U_SHAPE, EAST, WEST) == tuple(reversed(path))


def test_one_corner_is_passed_where_home_is_seen_behind_it() -> None:
    path = path_inside(U_SHAPE, WEST, FOOT)
    assert path is not None
    assert path[1:] == (MapPoint(13.0, -27.0), FOOT)


def test_where_nothing_leads_there_is_no_path() -> None:
    assert path_inside(U_SHAPE, MapPoint(80.0, 0.0), EAST) is None
    assert path_inside(U_SHAPE, EAST, MapPoint(80.0, 0.0)) is None
    assert path_inside(U_SHAPE, EAST, MapPoint(math.nan, 0.0)) is None


@pytest.mark.slow
@settings(max_examples=60)
@given(fences(), share, share, share, share)
def test_there_is_always_a_path_it_lies_inside_and_is_the_straight_one_where_that_is_inside(
    fence: Fence, north: float, east: float, to_north: float, to_east: float
) -> None:
    start, end = inside(shape(fence), north, east), inside(shape(fence), to_north, to_east)
    path = path_inside(fence, start, end)
    assert path is not None
    assert (path[0], path[-1]) == (start, end)
    assert all(path_is_inside(fence, a, b) for a, b in pairwise(path))
    assert length(path) >= start.distance(end) - 1e-6
    if path_is_inside(fence, start, end):
        assert path == (start, end)


@pytest.mark.nightly
@settings(max_examples=200)
@given(fences(), share, share, share, share)
def test_no_path_with_this_room_is_shorter(
    fence: Fence, north: float, east: float, to_north: float, to_east: float
) -> None:
    ground = shapely.buffer(shape(fence), -fence_path.ROOM_M[0], join_style="mitre", mitre_limit=5.0)
    if not isinstance(ground, shapely.Polygon) or ground.is_empty:
        return
    start, end = inside(ground, north, east), inside(ground, to_north, to_east)
    ends = shapely.points([(start.north, start.east), (end.north, end.east)])
    if path_is_inside(fence, start, end) or not ground.covers(ends).all():
        return  # most pairs: nothing to compare
    path = path_inside(fence, start, end)
    assert path is not None
    assert length(path) == pytest.approx(every_pair(ground, ground, start, end), abs=1e-6)
    assert shape(fence).boundary.distance(line(*path)) >= 2.0 - 1e-6


@pytest.mark.parametrize("width", [3.0, 1.5, 0.6, 0.05])
def test_a_neck_too_narrow_for_the_room_is_passed_with_less(width: float) -> None:
    half = width / 2
    ring = (
        (0, 0),
        (40, 0),
        (40, 20 - half),
        (60, 20 - half),
        (60, 0),
        (100, 0),
        (100, 40),
        (60, 40),
        (60, 20 + half),
        (40, 20 + half),
        (40, 40),
        (0, 40),
    )
    fence = Fence(tuple((float(n), float(e)) for n, e in ring), (), 1.0, 1.0)
    start, end = MapPoint(5.0, 35.0), MapPoint(95.0, 35.0)
    path = path_inside(fence, start, end)
    assert path is not None
    assert all(path_is_inside(fence, a, b) for a, b in pairwise(path))


@pytest.mark.parametrize("start", [MapPoint(14.9, -40.0), MapPoint(94.9, -25.1), MapPoint(95.0, -55.0)])
def test_a_start_at_the_edge_is_joined_to_the_path(start: MapPoint) -> None:
    path = path_inside(U_SHAPE, start, EAST)
    assert path is not None
    assert path[1:] == (MapPoint(13.0, -27.0), MapPoint(13.0, 27.0), EAST)
    assert all(path_is_inside(U_SHAPE, a, b) for a, b in pairwise(path))


def test_holes_are_gone_round_on_their_shorter_side(monkeypatch: pytest.MonkeyPatch) -> None:
    fence = holed(monkeypatch)
    start, end = MapPoint(20.0, 50.0), MapPoint(150.0, 40.0)
    path = path_inside(fence, start, end)
    assert path is not None
    ground = shapely.buffer(HOLED, -2.0, join_style="mitre", mitre_limit=5.0)
    assert ground.covers(line(*path))
    assert length(path) == pytest.approx(every_pair(ground, ground, start, end), abs=1e-6)
    assert not is_in_sight(fence, start, end)


@given(share, share, share, share)
def test_holes_hide_no_path(north: float, east: float, to_north: float, to_east: float) -> None:
    with pytest.MonkeyPatch.context() as patch:
        fence = holed(patch)
        start, end = inside(HOLED, north, east), inside(HOLED, to_north, to_east)
        path = path_inside(fence, start, end)
        assert path is not None
        assert HOLED.covers(line(*path))
        assert length(path) >= start.distance(end) - 1e-6


def test_a_corner_that_is_grazed_is_not_seen_past() -> None:
    corner = MapPoint(15.0, -25.0)  # of our limit, between west arm and foot
    grazing = MapPoint(95.0, -25.0)
    assert path_is_inside(U_SHAPE, grazing, MapPoint(-10.0, -25.0))
    assert is_in_sight(U_SHAPE, MapPoint(90.0, -26.5), MapPoint(-10.0, -26.5))
    assert not is_in_sight(U_SHAPE, MapPoint(90.0, -25.5), MapPoint(-10.0, -25.5))
    assert is_in_sight(U_SHAPE, corner, FOOT), "at the corner itself"
    assert not is_in_sight(U_SHAPE, WEST, EAST)


@pytest.mark.slow
@settings(max_examples=40)
@given(fences(), share, share, share, share)
def test_a_corner_is_cut_only_where_its_triangle_is_well_inside(
    fence: Fence, north: float, east: float, to_north: float, to_east: float
) -> None:
    route = route_inside(fence, inside(shape(fence), north, east), inside(shape(fence), to_north, to_east))
    assert route is not None
    assert len(route.turns) == len(route.points)
    ground = shapely.buffer(shape(fence), 1e-6 - SIGHT_ROOM_M, join_style="mitre", mitre_limit=5.0)
    for k, cut in enumerate(route.turns):
        assert cut in (0.0, *CUTS_M)
        if cut:
            before, at, after = route.points[k - 1 : k + 2]
            ends = [
                (
                    at.north + (o.north - at.north) * cut / at.distance(o),
                    at.east + (o.east - at.east) * cut / at.distance(o),
                )
                for o in (before, after)
            ]
            assert ground.covers(shapely.Polygon([ends[0], (at.north, at.east), ends[1]]))
            assert 2 * cut <= min(before.distance(at), at.distance(after)) + 1e-9


def test_what_is_prepared_is_not_made_again() -> None:
    fence = polygon_fence(((0, 0), (100, 0), (100, 40), (40, 40), (40, 100), (0, 100)), 5, 100, 3)
    prepare(fence)
    made = fence_path._neighbours.cache_info().misses
    assert path_inside(fence, MapPoint(90.0, 20.0), MapPoint(20.0, 90.0)) is not None
    assert fence_path._neighbours.cache_info().misses == made
    assert contains(fence, MapPoint(20.0, 20.0))
