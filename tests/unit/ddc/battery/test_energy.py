from __future__ import annotations

import pytest

from hawk.ddc.battery.energy import ASSUMED_DRAIN, DrainReading, Reserve, seconds_home


def test_the_flight_home_is_climb_flight_descent_and_landing() -> None:
    assert seconds_home(0, 10, 10, 4) == pytest.approx(10 / 0.5)
    assert seconds_home(40, 30, 60, 4) == pytest.approx(30 / 2 + 10 + 50 / 1.5 + 20)
    assert seconds_home(0, 80, 60, 4) == pytest.approx(70 / 1.5 + 20)


def test_drain_is_assumed_until_it_was_measured() -> None:
    reading = DrainReading(20)
    assert reading.drain == ASSUMED_DRAIN
    for second in range(30):
        reading.update(90 - 0.2 * second, float(second))
    assert reading.drain == pytest.approx(0.2)
    reading.reset()
    assert reading.drain == ASSUMED_DRAIN


def test_drain_never_reads_as_nothing() -> None:
    reading = DrainReading(20)
    for second in range(60):
        reading.update(90.0, float(second))
    assert reading.drain == pytest.approx(ASSUMED_DRAIN / 3)


def test_old_readings_are_forgotten() -> None:
    reading = DrainReading(20)
    for second in range(60):
        reading.update(100 - second, float(second))
    for second in range(60, 130):
        reading.update(40 - 0.1 * (second - 60), float(second))
    assert reading.drain == pytest.approx(ASSUMED_DRAIN, abs=0.02)


def test_twenty_seconds_of_flight_are_measured_and_a_minute_is_remembered() -> None:
    reading = DrainReading(20)
    for second in range(20):
        reading.update(90 - 0.2 * second, 100.0 + second)
        assert reading.measured is None
    reading.update(90 - 0.2 * 20, 120.0)
    assert reading.measured == pytest.approx(0.2)
    reading.reset()
    reading.update(30, 0.0)
    for second in range(1, 61):
        reading.update(90 - 0.2 * second, float(second))
    assert reading.measured != pytest.approx(0.2, rel=0.01), "the first reading still counts"
    reading.update(90 - 0.2 * 61, 61.0)
    assert reading.measured == pytest.approx(0.2)


def test_a_burst_of_readings_in_one_second_is_one() -> None:
    reading = DrainReading(20)
    for second in range(31):
        reading.update(90 - 0.2 * second, float(second))
    for tick in range(1, 20):
        reading.update(10.0, 30.0 + tick / 20)
    reading.update(90 - 0.2 * 31, 31.0)
    assert reading.measured == pytest.approx(0.2)


def test_an_assumed_battery_is_empty_after_a_quarter_of_an_hour() -> None:
    assert DrainReading(20).drain * 900 == pytest.approx(100.0)


def test_five_percent_at_the_end_are_enough() -> None:
    assert Reserve(15.0, 30.0, 0.0, flight=10.0).lasts
    assert not Reserve(14.9, 30.0, 0.0, flight=10.0).lasts


def test_two_readings_are_no_drain() -> None:
    reading = DrainReading(20)
    for second, charge in ((0.0, 90.0), (30.0, 80.0)):
        reading.update(charge, second)
    assert reading.measured is None
    reading.update(70.0, 60.0)
    assert reading.measured == pytest.approx(1 / 3)


def test_the_charge_lasts_while_five_percent_are_left_at_the_end() -> None:
    reading = DrainReading(20)
    flight = reading.reserve(50, 100, 30, 60, 4).flight
    assert flight == pytest.approx(1.3 * ASSUMED_DRAIN * seconds_home(100, 30, 60, 4))
    assert reading.reserve(flight + 5.0001, 100, 30, 60, 4).lasts
    assert not reading.reserve(flight + 4.9999, 100, 30, 60, 4).lasts
    assert reading.reserve(50, 100, 30, 60, 0.1).flight == reading.reserve(50, 100, 30, 60, 0.5).flight
    found = reading.reserve(50, 100, 30, 60, 4)
    assert found.time_left == pytest.approx((50 - 20 - flight) / ASSUMED_DRAIN)
    assert (found.percentage, found.needed) == (50, 20 + flight)


def test_readings_come_often_and_one_a_second_counts() -> None:
    reading = DrainReading(20)
    for tick in range(1200):
        reading.update(90 - 0.01 * tick, tick * 0.05)
    assert reading.drain == pytest.approx(0.2, rel=0.01)


def test_the_farther_the_sooner_it_must_return() -> None:
    reading = DrainReading(20)
    near, far = reading.reserve(50, 0, 30, 60, 4), reading.reserve(50, 150, 30, 60, 4)
    assert 20 < near.needed < far.needed
    assert near.time_left > far.time_left
    assert not near.is_reached
    assert reading.reserve(20.1, 0, 30, 60, 4).is_reached
    assert reading.reserve(10, 0, 30, 60, 4).time_left == 0


def test_a_headwind_makes_the_return_costlier_and_one_that_cannot_be_flown_against_reaches_the_reserve() -> None:
    reading = DrainReading(20)
    calm, windy = (reading.reserve(60, 100, 30, 60, speed) for speed in (4, 2))
    assert windy.needed - calm.needed == pytest.approx(1.3 * ASSUMED_DRAIN * 25)
    assert reading.reserve(60, 200, 30, 60, 0.0).is_reached
