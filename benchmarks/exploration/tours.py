"""The oracle's tours: the shortest flights found over the known lots, without fence and errors.

Each was searched for over its known lot, flown, changed a little and flown again; turns on the spot where it begins and
ends cost nothing. The search is that of commit 74223f37; its tours are kept in ``tours.json``.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.exploration.lots import Lot
from benchmarks.exploration.setups import Setup
from benchmarks.figures import BenchmarkError
from hawk.algo.ground import Floats

_FILE: Final = Path(__file__).with_name("tours.json")
_SEARCH: Final = 6
"""Version of the search."""


@dataclass(frozen=True, slots=True)
class OracleTour:
    """``places`` (K, 2) as flown, the start first; distance (metres) and seconds until the lot was seen."""

    places: Floats
    distance_m: float
    seconds: float


def tour_of(lot: Lot, setup: Setup) -> OracleTour:
    """Return the tour of a lot. Raises BenchmarkError for one that was never searched for, or another set-up's."""
    kept = _tours().get(f"{setup.name}.{setup.version}.{_SEARCH}.{lot.seed}")
    if kept is None:
        raise BenchmarkError(f"no tour over the lot of seed {lot.seed} is kept: take 1 to 200")
    return OracleTour(np.array(kept["places"]), kept["distance_m"], kept["seconds"])


@cache
def _tours() -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = json.loads(_FILE.read_text(encoding="utf-8"))
    return found
