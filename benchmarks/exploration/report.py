"""From flights to figures: ratios by seed, their medians and 90th percentiles, one table and one JSON object."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from benchmarks.exploration.flight import Flown
from benchmarks.exploration.runs import SeedRun
from benchmarks.figures import Figure, Limit

_TARGETS: Final[dict[str, Limit]] = {
    "distance_over_oracle_median": Limit(highest=1.10),
    "distance_over_oracle_p90": Limit(highest=1.25),
    "plan_ms_p99": Limit(highest=30.0),
    "excursions": Limit(0, 0),
    "coverage_min": Limit(lowest=0.98),
}


_PREFIX: Final = "exploration_"


def prefixed(found: Iterable[Figure]) -> list[Figure]:
    """Return the figures with keys that clash with no other benchmark's."""
    return [replace(figure, key=f"{_PREFIX}{figure.key}") for figure in found]


def figures(runs: Sequence[SeedRun]) -> list[Figure]:
    """Return the figures of all runs together."""
    flights = [run.planner for run in runs]
    plan_ms = [float(ms) for flight in flights for ms in flight.plan_ms]
    return [
        _figure("lots", "lots of 0.3, 1 and 3 ha", float(len(runs))),
        *_of_planner(runs, ""),
        *_of_outline(runs, ""),
        *(figure for name, words, those in _sizes(runs) for figure in _of_planner(those, name, words)[:4]),
        *(figure for name, words, those in _sizes(runs) for figure in _of_outline(those, name, words)),
        _figure("plan_ms_p99", "step of the planner, p99", _percentile(plan_ms, 99), "ms"),
        _figure("plan_ms_max", "step of the planner, worst", _percentile(plan_ms, 100), "ms"),
        _figure("excursions", "excursions, all flights", float(sum(flight.excursions for flight in flights))),
        _figure("coverage_min", "lot seen at the end, worst seed", min(flight.coverage for flight in flights)),
        _figure("unfinished", "ended with less than 98 % seen", float(sum(f.distance_m is None for f in flights))),
        _figure("not_done", "did not end by itself", float(sum(f.end != "done" for f in flights))),
    ]


def _of_planner(runs: Sequence[SeedRun], name: str, words: str = "") -> list[Figure]:
    """Return the planner's figures; ``name`` ends their keys and ``words`` their texts."""
    distances = [_distance(run.planner) for run in runs]
    seconds = [math.inf if run.planner.seconds is None else run.planner.seconds for run in runs]
    oracle, bounds = [run.best_distance_m for run in runs], [run.bound for run in runs]
    whole = [run.planner.whole_distance_m for run in runs]
    return [
        *_spread(f"distance_over_oracle{name}", f"distance by oracle{words}", _ratios(distances, oracle)),
        *_spread(
            f"seconds_over_oracle{name}", f"time by oracle's{words}",
            _ratios(seconds, [run.oracle.seconds for run in runs]),
        ),
        *_spread(f"flown_distance_over_bound{name}", f"distance by bound{words}", _ratios(distances, bounds)),
        *_spread(f"flown_oracle_over_bound{name}", f"oracle by bound{words}", _ratios(oracle, bounds)),
        *_spread(
            f"whole_distance_over_distance{name}", f"distance to its own end by distance{words}",
            _ratios(whole, distances),
        ),
        _figure(f"seconds_median{name}", f"time{words}, median", _percentile(seconds, 50), "s"),
        _figure(f"distance_median{name}", f"distance{words}, median", _percentile(distances, 50), "m"),
    ]  # fmt: skip


def _of_outline(runs: Sequence[SeedRun], name: str, words: str = "") -> list[Figure]:
    """Return the figures of the flights with an outline, as `_of_planner`."""
    best = [run.best_distance_m for run in runs]
    distances = [_distance(run.outline) for run in runs]
    whole = [run.outline.whole_distance_m for run in runs]
    return [
        *_spread(f"outline_over_oracle{name}", f"outline, distance by oracle{words}", _ratios(distances, best)),
        *_spread(f"outline_whole{name}", f"outline, to its end{words}", _ratios(whole, best)),
    ]


def _sizes(runs: Sequence[SeedRun]) -> Iterator[tuple[str, str, list[SeedRun]]]:
    """Yield the ends of keys and texts, and the runs, of each size of lots."""
    for hectares in sorted({round(run.lot.area / 1e4, 1) for run in runs}):
        those = [run for run in runs if round(run.lot.area / 1e4, 1) == hectares]
        yield f"_{hectares:g}_ha".replace(".", "_"), f", {hectares:g} ha", those


def rows(setup: str, runs: Iterable[SeedRun]) -> list[dict[str, Any]]:
    """Return one JSON object a seed: lot, bound, oracle, and distance and time of both flights."""
    return [
        {
            "setup": setup,
            "seed": run.lot.seed,
            "kind": run.lot.kind,
            "area_m2": round(run.lot.area),
            "bound_m": round(run.bound, 1),
            "best_distance_m": round(run.best_distance_m, 1),
            "oracle": {"distance_m": round(run.oracle.distance_m, 1), "seconds": round(run.oracle.seconds, 1)},
            "planner": _row(run.planner),
            "outline": _row(run.outline),
        }
        for run in runs
    ]


def distance_over_oracle(run: SeedRun) -> float:
    """Return the planner's distance by the shortest known one, infinite when it did not show enough."""
    return _distance(run.planner) / run.best_distance_m


def _distance(flight: Flown) -> float:
    """Return the distance until enough was seen, infinite when it never was."""
    return math.inf if flight.distance_m is None else flight.distance_m


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


def _ratios(distances: Sequence[float], references: Sequence[float]) -> list[float]:
    return [distance / reference for distance, reference in zip(distances, references, strict=True) if reference > 0]


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
