from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
import shapely

from benchmarks.figures import BenchmarkError, Figure
from benchmarks.flown_surveys import WorldRun, figures, problem_of, rings_of
from benchmarks.lawnmower import OVERLAP, lanes
from hawk.algo.path_plan.footprint import Swath
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import SurveyMap
from hawk.survey.truth import GroundTruth

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


def test_the_true_lots_are_projected_on_the_survey_s_map() -> None:
    origin = GlobalPose(43.26, -79.92, 0.0)
    truth = GroundTruth((), (), (), (np.array([[10.0, 20.0], [50.0, 20.0], [50.0, 60.0]]),), origin)
    survey = SurveyMap(GlobalPose(43.2597, -79.9195, 0.0), {}, {})
    (ring,) = rings_of(truth, survey)
    assert truth.to_world(ring, survey.datum) == pytest.approx(truth.lots[0], abs=1e-6)


RUN = WorldRun(1, 0, "", 220.0, 60.0, 0.95, 200.0, 55.0, 0, 300.0, 0.94, 0.001, 0)


def by_key(found: list[Figure]) -> dict[str, Figure]:
    return {figure.key: figure for figure in found}


def test_figures_compare_with_the_model_and_with_the_lawnmower() -> None:
    found = by_key(figures([RUN, replace(RUN, distance_m=190.0, f1=0.90)]))
    assert found["flown_distance_over_kinematic"].value == pytest.approx(410 / 400)
    assert found["flown_distance_over_kinematic"].passed
    assert found["flown_f1_gain"].value == pytest.approx((0.01 - 0.04) / 2)
    assert not found["flown_f1_gain"].passed
    assert found["flown_f1_gain_min"].value == pytest.approx(-0.04)
    assert found["flown_distance_over_lawnmower"].value == pytest.approx(410 / 600)


def test_a_distance_much_longer_than_the_model_s_and_an_excursion_are_missed() -> None:
    found = by_key(figures([replace(RUN, distance_m=260.0, excursions=1, status=4, late=0.02)]))
    for key in ("flown_distance_over_kinematic", "flown_excursions", "flown_finished", "flown_late_frames"):
        assert found[key].passed is False


def test_late_pictures_and_worlds_that_were_not_measured_are_reported() -> None:
    assert problem_of([RUN], 1) == ""
    assert problem_of([RUN, replace(RUN, seed=7, late=0.5)], 3) == (
        "VOID: the simulator drew too late for 7; only 2 of 3 worlds were measured"
    )
