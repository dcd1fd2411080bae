"""One small lot, flown by everyone once; each test looks at a part of it."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.exploration import __main__ as command
from benchmarks.exploration import campaign
from benchmarks.exploration.flight import fly
from benchmarks.exploration.lots import Lot
from benchmarks.exploration.oracle import best_tour
from benchmarks.exploration.pilots import FrontierPilot, PlannerPilot, TourPilot
from benchmarks.exploration.polish import OracleTour
from benchmarks.exploration.report import distance_over_oracle, figures, rows
from benchmarks.exploration.runs import KNOWN_LOT, NEAREST, OUTLINE, PLANNER, SeedRun, fly_known_lot, fly_outline
from benchmarks.exploration.setups import Setup, flown
from benchmarks.exploration.tour_cache import TourCache
from benchmarks.exploration.tour_flights import TourFlights
from hawk.algo.ground import Floats
from hawk.algo.path_plan.tour import as_place

pytestmark = [pytest.mark.flight, pytest.mark.nightly]


@dataclass(frozen=True)
class TourFlown:
    """One of the oracle's flights: waypoints (K, 2), whether it turned on the spot, metres."""

    places: Floats
    turns: bool
    distance_m: float


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
                oracle_flights.append(TourFlown(places.copy(), self._kind, tour.distance_m))
            return tour

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("benchmarks.exploration.oracle.TourFlights", Recorded)
        yield _everyone_s()


def _everyone_s() -> SeedRun:
    setup = flown()
    lot = setup.lot(3)
    flights = {PLANNER: fly(lot, setup, PlannerPilot()), KNOWN_LOT: fly_known_lot(lot, setup)}
    flights[OUTLINE] = fly_outline(lot, setup)
    flights[NEAREST] = fly(lot, setup, FrontierPilot(), to_the_end=False)
    return SeedRun(lot, setup.bound(lot.area), best_tour(lot, setup, 0.98), flights)


def test_the_planner_sees_it_all_ends_by_itself_and_stays_inside(small: SeedRun) -> None:
    flight = small.planner
    assert flight.end == "done"
    assert flight.coverage >= 0.98
    assert flight.excursions == 0
    assert flight.distance_m is not None
    assert flight.distance_m <= flight.whole_distance_m
    assert small.oracle.distance_m < 2.0 * flight.distance_m


def test_the_oracle_s_tour_shows_enough_when_flown_again(small: SeedRun, oracle_flights: list[TourFlown]) -> None:
    best = min(oracle_flights, key=lambda one: one.distance_m)
    assert best.distance_m == small.oracle.distance_m
    pilot = TourPilot([as_place(place) for place in best.places[1:]], turns=best.turns)
    again = fly(small.lot, flown(), pilot, errors=False, to_the_end=False)
    assert again.coverage >= 0.98
    assert (
        again.distance_m == small.oracle.distance_m
    )  # though the oracle flew only what its last flights had not in common


def test_equal_seeds_fly_equally(small: SeedRun) -> None:
    again = fly(small.lot, flown(), PlannerPilot())
    assert np.array_equal(again.track, small.planner.track)


def test_a_flight_that_did_not_see_enough_never_looks_short(small: SeedRun) -> None:
    poor = replace(small.planner, distance_m=None, seconds=None, coverage=0.5)
    run = replace(small, flights={**small.flights, PLANNER: poor})
    assert distance_over_oracle(run) == math.inf
    by_key = {figure.key: figure for figure in figures([run])}
    assert by_key["distance_over_oracle_median"].value is None
    assert by_key["distance_over_oracle_median"].passed is False
    assert by_key["coverage_min"].passed is False
    assert by_key["unfinished"].value == 1


def test_time_is_by_the_oracle_s_of_the_same_lot(small: SeedRun) -> None:
    slow = replace(small, flights={**small.flights, PLANNER: replace(small.planner, seconds=3 * small.oracle.seconds)})
    times = {figure.key: figure.value for figure in figures([slow])}
    assert times["seconds_over_oracle_0_3_ha_median"] == pytest.approx(3.0)


def test_the_best_distance_is_the_oracle_s_or_a_shorter_one_that_was_flown(small: SeedRun) -> None:
    slow, fast = (replace(small.planner, distance_m=small.oracle.distance_m * factor) for factor in (1.2, 0.9))
    assert replace(small, flights={PLANNER: slow}).best_distance_m == small.oracle.distance_m
    lucky = replace(small, flights={PLANNER: slow, NEAREST: fast})
    assert lucky.best_distance_m == pytest.approx(0.9 * small.oracle.distance_m)
    assert distance_over_oracle(lucky) == pytest.approx(1.2 / 0.9)


def test_a_pilot_that_knows_the_lot_sees_enough_of_it_and_ends_there(small: SeedRun) -> None:
    known = small.flights[KNOWN_LOT]
    assert known.end == "seen"
    assert known.distance_m == pytest.approx(known.whole_distance_m, abs=0.5)
    assert known.excursions == 0


def test_with_an_outline_every_place_of_it_is_seen_inside_the_fence(small: SeedRun) -> None:
    flight = small.flights[OUTLINE]
    assert flight.end == "done"
    assert flight.coverage >= 0.99
    assert flight.excursions == 0


def test_every_promised_figure_is_there(small: SeedRun) -> None:
    keys = {figure.key for figure in figures([small])}
    promised = {
        "distance_over_oracle_median", "distance_over_oracle_p90", "distance_over_nearest_frontier_median",
        "known_lot_over_oracle_median", "known_lot_over_oracle_p90", "distance_over_oracle_0_3_ha_median",
        "seconds_over_oracle_0_3_ha_median", "seconds_over_oracle_0_3_ha_p90",
        "outline_over_oracle_median", "outline_over_oracle_0_3_ha_median", "outline_whole_0_3_ha_median",
        "plan_ms_p99", "excursions", "coverage_min", "nearest_frontier_over_oracle_median",
    }  # fmt: skip
    assert promised <= keys
    (row,) = rows([small])
    assert row["planner"]["distance_m"] == pytest.approx(small.planner.distance_m, abs=0.1)
    assert json.dumps(row)


def test_tours_are_kept_and_not_computed_again(small: SeedRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "tours.json"
    TourCache(path).keep(small.lot, flown(), small.oracle)
    monkeypatch.setattr("benchmarks.exploration.tour_cache.best_tour", None)
    assert TourCache(path).tour(small.lot, flown()).distance_m == pytest.approx(small.oracle.distance_m, abs=0.01)
    unwritten = tmp_path / "unwritten.json"
    TourCache(unwritten, writes=False).keep(small.lot, flown(), small.oracle)
    assert not unwritten.exists()


def test_workers_find_what_one_process_finds(small: SeedRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(campaign, "ProcessPoolExecutor", ThreadPoolExecutor)
    monkeypatch.setattr(campaign, "_one", lambda seed, tours: small)
    path = tmp_path / "tours.json"
    assert campaign.fly_all([3, 4], path, 2) == [small, small]
    assert TourCache(path).tour(small.lot, flown()).distance_m == pytest.approx(small.oracle.distance_m, abs=0.01)


def test_the_command_writes_json(
    small: SeedRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(command, "fly_all", lambda seeds, tours, workers: [small] * len(seeds))
    out = tmp_path / "out" / "exploration.json"
    assert command.main(["--seeds", "3-4", "--json", str(out)]) == 0
    values = json.loads(out.read_text())
    assert values["excursions"] == 0
    assert len(values["flights"]) == 2
    assert "distance by oracle, median" in capsys.readouterr().out


def test_among_all_benchmarks_the_keys_do_not_clash(small: SeedRun, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(campaign, "fly_all", lambda seeds, tours, workers: [small])
    assert {"exploration_excursions", "exploration_distance_over_oracle_median"} <= {
        f.key for f in campaign.measure([3])
    }
