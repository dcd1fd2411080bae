"""The simulated rangefinder and the sloped ground, as the contract states of ArduCopter."""

from __future__ import annotations

import argparse
import math
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.autopilot.telemetry import build
from hawk.sim.cli import make_parser
from hawk.sim.geometry import Slope
from hawk.sim.vehicle import Body, Demand, step_body
from tests.unit.sim.test_faults import put

DISTANCE, RANGE = mavlink.MAVLINK_MSG_ID_DISTANCE_SENSOR, mavlink.MAVLINK_MSG_ID_RANGEFINDER
EAST = math.pi / 2


def with_sensor(station: Any, most_m: float = 50.0) -> Any:
    station.set_parameter("RNGFND1_TYPE", 100, 2)
    station.set_parameter("RNGFND1_MAX", most_m)
    station.autopilot.reboot()
    return station


def test_without_the_parameter_there_is_none_though_its_rate_was_asked_for(station: Any) -> None:
    station.stream(DISTANCE, RANGE)
    station.run(2.0)
    assert station.all("DISTANCE_SENSOR") == station.all("RANGEFINDER") == []


def test_it_is_there_after_a_boot_in_centimetres_and_looks_down(station: Any) -> None:
    station.set_parameter("RNGFND1_TYPE", 100, 2)
    assert build(DISTANCE, station.autopilot) is None, "not before it boots"
    with_sensor(station).fly(12.0)
    message: Any = build(DISTANCE, station.autopilot)
    assert message.current_distance == pytest.approx(station.autopilot.body.height * 100, abs=3)
    assert (message.min_distance, message.max_distance) == (20, 5000)
    assert (message.orientation, message.signal_quality) == (25, 0)
    metres: Any = build(RANGE, station.autopilot)
    assert metres.distance == pytest.approx(station.autopilot.body.height, abs=0.03)


def test_it_measures_along_its_own_axis(station: Any) -> None:
    with_sensor(station).fly(12.0)
    station.local_target(40.0, 0.0, -12.0)
    station.run(1.5)
    body = station.autopilot.body
    assert abs(body.pitch) > 0.1
    message: Any = build(DISTANCE, station.autopilot)
    slant = body.height / math.cos(body.roll) / math.cos(body.pitch)
    assert message.current_distance == pytest.approx(slant * 100, abs=2)


def test_beyond_its_limit_it_says_what_it_measures(station: Any) -> None:
    with_sensor(station, 5.0).fly(12.0)
    message: Any = build(DISTANCE, station.autopilot)
    assert message.current_distance > message.max_distance == 500


@pytest.mark.slow
def test_a_stuck_one_and_its_end(station: Any) -> None:
    with_sensor(station).fly(12.0)
    put(station, rangefinder="stuck")
    station.local_target(0.0, 0.0, -20.0)
    station.run(8.0)
    stuck: Any = build(DISTANCE, station.autopilot)
    assert stuck.current_distance == pytest.approx(1200, abs=30)
    put(station, rangefinder="ok")
    well: Any = build(DISTANCE, station.autopilot)
    assert well.current_distance == pytest.approx(2000, abs=30)


@pytest.mark.slow
def test_over_rising_ground_it_measures_less(make_station: Any) -> None:
    station = with_sensor(make_station(slope=Slope(10.0, EAST)))
    station.fly(12.0)
    station.local_target(0.0, 40.0, -12.0)
    station.run(15.0)
    message: Any = build(DISTANCE, station.autopilot)
    assert station.local()[1] == pytest.approx(40.0, abs=1.0)
    assert message.current_distance == pytest.approx(800, abs=15)


def test_the_option_of_the_autopilot_sets_the_parameters(make_station: Any) -> None:
    station = make_station(rangefinder_m=40.0)
    assert station.autopilot.parameters["RNGFND1_TYPE"] == 100
    message: Any = build(DISTANCE, station.autopilot)
    assert message.max_distance == 4000


def test_the_slope_is_zero_at_the_start_and_rises_to_its_direction() -> None:
    slope = Slope(6.0, EAST, (5.0, 10.0))
    assert slope.height(99.0, 10.0) == pytest.approx(0.0)
    assert slope.height(5.0, 110.0) == pytest.approx(6.0)
    assert Slope().height(50.0, 50.0) == 0.0


@pytest.mark.parametrize(("yaw", "roll", "pitch"), [(EAST, 0.0, 0.06), (0.0, -0.06, 0.0), (-EAST, 0.0, -0.06)])
def test_a_drone_stands_parallel_to_the_slope(yaw: float, roll: float, pitch: float) -> None:
    body = step_body(Body(yaw=yaw), Demand(), (0.0, 0.0, 0.0), 0.01, Slope(6.0, EAST))
    assert body.roll == pytest.approx(roll, abs=1e-3)
    assert body.pitch == pytest.approx(pitch, abs=1e-3)


def test_it_lands_on_risen_ground() -> None:
    body = Body(position=(0.0, 50.0, -8.0), velocity=(0.0, 0.0, 1.0), on_ground=False)
    for _ in range(1000):
        body = step_body(body, Demand((0.0, 0.0, 0.0), motors=True), (0.0, 0.0, 0.0), 0.01, Slope(10.0, EAST))
    assert body.on_ground
    assert not body.crashed
    assert body.position[2] == pytest.approx(-5.0)


def test_the_option() -> None:
    parser = make_parser()
    assert parser.parse_args([]).slope == (0.0, 0.0)
    assert parser.parse_args(["--slope", "6,90"]).slope == (6.0, 90.0)
    assert parser.parse_args([]).rangefinder == 0.0
    for wrong in ("6", "steep,0", "31,0", "-1,0", "6,400", "nan,0"):
        with pytest.raises((SystemExit, argparse.ArgumentTypeError)):
            parser.parse_args([f"--slope={wrong}"])
