"""From flights to figures: ratios by seed, their medians and 90th percentiles, one table and one JSON object."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from benchmarks.exploration.flight import Flown
from benchmarks.exploration.runs import BASELINES, KNOWN_LOT, NEAREST, OUTLINE, PLANNER, SeedRun
from benchmarks.figures import Figure, Limit

_TARGETS: Final[dict[str, Limit]] = {
    "way_over_oracle_median": Limit(highest=1.10),
    "way_over_oracle_p90": Limit(highest=1.25),
    "way_over_nearest_frontier_median": Limit(highest=0.85),
    "way_over_bound_median": Limit(highest=1.66),
    "oracle_over_bound_median": Limit(highest=1.60),
    "nearest_frontier_over_bound_median": Limit(highest=2.05),
    "plan_ms_p99": Limit(highest=30.0),
    "excursions": Limit(0, 0),
    "coverage_min": Limit(lowest=0.98),
}


_PREFIX: Final = "exploration_"


def prefixed(found: Iterable[Figure]) -> list[Figure]:
    """Return the figures with keys that clash with no other benchmark's."""
    return [replace(figure, key=f"{_PREFIX}{figure.key}") for figure in found]


def figures(flown: Sequence[SeedRun], prototype: Sequence[SeedRun]) -> list[Figure]:
    """Return the figures of both set-ups; one without runs is left out."""
    found: list[Figure] = []
    if flown:
        found += _of_flown(flown)
    if prototype:
        found += _of_prototype(prototype)
    both = [run.planner for run in (*flown, *prototype)]
    found += [
        _figure("plan_ms_p99", "step of the planner, p99", _percentile(_plans(both), 99), "ms"),
        _figure("plan_ms_max", "step of the planner, worst", _percentile(_plans(both), 100), "ms"),
        _figure("excursions", "excursions, all flights", float(sum(flight.excursions for flight in both))),
        _figure("coverage_min", "lot seen at the end, worst seed", min(flight.coverage for flight in both)),
        _figure("unfinished", "ended with less than 98 % seen", float(sum(f.way is None for f in both))),
        _figure("not_done", "did not end by itself", float(sum(f.end != "done" for f in both))),
    ]
    return found


def _of_flown(runs: Sequence[SeedRun]) -> list[Figure]:
    oracle = [run.best_way for run in runs]
    ways = _ways(runs, PLANNER)
    nearest = _ways(runs, NEAREST)
    seconds = _seconds(runs)
    found = [
        _figure("lots", "lots of 0.3, 1 and 3 ha", float(len(runs))),
        *_spread("way_over_oracle", "way by oracle", _ratios(ways, oracle)),
        *_by_size(runs),
        *_spread("told_over_oracle", "lot known, way by oracle", _ratios(_ways(runs, KNOWN_LOT), oracle)),
        *_spread("outline_over_oracle", "outline, way by oracle", _ratios(_ways(runs, OUTLINE), oracle)),
        *_outline_by_size(runs),
        *_spread("way_over_nearest_frontier", "way by nearest frontier", _ratios(ways, nearest)),
    ]
    for name in BASELINES:
        found += _spread(f"{name}_over_oracle", f"{name} by oracle", _ratios(_ways(runs, name), oracle))
        found += _spread(f"way_over_{name}", f"way by {name}", _ratios(ways, _ways(runs, name)))[: name != NEAREST]
    found += [
        *_spread("seconds_over_oracle", "time by oracle's", _ratios(seconds, [run.oracle.seconds for run in runs])),
        *_spread("flown_way_over_bound", "way by bound", _ratios(ways, [run.bound for run in runs])),
        *_spread("flown_oracle_over_bound", "oracle by bound", _ratios(oracle, [run.bound for run in runs])),
        *_spread("whole_way_over_way", "way to its own end by way", _ratios(_whole(runs), ways)),
        _figure("seconds_median", "time, median", _percentile(seconds, 50), "s"),
        _figure("way_median", "way, median", _percentile(ways, 50), "m"),
    ]
    return found


def _sizes(runs: Sequence[SeedRun]) -> Iterator[tuple[float, str, list[SeedRun]]]:
    """Yield hectares, their part of a key, and the runs over lots of that size."""
    for hectares in sorted({round(run.lot.area / 1e4, 1) for run in runs}):
        those = [run for run in runs if round(run.lot.area / 1e4, 1) == hectares]
        yield hectares, f"{hectares:g}".replace(".", "_"), those


def _by_size(runs: Sequence[SeedRun]) -> list[Figure]:
    found = []
    for hectares, name, those in _sizes(runs):
        ways = [way_over_oracle(run) for run in those]
        found += _spread(f"way_over_oracle_{name}_ha", f"way by oracle, {hectares:g} ha", ways)
        times = _ratios(_seconds(those), [run.oracle.seconds for run in those])
        found += _spread(f"seconds_over_oracle_{name}_ha", f"time by oracle's, {hectares:g} ha", times)
    return found


def _outline_by_size(runs: Sequence[SeedRun]) -> list[Figure]:
    found = []
    for hectares, name, those in _sizes(runs):
        best = [run.best_way for run in those]
        found += _spread(
            f"outline_over_oracle_{name}_ha", f"outline, {hectares:g} ha", _ratios(_ways(those, OUTLINE), best)
        )
        whole = [run.flights[OUTLINE].whole_way for run in those]
        found += _spread(f"outline_whole_{name}_ha", f"outline, to its end, {hectares:g} ha", _ratios(whole, best))
    return found


def _seconds(runs: Sequence[SeedRun]) -> list[float]:
    """Return the planner's times to 98 % of the lot, infinite where it never saw so much."""
    return [math.inf if run.planner.seconds is None else run.planner.seconds for run in runs]


def _of_prototype(runs: Sequence[SeedRun]) -> list[Figure]:
    bounds = [run.bound for run in runs]
    oracle = [run.best_way for run in runs]
    nearest = _ratios(_ways(runs, NEAREST), bounds)
    return [
        _figure("prototype_lots", "lots of 0.5 ha seen through a disc", float(len(runs))),
        *_spread("way_over_bound", "disc: way by bound", _ratios(_ways(runs, PLANNER), bounds)),
        *_spread("oracle_over_bound", "disc: oracle by bound", _ratios(oracle, bounds)),
        *_spread("nearest_frontier_over_bound", "disc: nearest frontier by bound", nearest),
        *_spread("prototype_way_over_oracle", "disc: way by oracle", _ratios(_ways(runs, PLANNER), oracle)),
    ]


def rows(setup: str, runs: Iterable[SeedRun]) -> list[dict[str, Any]]:
    """Return one JSON object a seed: lot, bound, oracle, and distance and time of every pilot."""
    return [
        {
            "setup": setup,
            "seed": run.lot.seed,
            "kind": run.lot.kind,
            "area_m2": round(run.lot.area),
            "bound_m": round(run.bound, 1),
            "best_way_m": round(run.best_way, 1),
            "oracle": {"way_m": round(run.oracle.way, 1), "seconds": round(run.oracle.seconds, 1)},
            **{name: _row(flight) for name, flight in run.flights.items()},
        }
        for run in runs
    ]


def way_over_oracle(run: SeedRun) -> float:
    """Return the planner's distance by the shortest known one, infinite when it did not show enough."""
    return math.inf if run.planner.way is None else run.planner.way / run.best_way


def _row(flight: Flown) -> dict[str, Any]:
    return {
        "way_m": None if flight.way is None else round(flight.way, 1),
        "seconds": None if flight.seconds is None else round(flight.seconds, 1),
        "whole_way_m": round(flight.whole_way, 1),
        "whole_seconds": round(flight.whole_seconds, 1),
        "coverage": round(flight.coverage, 4),
        "excursions": flight.excursions,
        "end": flight.end,
        "plan_ms_p99": round(float(np.percentile(flight.plan_ms, 99)), 2),
    }


def _ways(runs: Sequence[SeedRun], name: str) -> list[float]:
    """Return the distances until enough was seen.

    The planner's is infinite when it never was. A rule that gave up gets the distance it flew, which flatters it.
    """
    short = math.inf if name == PLANNER else None
    ways = []
    for run in runs:
        flight = run.flights[name]
        ways.append(flight.way if flight.way is not None else flight.whole_way if short is None else short)
    return ways


def _whole(runs: Sequence[SeedRun]) -> list[float]:
    return [run.planner.whole_way for run in runs]


def _ratios(ways: Sequence[float], references: Sequence[float]) -> list[float]:
    return [way / reference for way, reference in zip(ways, references, strict=True) if reference > 0]


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
