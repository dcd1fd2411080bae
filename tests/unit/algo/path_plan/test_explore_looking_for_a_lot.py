"""Exploring where vision saw stalls for a moment and the map knows no lot yet, and over lots in parts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from hawk.algo.ground import CoarseLayers, Window
from hawk.model.poses import MapPose
from tests.unit.algo.path_plan.flight import KnownMap, fence_around, fly

pytestmark = pytest.mark.flight


class LateMap(KnownMap):
    """Knows no lot before enough of it was seen: a few stalls at a picture's edge are not believed."""

    def coarse(self, window: Window) -> CoarseLayers:
        found = super().coarse(window)
        nothing = np.zeros_like(found.lot)
        return found if self.lot_area_m2() > 0 else replace(found, lot=nothing, likely=nothing)

    def lot_area_m2(self) -> float:
        area = super().lot_area_m2()
        return area if area > 600.0 else 0.0


@pytest.mark.nightly
def test_it_moves_on_to_where_the_map_believes_the_lot() -> None:
    lot = shapely.box(10.0, -40.0, 60.0, 40.0)
    flight = fly(lot, (0.0, 0.0), fence_around(lot, 25.0), known=LateMap(lot, 120.0))
    assert not flight.plans[0].explore.lot_known
    assert flight.plans[0].explore.seen == 0.0
    assert flight.plans[-1].explore.lot_known
    assert flight.done
    assert flight.coverage >= 0.98


def test_it_ends_soon_where_there_is_no_lot_and_does_not_call_that_explored() -> None:
    far = shapely.box(200.0, 200.0, 210.0, 210.0)
    fence = fence_around(shapely.box(-100.0, -100.0, 100.0, 100.0), 0.0)
    flight = fly(far, (0.0, 0.0), fence, known=LateMap(far, 220.0))
    assert flight.done
    assert not any(plan.explore.lot_known for plan in flight.plans)
    assert flight.plans[-1].explore.seen == 0.0
    assert 10.0 < flight.distance_m < 200.0


@pytest.mark.nightly
def test_the_road_between_two_lots_is_crossed() -> None:
    lot = shapely.union(shapely.box(-60.0, -20.0, 60.0, 0.0), shapely.box(-60.0, 32.0, 60.0, 52.0))
    fence = fence_around(lot.envelope, 15.0)
    known = KnownMap(lot, 140.0)
    known.look(MapPose(0.0, 16.0, 60.0, 0.0, 0.0, 0.0))  # from higher up both were in sight
    flight = fly(lot, (-55.0, -10.0), fence, known=known)
    assert flight.done
    assert flight.coverage >= 0.98
    assert all(shapely.Polygon(fence.polygon).covers(shapely.Point(place)) for place in flight.places)
