"""Rows: remote control, mode switch; the receiver's loss."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from hawk.ddc.readings.remote_control import switch_position
from tests.contract.vehicle import LOITER, STABILIZE, Vehicle

pytestmark = pytest.mark.contract
RC_CHANNELS, SYS_STATUS = 65, 1
RECEIVER = 1 << 16
AT_START = 1800
"""Pulse of the switch in both simulations, microseconds."""
MODES = (LOITER, 9, 6, 16, 2, STABILIZE)
"""LOITER, LAND, RTL, POSHOLD, ALT_HOLD, STABILIZE."""


@pytest.fixture
def radio(grounded: Vehicle) -> Iterator[Vehicle]:
    """The vehicle on the ground, its channels heard."""
    grounded.stream(RC_CHANNELS, 10.0)
    grounded.stream(SYS_STATUS, 5.0)
    before = grounded.pilot.counts.get("RC_CHANNELS", 0)
    grounded.wait(lambda: grounded.pilot.counts.get("RC_CHANNELS", 0) > before, 10.0)
    try:
        yield grounded
    finally:
        grounded.faults.radio(True)
        grounded.faults.mode_switch(AT_START)
        grounded.wait(lambda: channels(grounded)["chan5_raw"] == AT_START, 10.0)


def channels(vehicle: Vehicle) -> dict[str, Any]:
    return vehicle.pilot.messages["RC_CHANNELS"]


def receiver(vehicle: Vehicle, what: str) -> bool:
    return bool(int(vehicle.pilot.messages["SYS_STATUS"][f"onboard_control_sensors_{what}"]) & RECEIVER)


def test_the_channels_come_when_asked_for_and_the_receiver_is_healthy(radio: Vehicle) -> None:
    heard = channels(radio)
    assert [heard[f"chan{number}_raw"] for number in (1, 2, 3, 4, 5)] == [1500, 1500, 1000, 1500, AT_START]
    assert heard["chan17_raw"] == heard["chan18_raw"] == 0
    assert heard["chancount"] >= 8
    assert heard["rssi"] == 255  # not known
    radio.wait(lambda: receiver(radio, "health"), 10.0)
    assert receiver(radio, "present")
    assert receiver(radio, "enabled")


def test_the_switch_sits_on_channel_five_and_its_last_position_is_stabilize(radio: Vehicle) -> None:
    assert radio.parameter("FLTMODE_CH") == 5
    assert radio.parameter("FLTMODE6") == STABILIZE
    for position in range(1, 7):
        assert radio.knows(f"FLTMODE{position}")


@pytest.mark.fault(
    "the receiver is lost and ArduCopter repeats its last pulses",
    "SYS_STATUS decides; it says so only while FS_THR_ENABLE is not 0, which refuses Arm",
)
def test_a_lost_receiver_keeps_its_last_pulses_and_shows_in_the_health_alone(radio: Vehicle) -> None:
    radio.set({"FS_THR_ENABLE": 1})
    radio.faults.radio(False)
    assert radio.wait(lambda: not receiver(radio, "health"), 10.0) < 5.0
    assert receiver(radio, "present")
    before = radio.pilot.counts["RC_CHANNELS"]
    radio.wait(lambda: radio.pilot.counts["RC_CHANNELS"] > before + 3, 10.0)
    assert channels(radio)["chan5_raw"] == AT_START
    assert channels(radio)["chancount"] >= 8
    radio.faults.radio(True)
    radio.wait(lambda: receiver(radio, "health"), 10.0)


def test_with_its_failsafe_off_a_lost_receiver_is_not_reported(radio: Vehicle) -> None:
    radio.set({"FS_THR_ENABLE": 0})
    radio.faults.radio(False)
    radio.let_pass(4.0)
    assert receiver(radio, "health")


@pytest.mark.parametrize("pulse", [1165, 1230, 1231, 1360, 1361, 1490, 1491, 1620, 1621, 1749, 1750])
def test_each_position_commands_its_mode(radio: Vehicle, pulse: int) -> None:
    radio.set({f"FLTMODE{position}": mode for position, mode in enumerate(MODES, start=1)})
    position = switch_position(pulse)
    assert position is not None
    other = AT_START if position != 6 else 1165
    radio.faults.mode_switch(other)
    radio.wait(lambda: switch_position(channels(radio)["chan5_raw"]) == switch_position(other), 10.0)
    radio.let_pass(1.0)
    radio.faults.mode_switch(pulse)
    radio.wait(lambda: radio.mode == MODES[position - 1], 10.0)
    assert switch_position(channels(radio)["chan5_raw"]) == position


def test_a_switch_that_rests_leaves_the_mode_that_a_station_sets(radio: Vehicle) -> None:
    radio.set_mode(4)
    radio.let_pass(2.0)
    assert radio.mode == 4
