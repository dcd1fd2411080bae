"""MAVLink commands to the autopilot. Every function may block for the acknowledgement (2 s).

Commands go out by `Link.command`, not by MAVSDK's Action plugin: the plugin changes the flight mode before arming, and
hides the result of the acknowledgement.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import IntEnum

from hawk.comm.autopilot.mavlink_link import Link, command_fields, require_finite
from hawk.comm.autopilot.streams import Stream
from hawk.comm.autopilot.vehicle import AutopilotError
from hawk.model.poses import GlobalPose
from hawk.model.sentences import say
from hawk.model.vehicle import CopterMode, mode_name


class MavCommand(IntEnum):
    """MAV_CMD numbers (MAVLink common.xml)."""

    NAV_TAKEOFF = 22
    DO_SET_MODE = 176
    DO_SET_HOME = 179
    DO_FLIGHTTERMINATION = 185
    DO_FENCE_ENABLE = 207
    COMPONENT_ARM_DISARM = 400
    SET_MESSAGE_INTERVAL = 511


class MavResult(IntEnum):
    """MAV_RESULT numbers (MAVLink common.xml)."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4
    IN_PROGRESS = 5
    CANCELLED = 6


class NotAcceptedError(AutopilotError):
    """The autopilot's acknowledgement was not ACCEPTED; its reason comes as STATUSTEXT beside it."""


_RESULTS: Mapping[int, str] = {
    MavResult.ACCEPTED: say("accepted"),
    MavResult.TEMPORARILY_REJECTED: say("temporarily rejected"),
    MavResult.DENIED: say("denied"),
    MavResult.UNSUPPORTED: say("unsupported"),
    MavResult.FAILED: say("failed"),
    MavResult.IN_PROGRESS: say("in progress"),
    MavResult.CANCELLED: say("cancelled"),
}
_CUSTOM_MODE_ENABLED = 1  # MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
_GLOBAL = 0  # MAV_FRAME_GLOBAL: altitude above sea level
_LOCAL_NED = 1  # MAV_FRAME_LOCAL_NED
_POSITION_AND_YAW = 2552
"""POSITION_TARGET_TYPEMASK: velocity, acceleration and yaw rate are ignored."""


def arm(link: Link) -> None:
    """Arm, with all of the autopilot's checks."""
    _command(link, say("Arm"), MavCommand.COMPONENT_ARM_DISARM, 1)


def disarm(link: Link) -> None:
    """Disarm; refused in the air (never forced)."""
    _command(link, say("Disarm"), MavCommand.COMPONENT_ARM_DISARM, 0)


def set_mode(link: Link, mode: CopterMode) -> None:
    """Ask for a flight mode."""
    _command(link, say("Mode {mode}", mode=str(mode_name(mode))), MavCommand.DO_SET_MODE, _CUSTOM_MODE_ENABLED, mode)


def send_mode(link: Link, mode: CopterMode) -> None:
    """Send a change of the flight mode and do not wait for the answer: the autopilot may hear without being heard."""
    link.send("COMMAND_LONG", command_fields(MavCommand.DO_SET_MODE, [_CUSTOM_MODE_ENABLED, mode]))


def takeoff(link: Link, relative_altitude: float) -> None:
    """Climb to metres above home. The autopilot accepts it armed and in GUIDED only."""
    if not (math.isfinite(relative_altitude) and relative_altitude > 0):
        raise AutopilotError(say("Takeoff height is {height} m: it must be above 0", height=relative_altitude))
    _command(link, say("Takeoff"), MavCommand.NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, relative_altitude)


def kill(link: Link) -> None:
    """Send one flight termination and do not wait for the answer: the caller repeats it until disarmed is seen."""
    link.send("COMMAND_LONG", command_fields(MavCommand.DO_FLIGHTTERMINATION, [1]))


def set_home(link: Link, place: GlobalPose) -> None:
    """Send a home and do not wait: HOME_POSITION is the answer. A COMMAND_LONG would round it to half a metre."""
    fields = {f"param{index}": 0.0 for index in range(1, 5)} | {
        "frame": _GLOBAL,
        "command": int(MavCommand.DO_SET_HOME),
        "current": 0,
        "autocontinue": 0,
        "x": round(place.latitude * 1e7),
        "y": round(place.longitude * 1e7),
        "z": place.altitude,
    }
    link.send("COMMAND_INT", fields)


def enable_fence(link: Link) -> None:
    """Switch the fence on; the autopilot refuses it where it has none."""
    _command(link, say("Fence"), MavCommand.DO_FENCE_ENABLE, 1)


def ask_rate(link: Link, stream: Stream) -> None:
    """Ask for a message's rate and do not wait: the arriving message is the answer."""
    parameters = [stream.message_id, stream.interval_us]
    link.send("COMMAND_LONG", command_fields(MavCommand.SET_MESSAGE_INTERVAL, parameters))


def position_target(boot_ms: int, place: tuple[float, float, float], yaw: float) -> dict[str, float | int]:
    """Return the fields of a SET_POSITION_TARGET_LOCAL_NED (EKF-local, metres, radians). Finite or AutopilotError."""
    x, y, z = place
    fields: dict[str, float | int] = {
        "time_boot_ms": boot_ms,
        "coordinate_frame": _LOCAL_NED,
        "type_mask": _POSITION_AND_YAW,
        "x": x,
        "y": y,
        "z": z,
        "yaw": yaw,
    }
    require_finite(fields)
    return fields


def _command(link: Link, name: str, command: MavCommand, *parameters: float) -> None:
    result = link.command(command, [float(value) for value in parameters])
    if result != MavResult.ACCEPTED:
        reason = _RESULTS.get(result, str(result))
        raise NotAcceptedError(say("{name} refused: {reason}", name=name, reason=reason))
