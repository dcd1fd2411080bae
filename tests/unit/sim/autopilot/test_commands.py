from __future__ import annotations

import math
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.autopilot.modes import ModeNumber

ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4


def test_what_is_not_known_is_unsupported(station: Any) -> None:
    assert station.command(mavlink.MAV_CMD_DO_MOTOR_TEST, 1) == UNSUPPORTED


@pytest.mark.parametrize("values", [(2.0,), (math.nan,)])
def test_arming_takes_one_or_zero(station: Any, values: tuple[float, ...]) -> None:
    station.wait_for_position()
    assert station.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, *values) == FAILED
    assert not station.autopilot.armed


@pytest.mark.parametrize("values", [(0.0, 4.0), (math.nan, 4.0), (1.0, math.nan), (1.0, 1e9)])
def test_nonsense_modes_fail(station: Any, values: tuple[float, ...]) -> None:
    assert station.command(mavlink.MAV_CMD_DO_SET_MODE, *values) == FAILED
    assert station.autopilot.mode.number == 0


@pytest.mark.slow
def test_land_and_return_as_commands(flying: Any) -> None:
    assert flying.command(mavlink.MAV_CMD_NAV_LAND) == ACCEPTED
    assert flying.autopilot.mode.number == 9
    assert flying.command(mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH) == ACCEPTED
    assert flying.autopilot.mode.number == 6


@pytest.mark.slow
def test_terminate_needs_its_one(flying: Any) -> None:
    assert flying.command(mavlink.MAV_CMD_DO_FLIGHTTERMINATION, 0) == ACCEPTED
    assert flying.autopilot.armed


def test_forced_arming_skips_the_checks(make_station: Any) -> None:
    station = make_station(gnss_wait_s=60.0)
    station.mode(4)
    assert station.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1, 2989) == ACCEPTED
    assert station.autopilot.armed


@pytest.mark.slow
def test_speed_and_heading(flying: Any) -> None:
    assert flying.command(mavlink.MAV_CMD_DO_CHANGE_SPEED, 1, 3.0) == ACCEPTED
    assert flying.command(mavlink.MAV_CMD_CONDITION_YAW, 90) == ACCEPTED
    flying.run(6.0)
    assert flying.autopilot.body.yaw == pytest.approx(math.pi / 2, abs=0.05)
    assert flying.command(mavlink.MAV_CMD_CONDITION_YAW, 30, 0, -1, 1) == ACCEPTED
    flying.run(6.0)
    assert flying.autopilot.body.yaw == pytest.approx(math.pi / 3, abs=0.05)
    flying.mode(17)
    assert flying.command(mavlink.MAV_CMD_DO_CHANGE_SPEED, 1, 3.0) == FAILED


def test_the_fence_can_be_switched(station: Any) -> None:
    def enabled() -> bool:
        station.command(mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_SYS_STATUS)
        status = station.last("SYS_STATUS").onboard_control_sensors_enabled
        return bool(status & mavlink.MAV_SYS_STATUS_GEOFENCE)

    parameters = station.autopilot.parameters
    assert not enabled()
    assert station.command(mavlink.MAV_CMD_DO_FENCE_ENABLE, 1) == ACCEPTED
    assert (enabled(), parameters["FENCE_ENABLE"]) == (True, 0)
    parameters.set("FENCE_ENABLE", 1)
    assert station.command(mavlink.MAV_CMD_DO_AUX_FUNCTION, 11, 0) == ACCEPTED
    assert (enabled(), parameters["FENCE_ENABLE"]) == (False, 1)
    parameters.set("FENCE_ENABLE", 1)
    assert not enabled(), "the same value again turns nothing on"
    parameters.set("FENCE_ENABLE", 0)
    assert not enabled()
    parameters.set("FENCE_ENABLE", 1)
    assert enabled()
    assert station.command(mavlink.MAV_CMD_DO_AUX_FUNCTION, 12, 2) == FAILED
    station.command(mavlink.MAV_CMD_DO_FENCE_ENABLE, 0)
    station.autopilot.reboot()
    assert enabled()
    parameters.set("FENCE_ACTION", 0)
    assert not enabled(), "a fence that only reports is none"


@pytest.mark.slow
def test_reposition_in_another_mode_needs_its_flag(flying: Any) -> None:
    flying.mode(17)
    home = flying.autopilot.home
    latitude, longitude, _ = flying.autopilot.origin.to_geodetic((home[0] + 5, home[1], home[2]))
    place = (0.0, latitude, longitude, 15.0)
    assert flying.command(mavlink.MAV_CMD_DO_REPOSITION, -1, 0, 0, *place) == DENIED
    assert flying.command(mavlink.MAV_CMD_DO_REPOSITION, -1, 1, 0, *place) == ACCEPTED
    assert flying.autopilot.mode.number == 4
    flying.run(8.0)
    assert flying.autopilot.body.height == pytest.approx(15.0, abs=0.3)


@pytest.mark.slow
def test_reposition_to_nowhere_is_denied(flying: Any) -> None:
    assert flying.command(mavlink.MAV_CMD_DO_REPOSITION, -1, 0, 0, 0, math.nan, 0, 15) == DENIED
    assert not flying.autopilot.stopped


@pytest.mark.slow
def test_home_can_be_set(flying: Any) -> None:
    flying.local_target(10.0, 0.0, -12.0)
    flying.run(6.0)
    assert flying.command(mavlink.MAV_CMD_DO_SET_HOME, 1) == ACCEPTED
    assert flying.autopilot.home[0] == pytest.approx(10.0, abs=0.3)
    assert flying.all("HOME_POSITION")


def set_home(station: Any, north: float, up: float = 0.0) -> None:
    """Send DO_SET_HOME as a COMMAND_INT, as a second station does."""
    latitude, longitude, altitude = station.autopilot.origin.to_geodetic((north, 0.0, -up))
    place = (round(latitude * 1e7), round(longitude * 1e7), altitude)
    station.send(mavlink.MAVLink_command_int_message(1, 1, 0, mavlink.MAV_CMD_DO_SET_HOME, 0, 0, 0, 0, 0, 0, *place))
    station.listen()


@pytest.mark.nightly
def test_a_home_that_is_moved_is_reported_at_once_and_rtl_flies_there(flying: Any) -> None:
    flying.heard.clear()
    set_home(flying, 60.0)
    assert flying.last("HOME_POSITION").x == pytest.approx(60.0, abs=0.1)
    flying.mode(ModeNumber.RTL)
    flying.run(90.0, until=lambda: not flying.autopilot.armed)
    assert flying.autopilot.body.position[0] == pytest.approx(60.0, abs=1.0)


@pytest.mark.nightly
def test_rtl_flies_to_home_as_it_was_when_rtl_began(flying: Any) -> None:
    """As on a real ArduCopter: 60 m north, set back during RTL, landed 60 m north."""
    set_home(flying, 60.0)
    flying.mode(ModeNumber.RTL)
    flying.run(8.0)
    set_home(flying, 0.0)
    flying.run(10.0)
    assert flying.autopilot.body.position[0] == pytest.approx(60.0, abs=3.0)
    flying.mode(ModeNumber.GUIDED)
    flying.mode(ModeNumber.RTL)
    flying.run(90.0, until=lambda: not flying.autopilot.armed)
    assert flying.autopilot.body.position[0] == pytest.approx(0.0, abs=1.0)


def test_a_home_that_was_set_stays_at_the_next_arming_and_a_boot_frees_it(station: Any) -> None:
    station.wait_for_position()
    set_home(station, 40.0)
    station.mode(ModeNumber.GUIDED)
    assert station.arm() == 0
    assert station.autopilot.home[0] == pytest.approx(40.0, abs=0.1)
    station.autopilot.boot()
    station.run(5.0)
    station.mode(ModeNumber.GUIDED)
    assert station.arm() == 0
    assert station.autopilot.home[0] == pytest.approx(0.0, abs=0.1)


@pytest.mark.slow
def test_home_may_be_set_to_where_it_is_by_no_place(flying: Any) -> None:
    set_home(flying, 60.0)
    assert flying.command(mavlink.MAV_CMD_DO_SET_HOME, 0, 0, 0, 0, 0, 0, 0) == 0
    assert flying.autopilot.home == flying.autopilot.estimate.position


def test_home_cannot_be_set_before_there_is_a_position(make_station: Any) -> None:
    station = make_station(gnss_wait_s=60.0)
    assert station.command(mavlink.MAV_CMD_DO_SET_HOME, 1) == FAILED


def test_the_checks_can_be_asked_for(station: Any) -> None:
    station.wait_for_position()
    station.autopilot.radio_present = False
    station.run(1.5)
    station.heard.clear()
    assert station.command(mavlink.MAV_CMD_RUN_PREARM_CHECKS) == ACCEPTED
    assert station.texts() == ["PreArm: Radio failsafe on"]


def test_only_a_plain_reboot_is_known(station: Any) -> None:
    assert station.command(mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 2) == UNSUPPORTED
