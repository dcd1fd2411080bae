"""From flights to figures: ratios by seed, their medians and 90th percentiles, one table and one JSON object."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from benchmarks.exploration.flight import Flown
from benchmarks.exploration.runs import KNOWN_LOT, NEAREST, OUTLINE, PLANNER, SeedRun
from benchmarks.figures import Figure, Limit

_TARGETS: Final[dict[str, Limit]] = {
    "distance_over_oracle_median": Limit(highest=1.10),
    "distance_over_oracle_p90": Limit(highest=1.25),
    "distance_over_nearest_frontier_median": Limit(highest=0.85),
    "plan_ms_p99": Limit(highest=30.0),
    "excursions": Limit(0, 0),
    "coverage_min": Limit(lowest=0.98),
}


_PREFIX: Final = "exploration_"


def prefixed(found: Iterable[Figure]) -> list[Figure]:
    """Return the figures with keys that clash with no other benchmark's."""
    return [replace(figure, key=f"{_PREFIX}{figure.key}") for figure in found]


def figures(runs: Sequence[SeedRun]) -> list[Figure]:
    """Return the figures of all flights."""
    flights = [run.planner for run in runs]
    return [
        *_distance_figures(runs),
        _figure("plan_ms_p99", "step of the planner, p99", _percentile(_plans(flights), 99), "ms"),
        _figure("plan_ms_max", "step of the planner, worst", _percentile(_plans(flights), 100), "ms"),
        _figure("excursions", "excursions, all flights", float(sum(flight.excursions for flight in flights))),
        _figure("coverage_min", "lot seen at the end, worst seed", min(flight.coverage for flight in flights)),
        _figure("unfinished", "ended with less than 98 % seen", float(sum(f.distance_m is None for f in flights))),
        _figure("not_done", "did not end by itself", float(sum(f.end != "done" for f in flights))),
    ]


def _distance_figures(runs: Sequence[SeedRun]) -> list[Figure]:
    oracle = [run.best_distance_m for run in runs]
    distances = _distances(runs, PLANNER)
    nearest = _distances(runs, NEAREST)
    seconds = _seconds(runs)
    return [
        _figure("lots", "lots of 0.3, 1 and 3 ha", float(len(runs))),
        *_spread("distance_over_oracle", "distance by oracle", _ratios(distances, oracle)),
        *_by_size(runs),
        *_spread(
            "known_lot_over_oracle", "lot known, distance by oracle", _ratios(_distances(runs, KNOWN_LOT), oracle)
        ),
        *_spread("outline_over_oracle", "outline, distance by oracle", _ratios(_distances(runs, OUTLINE), oracle)),
        *_spread("distance_over_nearest_frontier", "distance by nearest frontier", _ratios(distances, nearest)),
        *_spread(f"{NEAREST}_over_oracle", "nearest frontier by oracle", _ratios(nearest, oracle)),
        *_spread("seconds_over_oracle", "time by oracle's", _ratios(seconds, [run.oracle.seconds for run in runs])),
        *_spread("flown_distance_over_bound", "distance by bound", _ratios(distances, [run.bound for run in runs])),
        *_spread("flown_oracle_over_bound", "oracle by bound", _ratios(oracle, [run.bound for run in runs])),
        *_spread(
            "whole_distance_over_distance", "distance to its own end by distance", _ratios(_whole(runs), distances)
        ),
        _figure("seconds_median", "time, median", _percentile(seconds, 50), "s"),
        _figure("distance_median", "distance, median", _percentile(distances, 50), "m"),
    ]


def _by_size(runs: Sequence[SeedRun]) -> list[Figure]:
    """Return the figures of each size of lots, of the planner by itself and with the outline."""
    found = []
    for hectares in sorted({round(run.lot.area / 1e4, 1) for run in runs}):
        those = [run for run in runs if round(run.lot.area / 1e4, 1) == hectares]
        name, size = f"{hectares:g}_ha".replace(".", "_"), f"{hectares:g} ha"
        best = [run.best_distance_m for run in those]
        times = _ratios(_seconds(those), [run.oracle.seconds for run in those])
        outlined = _ratios(_distances(those, OUTLINE), best)
        whole = _ratios([run.flights[OUTLINE].whole_distance_m for run in those], best)
        distances = [distance_over_oracle(run) for run in those]
        found += _spread(f"distance_over_oracle_{name}", f"distance by oracle, {size}", distances)
        found += _spread(f"seconds_over_oracle_{name}", f"time by oracle's, {size}", times)
        found += _spread(f"outline_over_oracle_{name}", f"outline, {size}", outlined)
        found += _spread(f"outline_whole_{name}", f"outline, to its end, {size}", whole)
    return found


def _seconds(runs: Sequence[SeedRun]) -> list[float]:
    """Return the planner's times to 98 % of the lot, infinite where it never saw so much."""
    return [math.inf if run.planner.seconds is None else run.planner.seconds for run in runs]


def rows(runs: Iterable[SeedRun]) -> list[dict[str, Any]]:
    """Return one JSON object a seed: lot, bound, oracle, and distance and time of every pilot."""
    return [
        {
            "seed": run.lot.seed,
            "kind": run.lot.kind,
            "area_m2": round(run.lot.area),
            "bound_m": round(run.bound, 1),
            "best_distance_m": round(run.best_distance_m, 1),
            "oracle": {"distance_m": round(run.oracle.distance_m, 1), "seconds": round(run.oracle.seconds, 1)},
            **{name: _row(flight) for name, flight in run.flights.items()},
        }
        for run in runs
    ]


def distance_over_oracle(run: SeedRun) -> float:
    """Return the planner's distance by the shortest known one, infinite when it did not show enough."""
    return math.inf if run.planner.distance_m is None else run.planner.distance_m / run.best_distance_m


def _row(flight: Flown) -> dict[str, Any]:
    return {
        "distance_m": None if flight.distance_m is None else round(flight.distance_m, 1),
        "seconds": None if flight.seconds is None else round(flight.seconds, 1),
        "whole_distance_m": round(flight.whole_distance_m, 1),
        "whole_seconds": round(flight.whole_seconds, 1),
        "coverage": round(flight.coverage, 4),
        "excursions": flight.excursions,
        "end": flight.end,
        "plan_ms_p99": round(float(np.percentile(flight.plan_ms, 99)), 2),
    }


def _distances(runs: Sequence[SeedRun], name: str) -> list[float]:
    """Return the distances until enough was seen.

    The planner's is infinite when it never was. A rule that ended early gets the distance it flew, which flatters it.
    """
    short = math.inf if name == PLANNER else None
    distances = []
    for run in runs:
        flight = run.flights[name]
        distances.append(
            flight.distance_m if flight.distance_m is not None else flight.whole_distance_m if short is None else short
        )
    return distances


def _whole(runs: Sequence[SeedRun]) -> list[float]:
    return [run.planner.whole_distance_m for run in runs]


def _ratios(distances: Sequence[float], references: Sequence[float]) -> list[float]:
    return [distance / reference for distance, reference in zip(distances, references, strict=True) if reference > 0]


def _plans(flights: Iterable[Flown]) -> list[float]:
    return [float(ms) for flight in flights for ms in flight.plan_ms]


def _spread(key: str, text: str, ratios: Sequence[float]) -> list[Figure]:
    return [
        _figure(f"{key}_median", f"{text}, median", _percentile(ratios, 50)),
        _figure(f"{key}_p90", f"{text}, p90", _percentile(ratios, 90)),
    ]


def _figure(key: str, text: str, value: float, unit: str = "") -> Figure:
    return Figure(key, text, value if math.isfinite(value) else None, unit, limit=_TARGETS.get(key))


def _percentile(values: Sequence[float], share: float) -> float:
    """Return a percentile, endless as soon as one of its neighbours is."""
    return float(np.percentile(values, share, method="higher" if np.isinf(values).any() else "linear"))
