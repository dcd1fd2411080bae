"""Kinds of MAVLink systems in words, and which of them hawk flies (MAV_TYPE, MAV_AUTOPILOT of HEARTBEAT)."""

from __future__ import annotations

from typing import Final

from hawk.model.sentences import say

COPTERS: Final = {
    2: say("quadrotor"),
    3: say("coaxial"),
    4: say("helicopter"),
    13: say("hexarotor"),
    14: say("octorotor"),
    15: say("tricopter"),
    29: say("dodecarotor"),
    35: say("decarotor"),
    43: say("multirotor"),
}
"""MAV_TYPE of what ArduCopter flies."""
ARDUPILOT: Final = 3  # MAV_AUTOPILOT_ARDUPILOTMEGA
NO_AUTOPILOT: Final = 8  # MAV_AUTOPILOT_INVALID
GROUND_STATION: Final = 6  # MAV_TYPE_GCS
_OTHERS: Final = {
    0: say("generic vehicle"),
    1: say("plane"),
    5: say("antenna tracker"),
    6: say("ground station"),
    7: say("airship"),
    8: say("balloon"),
    9: say("rocket"),
    10: say("rover"),
    11: say("boat"),
    12: say("submarine"),
    16: say("flapping wing"),
    17: say("kite"),
    18: say("companion computer"),
    19: say("VTOL"),
    20: say("VTOL"),
    21: say("VTOL"),
    22: say("VTOL"),
    23: say("VTOL"),
    24: say("VTOL"),
    25: say("VTOL"),
    26: say("gimbal"),
    27: say("ADS-B receiver"),
    28: say("parafoil"),
    30: say("onboard camera"),
    31: say("charging station"),
    32: say("FLARM"),
    33: say("servo"),
    34: say("Remote ID transmitter"),
    36: say("smart battery"),
    37: say("parachute"),
    38: say("log"),
    39: say("video encoder"),
    40: say("IMU"),
    41: say("GNSS receiver"),
    42: say("winch"),
}
_AUTOPILOTS: Final = {0: say("generic autopilot"), 3: "ArduPilot", 12: "PX4"}


def is_copter(kind: int, autopilot: int) -> bool:
    """Return True for a copter that an ArduPilot flies."""
    return kind in COPTERS and autopilot == ARDUPILOT


def kind_words(kind: int, autopilot: int) -> str:
    """Return what a system is: ``antenna tracker (ArduPilot)``, ``ground station``."""
    words = COPTERS.get(kind) or _OTHERS.get(kind) or f"MAV_TYPE {kind}"
    if autopilot == NO_AUTOPILOT:
        return words
    return say("{kind} ({maker})", kind=words, maker=_AUTOPILOTS.get(autopilot, f"MAV_AUTOPILOT {autopilot}"))
