from __future__ import annotations

import asyncio
import contextlib
import logging
from pathlib import Path

import pytest

from hawk.comm.autopilot.autopilot import MavsdkAutopilot
from hawk.comm.autopilot.mavlink_link import Link
from hawk.comm.autopilot.vehicle import AutopilotError, VehicleTopics
from hawk.comm.clock import Clock
from hawk.config.sections import AutopilotSettings
from hawk.runtime.repeated_log import EVERY_S, Repeated
from tests.manual_clock import ManualClock


def test_what_stays_wrong_is_reported_at_once_and_then_once_a_minute() -> None:
    clock = ManualClock()
    repeated = Repeated(clock)
    said = []
    for _ in range(int(5 * EVERY_S)):
        said.append(repeated.due("no device"))
        clock.advance(0.5)
    shown = [line for line in said if line]
    assert shown[0] == "no device"
    assert shown[1] == "no device (119 times more in the last 60 s)"
    assert len(shown) == 3


def test_another_line_is_reported_at_once_and_one_that_ended_too() -> None:
    repeated = Repeated(ManualClock())
    assert repeated.due("a") == "a"
    assert repeated.due("b") == "b"
    assert repeated.due("a") is None
    repeated.ends()
    assert repeated.due("a") == "a"


def test_few_lines_are_remembered() -> None:
    repeated = Repeated(ManualClock())
    for number in range(1000):
        assert repeated.due(str(number)) == str(number)
    assert len(repeated._said) < 100


def test_a_device_that_is_not_there_is_named_before_mavsdk_is_asked(tmp_path: Path) -> None:
    link = Link(f"serial://{tmp_path}/ttyUSB0:57600", 245, Clock(), lambda _: None)
    with pytest.raises(AutopilotError, match=r"autopilot\.url: .*/ttyUSB0 is not there: .*plug"):
        link.open()
    link.close()


@pytest.mark.slow
async def test_a_missing_serial_device_is_logged_once_though_it_is_looked_for_twice_a_second(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    clock = Clock()
    settings = AutopilotSettings(url=f"serial://{tmp_path}/ttyUSB0:57600")
    autopilot = MavsdkAutopilot(settings, clock, VehicleTopics.create(clock))
    with caplog.at_level(logging.INFO):
        await autopilot.start()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(2.2):
                await asyncio.Event().wait()
        await autopilot.close()
    assert "ttyUSB0 is not there" in autopilot.problem
    shown = [
        record for record in caplog.records if "ttyUSB0" in record.getMessage() or "open failed" in record.getMessage()
    ]
    assert len(shown) == 1
    assert shown[0].levelno == logging.WARNING
