"""Vehicles over the looks of a flight: those that stand add up, those that drive are forgotten."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from hawk.algo.mapper.core import MapCore, MapperSettings
from hawk.algo.mapper.vehicles import TrackedVehicle, VehicleLook, VehicleTracker, moved_vehicles
from hawk.algo.vision.detection import Vehicle
from hawk.model.vehicles import VehicleKind
from tests.unit.algo.synthetic import SyntheticVision, pose_at, rows_lot

CAR = Vehicle(VehicleKind.CAR, 10.0, 5.0, 0.4, 1.8, 4.5, 0.85, 1.0)


def everywhere(places: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.ones(len(places), np.bool_)


def nowhere(places: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.zeros(len(places), np.bool_)


class Flight:
    """Looks at vehicles, one a second, each an independent one."""

    def __init__(self) -> None:
        self.tracker = VehicleTracker()
        self.time = 0
        self.next_id = 1

    def look(
        self,
        *found: Vehicle,
        in_picture: Callable[[NDArray[np.float64]], NDArray[np.bool_]] = everywhere,
        weight: float = 1.0,
    ) -> None:
        self.time += 1
        sight = VehicleLook(found, in_picture, weight, 3.0 * self.time, float(self.time), self.time)
        self.next_id = self.tracker.look(sight, (10.0, 5.0), 40.0, self.next_id)

    @property
    def shown(self) -> list[TrackedVehicle]:
        return [one for one in self.tracker.known.values() if one.is_shown]


def test_a_car_that_stands_is_one_and_grows_sure() -> None:
    flight = Flight()
    for k in range(5):
        flight.look(replace(CAR, north=CAR.north + 0.3 * (-1) ** k))
    (one,) = flight.shown
    assert one.probability > 0.99
    assert math.hypot(one.north - CAR.north, one.east - CAR.east) < 0.2
    assert one.on_map().kind is VehicleKind.CAR
    assert one.on_map().stood_s == 4
    assert one.on_map().looks == 5


def test_cars_bumper_to_bumper_are_two() -> None:
    flight = Flight()
    behind = replace(CAR, north=CAR.north + 5.2 * math.cos(0.4), east=CAR.east + 5.2 * math.sin(0.4))
    for _ in range(3):
        flight.look(CAR, behind)
    assert len(flight.shown) == 2


def test_a_car_that_drives_leaves_nothing_behind() -> None:
    flight = Flight()
    for k in range(8):
        flight.look(replace(CAR, north=CAR.north + 6.0 * k))
    assert len(flight.shown) <= 2, "the last look, and perhaps the one before"


def test_a_car_that_left_is_forgotten_and_one_out_of_sight_is_kept() -> None:
    flight = Flight()
    for _ in range(4):
        flight.look(CAR)
    for _ in range(10):
        flight.look(in_picture=nowhere)
    assert len(flight.shown) == 1
    for _ in range(6):
        flight.look()
    assert flight.tracker.known == {}
    assert (1, None) in list(flight.tracker.shown(0))


def test_one_missed_look_takes_no_car_that_was_seen_often() -> None:
    flight = Flight()
    for _ in range(4):
        flight.look(CAR)
    flight.look()
    assert len(flight.shown) == 1


def test_a_frame_from_the_same_place_adds_little() -> None:
    flight = Flight()
    flight.look(CAR)
    before = flight.shown[0].probability
    flight.look(CAR, weight=0.02)
    assert flight.shown[0].probability - before < 0.01


def test_a_doubtful_find_is_no_part_of_the_map_until_it_is_seen_again() -> None:
    flight = Flight()
    doubtful = replace(CAR, probability=0.45)
    flight.look(doubtful)
    assert flight.shown == []
    flight.look(CAR)
    assert len(flight.shown) == 1


def test_what_an_edge_cuts_does_not_shrink_a_car() -> None:
    flight = Flight()
    for _ in range(3):
        flight.look(CAR)
    for _ in range(3):
        flight.look(replace(CAR, length=2.5, visible=0.4))
    assert flight.shown[0].length == pytest.approx(CAR.length, abs=0.25)


@settings(max_examples=40)
@given(st.permutations(range(6)), st.floats(-0.2, 0.2))
def test_the_order_of_finds_in_a_look_changes_nothing(order: list[int], off: float) -> None:
    cars = [replace(CAR, east=CAR.east + 2.6 * k + off) for k in range(6)]
    one, other = Flight(), Flight()
    for _ in range(2):
        one.look(*cars)
        other.look(*(cars[k] for k in order))
    places = [sorted((each.north, each.east) for each in flight.tracker.known.values()) for flight in (one, other)]
    assert places[0] == places[1]


def test_it_comes_back_from_bytes_and_damaged_bytes_are_refused() -> None:
    flight = Flight()
    flight.look(CAR)
    (one,) = flight.shown
    assert TrackedVehicle.from_bytes(one.to_bytes()) == one
    for damaged in (b"{", b"[]", one.to_bytes().replace(b"10.0", b"NaN"), one.to_bytes().replace(b"[1.0, ", b"[")):
        with pytest.raises(ValueError, match=r"vehicle|JSON|Expecting"):
            TrackedVehicle.from_bytes(damaged)


def test_the_kind_is_that_of_most_looks() -> None:
    flight = Flight()
    for kind in (VehicleKind.CAR, VehicleKind.VAN, VehicleKind.VAN):
        flight.look(replace(CAR, kind=kind))
    assert flight.shown[0].on_map().kind is VehicleKind.VAN


def test_a_correction_of_the_map_moves_and_turns_them() -> None:
    turn = 0.1
    correction = np.array([[math.cos(turn), -math.sin(turn), 2.0], [math.sin(turn), math.cos(turn), -1.0]])
    (one,) = moved_vehicles([CAR], correction)
    assert one.angle == pytest.approx(CAR.angle + turn)
    assert (one.north, one.east) == pytest.approx(tuple(correction @ (CAR.north, CAR.east, 1.0)))


def test_the_map_has_the_vehicles_and_takes_them_over_a_restart() -> None:
    vision, core = SyntheticVision(rows_lot()), MapCore(MapperSettings(), "m")
    for k in range(4):
        seen = vision.look(pose_at(6.0 * k, 10.0), float(k))
        core.fuse(replace(seen, vehicles=(CAR,)))
        core.encode(seen.pose)
    assert core.index.vehicles is not None
    (vehicle,) = core.index.vehicles.values()
    assert vehicle.looks == 4
    other = MapCore(MapperSettings(), "")
    assert other.restore([core.changes_since(0).parts]) == []
    assert other.index.vehicles is not None
    assert [one.kind for one in other.index.vehicles.values()] == [vehicle.kind]
