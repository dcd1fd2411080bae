"""Fields of messages by which a ground station commands the autopilot, whose MAVLink id is 1/1."""

from __future__ import annotations

from typing import Any, Final

FORCE: Final = 21196.0
"""Parameter 2 of MAV_CMD_COMPONENT_ARM_DISARM: also in the air (MAVLink common.xml)."""


def command_fields(number: int, *values: float) -> dict[str, float]:
    """Return the fields of a COMMAND_LONG; parameters that are not given are 0."""
    named = {f"param{k}": value for k, value in enumerate((*values, *(0.0,) * (7 - len(values))), 1)}
    return {"target_system": 1, "target_component": 1, "command": number, "confirmation": 0, **named}


def parameter_fields(name: str, value: float) -> dict[str, Any]:
    """Return the fields of a PARAM_SET."""
    return {
        "target_system": 1,
        "target_component": 1,
        "param_id": name.encode(),
        "param_value": value,
        "param_type": 9,  # MAV_PARAM_TYPE_REAL32
    }
