"""Flies every pilot over a seed's lot and keeps what came of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from benchmarks.exploration.flight import WANTED, Flown, Pilot, fly
from benchmarks.exploration.lots import Lot
from benchmarks.exploration.oracle import shortened
from benchmarks.exploration.pilots import GainByDistance, MExplore, NearestFrontier, PlannerPilot, RulePilot
from benchmarks.exploration.polish import OracleTour
from benchmarks.exploration.setups import Setup
from benchmarks.exploration.surveyed import KnownLotMap
from benchmarks.exploration.tour_cache import TourCache
from hawk.algo.path_plan.settings import PathPlanSettings

PLANNER: Final = "planner"
KNOWN_LOT: Final = "known_lot"
"""The planner over a known lot, without errors: the price of its search alone."""
KNOWN_LOT_SETTINGS: Final = PathPlanSettings(first_spare=0.05, border=0.0, turn_m=0.0, leg_m=0.0, near_lot_m=25.0)
"""Settings for a known lot: nothing is looked for beside it, and it may be left for a while."""
OUTLINE: Final = "outline"
"""The planner as the flight has it with an outline: the lot as it is, positions and map with their errors."""
NEAREST: Final = "nearest_frontier"
BASELINES: Final[Mapping[str, Callable[[Setup], Pilot]]] = {
    NEAREST: lambda _: RulePilot(NearestFrontier()),
    "m_explore": lambda _: RulePilot(MExplore()),
    "gain_by_distance": lambda setup: RulePilot(GainByDistance(math.sqrt(setup.footprint_area))),
}
_NEARLY: Final = 1.1
"""The oracle's search begins with paths that are no longer than this multiple of its own."""


@dataclass(frozen=True, slots=True)
class SeedRun:
    """All flights over one lot; ``bound`` is the least distance, metres."""

    lot: Lot
    bound: float
    oracle: OracleTour
    flights: Mapping[str, Flown]

    @property
    def best_distance_m(self) -> float:
        """The shortest distance known over this lot, metres: the oracle's, or a shorter one of another pilot."""
        return min(
            [
                self.oracle.distance_m,
                *(flight.distance_m for flight in self.flights.values() if flight.distance_m is not None),
            ]
        )

    @property
    def planner(self) -> Flown:
        """The planner's own flight."""
        return self.flights[PLANNER]


def run_seed(setup: Setup, seed: int, tours: TourCache, *, shorten: bool = False) -> SeedRun:
    """Fly the planner to its own end and the others until enough was seen.

    ``shorten``: the oracle's search begins with their paths as well.
    """
    lot = setup.lot(seed)
    flights = {PLANNER: fly(lot, setup, PlannerPilot(is_disc=setup.is_disc))}
    if not setup.is_disc:
        flights[KNOWN_LOT] = fly_known_lot(lot, setup)
        flights[OUTLINE] = fly_outline(lot, setup)
    for name, pilot in BASELINES.items():
        flights[name] = fly(lot, setup, pilot(setup), to_the_end=False)
    oracle = tours.tour(lot, setup)
    if shorten:
        oracle = _shortened(lot, setup, oracle, flights.values())
        tours.keep(lot, setup, oracle)
    return SeedRun(lot, setup.bound(lot.area), oracle, flights)


def _shortened(lot: Lot, setup: Setup, oracle: OracleTour, flights: Iterable[Flown]) -> OracleTour:
    """Begin with the paths that are not much longer than the oracle's."""
    short = [
        one.track for one in flights if one.distance_m is not None and one.distance_m < _NEARLY * oracle.distance_m
    ]
    tracks = [track[: int(np.searchsorted(track[:, 2], WANTED)) + 1, :2] for track in short]
    return shortened(lot, setup, oracle, tracks, WANTED)


def fly_known_lot(lot: Lot, setup: Setup) -> Flown:
    """Fly the planner over a known lot, without errors, until enough was seen; by the camera's picture."""
    return fly(
        lot, setup, PlannerPilot(settings=KNOWN_LOT_SETTINGS), errors=False, to_the_end=False, survey=KnownLotMap
    )


def fly_outline(lot: Lot, setup: Setup) -> Flown:
    """Fly the planner over the lot's own outline, with errors of position and map, until it is done by itself."""
    return fly(lot, setup, PlannerPilot(ground=lot.outline))
