"""Flies every pilot over a seed's lot and keeps what came of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from benchmarks.exploration.flight import Flown, fly
from benchmarks.exploration.lots import Lot
from benchmarks.exploration.pilots import FrontierPilot, PlannerPilot
from benchmarks.exploration.setups import Setup
from benchmarks.exploration.surveyed import KnownLotMap
from benchmarks.exploration.tours import OracleTour, tour_of
from hawk.algo.path_plan.settings import PathPlanSettings

PLANNER: Final = "planner"
KNOWN_LOT: Final = "known_lot"
"""The planner over a known lot, without errors: the price of its search alone."""
KNOWN_LOT_SETTINGS: Final = PathPlanSettings(first_spare=0.05, border=0.0, turn_m=0.0, leg_m=0.0, near_lot_m=25.0)
"""Settings for a known lot: nothing is looked for beside it, and it may be left for a while."""
OUTLINE: Final = "outline"
"""The planner as the flight has it with an outline: the lot as it is, positions and map with their errors."""
NEAREST: Final = "nearest_frontier"
"""A simple rule: the nearest cell between what is known and what is not."""


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


def run_seed(setup: Setup, seed: int) -> SeedRun:
    """Fly the planner to its own end and the others until enough was seen."""
    lot = setup.lot(seed)
    flights = {
        PLANNER: fly(lot, setup, PlannerPilot()),
        KNOWN_LOT: fly_known_lot(lot, setup),
        OUTLINE: fly_outline(lot, setup),
        NEAREST: fly(lot, setup, FrontierPilot(), to_the_end=False),
    }
    return SeedRun(lot, setup.bound(lot.area), tour_of(lot, setup), flights)


def fly_known_lot(lot: Lot, setup: Setup) -> Flown:
    """Fly the planner over a known lot, without errors, until enough was seen; by the camera's picture."""
    return fly(
        lot, setup, PlannerPilot(settings=KNOWN_LOT_SETTINGS), errors=False, to_the_end=False, survey=KnownLotMap
    )


def fly_outline(lot: Lot, setup: Setup) -> Flown:
    """Fly the planner over the lot's own outline, with errors of position and map, until it is done by itself."""
    return fly(lot, setup, PlannerPilot(ground=lot.outline))
