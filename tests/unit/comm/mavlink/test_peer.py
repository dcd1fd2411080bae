from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.comm.mavlink.peer import OTHER_HOST_S, SHOWN_S, SILENT_S, Expected, PeerKeeper, address_text, plain_host

AUTOPILOT = ("192.168.1.10", 5000)
AGAIN = ("192.168.1.10", 5001)
STRANGER = ("192.168.1.66", 6000)


def beat(system: int = 1, component: int = 1, autopilot: int = 3, kind: int = 2) -> bytes:
    message = mavlink.MAVLink_heartbeat_message(kind, autopilot, 0, 4, 4, 3)
    return bytes(message.pack(mavlink.MAVLink(None, system, component)))


def attitude(system: int = 1) -> bytes:
    return bytes(mavlink.MAVLink_attitude_message(1, 0, 0, 0, 0, 0, 0).pack(mavlink.MAVLink(None, system, 1)))


@pytest.fixture
def keeper() -> PeerKeeper:
    """A keeper that heard its autopilot at second 0."""
    keeper = PeerKeeper(Expected())
    assert keeper.admit(AUTOPILOT, beat(), 0.0)
    return keeper


@pytest.mark.parametrize(
    "noise", [b"", b"hello", attitude(), beat(component=154), beat(autopilot=8), beat()[:-1], beat(1, 190, 8)]
)
def test_only_an_autopilots_heartbeat_makes_a_sender_the_kept_one(noise: bytes) -> None:
    keeper = PeerKeeper(Expected())
    assert not keeper.admit(STRANGER, noise, 0.0)
    assert (keeper.kept, keeper.refused, keeper.second_sender(0.0)) == (None, 1, "")
    assert keeper.admit(AUTOPILOT, attitude() + beat(3), 0.1)
    assert (keeper.kept, keeper.system_id) == (AUTOPILOT, 3)
    assert keeper.admit(AUTOPILOT, attitude(), 0.2)


def test_a_second_sender_is_refused_and_shown_while_it_is_heard(keeper: PeerKeeper) -> None:
    assert not keeper.admit(STRANGER, beat(), 1.0)
    assert not keeper.admit(("192.168.1.66", 6001), attitude(), 2.0)  # the same host: the same sender
    words = "192.168.1.66:6000 (system 1) sends to the autopilot's port, too. It is not heard."
    assert keeper.second_sender(2.0 + SHOWN_S) == words
    assert keeper.second_sender(2.1 + SHOWN_S) == ""
    assert not keeper.admit(AGAIN, b"junk", 20.0)
    assert keeper.second_sender(20.0).startswith("192.168.1.10:5001 (no MAVLink) sends")
    assert (keeper.kept, keeper.refused) == (AUTOPILOT, 3)


def test_a_copter_that_is_waited_with_is_no_second_sender() -> None:
    keeper = PeerKeeper(Expected(wait_s=2.0))
    assert not keeper.admit(AUTOPILOT, beat(), 0.0), "another copter may be heard yet"
    assert keeper.second_sender(0.0) == ""
    assert not keeper.admit(AUTOPILOT, attitude(), 0.5)
    assert not keeper.admit(AUTOPILOT, beat(), 1.0)
    assert keeper.second_sender(1.0) == ""
    assert keeper.admit(AUTOPILOT, beat(), 2.0)


def test_a_router_that_starts_again_is_heard_on_its_new_port_once_the_old_one_is_silent(keeper: PeerKeeper) -> None:
    assert not keeper.admit(AGAIN, beat(), 1.0)
    assert not keeper.admit(AGAIN, beat(2), SILENT_S + 0.1), "another system id"
    assert not keeper.admit(AGAIN, attitude(), SILENT_S + 0.1), "no heartbeat"
    assert keeper.admit(AGAIN, beat(), SILENT_S + 0.2)
    assert (keeper.kept, keeper.second_sender(SILENT_S + 0.2)) == (AGAIN, "")
    assert not keeper.admit(AUTOPILOT, beat(), SILENT_S + 0.3)


def test_another_host_waits_much_longer(keeper: PeerKeeper) -> None:
    assert not keeper.admit(STRANGER, beat(), OTHER_HOST_S - 0.1)
    assert keeper.admit(STRANGER, beat(), OTHER_HOST_S)


@pytest.mark.parametrize("rival", [AGAIN, STRANGER])
def test_a_sender_that_spoke_beside_the_kept_one_never_replaces_it(keeper: PeerKeeper, rival: tuple[str, int]) -> None:
    keeper.admit(rival, beat(), 1.0)
    keeper.heard(2.0)
    for second in range(3, 300):
        assert not keeper.admit(rival, beat(), float(second))
    if rival == STRANGER:
        assert not keeper.admit(("192.168.1.66", 7777), beat(), 301.0), "its other ports are the same rival"
    assert keeper.admit(AUTOPILOT, beat(), 302.0)


@pytest.mark.parametrize(
    ("expected", "allowed"),
    [
        (Expected(system_id=1, host="192.168.1.10"), AUTOPILOT),
        (Expected(host="192.168.1.10"), ("::ffff:192.168.1.10", 9)),
        (Expected(host="192.168.1.10", port=5000), AUTOPILOT),
    ],
)
def test_the_expected_address_is_kept_though_another_speaks_first(expected: Expected, allowed: tuple[str, int]) -> None:
    keeper = PeerKeeper(expected)
    assert not keeper.admit(STRANGER, beat(), 0.0)
    words = "192.168.1.66:6000 (system 1) sends to the autopilot's port, but is not the expected autopilot."
    assert keeper.second_sender(0.0) == words
    assert keeper.admit(allowed, beat(), 1.0)
    assert not keeper.admit(STRANGER, beat(), 1000.0)
    assert not keeper.admit(("192.168.1.10", 4999), beat(7), 1000.0)


def test_an_expected_system_id_is_waited_for() -> None:
    keeper = PeerKeeper(Expected(system_id=7))
    assert not keeper.admit(STRANGER, beat(1), 0.0)
    assert keeper.admit(AUTOPILOT, beat(1) + beat(7), 1.0)
    assert keeper.system_id == 7


def test_addresses_are_written_as_they_are_entered() -> None:
    assert address_text(("::ffff:10.0.0.1", 5)) == "10.0.0.1:5"
    assert address_text(("fe80::1", 5)) == "[fe80::1]:5"
    assert plain_host("no-number") == "no-number"


def test_a_thousand_senders_are_not_all_remembered(keeper: PeerKeeper) -> None:
    for number in range(1000):
        assert not keeper.admit((f"10.0.{number // 250}.{number % 250}", 1), beat(), 0.01 * number)
    assert len(keeper._strangers) <= 256
    assert keeper.refused == 1000


@given(
    st.lists(
        st.tuples(
            st.sampled_from([AUTOPILOT, STRANGER, ("192.168.1.66", 1), ("10.1.1.1", 3)]),
            st.sampled_from([beat(1), beat(2), attitude(), b"junk"]),
            st.floats(0.0, 2.9),
        ),
        max_size=60,
    )
)  # fmt: skip
def test_while_the_kept_sender_is_heard_nobody_else_is(events: list[tuple[tuple[str, int], bytes, float]]) -> None:
    keeper, now = PeerKeeper(Expected()), 0.0
    assert keeper.admit(AUTOPILOT, beat(), now)
    for sender, data, pause in events:
        now += pause / 2
        assert keeper.admit(sender, data, now) == (sender == AUTOPILOT)
        now += pause / 2
        keeper.heard(now)
        assert (keeper.kept, keeper.system_id) == (AUTOPILOT, 1)


TRACKER, ROVER = 5, 10


@pytest.mark.fault(
    "an antenna tracker, rover, plane or another autopilot is heard first, on a UDP port or on one line with "
    "the copter",
    "it is never taken for the vehicle; the copter is waited for, and what is heard meanwhile is named",
)
@pytest.mark.parametrize(
    ("other", "words"),
    [
        (beat(2, kind=TRACKER), "antenna tracker (ArduPilot)"),
        (beat(2, kind=ROVER), "rover (ArduPilot)"),
        (beat(2, autopilot=12), "quadrotor (PX4)"),
        (beat(2, kind=77), "MAV_TYPE 77 (ArduPilot)"),
    ],
)
def test_what_is_no_arducopter_is_named_and_never_kept(other: bytes, words: str) -> None:
    keeper = PeerKeeper(Expected())
    for second in range(40):
        assert not keeper.admit(STRANGER, other, float(second))
    assert keeper.second_sender(40.0) == (
        f"192.168.1.66:6000 (system 2) sends to the autopilot's port, but is no ArduCopter: {words}."
    )
    assert keeper.admit(AUTOPILOT, beat(), 41.0), "the copter is, whatever came first"
    assert (keeper.kept, keeper.system_id) == (AUTOPILOT, 1)


def test_a_copter_behind_the_router_of_a_tracker_is_kept_by_its_own_id() -> None:
    keeper = PeerKeeper(Expected())
    assert not keeper.admit(AUTOPILOT, beat(2, kind=TRACKER), 0.0)
    assert keeper.admit(AUTOPILOT, beat(2, kind=TRACKER) + beat(1), 0.1)
    assert (keeper.system_id, keeper.second_sender(0.1)) == (1, "")


def test_a_system_id_that_was_named_and_is_no_copter_is_not_kept() -> None:
    keeper = PeerKeeper(Expected(system_id=2))
    assert not keeper.admit(AUTOPILOT, beat(2, kind=TRACKER), 0.0)
    assert not keeper.admit(AUTOPILOT, beat(1), 0.0)
    assert keeper.admit(AUTOPILOT, beat(2), 0.1)


@pytest.mark.fault(
    "a second copter on the link",
    "at a start on the ground none is kept before `autopilot.vehicle_system_id` names ours; one that comes "
    "later is shown and refuses Arm until ours is named; a flight that goes on keeps its vehicle",
)
def test_of_two_copters_none_is_kept_before_one_is_named() -> None:
    keeper = PeerKeeper(Expected(wait_s=1.5))
    for second in range(20):
        assert not keeper.admit(AUTOPILOT, beat(3), float(second))
        assert not keeper.admit(STRANGER, beat(1), second + 0.5)
    assert keeper.second_sender(20.0) == (
        "Several copters are heard: system 3 at 192.168.1.10:5000, system 1 at 192.168.1.66:6000. "
        "Name yours in autopilot.vehicle_system_id, autopilot.vehicle_address."
    )
    assert not keeper.admit(AUTOPILOT, beat(3), 20.0)
    assert keeper.admit(AUTOPILOT, beat(3), 20.5 + SILENT_S), "the other one has gone"


def test_one_copter_alone_is_kept_after_the_time_to_wait() -> None:
    keeper = PeerKeeper(Expected(wait_s=1.5))
    assert [keeper.admit(AUTOPILOT, beat(), at) for at in (0.0, 1.0, 1.5)] == [False, False, True]


def test_two_copters_of_one_router_are_two() -> None:
    keeper = PeerKeeper(Expected(wait_s=1.5))
    assert not keeper.admit(AUTOPILOT, beat(1) + beat(3), 0.0)
    assert not keeper.admit(AUTOPILOT, beat(1) + beat(3), 2.0)
    named = PeerKeeper(Expected(system_id=3))
    assert named.admit(AUTOPILOT, beat(1) + beat(3), 0.0)


@pytest.mark.slow
def test_a_flood_of_forged_copters_is_kept_short() -> None:
    keeper = PeerKeeper(Expected(wait_s=2.0))
    for port in range(2000):
        assert not keeper.admit(("192.168.1.66", 1024 + port), beat(), port / 1000)
    words = keeper.second_sender(2.0)
    assert words.startswith("Several copters are heard: system 1 at 192.168.1.66:")
    assert words.count("system 1 at") == 8
    assert len(keeper._copters) <= 256, "the thread that passes the autopilot's datagrams looks at each of them"
    assert not keeper.admit(AUTOPILOT, beat(), 6.0)
    assert not keeper.admit(AUTOPILOT, beat(), 7.9)
    assert keeper.admit(AUTOPILOT, beat(), 8.0), "once it is alone"
