"""Places of vehicles: one each, the first that fits."""

from __future__ import annotations

import math

import numpy as np
import shapely
from hypothesis import given
from hypothesis import strategies as st

from hawk.lots.survey.vehicle_places import Grounds, Place, places_of

STALLS = np.array([(0.0, 2.5 * n, 0.0, 2.5, 5.0) for n in range(4)])
KERB = ((10.0, -5.0), (10.0, 30.0), (12.2, 30.0), (12.2, -5.0))
LOT = shapely.box(-5, -5, 9, 30)
ROAD = shapely.box(12, -50, 20, 50)
GROUNDS = Grounds(STALLS, {"kerb": KERB, "damaged": ()}, LOT, ROAD)


def car(north: float, east: float, angle: float = 0.0, length: float = 4.5) -> tuple[float, ...]:
    return north, east, angle, 1.8, length


def test_each_place_has_its_vehicles() -> None:
    found = places_of(
        np.array([
            car(0.2, 2.6), car(11.0, 4.0, math.pi / 2), car(6.0, 10.0, math.pi / 2), car(16.0, 0.0), car(40.0, 0.0),
        ]), GROUNDS,
    )  # fmt: skip
    assert [(each.place, each.of) for each in found] == [
        (Place.STALL, "1"), (Place.SECTION, "kerb"), (Place.BESIDE, ""), (Place.ROAD, ""), (Place.ELSEWHERE, ""),
    ]  # fmt: skip


def test_a_lorry_across_two_stalls_stands_on_one_of_them() -> None:
    (lorry,) = places_of(np.array([(0.0, 1.4, math.pi / 2, 2.5, 8.0)]), GROUNDS)
    assert lorry.place is Place.STALL


def test_a_car_that_covers_little_of_a_stall_stands_beside_it() -> None:
    (beside,) = places_of(np.array([car(4.0, 0.0)]), GROUNDS)
    assert beside.place is Place.BESIDE


def test_no_vehicle_and_no_ground_is_no_error() -> None:
    nothing = Grounds(np.zeros((0, 5)), {})
    assert places_of(np.zeros((0, 5)), GROUNDS) == ()
    assert [each.place for each in places_of(np.array([car(0.0, 0.0)]), nothing)] == [Place.ELSEWHERE]


@given(st.lists(st.tuples(st.floats(-60, 60), st.floats(-60, 60), st.floats(0, math.pi)), max_size=12))
def test_every_vehicle_has_one_place_whatever_the_others_are(given_ones: list[tuple[float, float, float]]) -> None:
    vehicles = np.array([car(*each) for each in given_ones], float).reshape(-1, 5)
    found = places_of(vehicles, GROUNDS)
    assert len(found) == len(vehicles)
    for number, place in enumerate(found):
        assert places_of(vehicles[number : number + 1], GROUNDS) == (place,)
        assert bool(place.of) == (place.place in (Place.STALL, Place.SECTION))
