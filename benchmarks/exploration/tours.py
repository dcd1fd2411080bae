"""The best tours known over the lots: what a planner could fly at best if it knew the border before.

They come with the benchmark (``tours-SETUP.json``). Lines to and fro in many directions were annealed with the whole
truth, flown, changed a little and flown again, without fence and errors (`benchmarks.exploration.oracle` of commit
1c8c3325): they are meant to be hard to beat. A set-up of another version has none.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from benchmarks.exploration.setups import Setup
from benchmarks.figures import BenchmarkError
from hawk.algo.ground import Floats

SEARCH: Final = 6
"""Version of the search that made them."""


@dataclass(frozen=True, slots=True)
class OracleTour:
    """``places`` (K, 2) as flown, the start first; distance (metres) and seconds until the lot was seen."""

    places: Floats
    distance_m: float
    seconds: float


def read_tours(setup: Setup) -> dict[int, OracleTour]:
    """Return the tours of a set-up by seed. Raises BenchmarkError where none was made for it."""
    begin = f"{setup.name}.{setup.version}.{SEARCH}."
    kept = json.loads(Path(__file__).with_name(f"tours-{setup.name}.json").read_text(encoding="utf-8"))
    found = {
        int(key.removeprefix(begin)): OracleTour(np.array(tour["places"]), tour["distance_m"], tour["seconds"])
        for key, tour in kept.items()
        if key.startswith(begin)
    }
    if not found:
        raise BenchmarkError(f"no tours come with set-up {setup.name}, version {setup.version}")
    return found
