"""Keeps the oracle's tours between runs: nothing else takes so long.

Tours of many lots come with the benchmark (``tours-SETUP.json``, as `python -m benchmarks.exploration --tours` wrote
them). One made by an older search, or over other lots, has another key and is not used.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.exploration.flight import WANTED
from benchmarks.exploration.lots import Lot
from benchmarks.exploration.oracle import VERSION, best_tour
from benchmarks.exploration.polish import OracleTour
from benchmarks.exploration.setups import Setup


def shipped(setup: str) -> TourCache:
    """Return the tours over a set-up's lots that come with the benchmark; others are made again, and not kept."""
    return TourCache(Path(__file__).with_name(f"tours-{setup}.json"), writes=False)


class TourCache:
    """Keeps tours in a file, by set-up, versions and seed: what this program computed before."""

    def __init__(self, path: Path | None, *, writes: bool = True) -> None:
        """``writes`` False reads the file only: for one of several processes."""
        self._path = path
        self._writes = writes
        self._known: dict[str, dict[str, Any]] = {}
        if path is not None and path.exists():
            kept = json.loads(path.read_text(encoding="utf-8"))
            self._known = {key: tour for key, tour in kept.items() if "distance_m" in tour}

    def read_only(self) -> TourCache:
        """Return the same, to be read by one of several processes."""
        return TourCache(self._path, writes=False)

    def tour(self, lot: Lot, setup: Setup) -> OracleTour:
        """Return the tour of a lot, from the file if it is there."""
        key = _key(lot, setup)
        if key not in self._known:
            self._keep(key, best_tour(lot, setup, WANTED))
        kept = self._known[key]
        return OracleTour(np.array(kept["places"]), kept["distance_m"], kept["seconds"])

    def keep(self, lot: Lot, setup: Setup, tour: OracleTour) -> None:
        """Take a tour of another process."""
        self._keep(_key(lot, setup), tour)

    def _keep(self, key: str, tour: OracleTour) -> None:
        places = np.round(tour.places, 2).tolist()
        self._known[key] = {
            "places": places,
            "distance_m": round(tour.distance_m, 2),
            "seconds": round(tour.seconds, 2),
        }
        if self._path is not None and self._writes:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            lines = [f"{json.dumps(name)}: {json.dumps(tour)}" for name, tour in self._known.items()]
            self._path.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def _key(lot: Lot, setup: Setup) -> str:
    return f"{setup.name}.{setup.version}.{VERSION}.{lot.seed}"
