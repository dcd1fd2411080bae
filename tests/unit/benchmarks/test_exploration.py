from __future__ import annotations

import json
import math
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import shapely

from benchmarks.exploration import __main__ as command
from benchmarks.exploration import campaign
from benchmarks.exploration.disc import Disc
from benchmarks.exploration.flight import fly
from benchmarks.exploration.lots import FENCE_MARGIN_M, KINDS, Lot, draw_lot
from benchmarks.exploration.oracle import best_tour
from benchmarks.exploration.pilots import MExplore, NearestFrontier, PlannerPilot, RulePilot, TourPilot
from benchmarks.exploration.polish import OracleTour
from benchmarks.exploration.report import figures, rows, way_over_oracle
from benchmarks.exploration.runs import NEAREST, PLANNER, TOLD, SeedRun, fly_told
from benchmarks.exploration.setups import DISC_M, GOOD_SHARE, Setup, flown, prototype
from benchmarks.exploration.surveyed import Coverage, SurveyedMap, ToldMap, within
from benchmarks.exploration.tour_cache import TourCache, shipped
from benchmarks.exploration.tour_flights import TourFlights
from hawk.algo.frame import FrameInput
from hawk.algo.mapper.grid import COARSE_M
from hawk.algo.mapper.window import Window
from hawk.algo.path_plan.footprint import LEVEL, Corners, Floats, Footprint
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.tour import as_place, length_of
from hawk.model import MapPose, PathPlan


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


def test_the_least_way_sweeps_what_the_first_look_does_not_show() -> None:
    setup = flown()
    assert setup.swath.width == pytest.approx(0.85 * 2 * 35 * math.tan(math.radians(35)))
    assert setup.bound(10_000.0) == pytest.approx((10_000 - setup.swath.width * setup.swath.depth) / setup.swath.width)
    assert setup.bound(100.0) == 0.0
    assert prototype().bound(5_000.0) == pytest.approx((5_000 - math.pi * 400) / 40)


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


def test_a_disc_shows_a_disc() -> None:
    lot = replace(prototype().lot(0), shape=shapely.box(-60, -60, 60, 60))
    coverage = Coverage(lot, prototype())
    coverage.look(at(0, 0))
    assert coverage.share == pytest.approx(math.pi * DISC_M**2 / 120**2, rel=0.02)


def test_a_cell_counts_when_its_middle_lies_inside() -> None:
    corners = np.array([[1.4, 1.4], [3.6, 1.4], [3.6, 2.6], [1.4, 2.6]])
    part = (slice(0, 6), slice(0, 6))
    expected = np.zeros((6, 6), np.uint8)
    expected[2, 2:4] = 1
    assert np.array_equal(within(corners, part), expected)
    assert np.array_equal(within(corners[::-1], part), expected)


def test_the_map_is_laid_where_the_drone_believes_to_be() -> None:
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


def test_someone_who_was_told_the_lot_has_only_to_see_it() -> None:
    setup = flown()
    lot = replace(setup.lot(0), shape=shapely.box(-32, -32, 32, 32))
    known = ToldMap(lot, setup, np.random.default_rng(1))
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


@dataclass(frozen=True)
class TourFlown:
    """One of the oracle's flights: way points (K, 2), whether it turned on the spot, metres."""

    places: Floats
    turns: bool
    way: float


@pytest.fixture(scope="module")
def oracle_flights() -> list[TourFlown]:
    """Every flight that the oracle made over the small lot."""
    return []


@pytest.fixture(scope="module")
def small(oracle_flights: list[TourFlown]) -> Iterator[SeedRun]:
    """One small lot flown by everyone."""

    class Recorded(TourFlights):
        def __init__(self, lot: Lot, setup: Setup, *, turns: bool) -> None:
            super().__init__(lot, setup, turns=turns)
            self._kind = turns

        def fly(self, places: Floats) -> OracleTour | None:
            tour = super().fly(places)
            if tour is not None:
                oracle_flights.append(TourFlown(places.copy(), self._kind, tour.way))
            return tour

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("benchmarks.exploration.oracle.TourFlights", Recorded)
        yield _everyone_s()


def _everyone_s() -> SeedRun:
    setup = flown()
    lot = setup.lot(3)
    flights = {PLANNER: fly(lot, setup, PlannerPilot()), TOLD: fly_told(lot, setup)}
    for name, rule in (
        (NEAREST, NearestFrontier()),
        ("m_explore", MExplore()),
        ("gain_by_distance", NearestFrontier()),
    ):
        flights[name] = fly(lot, setup, RulePilot(rule), to_the_end=False)
    return SeedRun(lot, setup.bound(lot.area), best_tour(lot, setup, 0.98), flights)


def test_the_planner_sees_it_all_ends_by_itself_and_stays_inside(small: SeedRun) -> None:
    flight = small.planner
    assert flight.end == "done"
    assert flight.coverage >= 0.98
    assert flight.excursions == 0
    assert flight.way is not None
    assert flight.way <= flight.whole_way
    assert small.oracle.way < 2.0 * flight.way


def test_the_oracle_s_tour_shows_enough_when_flown_again(small: SeedRun, oracle_flights: list[TourFlown]) -> None:
    best = min(oracle_flights, key=lambda one: one.way)
    assert best.way == small.oracle.way
    pilot = TourPilot([as_place(place) for place in best.places[1:]], turns=best.turns)
    again = fly(small.lot, flown(), pilot, errors=False, to_the_end=False)
    assert again.coverage >= 0.98
    assert again.way == small.oracle.way  # though the oracle flew only what its last flights had not in common


def test_a_pilot_that_turns_where_its_tour_begins_and_ends_sees_more_on_the_same_way() -> None:
    setup = flown()
    lot = setup.lot(3)
    flights = [fly(lot, setup, TourPilot([(10.0, 0.0)], turns=turns), errors=False) for turns in (False, True)]
    assert flights[1].coverage > flights[0].coverage + 0.03
    assert flights[1].whole_way == pytest.approx(flights[0].whole_way, abs=1.0)
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


def test_equal_seeds_fly_equally(small: SeedRun) -> None:
    again = fly(small.lot, flown(), PlannerPilot())
    assert np.array_equal(again.track, small.planner.track)


def test_an_excursion_is_counted_once_each_time() -> None:
    setup = flown()
    lot = replace(setup.lot(3), start=(0.0, 0.0))
    ring = ((-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0))
    outside = replace(lot, fence=replace(lot.fence, polygon=ring), start=(12.0, 0.0))
    flight = fly(outside, setup, TourPilot([(0.0, 0.0)]), errors=False)
    assert flight.excursions == 1


def test_a_flight_that_did_not_see_enough_never_looks_short(small: SeedRun) -> None:
    poor = replace(small.planner, way=None, seconds=None, coverage=0.5)
    run = replace(small, flights={**small.flights, PLANNER: poor})
    assert way_over_oracle(run) == math.inf
    told = {figure.key: figure for figure in figures([run], [])}
    assert told["way_over_oracle_median"].value is None
    assert told["way_over_oracle_median"].passed is False
    assert told["coverage_min"].passed is False
    assert told["unfinished"].value == 1


def test_the_best_way_is_the_oracle_s_or_a_shorter_one_that_was_flown(small: SeedRun) -> None:
    slow, fast = (replace(small.planner, way=small.oracle.way * factor) for factor in (1.2, 0.9))
    assert replace(small, flights={PLANNER: slow}).best_way == small.oracle.way
    lucky = replace(small, flights={PLANNER: slow, NEAREST: fast})
    assert lucky.best_way == pytest.approx(0.9 * small.oracle.way)
    assert way_over_oracle(lucky) == pytest.approx(1.2 / 0.9)


def test_who_was_told_the_lot_sees_enough_of_it_and_ends_there(small: SeedRun) -> None:
    told = small.flights[TOLD]
    assert told.end == "seen"
    assert told.way == pytest.approx(told.whole_way, abs=0.5)
    assert told.excursions == 0


def test_every_promised_figure_is_there(small: SeedRun) -> None:
    keys = {figure.key for figure in figures([small], [small])}
    promised = {
        "way_over_oracle_median", "way_over_oracle_p90", "way_over_nearest_frontier_median", "way_over_bound_median",
        "told_over_oracle_median", "told_over_oracle_p90", "way_over_oracle_0_3_ha_median",
        "plan_ms_p99", "excursions", "coverage_min", "oracle_over_bound_median", "nearest_frontier_over_bound_median",
    }  # fmt: skip
    assert promised <= keys
    (row,) = rows("flown", [small])
    assert row["planner"]["way_m"] == pytest.approx(small.planner.way, abs=0.1)
    assert json.dumps(row)


def test_tours_are_kept_and_not_computed_again(small: SeedRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "tours.json"
    TourCache(path).keep(small.lot, flown(), small.oracle)
    monkeypatch.setattr("benchmarks.exploration.tour_cache.best_tour", None)
    assert TourCache(path).tour(small.lot, flown()).way == pytest.approx(small.oracle.way, abs=0.01)
    unwritten = tmp_path / "unwritten.json"
    TourCache(unwritten, writes=False).keep(small.lot, flown(), small.oracle)
    assert not unwritten.exists()


@pytest.mark.parametrize(("setup", "seed"), [(flown(), 3), (flown(), 4), (prototype(), 9)])
def test_tours_that_come_with_the_benchmark_are_flights_over_its_lots(
    setup: Setup, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("benchmarks.exploration.tour_cache.best_tour", None)
    lot = setup.lot(seed)
    tour = shipped(setup.name).tour(lot, setup)
    assert math.dist(tour.places[0], lot.start) < 1.0
    assert length_of(tour.places) == pytest.approx(tour.way, rel=0.02)
    leant = setup.height * math.tan(math.radians(PathPlanSettings().lean_deg))
    far = lot.shape.difference(shapely.LineString(tour.places).buffer(setup.swath.reach + leant))
    assert far.area <= 0.02 * lot.area


def test_workers_find_what_one_process_finds(small: SeedRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(campaign, "ProcessPoolExecutor", ThreadPoolExecutor)
    monkeypatch.setattr(campaign, "_one", lambda name, seed, tours: small)
    path = tmp_path / "tours.json"
    assert campaign.fly_all("flown", [3, 4], path, 2) == [small, small]
    assert TourCache(tmp_path / "tours-flown.json").tour(small.lot, flown()).way == pytest.approx(
        small.oracle.way, abs=0.01
    )


def test_a_disc_s_leg_shows_a_capsule() -> None:
    cells = np.array([[0, 19], [0, 21], [-19, 0], [-15, -15], [50, 19.5], [69, 0], [71, 0]], np.float32)
    shown = Disc(40.0, 40.0).shown(cells, np.array([[0.0, 0.0]]), np.array([[50.0, 0.0]]))[0]
    assert shown.tolist() == [True, False, True, False, True, True, False]


def test_the_command_writes_json_and_pictures(
    small: SeedRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(command, "fly_all", lambda name, seeds, tours, workers: [small] * len(seeds))
    out = tmp_path / "out" / "exploration.json"
    assert command.main(["--seeds", "3-4", "--json", str(out), "--picture", str(tmp_path / "pictures")]) == 0
    values = json.loads(out.read_text())
    assert values["excursions"] == 0
    assert len(values["flights"]) == 4
    assert len(list((tmp_path / "pictures").glob("*.png"))) == 4
    assert "way by oracle, median" in capsys.readouterr().out


@pytest.mark.parametrize("arguments", [["--seeds", "x"], ["--setups", "moon"]])
def test_wrong_options_are_refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        command.main(arguments)
    assert ended.value.code == 2
    assert arguments[0] in capsys.readouterr().err


def test_among_all_benchmarks_the_keys_do_not_clash(small: SeedRun, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(campaign, "fly_all", lambda name, seeds, tours, workers: [small])
    assert {"exploration_excursions", "exploration_way_over_oracle_median"} <= {f.key for f in campaign.measure([3])}


def test_a_flight_ends_when_nothing_moves() -> None:
    setup = flown()
    lot = setup.lot(3)

    class Idle:
        def plan(self, frame: FrameInput, known: SurveyedMap) -> PathPlan:
            return PathPlan()

    flight = fly(lot, setup, Idle())
    assert flight.end == "stuck"
    assert flight.way is None
