"""MAV_CMD_* commands: their effect on the autopilot and their answers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.autopilot.autopilot import Autopilot, RefusedError
from hawk.sim.autopilot.modes import ModeNumber

FORCE_DISARM = 21196
FORCE_ARM = 2989
"""ArduPilot's magic numbers. 21196 with "arm" (MAVSDK's ``arm_force``) is acknowledged and does nothing."""
FENCE_SWITCH = 11
"""RCx_OPTION of the switch that turns the fence on and off."""


@dataclass(frozen=True, slots=True)
class Command:
    """COMMAND_LONG or COMMAND_INT in one form. ``x`` and ``y`` are degrees in a COMMAND_INT with a global frame."""

    number: int
    parameters: tuple[float, float, float, float]
    x: float
    y: float
    z: float
    frame: int
    sender: tuple[int, int]
    is_int: bool = False

    @classmethod
    def of(cls, message: Any) -> Command:
        """Read a pymavlink message."""
        first = (message.param1, message.param2, message.param3, message.param4)
        sender = (message.get_srcSystem(), message.get_srcComponent())
        if message.get_type() == "COMMAND_INT":
            x, y = message.x * 1e-7, message.y * 1e-7
            return cls(message.command, first, x, y, message.z, message.frame, sender, is_int=True)
        frame = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT
        return cls(message.command, first, message.param5, message.param6, message.param7, frame, sender)


def execute(command: Command, autopilot: Autopilot) -> int:
    """Execute a command and return its MAV_RESULT."""
    handler = _HANDLERS.get(command.number)
    if handler is None:
        return int(mavlink.MAV_RESULT_UNSUPPORTED)
    try:
        result = handler(command, autopilot)
    except RefusedError:
        return int(mavlink.MAV_RESULT_FAILED)
    return int(mavlink.MAV_RESULT_ACCEPTED if result is None else result)


def _arm_disarm(command: Command, autopilot: Autopilot) -> None:
    arm, magic = command.parameters[0], command.parameters[1]
    if arm == 0.0:
        autopilot.disarm(force=magic == FORCE_DISARM)
    elif arm == 1.0 and magic != FORCE_DISARM:
        autopilot.arm(force=magic == FORCE_ARM)
    elif arm != 1.0:
        raise RefusedError("neither arm nor disarm")


def _set_mode(command: Command, autopilot: Autopilot) -> None:
    base, custom = command.parameters[0], command.parameters[1]
    if not (math.isfinite(base) and math.isfinite(custom)) or not int(base) & 1:
        raise RefusedError("not a custom mode")
    autopilot.set_mode(int(custom))


def _terminate(command: Command, autopilot: Autopilot) -> None:
    if command.parameters[0] > 0.5:
        autopilot.terminate()


def _reposition(command: Command, autopilot: Autopilot) -> int | None:
    """DO_REPOSITION: degrees and an altitude; the yaw is ignored, the mode is changed when its flag is set."""
    change_mode = int(command.parameters[1]) & mavlink.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE
    if autopilot.mode.number != ModeNumber.GUIDED:
        if not change_mode:
            return int(mavlink.MAV_RESULT_DENIED)
        autopilot.set_mode(ModeNumber.GUIDED)
    if not all(map(math.isfinite, (command.x, command.y, command.z))):
        return int(mavlink.MAV_RESULT_DENIED)
    altitude = command.z
    if command.frame not in (mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_FRAME_GLOBAL_INT):
        if autopilot.home is None:
            raise RefusedError("no home")
        altitude += autopilot.origin.altitude - autopilot.home[2]
    autopilot.fly_to(autopilot.origin.to_world(command.x, command.y, altitude), None, strict=True)
    return None


def _change_speed(command: Command, autopilot: Autopilot) -> None:
    if command.parameters[0] in (0.0, 1.0):
        autopilot.set_speed(command.parameters[1])


def _yaw(command: Command, autopilot: Autopilot) -> None:
    angle, _, direction, relative = command.parameters
    yaw = math.radians(angle)
    autopilot.turn_to(autopilot.estimate.yaw + math.copysign(yaw, direction or 1.0) if relative else yaw)


def _fence_enable(command: Command, autopilot: Autopilot) -> None:
    autopilot.fence.switch(command.parameters[0] == 1.0, autopilot.parameters)


def _switch(command: Command, autopilot: Autopilot) -> int | None:
    """Take a switch of the remote control: position 0 is low, 2 high."""
    function, position = command.parameters[:2]
    if function != FENCE_SWITCH:
        return int(mavlink.MAV_RESULT_FAILED)
    autopilot.fence.switch(position == 2.0, autopilot.parameters)
    return None


def _reboot(command: Command, autopilot: Autopilot) -> int | None:
    if command.parameters[0] not in (1.0, 3.0):
        return int(mavlink.MAV_RESULT_UNSUPPORTED)
    autopilot.reboot()
    return None


def _set_home(command: Command, autopilot: Autopilot) -> None:
    """DO_SET_HOME by any station: a place, or the present one. A COMMAND_LONG's altitude is above sea level here."""
    if autopilot.home is None:
        raise RefusedError("no position yet")
    if command.parameters[0] == 1.0 or (command.x == 0.0 and command.y == 0.0):
        autopilot.set_home(autopilot.estimate.position)
        return
    if command.parameters[0] != 0.0:
        raise RefusedError("neither a place nor the present one")
    altitude = command.z
    if command.is_int and command.frame not in (mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_FRAME_GLOBAL_INT):
        altitude += autopilot.origin.altitude - autopilot.home[2]
    autopilot.set_home(autopilot.origin.to_world(command.x, command.y, altitude))


_HANDLERS: dict[int, Callable[[Command, Autopilot], int | None]] = {
    mavlink.MAV_CMD_COMPONENT_ARM_DISARM: _arm_disarm,
    mavlink.MAV_CMD_DO_SET_MODE: _set_mode,
    mavlink.MAV_CMD_NAV_TAKEOFF: lambda command, autopilot: autopilot.take_off(command.z),
    mavlink.MAV_CMD_NAV_LAND: lambda _, autopilot: autopilot.set_mode(ModeNumber.LAND),
    mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH: lambda _, autopilot: autopilot.set_mode(ModeNumber.RTL),
    mavlink.MAV_CMD_DO_FLIGHTTERMINATION: _terminate,
    mavlink.MAV_CMD_DO_REPOSITION: _reposition,
    mavlink.MAV_CMD_DO_CHANGE_SPEED: _change_speed,
    mavlink.MAV_CMD_CONDITION_YAW: _yaw,
    mavlink.MAV_CMD_DO_FENCE_ENABLE: _fence_enable,
    mavlink.MAV_CMD_DO_AUX_FUNCTION: _switch,
    mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: _reboot,
    mavlink.MAV_CMD_RUN_PREARM_CHECKS: lambda _, autopilot: autopilot.report_pre_arm(),
    mavlink.MAV_CMD_DO_SET_HOME: _set_home,
}
