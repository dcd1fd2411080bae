"""The ground from range and height: cars and roofs do not count, slopes do, and a range that lies is not believed."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.comm.autopilot.terrain import FRESH_S, RangeReading, Terrain, TerrainEstimator, ground_below
from tests.examples import examples

STEP_S = 0.1
SPEED = 4.0

Surface = Callable[[float], float]
"""Height of what is below (m above the arm place) at a distance flown (m)."""


class Flight:
    """Flies north and measures. ``measure`` replaces the true distance."""

    def __init__(self, surface: Surface = lambda _: 0.0) -> None:
        self.watch = TerrainEstimator()
        self.surface = surface
        self.time = self.north = 0.0
        self.height = 30.0
        self.last = Terrain(0.0)
        self.measure: Callable[[float], float | None] = lambda distance: distance

    def fly(self, seconds: float, speed: float = SPEED, climb: float = 0.0) -> Terrain:
        for _ in range(round(seconds / STEP_S)):
            self.time += STEP_S
            self.north += speed * STEP_S
            self.height += climb * STEP_S
            distance = self.measure(self.height - self.surface(self.north))
            reading = RangeReading(self.time, distance, 0.2, 50.0)
            self.last = self.watch.take(reading, (self.north, 0.0, self.height))
        return self.last


def cars(north: float) -> float:
    """Cars, 1.5 m high and 4.5 m long, in a line with 1.2 m between them: three readings at 4 m/s and 10 Hz."""
    return 1.5 if north % 5.7 < 4.5 else 0.0


def test_level_ground_is_at_the_height_of_the_arm_place() -> None:
    found = Flight().fly(5.0)
    assert found.ground == pytest.approx(0.0, abs=0.2)
    assert found.distance == pytest.approx(30.0)
    assert not found.doubt


@pytest.mark.parametrize("percent", [-8, -3, 3, 8, 12])
def test_rising_and_falling_ground_is_followed(percent: int) -> None:
    flight = Flight(lambda north: north * percent / 100)
    found = flight.fly(20.0)
    assert found.ground == pytest.approx(flight.north * percent / 100, abs=0.5)
    assert not found.doubt


@pytest.mark.fault("cars, crowns and roofs pass below", "they are not taken for ground")
def test_the_ground_counts_and_not_the_cars_on_it() -> None:
    flight = Flight(cars)
    flight.fly(3.0)
    for _ in range(100):
        assert flight.fly(0.2).ground == pytest.approx(0.3, abs=0.6)


@pytest.mark.slow
@pytest.mark.fault("cars, crowns and roofs pass below")
@settings(max_examples=examples(30))
@given(st.floats(-0.06, 0.06), st.floats(5.0, 20.0), st.floats(5.0, 30.0))
def test_no_roof_is_taken_for_ground(slope: float, high: float, long: float) -> None:
    def surface(north: float) -> float:
        return slope * north + (high if 60.0 < north < 60.0 + long else 0.0)

    flight = Flight(surface)
    while flight.north < 120.0:
        found = flight.fly(0.2)
        if flight.north > 20.0:
            assert found.ground is not None
            assert found.ground <= slope * flight.north + 0.15 * long + 1.5


@pytest.mark.fault("single readings are too long", "the ground's height stays within 0.3 m")
def test_a_few_readings_that_are_too_long_dig_no_hole() -> None:
    flight = Flight()
    flight.fly(5.0)
    flight.measure = lambda distance: distance + 12.0
    flight.fly(0.2)
    flight.measure = lambda distance: distance
    assert flight.fly(1.0).ground == pytest.approx(0.0, abs=0.3)


@pytest.mark.fault(
    "the rangefinder falls silent in flight, or its range ends",
    "the estimate ends after 3 s, heights count above the arm place; silence is shown",
)
def test_without_readings_the_estimate_ends() -> None:
    flight = Flight(lambda _: 5.0)
    assert flight.fly(5.0).ground == pytest.approx(5.0, abs=0.3)
    flight.measure = lambda _: None
    assert flight.fly(FRESH_S - 0.5).ground == pytest.approx(5.0, abs=0.3)
    found = flight.fly(1.0)
    assert found.ground is None
    assert ground_below(found) == 0.0


def test_before_enough_readings_and_without_a_place_nothing_is_known() -> None:
    assert Flight().fly(0.4).ground is None
    watch = TerrainEstimator()
    for index in range(50):
        found = watch.take(RangeReading(index * STEP_S, 10.0, 0.2, 50.0), None)
        assert (found.distance, found.ground) == (10.0, None)


@pytest.mark.slow
@pytest.mark.fault(
    "the rangefinder repeats one distance",
    "doubted after 5 m of climb, shown, not used for scale or clearance",
)
def test_a_range_that_does_not_follow_the_climb_is_not_believed() -> None:
    flight = Flight()
    flight.height = 3.0
    flight.measure = lambda _: 3.0
    found = flight.fly(10.0, speed=0.0, climb=2.0)
    assert found.doubt == "its distance does not follow the height"
    assert found.believed_ground is None
    assert ground_below(found) == 0.0
    assert flight.fly(60.0).doubt, "it stays so in level flight"
    flight.measure = lambda distance: distance
    flight.fly(2.0, speed=0.0)
    assert not flight.fly(4.0, speed=0.0, climb=2.0).doubt, "and ends when it follows a climb again"


def test_a_climb_over_a_roof_is_no_doubt() -> None:
    flight = Flight(lambda north: 10.0 if north > 20.0 else 0.0)
    flight.height = 14.0
    flight.fly(5.7)
    assert not flight.fly(6.0, speed=0.0, climb=2.0).doubt


@pytest.mark.fault("the rangefinder gives ground that no lot has", "doubted after 2 s")
@pytest.mark.parametrize("ground", [16.0, -16.0])
def test_ground_that_no_lot_has_is_not_believed_after_a_while(ground: float) -> None:
    flight = Flight()
    flight.fly(5.0)
    flight.watch.reset()
    flight.surface = lambda _: ground
    flight.fly(1.5)
    assert not flight.last.doubt
    found = flight.fly(3.0)
    assert found.doubt == f"it measures {30 - ground:.0f} m at 30 m above the arm place"
    assert found.believed_ground is None
    flight.surface = lambda _: 0.0
    assert not flight.fly(40.0).doubt


def test_ground_far_below_a_high_flight_is_believed() -> None:
    flight = Flight(lambda _: -14.0)
    flight.height = 30.0
    assert flight.fly(10.0).believed_ground == pytest.approx(-14.0, abs=0.3)


def test_a_car_below_is_the_distance_that_counts_for_safety() -> None:
    flight = Flight(lambda north: 8.0 if north > 15.0 else 0.0)
    flight.fly(5.0)
    assert flight.last.distance == pytest.approx(22.0)
    assert flight.last.ground == pytest.approx(0.8, abs=0.6)


def test_the_ground_below_is_that_which_is_believed() -> None:
    assert ground_below(None) == 0.0
    assert ground_below(Terrain(1.0, distance=20.0, ground=3.0, most=50.0)) == 3.0
    assert ground_below(Terrain(1.0, distance=20.0, ground=3.0, most=50.0, doubt="stuck")) == 0.0
    assert ground_below(Terrain(1.0, distance=20.0, ground=None, most=50.0)) == 0.0
