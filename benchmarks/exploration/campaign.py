"""Flies many seeds of a set-up, in one process or several."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor

import cv2

from benchmarks.exploration.report import distance_over_oracle, figures, prefixed
from benchmarks.exploration.runs import SeedRun, run_seed
from benchmarks.exploration.setups import flown
from benchmarks.figures import Figure


def measure(seeds: Sequence[int]) -> list[Figure]:
    """Return the figures of a few seeds, for the table of all benchmarks."""
    return prefixed(figures(fly_all(seeds, 1)))


def fly_all(seeds: Sequence[int], workers: int) -> list[SeedRun]:
    """Fly every seed. Raises BenchmarkError for one without a tour of the oracle."""
    if workers <= 1:
        return [_one(seed) for seed in seeds]
    with ProcessPoolExecutor(min(workers, os.cpu_count() or 1)) as pool:
        return list(pool.map(_one, seeds))


def _one(seed: int) -> SeedRun:
    cv2.setNumThreads(1)
    run = run_seed(flown(), seed)
    ratio = distance_over_oracle(run)
    result = "not all seen" if math.isinf(ratio) else f"{ratio:.3f} of the best {run.best_distance_m:.0f} m"
    print(f"{seed} ({run.lot.kind}, {run.lot.area / 1e4:.1f} ha): {result}", file=sys.stderr, flush=True)
    return run
