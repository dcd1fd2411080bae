from __future__ import annotations

import asyncio
import socket
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.comm.passive_listener import heartbeats, wait_until_disarmed

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


def packed(message: mavlink.MAVLink_message, *, version_1: bool = False, key: bytes | None = None) -> bytes:
    sender = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    if key is not None:
        sender.signing.secret_key, sender.signing.sign_outgoing = key, True
    return bytes(message.pack(sender, force_mavlink1=version_1))


@given(
    mode=st.integers(0, 2**32 - 1), kind=st.integers(0, 255), autopilot=st.integers(0, 255), base=st.integers(0, 255),
    status=st.integers(0, 255), version_1=st.booleans(), signed=st.booleans(), noise=st.binary(max_size=40),
)  # fmt: skip
def test_heartbeats_are_read_as_pymavlink_packs_them(
    mode: int, kind: int, autopilot: int, base: int, status: int, version_1: bool, signed: bool, noise: bytes
) -> None:
    message = mavlink.MAVLink_heartbeat_message(kind, autopilot, base, mode, status, 3)
    data = packed(message, version_1=version_1, key=b"k" * 32 if signed and not version_1 else None)
    noise = noise.translate(None, b"\xfd\xfe")
    assert list(heartbeats(noise + data + data)) == [(autopilot, base)] * 2


def test_a_heartbeat_is_found_after_other_messages_in_the_same_datagram() -> None:
    others = packed(mavlink.MAVLink_attitude_message(1, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0))
    others += packed(mavlink.MAVLink_statustext_message(6, b"Arming motors"))
    assert list(heartbeats(others + heartbeat(ARMED) + others)) == [(3, ARMED)]


def test_a_damaged_or_cut_heartbeat_is_none() -> None:
    whole = heartbeat(0)
    for length in range(len(whole)):
        assert list(heartbeats(whole[:length])) == []
    for position in range(len(whole)):
        damaged = bytearray(whole)
        damaged[position] ^= 0x10
        assert list(heartbeats(bytes(damaged))) == []


@given(st.binary(max_size=300))
def test_any_datagram_is_survived(data: bytes) -> None:
    for autopilot, base_mode in heartbeats(data):
        assert {autopilot, base_mode} <= set(range(256))
