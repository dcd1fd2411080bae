"""The one mapping from what the autopilot does to our operation state."""

from __future__ import annotations

from hawk.model import CopterMode, LandedState, StateName

_HOLDING = frozenset({CopterMode.GUIDED, CopterMode.BRAKE})
_RETURNING = frozenset({CopterMode.RTL, CopterMode.SMART_RTL})


def is_on_ground(landed: LandedState) -> bool:
    """Whether the autopilot says it stands on the ground; what it does not know counts as in the air."""
    return landed is LandedState.ON_GROUND


def state_from_autopilot(
    armed: bool, landed: LandedState, custom_mode: int | None, at_start: bool = False
) -> StateName:
    """Return the state that stands for what the autopilot does.

    Used at start, after a lost link or reboot, and at every mode change that we did not ask for. ``at_start``: the
    daemon has just begun, so that nobody knows whether an operator is there.
    """
    if not armed:
        return StateName.IDLE
    if is_on_ground(landed):
        return StateName.ARM if custom_mode == CopterMode.GUIDED else StateName.MANUAL
    if custom_mode in _RETURNING:
        return StateName.RETURN_TO_LAUNCH
    if custom_mode == CopterMode.LAND:
        return StateName.LAND
    if custom_mode in _HOLDING:
        return StateName.COMMUNICATION_LOST if at_start else StateName.HOVER
    return StateName.MANUAL
