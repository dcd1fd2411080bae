"""Kinds of MAVLink systems: MAV_TYPE and MAV_AUTOPILOT of the common dialect, by number."""

from __future__ import annotations

import pytest

from hawk.comm.mavlink.frames import is_copter, kind_words
from tests.sweep import sweep

COPTERS = {2, 3, 4, 13, 14, 15, 29, 35, 43}
NAMES = {
    0: "generic vehicle",
    1: "plane",
    2: "quadrotor",
    3: "coaxial",
    4: "helicopter",
    5: "antenna tracker",
    6: "ground station",
    7: "airship",
    8: "balloon",
    9: "rocket",
    10: "rover",
    11: "boat",
    12: "submarine",
    13: "hexarotor",
    14: "octorotor",
    15: "tricopter",
    16: "flapping wing",
    17: "kite",
    18: "companion computer",
    **dict.fromkeys(range(19, 26), "VTOL"),
    26: "gimbal",
    27: "ADS-B receiver",
    28: "parafoil",
    29: "dodecarotor",
    30: "onboard camera",
    31: "charging station",
    32: "FLARM",
    33: "servo",
    34: "Remote ID transmitter",
    35: "decarotor",
    36: "smart battery",
    37: "parachute",
    38: "log",
    39: "video encoder",
    40: "IMU",
    41: "GNSS receiver",
    42: "winch",
    43: "multirotor",
    44: "MAV_TYPE 44",
}


@sweep("kind", NAMES)
def test_each_kind_has_its_name_and_only_a_copter_of_ardupilot_is_flown(kind: int) -> None:
    assert kind_words(kind, 8) == NAMES[kind], "without an autopilot it has no maker"
    assert kind_words(kind, 3) == f"{NAMES[kind]} (ArduPilot)"
    assert is_copter(kind, 3) is (kind in COPTERS)
    assert not is_copter(kind, 12)


@pytest.mark.parametrize(
    ("autopilot", "maker"), [(0, "generic autopilot"), (3, "ArduPilot"), (12, "PX4"), (7, "MAV_AUTOPILOT 7")]
)
def test_the_maker_is_named(autopilot: int, maker: str) -> None:
    assert kind_words(2, autopilot) == f"quadrotor ({maker})"
