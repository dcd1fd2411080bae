"""The site of the benchmark of rounds: drawn lots as plans, one fence about them, and the path home."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from benchmarks.known_flight import KnownFlight, SeenMap
from benchmarks.round import APART_M, HOME, drawn_lot, site_of, with_path_home
from hawk.model.known_lot import KnownLot
from tests.unit.algo.synthetic import CAMERA


@pytest.fixture(scope="module")
def lots() -> tuple[KnownLot, KnownLot]:
    return drawn_lot(1, (0.0, 0.0)), drawn_lot(1, (0.0, APART_M))


@pytest.mark.slow
def test_a_drawn_lot_has_every_stall_in_the_size_of_a_stall_and_moves_with_its_corner(
    lots: tuple[KnownLot, KnownLot],
) -> None:
    here, there = lots
    assert len(here.stalls) == 99
    for stall in here.stalls:
        assert 2.0 < stall.width < 3.2 < 4.0 < stall.length < 6.5
        assert 0.0 <= stall.angle < math.pi
    off = [(b.north - a.north, b.east - a.east) for a, b in zip(here.stalls, there.stalls, strict=True)]
    assert np.allclose(off, (0.0, APART_M))


@pytest.mark.slow
def test_one_fence_holds_all_stalls_and_the_start(lots: tuple[KnownLot, KnownLot]) -> None:
    fence = site_of(lots)
    places = [(stall.north, stall.east) for lot in lots for stall in lot.stalls]
    assert shapely.Polygon(fence.polygon).covers(shapely.MultiPoint([*places, HOME]))
    flight = KnownFlight(lots, (), SeenMap(lots, CAMERA), fence, CAMERA, distance_m=100.0)
    flight.places.append((HOME[0] + 30.0, HOME[1] + 40.0))
    assert with_path_home(flight) == pytest.approx(150.0)
