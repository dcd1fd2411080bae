"""DISTANCE_SENSOR as ArduCopter sends it: units, limits, tilt."""

from __future__ import annotations

import math
from typing import Any

import pytest

from hawk.comm.autopilot.terrain import looks_down, read_distance
from hawk.model.frames import Attitude

LEVEL = Attitude(10.0, 0.0, 0.0, 0.0)


def distance_sensor(centimetres: int, **changed: Any) -> dict[str, Any]:
    """A message as a real ArduCopter with RNGFND1_TYPE 100 sent it, 0.2 to 50 m."""
    return {
        "time_boot_ms": 18_971,
        "min_distance": 20,
        "max_distance": 5000,
        "current_distance": centimetres,
        "type": 4,
        "id": 0,
        "orientation": 25,
        "covariance": 0,
        "signal_quality": 0,
        **changed,
    }


def test_centimetres_become_metres_at_the_time_of_the_message() -> None:
    reading = read_distance(distance_sensor(1234), 10.0, LEVEL)
    assert reading.time == 10.0
    assert reading.distance == pytest.approx(12.34)
    assert reading.least == pytest.approx(0.2)
    assert reading.most == pytest.approx(50.0)


@pytest.mark.parametrize("degrees", [(20.0, 0.0), (0.0, -20.0), (15.0, 12.0)])
def test_a_lean_is_taken_out(degrees: tuple[float, float]) -> None:
    roll, pitch = map(math.radians, degrees)
    slant = 20.0 / (math.cos(roll) * math.cos(pitch))
    reading = read_distance(distance_sensor(round(slant * 100)), 10.0, Attitude(10.0, roll, pitch, 1.0))
    assert reading.distance == pytest.approx(20.0, abs=0.01)


@pytest.mark.parametrize("centimetres", [0, 20, 5000, 6000])
def test_at_or_beyond_the_limits_there_is_no_reading(centimetres: int) -> None:
    assert read_distance(distance_sensor(centimetres), 10.0, LEVEL).distance is None


def test_an_invalid_signal_a_strong_lean_and_an_unknown_attitude_are_no_reading() -> None:
    assert read_distance(distance_sensor(1000, signal_quality=1), 10.0, LEVEL).distance is None
    assert read_distance(distance_sensor(1000, signal_quality=100), 10.0, LEVEL).distance == pytest.approx(10.0)
    assert read_distance(distance_sensor(1000), 10.0, Attitude(10.0, 0.0, math.radians(31), 0.0)).distance is None
    assert read_distance(distance_sensor(1000), 10.0, None).distance is None


def test_only_a_sensor_that_looks_down_counts() -> None:
    assert looks_down(distance_sensor(1000))
    assert not looks_down(distance_sensor(1000, orientation=0))
    assert not looks_down({})
