from __future__ import annotations

import asyncio
import socket
import time

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.comm.passive_listener import wait_until_disarmed

ARMED = mavlink.MAV_MODE_FLAG_SAFETY_ARMED


def heartbeat(base_mode: int, autopilot: int = mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA) -> bytes:
    message = mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_QUADROTOR, autopilot, base_mode, 4, 4, 3)
    return bytes(message.pack(mavlink.MAVLink(None, srcSystem=1, srcComponent=1)))


async def test_it_waits_for_disarmed_and_never_says_a_word(unused_udp_port: int) -> None:
    waiting = asyncio.create_task(wait_until_disarmed(f"udpin://127.0.0.1:{unused_udp_port}", 60))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vehicle:
        vehicle.bind(("127.0.0.1", 0))
        vehicle.setblocking(False)
        await asyncio.sleep(0)
        for noise in (b"not MAVLink", heartbeat(ARMED), heartbeat(0, mavlink.MAV_AUTOPILOT_INVALID)):
            for _ in range(5):
                vehicle.sendto(noise, ("127.0.0.1", unused_udp_port))
                await asyncio.sleep(0.01)
        assert not waiting.done()
        async with asyncio.timeout(10):
            while not waiting.done():
                vehicle.sendto(heartbeat(0), ("127.0.0.1", unused_udp_port))
                await asyncio.sleep(0.01)
        with pytest.raises(BlockingIOError):
            vehicle.recv(1)
    assert await waiting


@pytest.mark.parametrize("url", ["serial:///dev/ttyAMA0:921600", "udpout://127.0.0.1:14550"])
async def test_a_link_that_cannot_be_listened_to_is_left_alone_for_a_while(url: str) -> None:
    began = time.monotonic()
    assert not await wait_until_disarmed(url, 0.2)
    assert time.monotonic() - began >= 0.19


async def test_a_port_that_somebody_else_holds_is_left_alone_for_a_while_too() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        began = time.monotonic()
        assert not await wait_until_disarmed(f"udpin://127.0.0.1:{other.getsockname()[1]}", 0.2)
        assert time.monotonic() - began >= 0.19
