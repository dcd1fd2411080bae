"""Messages of another station that write to the autopilot."""

from __future__ import annotations

import math
from typing import Any

import pytest
from pymavlink.dialects.v10 import ardupilotmega as v1
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.comm.mavlink.foreign_writes import FENCE, HOME, RALLY, Write, writes

STATION = mavlink.MAVLink(None, 254, 190)
ZEROS = (0.0,) * 6


def command(number: int, *values: float) -> Any:
    return mavlink.MAVLink_command_long_message(1, 1, number, 0, *(*values, 0.0, *ZEROS)[:7])


@pytest.mark.parametrize(
    ("message", "target", "written"),
    [
        (mavlink.MAVLink_param_set_message(1, 1, b"BATT_FS_LOW_ACT", 5.0, 9), 1, ("BATT_FS_LOW_ACT",)),
        (mavlink.MAVLink_param_set_message(0, 0, b"SIXTEEN_LETTERS_", 0.0, 9), 0, ("SIXTEEN_LETTERS_",)),
        (mavlink.MAVLink_param_set_message(1, 1, b"", 5.0, 9), 1, ()),
        (mavlink.MAVLink_param_set_message(1, 1, b"\x1b[2J", 5.0, 9), 1, ()),
        (mavlink.MAVLink_mission_count_message(1, 1, 4, 0), 1, ()),
        (mavlink.MAVLink_mission_count_message(7, 1, 4, 1), 7, (FENCE,)),
        (mavlink.MAVLink_mission_clear_all_message(1, 1, 2), 1, (RALLY,)),
        (mavlink.MAVLink_mission_clear_all_message(1, 1, 255), 1, (FENCE, RALLY)),
        (mavlink.MAVLink_mission_clear_all_message(1, 1, 0), 1, ()),
        (command(207), 1, (FENCE,)),
        (command(176, 0.0, 9.0), 1, ("mode 9",)),
        (command(176, 0.0, math.nan), 1, ()),
        (command(20), 1, ("mode 6",)),
        (command(21), 1, ("mode 9",)),
        (command(22), 1, ()),
        (mavlink.MAVLink_command_int_message(1, 1, 0, 176, 0, 0, 1, 6, 0, 0, 0, 0, 0.0), 1, ("mode 6",)),
        (mavlink.MAVLink_set_mode_message(1, 1, 5), 1, ("mode 5",)),
        (mavlink.MAVLink_command_int_message(1, 1, 0, 179, 0, 0, 0, 0, 0, 0, 1, 2, 3.0), 1, (HOME,)),
        (mavlink.MAVLink_attitude_message(0, 0, 0, 0, 0, 0, 0), 1, ()),
    ],
)
def test_what_a_message_writes(message: Any, target: int, written: tuple[str, ...]) -> None:
    found = list(writes(message.pack(STATION)))
    assert found == ([Write(254, 190, target, written)] if written else [])


@pytest.mark.parametrize(
    ("answer", "written"),
    [
        ((176, 0, 0, 0, 255, 190), [Write(255, 190, 1, ("mode",))]),
        ((20, 0, 0, 0, 255, 190), [Write(255, 190, 1, ("mode",))]),
        ((176, 4, 0, 0, 255, 190), []),
        ((400, 0, 0, 0, 255, 190), []),
    ],
    ids=["a mode", "a return", "refused", "another command"],
)
def test_an_answer_of_the_autopilot_says_who_asked_for_a_mode(answer: tuple[int, ...], written: list[Write]) -> None:
    autopilot = mavlink.MAVLink(None, 1, 1)
    assert list(writes(mavlink.MAVLink_command_ack_message(*answer).pack(autopilot))) == written


def test_each_frame_of_a_datagram_is_read_and_a_damaged_one_is_not() -> None:
    clear = mavlink.MAVLink_mission_clear_all_message(1, 1, 1).pack(STATION)
    switch = command(207).pack(STATION)
    damaged = bytearray(clear)
    damaged[-1] ^= 1
    assert len(list(writes(clear + switch))) == 2
    assert list(writes(bytes(damaged) + switch)) == [Write(254, 190, 1, (FENCE,))]
    for cut in range(len(switch)):
        assert list(writes(switch[:cut])) == []
    assert list(writes(b"\0" + switch)) == []


def test_a_signed_frame_and_mavlink_1_are_read() -> None:
    signer = mavlink.MAVLink(None, 254, 190)
    signer.signing.secret_key, signer.signing.sign_outgoing, signer.signing.link_id = b"k" * 32, True, 1
    signer.signing.timestamp = 1
    signed = mavlink.MAVLink_mission_clear_all_message(1, 1, 1).pack(signer)
    assert len(list(writes(signed + signed))) == 2
    old = v1.MAVLink_param_set_message(1, 1, b"RTL_ALT", 30_000.0, 9).pack(v1.MAVLink(None, 255, 1))
    assert list(writes(old)) == [Write(255, 1, 1, ("RTL_ALT",))]
