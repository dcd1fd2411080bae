"""Rows: mode names, arm, `arm_force`, takeoff, offboard, `goto_location`, RTL altitude, parameters, `send_command`."""

from __future__ import annotations

import time

import pytest
from mavsdk.plugins.action import ActionError
from mavsdk.plugins.offboard import Offboard, OffboardError
from mavsdk.plugins.param import ParamError

from tests.contract.vehicle import (
    BRAKE,
    GUIDED,
    LAND,
    LOITER,
    POSHOLD,
    RTL,
    SMART_RTL,
    STABILIZE,
    Vehicle,
)

pytestmark = pytest.mark.contract
UNKNOWN_S = 3.0


@pytest.mark.parametrize(
    ("mode", "name"),
    [
        (GUIDED, "OFFBOARD"),
        (BRAKE, "HOLD"),
        (LOITER, "HOLD"),
        (POSHOLD, "POSCTL"),
        (RTL, "RETURN_TO_LAUNCH"),
        (LAND, "LAND"),
        (SMART_RTL, "UNKNOWN"),
        (STABILIZE, "STABILIZED"),
    ],
)
def test_mavsdk_has_names_of_its_own_for_the_modes(grounded: Vehicle, mode: int, name: str) -> None:
    grounded.set_mode(mode)
    grounded.wait(lambda: grounded.pilot.telemetry.flight_mode().name == name, 3.0)


def test_a_mode_that_is_not_there_is_answered_with_failed(grounded: Vehicle) -> None:
    assert grounded.pilot.command(176, 1, 99) == 4
    assert grounded.mode == STABILIZE


@pytest.mark.parametrize("mode", [STABILIZE, GUIDED])
def test_it_arms_and_disarms_by_itself_after_a_while_on_the_ground(grounded: Vehicle, mode: int) -> None:
    grounded.set_mode(mode)
    grounded.pilot.action.arm()
    assert grounded.wait(lambda: grounded.armed, 3.0) < 1.5 * grounded.speed  # HEARTBEAT comes once a second
    assert 5.0 < grounded.wait(lambda: not grounded.armed, 30.0) < 15.0


def test_a_refusal_to_arm_is_failed_and_its_reason_a_text(grounded: Vehicle) -> None:
    grounded.set_mode(BRAKE)
    with pytest.raises(ActionError, match="FAILED"):
        grounded.pilot.action.arm()
    grounded.wait(lambda: grounded.said("Arm: BRAKE mode not armable"), 2.0)


def test_arm_force_succeeds_and_does_not_arm(grounded: Vehicle) -> None:
    grounded.pilot.action.arm_force()
    before = grounded.pilot.counts["HEARTBEAT"]
    grounded.wait(lambda: grounded.pilot.counts["HEARTBEAT"] >= before + 2, 5.0)
    assert not grounded.armed


def test_takeoff_without_arming_fails(grounded: Vehicle) -> None:
    with pytest.raises(ActionError, match="FAILED"):
        grounded.pilot.action.takeoff()
    assert not grounded.armed


def test_offboard_does_not_start_without_a_set_point(grounded: Vehicle) -> None:
    with pytest.raises(OffboardError, match="NO_SETPOINT_SET"):
        Offboard(grounded.pilot.system).start()


def test_goto_is_accepted_though_disarmed(grounded: Vehicle) -> None:
    home = grounded.pilot.telemetry.position()
    grounded.pilot.action.goto_location(home.latitude_deg, home.longitude_deg, home.absolute_altitude_m + 5.0, 0.0)
    assert not grounded.armed


def test_a_float_for_a_whole_number_is_refused_and_written_all_the_same(grounded: Vehicle) -> None:
    grounded.set({"FENCE_ACTION": 2})
    with pytest.raises(ParamError, match="WRONG_TYPE"):
        grounded.pilot.parameters.set_param_float("FENCE_ACTION", 1.0)
    assert grounded.parameter("FENCE_ACTION") == 1.0


def test_a_whole_number_for_a_float_is_refused_and_not_written(grounded: Vehicle) -> None:
    grounded.set({"FENCE_RADIUS": 120.0})
    with pytest.raises(ParamError, match="WRONG_TYPE"):
        grounded.pilot.parameters.set_param_int("FENCE_RADIUS", 130)
    assert grounded.parameter("FENCE_RADIUS") == 120.0


def test_an_unknown_parameter_is_a_time_out(grounded: Vehicle) -> None:
    began = time.monotonic()
    with pytest.raises(ParamError, match="TIMEOUT"):
        grounded.pilot.parameters.get_param_float("NO_SUCH_THING")
    assert time.monotonic() - began > UNKNOWN_S / 2


def test_a_parameter_that_was_set_is_read_back_within_three_seconds(grounded: Vehicle) -> None:
    for value in (1, 0, 1, 0):
        grounded.set({"FS_GCS_ENABLE": value})
        deadline = time.monotonic() + 3.0
        while grounded.parameter("FS_GCS_ENABLE") != value:
            assert time.monotonic() < deadline


def test_the_return_altitude_is_set_under_the_name_that_is_there(grounded: Vehicle) -> None:
    name, factor = ("RTL_ALT_M", 1.0) if grounded.knows("RTL_ALT_M") else ("RTL_ALT", 100.0)
    grounded.set({name: 15.0 * factor})
    began = time.monotonic()
    grounded.pilot.action.set_return_to_launch_altitude(25.0)
    if name == "RTL_ALT":
        assert time.monotonic() - began > UNKNOWN_S / 2  # RTL_ALT_M was tried first
    assert grounded.parameter(name) == 25.0 * factor


def test_the_ground_station_failsafe_is_off_and_watches_another_id(grounded: Vehicle) -> None:
    assert grounded.parameter("FS_GCS_ENABLE") == 0
    assert grounded.parameter(grounded.gcs_parameter) == 255


def test_without_a_radio_it_is_not_armable_though_all_is_well(grounded: Vehicle) -> None:
    grounded.faults.radio(False)
    try:
        grounded.wait(lambda: not grounded.pilot.telemetry.health().is_armable, 10.0)
        assert grounded.pilot.telemetry.health_all_ok()
    finally:
        grounded.faults.radio(True)
    grounded.wait(lambda: grounded.pilot.telemetry.health().is_armable, 20.0)
