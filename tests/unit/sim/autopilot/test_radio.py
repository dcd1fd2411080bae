"""The pilot's remote control of the simulated ArduCopter, as the real one showed it."""

from __future__ import annotations

from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.autopilot.modes import ModeNumber
from hawk.sim.autopilot.parameters import copter_parameters
from hawk.sim.autopilot.radio import POSITIONS, Radio
from hawk.sim.autopilot.telemetry import build
from tests.unit.sim.test_faults import put

RECEIVER = mavlink.MAV_SYS_STATUS_SENSOR_RC_RECEIVER


def channels(station: Any) -> Any:
    return build(mavlink.MAVLINK_MSG_ID_RC_CHANNELS, station.autopilot)


def status(station: Any) -> tuple[bool, bool, bool]:
    found = build(mavlink.MAVLINK_MSG_ID_SYS_STATUS, station.autopilot)
    bits = ("present", "enabled", "health")
    present, enabled, health = (bool(getattr(found, f"onboard_control_sensors_{bit}") & RECEIVER) for bit in bits)
    return present, enabled, health


def test_eight_channels_with_the_switch_in_its_last_position(make_station: Any) -> None:
    station = make_station()
    station.run(0.1)
    heard = channels(station)
    assert (heard.chancount, heard.rssi) == (8, 255)
    assert [heard.chan1_raw, heard.chan3_raw, heard.chan5_raw, heard.chan9_raw] == [1500, 1000, 1800, 0]
    assert status(station) == (True, True, True)


@pytest.mark.slow
def test_a_lost_receiver_keeps_its_pulses_and_is_reported_a_second_later(flying: Any) -> None:
    put(flying, radio="lost")
    flying.run(0.9)
    assert status(flying) == (True, True, True)
    flying.run(0.4)
    assert status(flying) == (True, True, False)
    assert (channels(flying).chancount, channels(flying).chan5_raw) == (8, 1800)
    put(flying, radio="ok")
    flying.run(0.3)
    assert status(flying) == (True, True, True)


def test_with_its_failsafe_off_the_loss_is_not_reported(flying: Any) -> None:
    flying.set_parameter("FS_THR_ENABLE", 0)
    put(flying, radio="lost")
    flying.run(3.0)
    assert status(flying) == (True, True, True)


def test_a_receiver_that_was_never_heard_is_not_there(make_station: Any) -> None:
    station = make_station()
    station.autopilot.radio_present = False
    station.autopilot.boot()
    station.run(2.0)
    assert status(station) == (False, False, False)
    assert (channels(station).chancount, channels(station).chan5_raw) == (0, 0)
    station.autopilot.radio_present = True
    station.run(0.3)
    assert status(station) == (True, True, True)


def test_the_switch_changes_the_mode_once_it_rests(flying: Any) -> None:
    flying.set_parameter("FLTMODE2", ModeNumber.LOITER)
    put(flying, mode_switch=2)
    flying.run(0.1)
    assert flying.autopilot.mode.number == ModeNumber.GUIDED
    flying.run(0.3)
    assert flying.autopilot.mode.number == ModeNumber.LOITER
    flying.command(mavlink.MAV_CMD_DO_SET_MODE, 1, ModeNumber.GUIDED)
    flying.run(1.0)
    assert flying.autopilot.mode.number == ModeNumber.GUIDED  # a switch that rests says nothing
    assert channels(flying).chan5_raw == POSITIONS[1]


def test_a_mode_that_cannot_be_flown_is_not_changed_to(flying: Any) -> None:
    flying.set_parameter("FLTMODE1", 3)  # AUTO is not flown here
    put(flying, mode_switch=1)
    flying.run(0.5)
    assert flying.autopilot.mode.number == ModeNumber.GUIDED


@pytest.mark.parametrize("spoil", ["lost", "no channel", "no pulse"])
def test_a_switch_that_is_not_heard_changes_nothing(spoil: str) -> None:
    parameters, radio = copter_parameters(), Radio()
    parameters.set("FLTMODE1", ModeNumber.LOITER)
    for step in range(10):
        assert radio.step(parameters, True, 0.0, step * 0.1) is None
    radio.switch = 800 if spoil == "no pulse" else POSITIONS[0]
    if spoil == "no channel":
        parameters.set("FLTMODE_CH", 0)
    for step in range(10, 30):
        assert radio.step(parameters, spoil != "lost", 0.0, step * 0.1) is None
    radio.switch = POSITIONS[0]
    parameters.set("FLTMODE_CH", 5)
    modes = [radio.step(parameters, True, 0.0, step * 0.1) for step in range(30, 40)]
    assert [mode for mode in modes if mode is not None] == [ModeNumber.LOITER]
