"""RC_CHANNELS and the receiver's bits of SYS_STATUS, as one reading with two ages."""

from __future__ import annotations

import math
from typing import Any

import pytest

from hawk.comm.autopilot.remote_control import RemoteControl, RemoteControlReports
from hawk.comm.topic import Topic
from tests.manual_clock import ManualClock
from tests.unit.comm.autopilot.telemetry_rig import Rig

RECEIVER = 1 << 16


def channels(count: int = 8, **pulses: int) -> dict[str, Any]:
    """As a real ArduCopter in simulation sends them."""
    first = {"chan1_raw": 1500, "chan2_raw": 1500, "chan3_raw": 1000, "chan4_raw": 1500, "chan5_raw": 1800}
    return {f"chan{number}_raw": 0 for number in range(1, 19)} | first | pulses | {"chancount": count, "rssi": 255}


def status(*, present: bool = True, healthy: bool = True) -> dict[str, Any]:
    return {
        "onboard_control_sensors_present": RECEIVER * present | 1,
        "onboard_control_sensors_health": RECEIVER * healthy | 1,
    }


@pytest.fixture
def topic() -> Topic[RemoteControl]:
    return Topic("remote_control", ManualClock(0.0))


def heard(topic: Topic[RemoteControl]) -> RemoteControl:
    assert topic.value is not None
    return topic.value


def test_pulses_are_counted_from_one_and_absent_ones_are_zero(topic: Topic[RemoteControl]) -> None:
    RemoteControlReports(topic).take_channels(channels(chan18_raw=65535), 3.0)
    now = heard(topic)
    assert (now.pulse(5), now.pulse(6), now.pulse(18)) == (1800, 0, 0)
    assert (now.pulse(1), now.pulse(0), now.pulse(19), now.pulse(-1)) == (1500, 0, 0, 0)
    assert len(now.pulses) == 18
    assert now.receiver_time == -math.inf, "not heard yet"
    assert RemoteControl().channels == 0
    assert (now.channels, now.time, now.receiver) == (8, 3.0, None)


@pytest.mark.parametrize(
    ("present", "healthy", "hears"), [(True, True, True), (True, False, False), (False, True, False)]
)
def test_a_receiver_must_be_there_and_healthy(
    topic: Topic[RemoteControl], present: bool, healthy: bool, hears: bool
) -> None:
    RemoteControlReports(topic).take_status(status(present=present, healthy=healthy), 2.0)
    assert heard(topic).receiver is hears
    assert heard(topic).receiver_time == 2.0
    assert heard(topic).time == -math.inf


def test_a_status_without_the_bits_says_nothing(topic: Topic[RemoteControl]) -> None:
    RemoteControlReports(topic).take_status({"battery_remaining": 80}, 2.0)
    assert topic.value is None


def test_a_boot_forgets_both_and_is_counted(topic: Topic[RemoteControl]) -> None:
    reports = RemoteControlReports(topic)
    reports.take_channels(channels(), 1.0)
    reports.take_status(status(), 1.0)
    reports.forget()
    assert heard(topic) == RemoteControl(boots=1)


def test_telemetry_hears_both_and_asks_for_the_channels() -> None:
    rig = Rig()
    assert rig.rates.due(0.0)
    rig.take(rig.said.heartbeat(), ("RC_CHANNELS", channels()))
    name, fields = rig.said.system()
    rig.take((name, fields | status()))
    now = rig.topics.remote_control.value
    assert now is not None
    assert (now.channels, now.receiver, now.time) == (8, True, rig.clock())
    assert 65 in {stream.message_id for stream in Rig().rates.due(0.0)}


def test_telemetry_drops_channels_that_cannot_be_read_and_goes_on() -> None:
    rig = Rig()
    rig.take(("RC_CHANNELS", {"chancount": 8}), ("RC_CHANNELS", channels() | {"chan7_raw": None}))
    assert rig.topics.remote_control.value is None
    rig.take(("RC_CHANNELS", channels()))
    assert rig.topics.remote_control.value is not None


def test_telemetry_forgets_the_channels_at_a_boot() -> None:
    rig = Rig()
    rig.arm_here()
    rig.take(("RC_CHANNELS", channels()))
    rig.said.boot = 0.0
    rig.fly(0.7)
    assert rig.boots == 1
    assert rig.topics.remote_control.value == RemoteControl(boots=1)
