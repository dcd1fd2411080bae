"""A forger who sends to the autopilot's port beside the autopilot: not believed, shown, and no reason to land."""

from __future__ import annotations

import asyncio
import contextlib
import functools
import socket
from collections.abc import AsyncIterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.comm.protocol.commands import Arm
from hawk.comm.protocol.heartbeat import Heartbeat
from hawk.model.operation import StateName
from hawk.survey.stack import SimulatedStack
from tests.integration.daemon_support import health, operator, over_a_picture

pytestmark = pytest.mark.integration

FORGED_HZ = 20.0
FORGED_BEATS = 8
"""Heartbeats to the operator through which the forger goes on."""


def lies(system: int) -> list[bytes]:
    """Return HEARTBEAT, EXTENDED_SYS_STATE, LOCAL_POSITION_NED and SYS_STATUS of a drone that stands and is empty."""
    mav = mavlink.MAVLink(None, system, 1)
    messages = (
        mavlink.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3),
        mavlink.MAVLink_extended_sys_state_message(0, mavlink.MAV_LANDED_STATE_ON_GROUND),
        mavlink.MAVLink_local_position_ned_message(1, 500.0, 500.0, 0.0, 0.0, 0.0, 0.0),
        mavlink.MAVLink_sys_status_message(0, 0, 0, 0, 9000, 0, 1, 0, 0, 0, 0, 0, 0),
    )
    return [bytes(message.pack(mav)) for message in messages]


@contextlib.asynccontextmanager
async def forger(stack: SimulatedStack, *systems: int) -> AsyncIterator[str]:
    """Forge telemetry of these system ids; gives the forger's address."""
    assert stack.address is not None
    place = urlsplit(stack.address.autopilot_url)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.connect((place.hostname, place.port))

        async def forge() -> None:
            while True:
                for lie in (lie for system in systems for lie in lies(system)):
                    sender.send(lie)
                await asyncio.sleep(1 / FORGED_HZ)

        forging = asyncio.create_task(forge())
        try:
            yield f"127.0.0.1:{sender.getsockname()[1]}"
        finally:
            forging.cancel()
            await asyncio.gather(forging, return_exceptions=True)


def is_shown(address: str, beat: Heartbeat) -> bool:
    part = health(beat, "link")
    return not part.healthy and f"{address} (system 1) sends to the autopilot's port, too." in part.reason


@pytest.mark.fault(
    "another sender forges HEARTBEAT, EXTENDED_SYS_STATE, position and battery, with the autopilot's system "
    "id and another one",
    "nothing of it is believed; the link's health and a message name address and system id within 1 s; Arm is "
    "refused until it is silent for 10 s; in flight the drone flies on by the first sender",
)
async def test_forged_telemetry_changes_nothing_but_the_health_of_the_link(tmp_path: Path) -> None:
    stack = over_a_picture(tmp_path)
    try:
        url = (await stack.start()).url
        async with operator(url) as flyer:
            await flyer.until(lambda beat: beat.connected and bool(beat.checks))
            async with forger(stack, 1) as address:
                await flyer.take_control()
                beat = await flyer.until(functools.partial(is_shown, address))
                assert not next(check for check in beat.checks if check.name == "Link").passed
                assert address in await flyer.refusal(Arm())
            await flyer.take_off()  # once the forger is silent
            async with forger(stack, 1, 7) as address:
                await flyer.until(functools.partial(is_shown, address))
                for _ in range(FORGED_BEATS):
                    beat = await flyer.hand.next()
                    assert (beat.state, beat.armed, beat.ardupilot_state) == (StateName.HOVER, True, "GUIDED")
                    assert (beat.battery_percentage or 0.0) > 50
                assert any(address in entry.details for entry in flyer.drone.log)
            await flyer.come_home()
    finally:
        await stack.stop()
