from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely

from benchmarks.exploration import __main__ as command
from benchmarks.exploration.flight import fly
from benchmarks.exploration.lots import FENCE_MARGIN_M, KINDS, draw_lot
from benchmarks.exploration.pilots import TourPilot
from benchmarks.exploration.setups import GOOD_SHARE, flown
from benchmarks.exploration.surveyed import Coverage, KnownLotMap, SurveyedMap, within
from benchmarks.exploration.tours import tour_of
from benchmarks.figures import BenchmarkError
from hawk.algo.frame import FrameInput
from hawk.algo.ground import COARSE_M, Floats, Window
from hawk.algo.path_plan.footprint import LEVEL, Corners, Footprint
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.tour import length_of
from hawk.model.plans import PathPlan
from hawk.model.poses import MapPose


def at(north: float, east: float, yaw: float = 0.0, height: float = 35.0) -> MapPose:
    return MapPose(north, east, height, 0.0, 0.0, yaw)


@pytest.mark.parametrize("kind", sorted(KINDS))
@pytest.mark.parametrize("seed", [2, 3])
def test_a_lot_has_its_area_and_the_drone_begins_in_it_and_inside_the_fence(kind: str, seed: int) -> None:
    lot = draw_lot(seed, 10_000.0, kind)
    assert lot.area == pytest.approx(10_000.0)
    assert isinstance(lot.shape, shapely.Polygon)
    assert lot.shape.contains(shapely.Point(lot.start))
    ours, theirs = (shapely.Polygon(ring) for ring in (lot.fence.polygon, lot.fence.autopilot_polygon))
    assert ours.contains(lot.shape)
    assert theirs.buffer(-FENCE_MARGIN_M + 0.1).contains(ours)
    assert draw_lot(seed, 10_000.0, kind).shape.equals(lot.shape)
    assert not draw_lot(seed + 10, 10_000.0, kind).shape.equals(lot.shape)


def test_fifteen_seeds_show_every_size_and_kind() -> None:
    lots = [flown().lot(seed) for seed in range(15)]
    assert {(round(lot.area), lot.kind) for lot in lots} == {(a, k) for a in (3_000, 10_000, 30_000) for k in KINDS}


def test_the_least_distance_sweeps_what_the_first_look_does_not_show() -> None:
    setup = flown()
    assert setup.swath.width == pytest.approx(0.85 * 2 * 35 * math.tan(math.radians(35)))
    assert setup.bound(10_000.0) == pytest.approx((10_000 - setup.swath.width * setup.swath.depth) / setup.swath.width)
    assert setup.bound(100.0) == 0.0


def test_coverage_is_what_the_true_footprint_shows() -> None:
    setup = flown()
    lot = replace(setup.lot(0), shape=shapely.box(-60, -60, 60, 60))
    coverage = Coverage(lot, setup)
    coverage.look(at(0, 0, yaw=0.7))
    once = coverage.share
    assert once == pytest.approx(setup.swath.width * setup.swath.depth / 120**2, rel=0.02)
    coverage.look(at(0, 0, yaw=0.7))
    assert coverage.share == once
    coverage.look(at(500, 0))
    assert coverage.share == once


def test_a_cell_counts_when_its_middle_lies_inside() -> None:
    corners = np.array([[1.4, 1.4], [3.6, 1.4], [3.6, 2.6], [1.4, 2.6]])
    part = (slice(0, 6), slice(0, 6))
    expected = np.zeros((6, 6), np.uint8)
    expected[2, 2:4] = 1
    assert np.array_equal(within(corners, part), expected)
    assert np.array_equal(within(corners[::-1], part), expected)


def test_the_map_is_placed_where_the_drone_believes_to_be() -> None:
    setup = flown()
    lot = replace(setup.lot(0), shape=shapely.box(-30, -30, 30, 30))
    maps = [SurveyedMap(lot, setup, np.random.default_rng(1), errors=False) for _ in range(2)]
    maps[0].look(at(28, 0), at(28, 0))
    maps[1].look(at(28, 0), at(32, 0))
    window = Window.around(np.array([[-60.0, -60.0], [90.0, 60.0]]), COARSE_M)
    edges = []
    for one in maps:
        layers = one.coarse(window)
        rows_ = np.flatnonzero(layers.lot.sum(1) > 0)
        edges.append(-(window.row + rows_.min()) * COARSE_M)
        assert layers.lot.max() <= 1
        assert (layers.lot <= layers.seen).all()
        assert (layers.well <= layers.seen).all()
    assert edges[0] == pytest.approx(30, abs=COARSE_M)
    assert edges[1] - edges[0] == pytest.approx(4, abs=COARSE_M)


def test_a_pilot_that_knows_the_lot_has_only_to_see_it() -> None:
    setup = flown()
    lot = replace(setup.lot(0), shape=shapely.box(-32, -32, 32, 32))
    known = KnownLotMap(lot, setup, np.random.default_rng(1))
    window = Window.around(np.array([[-60.0, -60.0], [60.0, 60.0]]), COARSE_M)
    known.look(at(20, 0), at(20, 0))
    for _ in range(2):
        layers = known.coarse(window)
        assert layers.lot.sum() * COARSE_M**2 == pytest.approx(64**2, rel=0.03)
        assert (layers.seen[layers.lot == 0] == 1).all()
        assert layers.well.sum() * COARSE_M**2 == pytest.approx(setup.footprint_area, rel=0.1)
        assert known.lot_area_m2() == lot.area
        known.look(at(20, 0), at(20, 0))
    extent = known.known_extent()
    assert extent is not None
    assert (extent[0] <= -32).all()
    assert (extent[1] >= 32).all()


@pytest.mark.slow
def test_a_pilot_that_turns_where_its_tour_begins_and_ends_sees_more_on_the_same_path() -> None:
    setup = flown()
    lot = setup.lot(3)
    flights = [fly(lot, setup, TourPilot([(10.0, 0.0)], turns=turns), errors=False) for turns in (False, True)]
    assert flights[1].coverage > flights[0].coverage + 0.03
    assert flights[1].whole_distance_m == pytest.approx(flights[0].whole_distance_m, abs=1.0)
    assert flights[1].end == "done"


class Watched(TourPilot):
    """A tour's pilot that keeps the poses from which pictures were taken."""

    def __init__(self, tour: list[tuple[float, float]]) -> None:
        super().__init__(tour)
        self.poses: list[MapPose] = []

    def plan(self, frame: FrameInput, known: SurveyedMap) -> PathPlan:
        assert frame.pose is not None
        self.poses.append(frame.pose)
        return super().plan(frame, known)


@pytest.mark.slow
@pytest.mark.parametrize("turn", [0.6, 1.2, 1.8, 2.4, 3.1])
def test_the_planner_counts_on_what_a_leaning_drone_shows(turn: float) -> None:
    """The body that flies leans as it speeds up, turns and brakes: nearly all that is counted on is seen, and more than
    of a picture that stays level."""
    setup, places = flown(), np.array([(0.0, 0.0), (30.0, 0.0), (30 + 35 * math.cos(turn), 35 * math.sin(turn))])
    lot = replace(setup.lot(1), start=(0.0, 0.0), yaw=0.0, shape=shapely.box(-90, -90, 90, 90))
    pilot = Watched([(float(north), float(east)) for north, east in places[1:]])
    assert fly(lot, setup, pilot, errors=False).end == "done"
    cells = np.stack(np.meshgrid(np.arange(-89, 90, 2.0), np.arange(-89, 90, 2.0)), -1).reshape(-1, 2)
    pictures = shapely.union_all([shapely.Polygon(setup.outline(pose, GOOD_SHARE)) for pose in pilot.poses])
    seen = shapely.contains_xy(pictures, cells[:, 0], cells[:, 1])
    leaning = replace(Footprint.of(setup.swath, PathPlanSettings()), spun=0.0)  # this pilot does not turn at the end
    counted, level = (
        footprint.shown(cells.astype(np.float32), places[:-1], places[1:], corners_of(places, leaning.turned)).any(0)
        for footprint in (leaning, replace(leaning, lean=LEVEL))
    )
    assert np.count_nonzero(counted & seen) > 0.97 * np.count_nonzero(counted)
    assert np.count_nonzero(counted) > 1.1 * np.count_nonzero(level)


def corners_of(places: Floats, turned: float) -> Corners:
    legs = np.diff(places, axis=0)
    directions = legs / np.hypot(*legs.T)[:, None]
    number = np.arange(len(legs))
    return Corners(
        np.vstack([np.zeros((1, 2)), directions[:-1]]), np.where(number > 0, turned, 0.0), number == len(legs) - 1
    )


def test_an_excursion_is_counted_once_each_time() -> None:
    setup = flown()
    lot = replace(setup.lot(3), start=(0.0, 0.0))
    ring = ((-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0))
    outside = replace(lot, fence=replace(lot.fence, polygon=ring), start=(12.0, 0.0))
    flight = fly(outside, setup, TourPilot([(0.0, 0.0)]), errors=False)
    assert flight.excursions == 1


@pytest.mark.parametrize("seed", [3, 4])
def test_tours_that_are_kept_are_flights_over_the_lots(seed: int) -> None:
    setup = flown()
    lot = setup.lot(seed)
    tour = tour_of(lot, setup)
    assert math.dist(tour.places[0], lot.start) < 1.0
    assert length_of(tour.places) == pytest.approx(tour.distance_m, rel=0.02)
    leant = setup.height * math.tan(math.radians(PathPlanSettings().lean_deg))
    far = lot.shape.difference(shapely.LineString(tour.places).buffer(setup.swath.reach + leant))
    assert far.area <= 0.02 * lot.area


def test_a_lot_without_a_tour_names_those_that_have_one() -> None:
    with pytest.raises(BenchmarkError, match="seed 201 is kept: take 1 to 200"):
        tour_of(flown().lot(201), flown())


@pytest.mark.parametrize("arguments", [["--seeds", "x"], ["--workers", "many"]])
def test_wrong_options_are_refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        command.main(arguments)
    assert ended.value.code == 2
    assert arguments[0] in capsys.readouterr().err


@pytest.mark.slow
def test_a_flight_ends_when_nothing_moves() -> None:
    setup = flown()
    lot = setup.lot(3)

    class Idle:
        def plan(self, frame: FrameInput, known: SurveyedMap) -> PathPlan:
            return PathPlan()

    flight = fly(lot, setup, Idle())
    assert flight.end == "stuck"
    assert flight.distance_m is None
