from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely

from benchmarks.known_flight import KnownFlight, SeenMap
from hawk.algo.frame import outcome
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.path_plan.known_tour import lot_tour
from hawk.model.known_lot import KnownLot, KnownStall
from hawk.model.lot_map import Stall, StallState
from hawk.model.plans import Fence, HeightParameters
from hawk.model.poses import MapPose
from tests.examples import nightly
from tests.unit.algo.path_plan.flight import LEVEL
from tests.unit.algo.synthetic import CAMERA, frame_at

HEIGHTS = HeightParameters(15.0, 35.0, 60.0)
RING = ((-150.0, -150.0), (-150.0, 150.0), (150.0, 150.0), (150.0, -150.0))
FENCE = Fence(RING, RING, 97.0, 100.0)


def lot_of(rows: int = 4, stalls: int = 24) -> KnownLot:
    """Return rows of stalls east and north of the origin."""
    row, number = np.divmod(np.arange(rows * stalls), stalls)
    places = np.column_stack([row * 11.0, number * 2.6]).tolist()
    return KnownLot("a lot", tuple(KnownStall(str(k), at[0], at[1], 0.0, 2.5, 5.0) for k, at in enumerate(places)), ())


def flight(
    known: KnownLot | None = None,
    off: tuple[float, float] = (0.0, 0.0),
    new: tuple[Stall, ...] = (),
    fence: Fence = FENCE,
) -> KnownFlight:
    known = known or lot_of()
    tour = outcome(lot_tour(known, CAMERA, HEIGHTS, fence, (0.0, 0.0), LEVEL))
    return KnownFlight((known,), (tour,), SeenMap((known,), CAMERA, off, new), fence, CAMERA, app=PathPlanApp(LEVEL))


@pytest.mark.slow
@pytest.mark.parametrize("off", [(3.5, -2.5), *nightly(((0.0, 0.0),))])
def test_every_stall_is_looked_at_in_little_more_than_the_planned_distance(off: tuple[float, float]) -> None:
    flown = flight(off=off)
    flown.fly()
    assert flown.last.explore.done
    assert flown.last.explore.seen == 1.0
    assert flown.lot_map.whole.all()
    assert flown.distance_m < 1.12 * flown.tours[0].distance_m + 8.0


class SeenInParts(SeenMap):
    """Pictures have shown all ground from the second frame on, but no stall in one picture."""

    def look(self, pose: MapPose) -> None:
        super().look(pose)
        if self.frames > 1:
            self.seen[:] = 1.0


@pytest.mark.nightly
def test_stalls_that_pictures_have_shown_in_parts_alone_are_looked_at() -> None:
    flown = flight(off=(1.5, -1.0))
    flown.lot_map = SeenInParts(flown.known, CAMERA, (1.5, -1.0))
    flown.fly()
    assert flown.last.explore.done
    assert flown.lot_map.whole.all()


@pytest.mark.nightly
def test_after_a_battery_swap_only_the_rest_is_flown() -> None:
    flown = flight()
    flown.fly(most_s=0.6 * flown.tours[0].distance_m / 5.0)
    assert not flown.last.explore.done
    left = int((~flown.lot_map.whole).sum())
    planned = flown.tours[0].distance_m
    again = KnownFlight(flown.known, flown.tours, flown.lot_map, flown.fence, CAMERA, app=PathPlanApp(LEVEL))
    again.fly()
    assert left > 0
    assert flown.lot_map.whole.mean() > 0.97  # of the flight before, cells of 1.6 m are known
    assert again.distance_m < planned + 8.0


@pytest.mark.slow
def test_the_drone_stays_inside_the_fence_and_out_of_its_zones_and_says_what_it_missed() -> None:
    zone = ((-20.0, 10.0), (-20.0, 16.0), (30.0, 16.0), (30.0, 10.0))
    ring = ((-25.0, -25.0), (-25.0, 30.0), (60.0, 30.0), (60.0, -25.0))
    flown = flight(fence=Fence(ring, ring, 97.0, 100.0, zones=(zone,), autopilot_zones=(zone,)))
    flown.fly()
    allowed = shapely.Polygon(ring).difference(shapely.Polygon(zone)).buffer(1.5)
    assert shapely.contains_xy(allowed, *np.array(flown.places).T).all()
    assert flown.last.explore.done
    assert flown.last.explore.seen < 1.0
    assert flown.last.explore.unreached


def _new(number: int, north: float, east: float) -> Stall:
    return Stall(number, north, east, 0.0, 2.5, 5.0, 0.1, StallState.FREE, 0.9, 5, 1.0, 1)


@pytest.mark.slow
def test_a_row_that_goes_on_beyond_the_plan_is_followed() -> None:
    new = tuple(_new(k, -11.0, -k * 2.6) for k in range(24))
    flown = flight(new=new)
    flown.fly()
    assert flown.lot_map.whole.all()
    assert len(flown.lot_map.shown) > 15  # of 24: 120 m of flight at most
    assert flown.distance_m < flown.tours[0].distance_m + 180.0


@pytest.mark.nightly
def test_without_the_plan_of_its_lot_a_tour_is_not_flown() -> None:
    flown = flight()
    frame = frame_at(MapPose(0.0, 0.0, 35.0, 0.0, 0.0, 0.0), 0, fence=FENCE)
    plan = flown.app.plan(replace(frame, known=(), tours=flown.tours), flown.lot_map).path
    assert plan.target is None
    assert plan.explore.reason == "nothing is mapped yet"


@pytest.mark.nightly
@pytest.mark.parametrize("off", [(3.5, -2.5), *nightly(((0.0, 0.0),))])
def test_a_section_is_looked_at_as_well_and_moves_with_the_plan(off: tuple[float, float]) -> None:
    """A kerb 40 m beside the rows: without it no picture goes there."""
    kerb = tuple(KnownStall(f"kerb {k}", -40.0, 5.5 * k, math.pi / 2, 2.5, 5.0) for k in range(8))
    plain = lot_of()
    known = replace(plain, section_places=kerb)
    flown = flight(known, off)
    flown.lot_map = SeenMap((replace(plain, stalls=(*plain.stalls, *kerb)),), CAMERA, off)
    places = flown.lot_map.plan_places
    flown.lot_map.plan_places = lambda lot: None if (all_ := places(lot)) is None else all_[: len(plain.stalls)]  # type: ignore[method-assign]
    flown.fly()
    assert flown.last.explore.done
    assert flown.last.explore.seen == 1.0
    assert flown.lot_map.whole.all()
    without = flight(plain, off)
    assert without.tours[0].distance_m < flown.tours[0].distance_m
