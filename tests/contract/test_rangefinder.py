"""The rangefinder that looks down: which message, which units, when it comes, what it says at a lean and beyond."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest

from tests.contract.vehicle import HEIGHT, Vehicle

pytestmark = pytest.mark.contract
DISTANCE_SENSOR, RANGEFINDER = 132, 173
ASK_INTERVAL = 511
SIMULATED, DOWN = 100, 25
MOST_M = 15.0


def ask(vehicle: Vehicle) -> None:
    """Ask for both messages, 10 a second."""
    for message in (DISTANCE_SENSOR, RANGEFINDER):
        assert vehicle.pilot.command(ASK_INTERVAL, message, 1e5) == 0


def centimetres(vehicle: Vehicle) -> int:
    """``current_distance`` of the last message."""
    return int(vehicle.pilot.messages["DISTANCE_SENSOR"]["current_distance"])


def slant(vehicle: Vehicle) -> float:
    """Distance to the ground at home's height along the drone's own axis, metres."""
    attitude = vehicle.pilot.messages["ATTITUDE"]
    return -vehicle.place[2] / (math.cos(attitude["roll"]) * math.cos(attitude["pitch"]))


def forget(vehicle: Vehicle) -> None:
    for name in ("DISTANCE_SENSOR", "RANGEFINDER"):
        vehicle.pilot.messages.pop(name, None)
        vehicle.pilot.counts.pop(name, None)


@pytest.fixture(scope="module")
def sensor(connected: Vehicle) -> Iterator[Vehicle]:
    """The vehicle with a rangefinder; afterwards without."""
    vehicle = connected
    vehicle.land()
    vehicle.write("RNGFND1_TYPE", SIMULATED)
    vehicle.write("RNGFND1_MAX", MOST_M)
    vehicle.reboot()
    ask(vehicle)
    try:
        yield vehicle
    finally:
        vehicle.land()
        vehicle.write("RNGFND1_TYPE", 0)
        vehicle.reboot()


def test_without_a_sensor_no_message_comes_though_its_rate_is_accepted(grounded: Vehicle) -> None:
    assert grounded.parameter("RNGFND1_TYPE") == 0
    assert grounded.parameter("RNGFND1_ORIENT") == DOWN
    ask(grounded)
    forget(grounded)
    grounded.let_pass(3.0)
    assert not {"DISTANCE_SENSOR", "RANGEFINDER"} & set(grounded.pilot.messages)


def test_it_comes_in_centimetres_and_looks_down(sensor: Vehicle) -> None:
    sensor.fly()
    sensor.let_pass(2.0)
    message = sensor.pilot.messages["DISTANCE_SENSOR"]
    assert message["orientation"] == DOWN
    assert message["signal_quality"] == 0, "unknown"
    assert message["max_distance"] == MOST_M * 100
    assert 0 < message["min_distance"] <= 100
    assert centimetres(sensor) == pytest.approx(HEIGHT * 100, abs=60)
    assert sensor.pilot.messages["RANGEFINDER"]["distance"] == pytest.approx(centimetres(sensor) / 100, abs=0.2)
    assert abs(message["time_boot_ms"] / 1000.0 - sensor.seconds) < 0.5


def test_it_measures_along_the_drone_s_axis_and_is_not_corrected_for_the_lean(sensor: Vehicle) -> None:
    sensor.fly()
    sensor.pilot.target(60.0, 0.0, -HEIGHT)
    sensor.wait(lambda: abs(sensor.pilot.messages["ATTITUDE"]["pitch"]) > math.radians(15.0), 10.0)
    sensor.let_pass(0.6)
    assert slant(sensor) > -sensor.place[2] + 0.2, "it leans"
    assert centimetres(sensor) / 100 == pytest.approx(slant(sensor), abs=0.35)


def test_beyond_its_limit_it_says_what_it_measures(sensor: Vehicle) -> None:
    sensor.fly()
    sensor.go(0.0, 0.0, -MOST_M - 3.0)
    sensor.let_pass(1.0)
    message = sensor.pilot.messages["DISTANCE_SENSOR"]
    assert message["current_distance"] > message["max_distance"]
    assert centimetres(sensor) == pytest.approx((MOST_M + 3.0) * 100, abs=60)


def test_on_the_ground_it_says_less_than_its_least_distance(sensor: Vehicle) -> None:
    sensor.land()
    sensor.let_pass(1.0)
    message = sensor.pilot.messages["DISTANCE_SENSOR"]
    assert message["current_distance"] <= message["min_distance"]


def test_after_a_boot_it_is_silent_until_it_is_asked_for(sensor: Vehicle) -> None:
    sensor.land()
    sensor.reboot()
    forget(sensor)
    sensor.let_pass(2.0)
    assert "DISTANCE_SENSOR" not in sensor.pilot.messages
    ask(sensor)
    sensor.wait(lambda: sensor.pilot.counts.get("DISTANCE_SENSOR", 0) >= 10, 5.0)
