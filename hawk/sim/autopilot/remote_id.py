"""A Remote ID transmitter behind the autopilot: it says whether it has everything that it must send.

Ages and words are those of ArduRemoteID (transport.cpp, ``arm_status_check``), whose OPEN_DRONE_ID_ARM_STATUS
ArduPilot passes on. It is silent until a ground station sends it something, so that a drone without Remote ID has none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

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
