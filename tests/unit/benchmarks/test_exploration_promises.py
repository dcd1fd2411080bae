"""A flight shows what the search for tours expects."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from benchmarks.exploration.flight import fly
from benchmarks.exploration.lots import Lot
from benchmarks.exploration.pilots import TourPilot
from benchmarks.exploration.setups import Setup, flown
from hawk.algo.path_plan.footprint import Footprint
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.tour import Terms, Tour, Wanted, as_place

CELL_M = 1.5
SWEEPS = 60


def searched(lot: Lot, setup: Setup, share: float) -> Tour:
    """The shortest tour found that promises so much of the lot; turns cost nothing, so it uses every corner."""
    north_0, east_0, north_1, east_1 = lot.shape.bounds
    grid = np.meshgrid(np.arange(north_0, north_1, CELL_M), np.arange(east_0, east_1, CELL_M), indexing="ij")
    cells = np.column_stack([axis.ravel() for axis in grid])
    cells = cells[shapely.contains_xy(lot.shape, cells)].astype(np.float32)
    weights = np.full(len(cells), CELL_M**2, np.float32)
    wanted = Wanted(cells, weights, (1 - share) * float(weights.sum()))
    terms = Terms(Footprint.of(setup.swath, PathPlanSettings()), short_by=12.0, trials=24, turned_first=True)
    tour = Tour(terms, wanted, np.array([lot.start]), None, np.random.default_rng(1))
    for sweep in range(SWEEPS):
        heat = 6.0 * (0.02 ** (sweep / SWEEPS))
        tour.sweep(1.2 + heat, heat)
    return tour


@pytest.mark.flight
@pytest.mark.parametrize("seed", [6, 18, 27])
@pytest.mark.nightly
def test_a_flight_shows_what_its_tour_promises(seed: int) -> None:
    setup = flown()
    lot = setup.lot(seed)
    tour = searched(lot, setup, 0.97)
    pilot = TourPilot([as_place(place) for place in tour.places[1:]], turns=True)
    flight = fly(lot, setup, pilot, errors=False, maps=False)
    assert flight.end == "done"
    assert flight.coverage >= 1 - tour.missing / lot.area
