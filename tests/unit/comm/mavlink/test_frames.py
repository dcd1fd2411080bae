from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.comm.mavlink.frames import Heartbeat, ground_station_heartbeat, heartbeats, is_mavlink_1, system_of
from tests.sweep import sweep

ARMED = mavlink.MAV_MODE_FLAG_SAFETY_ARMED


def heartbeat(base_mode: int, autopilot: int = mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA) -> bytes:
    return packed(mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_QUADROTOR, autopilot, base_mode, 4, 4, 3))


def packed(
    message: mavlink.MAVLink_message,
    *,
    version_1: bool = False,
    key: bytes | None = None,
    ids: tuple[int, int] = (1, 1),
) -> bytes:
    sender = mavlink.MAVLink(None, *ids)
    if key is not None:
        sender.signing.secret_key, sender.signing.sign_outgoing = key, True
    return bytes(message.pack(sender, force_mavlink1=version_1))


@pytest.mark.slow
@given(
    mode=st.integers(0, 2**32 - 1), kind=st.integers(0, 255), autopilot=st.integers(0, 255), base=st.integers(0, 255),
    status=st.integers(0, 255), version_1=st.booleans(), signed=st.booleans(), noise=st.binary(max_size=40),
    ids=st.tuples(st.integers(0, 255), st.integers(0, 255)),
)  # fmt: skip
def test_heartbeats_are_read_as_pymavlink_packs_them(
    mode: int,
    kind: int,
    autopilot: int,
    base: int,
    status: int,
    version_1: bool,
    signed: bool,
    noise: bytes,
    ids: tuple[int, int],
) -> None:
    message = mavlink.MAVLink_heartbeat_message(kind, autopilot, base, mode, status, 3)
    data = packed(message, version_1=version_1, key=b"k" * 32 if signed and not version_1 else None, ids=ids)
    noise = noise.translate(None, b"\xfd\xfe")
    assert list(heartbeats(noise + data + data)) == [Heartbeat(*ids, kind, autopilot, base)] * 2
    assert system_of(data) == ids[0]


def test_a_heartbeat_is_found_after_other_messages_in_the_same_datagram() -> None:
    others = packed(mavlink.MAVLink_attitude_message(1, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0))
    others += packed(mavlink.MAVLink_statustext_message(6, b"Arming motors"))
    assert list(heartbeats(others + heartbeat(ARMED) + others)) == [Heartbeat(1, 1, 2, 3, ARMED)]


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
    system_of(data)
    for beat in heartbeats(data):
        assert {beat.system, beat.component, beat.autopilot, beat.base_mode} <= set(range(256))


def test_our_heartbeat_is_a_ground_stations_as_pymavlink_reads_it() -> None:
    (beat,) = mavlink.MAVLink(None).parse_buffer(ground_station_heartbeat(245, 190))
    assert (beat.get_srcSystem(), beat.get_srcComponent()) == (245, 190)
    assert (beat.type, beat.autopilot, beat.base_mode) == (mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0)
    assert not next(heartbeats(ground_station_heartbeat(245, 190))).is_of_an_autopilot


@sweep(
    ("kind", "autopilot", "component", "is_copter"),
    [
        *((kind, 3, 1, True) for kind in (2, 3, 4, 13, 14, 15, 29, 35, 43)),
        *((kind, 3, 1, False) for kind in (0, 1, 5, 6, 10, 11, 12, 18, 20, 26, 27, 30, 99)),
        (2, 12, 1, False),
        (2, 8, 1, False),
        (2, 3, 154, False),
    ],
)
def test_a_copter_is_known_by_type_autopilot_and_component(
    kind: int, autopilot: int, component: int, is_copter: bool
) -> None:
    message = mavlink.MAVLink_heartbeat_message(kind, autopilot, 0, 4, 4, 3)
    (beat,) = heartbeats(packed(message, ids=(9, component)))
    assert beat.is_of_a_copter is is_copter
    assert beat.is_disarmed_copter is is_copter


def test_the_version_of_a_frame_is_known_for_the_system_that_is_asked_for() -> None:
    message = mavlink.MAVLink_attitude_message(1, 0, 0, 0, 0, 0, 0)
    for version_1 in (True, False):
        data = packed(message, version_1=version_1, ids=(7, 1))
        assert is_mavlink_1(data, 7) is version_1
        assert is_mavlink_1(data, 8) is None
    assert is_mavlink_1(b"", 7) is None
    assert is_mavlink_1(b"noise", 7) is None
