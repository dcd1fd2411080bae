"""Flies tours over one lot that differ little from each other: the part that two have in common is flown once.

A pilot looks no farther than its next waypoint, so a tour goes on from the last stage of an earlier flight at which
both had the same waypoints behind and before them.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from benchmarks.exploration.flight import Stage, fly
from benchmarks.exploration.lots import Lot
from benchmarks.exploration.pilots import Place, TourPilot
from benchmarks.exploration.polish import OracleTour
from benchmarks.exploration.setups import Setup
from hawk.algo.ground import Floats
from hawk.algo.path_plan.tour import as_place

_KEPT_FRAMES: Final = 4
_TRACK_STEP: Final = 4

_Kept = tuple[TourPilot, Stage]


class TourFlights:
    """Flights over one lot without errors, each until enough of it was seen."""

    def __init__(self, lot: Lot, setup: Setup, *, turns: bool) -> None:
        """``turns``: the drone turns on the spot before and after a tour."""
        self._lot, self._setup, self._turns = lot, setup, turns
        self._least = math.inf
        self._tour: list[Place] = []
        self._stages: list[_Kept] = []

    def fly(self, places: Floats) -> OracleTour | None:
        """Fly a tour (K, 2), the start first; None when it does not show enough. The shortest so far is kept."""
        tour = [as_place(place) for place in places[1:]]
        kept = self._stages[: self._alike(tour)]
        stage, pilot = None, TourPilot(tour, turns=self._turns)
        if kept:
            before, last = kept.pop()
            stage, pilot = last.copy(), replace(before, tour=tour)

        def watch(now: Stage) -> None:
            if len(now.track) % _KEPT_FRAMES == 0:
                kept.append((replace(pilot), now.copy()))

        flight = fly(
            self._lot, self._setup, pilot, errors=False, to_the_end=False, maps=False, stage=stage, watch=watch
        )
        if flight.distance_m is None or flight.seconds is None:
            return None
        if flight.distance_m < self._least:
            self._least, self._tour, self._stages = flight.distance_m, tour, kept
        return OracleTour(flight.track[::_TRACK_STEP, :2], flight.distance_m, flight.seconds)

    def _alike(self, tour: list[Place]) -> int:
        """Return how many of the kept stages the tour goes through as well: a pilot knows the next waypoint, and
        whether it is the last.
        """
        pairs = enumerate(zip(tour, self._tour, strict=False))
        differs = next((number for number, (one, other) in pairs if one != other), min(len(tour), len(self._tour)))
        latest = min(differs - 1, len(tour) - 2, len(self._tour) - 2)
        return sum(pilot.next <= latest for pilot, _ in self._stages)
