from __future__ import annotations

import itertools
import math

import pytest
import shapely

from benchmarks.figures import BenchmarkError
from hawk.algo.path_plan.footprint import Swath
from proving.lawnmower import OVERLAP, lanes

SWATH = Swath(40.0, 24.0, 35.0)
FENCE = shapely.box(-80, -120, 80, 120)
LOT = shapely.box(-40, -70, 40, 70)


def shown(places: list[tuple[float, float]], yaw: float) -> shapely.Geometry:
    """Return the ground that pictures at a fixed yaw show along the flight."""
    c, s = math.cos(yaw), math.sin(yaw)
    corners = [(a * SWATH.depth / 2, b * SWATH.width / 2) for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
    parts = []
    for one, other in itertools.pairwise(places):
        ends = [(n + c * x - s * y, e + s * x + c * y) for n, e in (one, other) for x, y in corners]
        parts.append(shapely.MultiPoint(ends).convex_hull)
    return shapely.union_all(parts)


@pytest.mark.parametrize("yaw", [0.0, 0.5, 2.0, -1.2])
def test_lanes_show_all_of_a_lot_from_inside_the_fence(yaw: float) -> None:
    places = lanes(LOT, FENCE, yaw, SWATH, (-38.0, -60.0))
    assert shown([(-38.0, -60.0), *places], yaw).intersection(LOT).area > 0.98 * LOT.area
    assert all(FENCE.buffer(-2).covers(shapely.Point(place)) for place in places)


def test_it_begins_at_the_end_that_is_nearer() -> None:
    near, far = (lanes(LOT, FENCE, 0.0, SWATH, start) for start in ((-38.0, -60.0), (38.0, 60.0)))
    assert math.dist(near[0], (-38, -60)) < math.dist(near[-1], (-38, -60))
    assert math.dist(far[0], (38, 60)) < math.dist(far[-1], (38, 60))
    assert len({round(east) for _, east in near}) == math.ceil(140 / (SWATH.width * OVERLAP))


def test_a_lane_that_leaves_the_fence_goes_by_its_corners() -> None:
    fence = shapely.difference(FENCE, shapely.box(-20, -10, 100, 10))
    lot = shapely.difference(LOT, shapely.box(-30, -20, 100, 20))
    places = [(0.0, -60.0), *lanes(lot, fence, math.pi / 2, SWATH, (0.0, -60.0))]
    for one, other in itertools.pairwise(places):
        assert fence.covers(shapely.LineString([one, other]))


def test_a_fence_in_two_parts_leaves_no_path() -> None:
    fence = shapely.union(shapely.box(-80, -120, -40, 120), shapely.box(40, -120, 80, 120)).union(
        shapely.box(-80, -120, 80, -117)
    )
    with pytest.raises(BenchmarkError, match="no path"):
        lanes(LOT, fence, math.pi / 2, SWATH, (-70.0, 0.0))
