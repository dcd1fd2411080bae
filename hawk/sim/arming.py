"""ArduPilot's checks before arming: every reason that speaks against it, in its own words."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from hawk.sim.fence import FenceType, fence_words


@dataclass(frozen=True, slots=True)
class ArmingView:
    """What the checks look at."""

    mode_name: str
    mode_arms: bool
    mode_needs_position: bool
    position_ok: bool
    home_set: bool
    radio_failsafe: bool
    gcs_failsafe: bool
    battery_failsafe: bool
    battery_voltage: float
    battery_arm_voltage: float
    fence_enabled: bool
    fence_breaches: FenceType
    throttle_high: bool
    crashed: bool


def pre_arm_reasons(view: ArmingView) -> list[str]:
    """Return what the vehicle would be refused for in its present mode (the PREARM bit of SYS_STATUS)."""
    return list(_pre_arm(view))


def arming_reasons(view: ArmingView) -> list[str]:
    """Return why arming is refused at this moment, the mode first as ArduCopter has it."""
    reasons = [] if view.mode_arms else [f"{view.mode_name} mode not armable"]
    reasons += _pre_arm(view)
    if view.throttle_high:
        reasons.append("Throttle too high")
    return reasons


def _pre_arm(view: ArmingView) -> Iterator[str]:
    if view.crashed:
        yield "Vehicle has crashed"
    if (view.mode_needs_position or view.fence_enabled) and not (view.position_ok and view.home_set):
        yield "fence requires position" if view.fence_enabled else "Need Position Estimate"
    elif view.fence_breaches:
        yield f"Vehicle breaching {fence_words(view.fence_breaches)} fence"
    if view.radio_failsafe:
        yield "Radio failsafe on"
    if view.gcs_failsafe:
        yield "GCS failsafe on"
    if view.battery_failsafe:
        yield "Battery 1 low voltage failsafe"
    elif view.battery_voltage < view.battery_arm_voltage:
        yield "Battery 1 below minimum arming voltage"
