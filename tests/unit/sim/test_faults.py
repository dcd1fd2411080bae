from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.camera.camera import Camera, SimulationClock
from hawk.sim.faults import CameraFaults, Fault, apply_camera_fault, apply_fault
from tests.unit.sim.camera.test_camera import GreyRenderer


def put(station: Any, /, **fields: Any) -> tuple[list[str], Camera, CameraFaults]:
    camera = Camera(GreyRenderer(), SimulationClock(), np.random.default_rng(1))
    server = CameraFaults()
    return apply_fault(Fault(**fields), station.autopilot, station.link, camera, server), camera, server


@pytest.mark.parametrize(
    ("fields", "named"),
    [
        ({"gps": "bad"}, "gps"),
        ({"battery": 101}, "battery"),
        ({"battery": float("nan")}, "battery"),
        ({"wind": -1}, "wind"),
        ({"gps_jump": (1.0, 2.0)}, "gps_jump"),
        ({"gps_jump": (float("inf"), 0.0, 0.0)}, "gps_jump"),
        ({"link_loss": 1.5}, "link_loss"),
        ({"sunshine": 1}, "sunshine"),
        ({"gps_walk": (0.7, 0.0, 0.0)}, "gps_walk"),
        ({"baro_drift": float("inf")}, "baro_drift"),
        ({"compass": "bent"}, "compass"),
        ({"compass_error_deg": 181}, "compass_error_deg"),
        ({"battery_cells": 0}, "battery_cells"),
        ({"battery_counter": "back"}, "battery_counter"),
        ({"link_version": 3}, "link_version"),
        ({"others": ["kite"]}, "others"),
        ({"rally": [(0.0, 0.0)]}, "rally"),
        ({"station": [{"kind": "PARAM SET", "fields": {}}]}, "station"),
        ({"camera_orientation": 9}, "camera_orientation"),
    ],
)
def test_nonsense_is_refused_by_its_name(fields: dict[str, Any], named: str) -> None:
    with pytest.raises(ValidationError) as error:
        Fault(**fields)
    assert error.value.errors()[0]["loc"][0] == named


def test_what_is_not_named_stays(flying: Any) -> None:
    put(flying, link_loss=0.5)
    put(flying, wind=3.0)
    assert flying.link.loss == 0.5
    assert flying.autopilot.wind.speed == 3.0
    assert flying.autopilot.estimator.receiving


def test_gnss_goes_and_comes(flying: Any) -> None:
    put(flying, gps="lost")
    assert not flying.autopilot.estimator.receiving
    put(flying, gps="ok")
    assert flying.autopilot.estimator.receiving


def test_an_ekf_shift_and_a_gps_jump_move_the_local_position(flying: Any) -> None:
    before = flying.local()
    put(flying, ekf_shift=(2.0, 0.0, 0.0))
    assert flying.local()[0] == pytest.approx(before[0] - 2.0)
    put(flying, gps_jump=(4.0, 0.0, 0.0))
    flying.run(0.02)
    assert flying.local()[0] == pytest.approx(before[0] + 2.0, abs=0.05)


def test_the_ekf_reports_a_glitch(flying: Any) -> None:
    flying.stream(193)
    flying.run(0.3)
    assert flying.last("EKF_STATUS_REPORT").flags == 831
    put(flying, gps_glitch=(25.0, 0.0, 0.0))
    flying.run(2.0)
    report = flying.last("EKF_STATUS_REPORT")
    assert report.flags == 33599
    assert report.pos_horiz_variance == pytest.approx(6.4, abs=0.2)


@pytest.mark.slow
def test_without_gnss_the_ekf_says_so_in_two_steps(flying: Any) -> None:
    flying.stream(193)
    put(flying, gps="lost")
    flying.run(7.0)
    assert flying.last("EKF_STATUS_REPORT").flags == 831
    flying.run(1.0)
    assert flying.last("EKF_STATUS_REPORT").flags == 37
    flying.run(8.0)
    assert flying.last("EKF_STATUS_REPORT").flags == 167


def test_another_station_moves_home(flying: Any) -> None:
    put(flying, home=(300.0, 0.0, 0.0))
    flying.listen()
    assert flying.last("HOME_POSITION").x == pytest.approx(300.0, abs=0.1)


def test_link_radio_stick_and_pilot(flying: Any) -> None:
    put(flying, link="cut", stick=0.5, pilot_mode=5)
    assert flying.link.cut
    assert flying.autopilot.mode.number == 5
    flying.run(3.0)
    assert flying.autopilot.body.height == pytest.approx(12.0, abs=0.3)
    put(flying, radio="lost")
    assert not flying.autopilot.radio_present


def test_a_mute_autopilot_hears_and_is_not_heard(flying: Any) -> None:
    put(flying, link="mute")
    flying.heard.clear()
    flying.send(mavlink.MAVLink_command_long_message(1, 1, mavlink.MAV_CMD_DO_SET_MODE, 0, 1, 6, 0, 0, 0, 0, 0))
    flying.run(2.0, heartbeat=True)
    assert not flying.heard
    assert flying.autopilot.mode.number == 6
    put(flying, link="ok")
    flying.run(1.1)
    assert flying.last("HEARTBEAT").custom_mode == 6


def test_a_late_parameter_is_confirmed_and_reads_as_the_old_one_for_a_while(flying: Any) -> None:
    put(flying, late_parameters_s=1.0)
    name = b"FS_GCS_ENABLE"

    def read() -> float:
        flying.send(mavlink.MAVLink_param_request_read_message(1, 1, name, -1))
        flying.listen()
        return float(flying.last("PARAM_VALUE").param_value)

    flying.send(mavlink.MAVLink_param_set_message(1, 1, name, 1.0, 2))
    flying.listen()
    assert flying.last("PARAM_VALUE").param_value == 1.0
    assert read() == 0.0
    flying.run(1.1)
    assert read() == 1.0


@pytest.mark.slow
def test_a_full_battery_clears_its_failsafe(flying: Any) -> None:
    put(flying, battery=10.0)
    flying.run(12.0)
    assert flying.autopilot.failsafes.battery
    put(flying, battery=100.0)
    assert not flying.autopilot.failsafes.battery
    assert flying.autopilot.battery.remaining == 1.0


def test_what_cannot_be_done_is_said(flying: Any) -> None:
    assert put(flying, pilot_mode=99)[0] == ["pilot_mode: no such mode 99"]
    assert put(flying, autopilot="reboot")[0] == ["autopilot: armed; power_cycle boots it all the same"]
    assert put(flying, autopilot="power_cycle")[0] == []
    assert not flying.autopilot.armed


@pytest.mark.slow
def test_a_repaired_vehicle_flies_again(flying: Any) -> None:
    flying.autopilot.terminate()
    flying.run(4.0)
    assert flying.arm() != 0
    put(flying, repair=True)
    flying.fly()
    assert flying.autopilot.body.height > 11.0


def test_repair_does_nothing_in_the_air(flying: Any) -> None:
    before = flying.autopilot.body
    put(flying, repair=True)
    assert flying.autopilot.body == before


def test_a_crash_of_the_program(flying: Any) -> None:
    put(flying, autopilot="crash")
    flying.heard.clear()
    flying.run(2.0)
    assert not flying.heard


@pytest.mark.parametrize("kind", ["dark", "frozen", "garbage", "damaged", "unstamped", "closed", "mirrored", "ok"])
def test_one_camera_fault_at_a_time(station: Any, kind: str) -> None:
    _, camera, server = put(station, camera=kind)
    states = {
        "dark": camera.dark,
        "frozen": camera.frozen,
        "garbage": server.garbage,
        "damaged": server.damaged,
        "unstamped": server.unstamped,
        "closed": server.closed,
        "mirrored": camera.mirrored,
    }
    assert [name for name, on in states.items() if on] == ([] if kind == "ok" else [kind])


def test_a_camera_sits_turned_until_it_is_turned_back(station: Any) -> None:
    _, camera, server = put(station, camera_turn_deg=-90.0)
    assert camera.turned == pytest.approx(-math.pi / 2)
    assert apply_camera_fault(Fault(camera="ok"), camera, server) == []
    assert camera.turned == pytest.approx(-math.pi / 2)
    assert apply_camera_fault(Fault(camera_turn_deg=0.0), camera, server) == []
    assert camera.turned == 0.0


def test_pictures_lose_their_contrast_until_it_is_back(station: Any) -> None:
    _, camera, server = put(station, camera_contrast=0.3, camera_blank_every=4)
    assert (camera.contrast, camera.blank_every) == (0.3, 4)
    assert apply_camera_fault(Fault(camera_contrast=1.0, camera_blank_every=0), camera, server) == []
    assert (camera.contrast, camera.blank_every) == (1.0, 0)


def test_the_battery_s_parts_are_set_one_by_one(flying: Any) -> None:
    battery = flying.autopilot.battery
    put(flying, battery_charge=30.0, battery_counter="still", battery_error_v=-0.2, battery_resistance_ohm=0.05)
    flying.run(1.0)
    assert (battery.remaining, battery.counts, battery.error_v, battery.resistance) == (
        pytest.approx(1.0, abs=0.02),
        False,
        -0.2,
        0.05,
    )
    assert battery.charge < 0.3
    put(flying, battery_counter="restart", battery_rest_v=9.5, battery_cells=4)
    assert (battery.remaining, battery.counts, battery.rest_v, battery.cells) == (1.0, True, 9.5, 4)
    put(flying, battery_rest_v=0.0)
    assert battery.rest_v is None


def test_a_boot_resets_the_counted_charge(station: Any) -> None:
    put(station, battery=40.0)
    put(station, autopilot="reboot")
    assert station.autopilot.battery.remaining == 1.0
    assert station.autopilot.battery.charge == pytest.approx(0.4)


def test_motors_stop_in_the_air(flying: Any) -> None:
    put(flying, motors="off")
    flying.stream(245)
    flying.run(0.3)
    assert not flying.autopilot.armed
    assert flying.last("EXTENDED_SYS_STATE").landed_state == 1  # ArduCopter's detector: disarmed is landed
    assert flying.autopilot.body.height > 10.0
    flying.run(4.0)
    assert flying.autopilot.body.crashed


def test_every_fault_stands_in_the_documentation() -> None:
    page = (Path(__file__).parents[3] / "docs" / "faults.md").read_text()
    assert [name for name in Fault.model_fields if f"`{name}`" not in page] == []
