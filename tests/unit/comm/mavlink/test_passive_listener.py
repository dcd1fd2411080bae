from __future__ import annotations

import asyncio
import socket
import time

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.comm.mavlink.passive_listener import _Listener, wait_until_disarmed
from hawk.comm.mavlink.peer import Expected

ARMED = mavlink.MAV_MODE_FLAG_SAFETY_ARMED


def heartbeat(base_mode: int, autopilot: int = mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, system: int = 1) -> bytes:
    message = mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_QUADROTOR, autopilot, base_mode, 4, 4, 3)
    return bytes(message.pack(mavlink.MAVLink(None, srcSystem=system, srcComponent=1)))


async def test_it_waits_for_disarmed_and_never_says_a_word(unused_udp_port: int) -> None:
    waiting = asyncio.create_task(wait_until_disarmed(f"udpin://127.0.0.1:{unused_udp_port}", 60, sure_s=0.05))
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


class Heard:
    """A listener whose clock the test moves."""

    def __init__(self, expected: Expected) -> None:
        self.now = 0.0
        self.listener = _Listener(expected, 2.0, lambda: self.now)

    def hear(self, data: bytes, port: int, pause: float = 0.5) -> bool:
        """Take a datagram after a pause; return True once "disarmed" is believed."""
        self.now += pause
        self.listener.datagram_received(data, ("127.0.0.1", port))
        return self.listener.disarmed.is_set()


@pytest.mark.fault(
    "a forger beside the autopilot while the daemon only listens after crashes in the air",
    '"disarmed" is believed after 2 s from one sender without a second one',
)
def test_one_forged_disarmed_is_not_believed() -> None:
    heard = Heard(Expected())
    assert not heard.hear(heartbeat(0), 6666)  # the forger came first
    for _ in range(20):
        assert not heard.hear(heartbeat(ARMED), 5000)
        assert not heard.hear(heartbeat(0), 6666)


def test_a_forger_beside_the_kept_autopilot_changes_nothing() -> None:
    heard = Heard(Expected())
    heard.hear(heartbeat(ARMED), 5000)
    for _ in range(20):
        assert not heard.hear(heartbeat(0), 6666, 0.1)
        assert not heard.hear(heartbeat(ARMED), 5000, 0.9)


def test_another_vehicle_behind_the_router_is_not_the_drone() -> None:
    heard = Heard(Expected(system_id=1))
    for _ in range(10):
        assert not heard.hear(heartbeat(ARMED) + heartbeat(0, system=7), 5000)


def test_disarmed_is_believed_when_it_lasts_and_begins_again_when_it_does_not() -> None:
    heard = Heard(Expected())
    for mode in (0, 0, 0, ARMED, 0, 0, 0, 0):
        assert not heard.hear(heartbeat(mode), 5000)
    assert heard.hear(heartbeat(0), 5000)
