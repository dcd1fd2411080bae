"""One small lot, flown by everyone once; each test looks at a part of it."""

from __future__ import annotations

import json
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.exploration import __main__ as command
from benchmarks.exploration import campaign
from benchmarks.exploration.flight import fly
from benchmarks.exploration.pilots import FrontierPilot, PlannerPilot
from benchmarks.exploration.report import distance_over_oracle, figures, rows
from benchmarks.exploration.runs import KNOWN_LOT, NEAREST, OUTLINE, PLANNER, SeedRun, fly_known_lot, fly_outline
from benchmarks.exploration.setups import flown
from benchmarks.exploration.tours import tour_of

pytestmark = [pytest.mark.flight, pytest.mark.nightly]


@pytest.fixture(scope="module")
def small() -> SeedRun:
    """One small lot flown by everyone."""
    return _everyone_s()


def _everyone_s() -> SeedRun:
    setup = flown()
    lot = setup.lot(3)
    flights = {PLANNER: fly(lot, setup, PlannerPilot()), KNOWN_LOT: fly_known_lot(lot, setup)}
    flights[OUTLINE] = fly_outline(lot, setup)
    flights[NEAREST] = fly(lot, setup, FrontierPilot(), to_the_end=False)
    return SeedRun(lot, setup.bound(lot.area), tour_of(lot, setup), flights)


def test_the_planner_sees_it_all_ends_by_itself_and_stays_inside(small: SeedRun) -> None:
    flight = small.planner
    assert flight.end == "done"
    assert flight.coverage >= 0.98
    assert flight.excursions == 0
    assert flight.distance_m is not None
    assert flight.distance_m <= flight.whole_distance_m
    assert small.oracle.distance_m < 2.0 * flight.distance_m


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


def test_workers_find_what_one_process_finds(small: SeedRun, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(campaign, "ProcessPoolExecutor", ThreadPoolExecutor)
    monkeypatch.setattr(campaign, "_one", lambda seed: small)
    assert campaign.fly_all([3, 4], 2) == campaign.fly_all([3, 4], 1) == [small, small]


def test_the_command_writes_json(
    small: SeedRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(command, "fly_all", lambda seeds, workers: [small] * len(seeds))
    out = tmp_path / "out" / "exploration.json"
    assert command.main(["--seeds", "3-4", "--json", str(out)]) == 0
    values = json.loads(out.read_text())
    assert values["excursions"] == 0
    assert len(values["flights"]) == 2
    assert "distance by oracle, median" in capsys.readouterr().out


def test_among_all_benchmarks_the_keys_do_not_clash(small: SeedRun, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(campaign, "fly_all", lambda seeds, workers: [small])
    assert {"exploration_excursions", "exploration_distance_over_oracle_median"} <= {
        f.key for f in campaign.measure([3])
    }
