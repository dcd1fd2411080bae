"""Flies the planner over a seed's lot, with and without the lot's outline, beside the oracle's tour."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.exploration.flight import Flown, PlannerPilot, fly
from benchmarks.exploration.lots import Lot
from benchmarks.exploration.setups import Setup
from benchmarks.exploration.tours import OracleTour


@dataclass(frozen=True, slots=True)
class SeedRun:
    """All flights over one lot; ``bound`` is the least distance, metres.

    ``planner`` is the planner's flight as it begins anywhere, ``outline`` that with the lot's border as the outline.
    """

    lot: Lot
    bound: float
    oracle: OracleTour
    planner: Flown
    outline: Flown

    @property
    def best_distance_m(self) -> float:
        """The shortest distance known over this lot, metres: the oracle's, or a shorter one of the planner."""
        flown = (flight.distance_m for flight in (self.planner, self.outline))
        return min([self.oracle.distance_m, *(distance for distance in flown if distance is not None)])


def run_seed(setup: Setup, seed: int, tour: OracleTour) -> SeedRun:
    """Fly the planner over a seed's lot to its own end, with errors of position and map."""
    lot = setup.lot(seed)
    planner, outline = (fly(lot, setup, PlannerPilot(ground)) for ground in (None, lot.outline))
    return SeedRun(lot, setup.bound(lot.area), tour, planner, outline)
