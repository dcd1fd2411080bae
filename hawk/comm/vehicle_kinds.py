"""Kinds of MAVLink systems in words, and which of them hawk flies (MAV_TYPE, MAV_AUTOPILOT of HEARTBEAT)."""

from __future__ import annotations

from typing import Final

COPTERS: Final = {
    2: "quadrotor", 3: "coaxial", 4: "helicopter", 13: "hexarotor", 14: "octorotor", 15: "tricopter",
    29: "dodecarotor", 35: "decarotor", 43: "multirotor",
}  # fmt: skip
"""MAV_TYPE of what ArduCopter flies."""
ARDUPILOT: Final = 3  # MAV_AUTOPILOT_ARDUPILOTMEGA
NO_AUTOPILOT: Final = 8  # MAV_AUTOPILOT_INVALID
GROUND_STATION: Final = 6  # MAV_TYPE_GCS
_OTHERS: Final = {
    0: "generic vehicle", 1: "plane", 5: "antenna tracker", 6: "ground station", 7: "airship", 8: "balloon",
    9: "rocket", 10: "rover", 11: "boat", 12: "submarine", 16: "flapping wing", 17: "kite",
    18: "companion computer", 19: "VTOL", 20: "VTOL", 21: "VTOL", 22: "VTOL", 23: "VTOL", 24: "VTOL", 25: "VTOL",
    26: "gimbal", 27: "ADS-B receiver", 28: "parafoil", 30: "camera", 31: "charging station", 32: "FLARM",
    33: "servo", 34: "Remote ID transmitter", 36: "battery", 37: "parachute", 38: "log", 39: "video encoder",
    40: "IMU", 41: "GNSS receiver", 42: "winch",
}  # fmt: skip
_AUTOPILOTS: Final = {0: "generic autopilot", 3: "ArduPilot", 12: "PX4"}


def is_copter(kind: int, autopilot: int) -> bool:
    """Return True for a copter that an ArduPilot flies."""
    return kind in COPTERS and autopilot == ARDUPILOT


def kind_words(kind: int, autopilot: int) -> str:
    """Return what a system is: ``antenna tracker (ArduPilot)``, ``ground station``."""
    words = COPTERS.get(kind) or _OTHERS.get(kind) or f"MAV_TYPE {kind}"
    if autopilot == NO_AUTOPILOT:
        return words
    return f"{words} ({_AUTOPILOTS.get(autopilot, f'MAV_AUTOPILOT {autopilot}')})"
