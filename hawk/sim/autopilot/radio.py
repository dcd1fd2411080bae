"""Transmitters beside the autopilot: the pilot's remote control (RC_Channel.cpp of ArduPilot), and Remote ID."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from hawk.sim.autopilot.parameters import Parameters

DEBOUNCE_S = 0.2
"""A position of the switch counts when it has lasted this long."""
POSITIONS = (1165, 1295, 1425, 1555, 1685, 1800)
"""Pulses in the middle of the six positions, microseconds; 1800 as ArduPilot's simulation sends at first."""
_LAST_PULSES = (1230, 1360, 1490, 1620, 1749)
_CHANNELS = 8
_THROTTLE, _SWITCH = 2, 4


@dataclass(frozen=True, slots=True)
class RadioReport:
    """Pulses (microseconds) and number of channels, as RC_CHANNELS gives them; ``was_heard`` since the boot."""

    pulses: tuple[int, ...] = (0,) * _CHANNELS
    channels: int = 0
    was_heard: bool = False


class Radio:
    """The receiver, and what the autopilot keeps of it: the last pulses stay after a loss, until a boot."""

    def __init__(self) -> None:
        self.switch = POSITIONS[-1]
        """Pulse of the pilot's mode switch, which sits on channel 5."""
        self.report = RadioReport()
        self._position: int | None = None
        self._next: tuple[int, float] | None = None

    def boot(self) -> None:
        """Forget what was heard."""
        self.report = RadioReport()
        self._position = self._next = None

    def step(self, parameters: Parameters, present: bool, stick: float, now: float) -> int | None:
        """Take the pulses of this moment; return the mode that the switch commands now, None for no change.

        ``stick``: throttle, 0..1; ``now``: seconds of the simulation.
        """
        if not present:
            return None
        pulses = [1500, 1500, 1000, 1500, 1500, 1000, 1000, 1800]
        pulses[_THROTTLE], pulses[_SWITCH] = round(1000 + stick * 1000), self.switch
        self.report = RadioReport(tuple(pulses), _CHANNELS, was_heard=True)
        position = self._moved_to(_position(pulses, parameters.flag("FLTMODE_CH")), now)
        return None if position is None else parameters.flag(f"FLTMODE{position}")

    def _moved_to(self, position: int | None, now: float) -> int | None:
        """Return a position when it is established and another one than before. The first one after a boot is none."""
        if position is None or position == self._position:
            self._next = None
        elif self._position is None:
            self._position = position
        elif self._next is None or self._next[0] != position:
            self._next = (position, now)
        elif now - self._next[1] >= DEBOUNCE_S:
            self._position, self._next = position, None
            return position
        return None


def _position(pulses: Sequence[int], channel: int) -> int | None:
    """Return the position, 1 to 6; None without a channel or a valid pulse."""
    pulse = pulses[channel - 1] if 1 <= channel <= len(pulses) else 0
    if not 900 < pulse < 2200:
        return None
    return 1 + sum(pulse > last for last in _LAST_PULSES)


COMPONENT = mavlink.MAV_COMP_ID_ODID_TXRX_1
PERIOD_S = 1.0
PLACE_AGE_S = 3.0
"""An older operator's place is missing, seconds."""
OTHER_AGE_S = 22.0
"""An older operator's id is missing, seconds."""
MESSAGES = frozenset(
    f"OPEN_DRONE_ID_{name}" for name in ("OPERATOR_ID", "SELF_ID", "BASIC_ID", "SYSTEM", "SYSTEM_UPDATE")
)
"""Messages of a ground station."""


class Transmitter:
    """Times are seconds of the simulation."""

    def __init__(self) -> None:
        self.is_broken = False
        """True: it sends nothing."""
        self.held: dict[str, Mapping[str, Any]] = {}
        """The last message of each kind, by name."""
        self._times: dict[str, float] = {}
        self._next = -math.inf

    def handle(self, message: Any, now: float) -> None:
        """Take a message of a ground station. An update counts only after a whole OPEN_DRONE_ID_SYSTEM."""
        kind, fields = message.get_type(), message.to_dict()
        if kind == "OPEN_DRONE_ID_SYSTEM_UPDATE":
            if "OPEN_DRONE_ID_SYSTEM" not in self.held:
                return
            kind, fields = "OPEN_DRONE_ID_SYSTEM", {**self.held["OPEN_DRONE_ID_SYSTEM"], **fields}
        self.held[kind] = fields
        self._times[kind] = now

    def poll(self, now: float, has_position: bool) -> Any | None:
        """Return the OPEN_DRONE_ID_ARM_STATUS that is due."""
        if self.is_broken or not self.held or now < self._next:
            return None
        self._next = now + PERIOD_S
        missing = self._missing(now, has_position)
        error = f"missing {' '.join(missing)}" if missing else ""
        status = mavlink.MAV_ODID_ARM_STATUS_PRE_ARM_FAIL_GENERIC if error else mavlink.MAV_ODID_ARM_STATUS_GOOD_TO_ARM
        return mavlink.MAVLink_open_drone_id_arm_status_message(status, error.encode())

    def _missing(self, now: float, has_position: bool) -> list[str]:
        missing = [] if has_position else ["LOC"]
        if not self._has("OPEN_DRONE_ID_OPERATOR_ID", OTHER_AGE_S, now):
            missing.append("OP_ID")
        if not self._has("OPEN_DRONE_ID_SYSTEM", PLACE_AGE_S, now):
            missing.append("SYS")
        elif not any(self.held["OPEN_DRONE_ID_SYSTEM"][name] for name in ("operator_latitude", "operator_longitude")):
            missing.append("OP_LOC")
        return missing

    def _has(self, kind: str, age: float, now: float) -> bool:
        return now - self._times.get(kind, -math.inf) <= age
