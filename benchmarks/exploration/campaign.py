"""Flies many seeds of a set-up, in one process or several."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import cv2

from benchmarks.exploration.report import distance_over_oracle, figures, prefixed
from benchmarks.exploration.runs import SeedRun, run_seed
from benchmarks.exploration.setups import flown
from benchmarks.exploration.tour_cache import TourCache, shipped
from benchmarks.figures import Figure


def measure(seeds: Sequence[int]) -> list[Figure]:
    """Return the figures of a few seeds, for the table of all benchmarks."""
    return prefixed(figures(fly_all(seeds, None, 1)))


def fly_all(seeds: Sequence[int], tours: Path | None, workers: int) -> list[SeedRun]:
    """Fly every seed. ``tours`` is the file that keeps the oracle's tours; None: those that come with the benchmark."""
    cache = shipped(flown().name) if tours is None else TourCache(tours)
    if workers <= 1:
        return [_one(seed, cache) for seed in seeds]
    found = []
    with ProcessPoolExecutor(min(workers, os.cpu_count() or 1)) as pool:
        one = partial(_one, tours=cache.read_only())
        for run in pool.map(one, seeds):
            cache.keep(run.lot, flown(), run.oracle)
            found.append(run)
    return found


def _one(seed: int, tours: TourCache) -> SeedRun:
    cv2.setNumThreads(1)
    run = run_seed(flown(), seed, tours)
    ratio = distance_over_oracle(run)
    result = "not all seen" if math.isinf(ratio) else f"{ratio:.3f} of the best {run.best_distance_m:.0f} m"
    print(f"{seed} ({run.lot.kind}, {run.lot.area / 1e4:.1f} ha): {result}", file=sys.stderr, flush=True)
    return run
