"""Flies many seeds of a set-up, in one process or several."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Final

import cv2

from benchmarks.exploration import setups
from benchmarks.exploration.report import distance_over_oracle, figures, prefixed
from benchmarks.exploration.runs import SeedRun, run_seed
from benchmarks.exploration.tours import OracleTour, read_tours
from benchmarks.figures import BenchmarkError, Figure

SETUPS: Final = {"flown": setups.flown}


def measure(seeds: Sequence[int]) -> list[Figure]:
    """Return the figures of a few seeds, for the table of all benchmarks. Raises BenchmarkError."""
    return prefixed(figures(fly_all("flown", seeds, 1)))


def fly_all(name: str, seeds: Sequence[int], workers: int) -> list[SeedRun]:
    """Fly every seed of a set-up. Raises BenchmarkError for one whose lot has no tour."""
    tours = read_tours(SETUPS[name]())
    if missing := [str(seed) for seed in seeds if seed not in tours]:
        known = f"{min(tours)}-{max(tours)}"
        raise BenchmarkError(f"seeds {', '.join(missing)}: no tour is known over their lots; name some of {known}")
    wanted = [(name, seed, tours[seed]) for seed in seeds]
    if workers <= 1:
        return [_one(*each) for each in wanted]
    with ProcessPoolExecutor(min(workers, os.cpu_count() or 1)) as pool:
        return list(pool.map(_one, *zip(*wanted, strict=True)))


def _one(name: str, seed: int, tour: OracleTour) -> SeedRun:
    cv2.setNumThreads(1)
    run = run_seed(SETUPS[name](), seed, tour)
    ratio = distance_over_oracle(run)
    result = "not all seen" if math.isinf(ratio) else f"{ratio:.3f} of the best {run.best_distance_m:.0f} m"
    print(f"{name} {seed} ({run.lot.kind}, {run.lot.area / 1e4:.1f} ha): {result}", file=sys.stderr, flush=True)
    return run
