"""Flies many seeds of a set-up, in one process or several."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Final

import cv2

from benchmarks.exploration import setups
from benchmarks.exploration.report import distance_over_oracle, figures, prefixed
from benchmarks.exploration.runs import SeedRun, run_seed
from benchmarks.exploration.tour_cache import TourCache, shipped
from benchmarks.figures import Figure

SETUPS: Final = {"flown": setups.flown, "prototype": setups.prototype}


def measure(seeds: Sequence[int]) -> list[Figure]:
    """Return the figures of a few seeds, for the table of all benchmarks."""
    return prefixed(figures(fly_all("flown", seeds, None, 1), fly_all("prototype", seeds, None, 1)))


def fly_all(
    name: str, seeds: Sequence[int], tours: Path | None, workers: int, *, shorten: bool = False
) -> list[SeedRun]:
    """Fly every seed of a set-up. ``tours`` names the files that keep the oracle's tours; None: those that come with
    the benchmark. ``shorten``: look for shorter ones that begin with the flights of the other pilots.
    """
    if tours is None:
        cache = shipped(name)
    else:
        cache = TourCache(tours.with_name(f"{tours.stem}-{name}{tours.suffix or '.json'}"))
    if workers <= 1:
        return [_one(name, seed, cache, shorten) for seed in seeds]
    found = []
    with ProcessPoolExecutor(min(workers, os.cpu_count() or 1)) as pool:
        one = partial(_one, name, tours=cache.read_only(), shorten=shorten)
        for run in pool.map(one, seeds):
            cache.keep(run.lot, SETUPS[name](), run.oracle)
            found.append(run)
    return found


def _one(name: str, seed: int, tours: TourCache, shorten: bool) -> SeedRun:
    cv2.setNumThreads(1)
    run = run_seed(SETUPS[name](), seed, tours, shorten=shorten)
    ratio = distance_over_oracle(run)
    result = "not all seen" if math.isinf(ratio) else f"{ratio:.3f} of the best {run.best_distance_m:.0f} m"
    print(f"{name} {seed} ({run.lot.kind}, {run.lot.area / 1e4:.1f} ha): {result}", file=sys.stderr, flush=True)
    return run
