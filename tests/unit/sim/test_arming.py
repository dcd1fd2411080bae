from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from hawk.sim.autopilot.failsafes import ArmingView, arming_reasons, pre_arm_reasons
from hawk.sim.autopilot.fence import FenceType

READY = ArmingView(
    mode_name="GUIDED",
    mode_arms=True,
    mode_needs_position=True,
    position_ok=True,
    home_set=True,
    radio_failsafe=False,
    gcs_failsafe=False,
    battery_failsafe=False,
    battery_voltage=12.6,
    battery_arm_voltage=0.0,
    fence_enabled=False,
    fence_breaches=FenceType.NONE,
    throttle_high=False,
    crashed=False,
)


def test_ready_means_no_reason() -> None:
    assert arming_reasons(READY) == []


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"mode_arms": False, "mode_name": "BRAKE"}, "BRAKE mode not armable"),
        ({"position_ok": False}, "Need Position Estimate"),
        ({"home_set": False}, "Need Position Estimate"),
        ({"position_ok": False, "fence_enabled": True, "mode_needs_position": False}, "fence requires position"),
        ({"fence_enabled": True, "fence_breaches": FenceType.POLYGON}, "Vehicle breaching Polygon fence"),
        ({"radio_failsafe": True}, "Radio failsafe on"),
        ({"gcs_failsafe": True}, "GCS failsafe on"),
        ({"battery_failsafe": True}, "Battery 1 low voltage failsafe"),
        ({"battery_arm_voltage": 12.7}, "Battery 1 below minimum arming voltage"),
        ({"throttle_high": True}, "Throttle too high"),
        ({"crashed": True}, "Vehicle has crashed"),
    ],
)
def test_each_reason_alone_refuses(change: dict[str, Any], reason: str) -> None:
    assert arming_reasons(replace(READY, **change)) == [reason]


def test_every_reason_is_reported_the_mode_first() -> None:
    bad = replace(READY, mode_arms=False, mode_name="RTL", radio_failsafe=True, gcs_failsafe=True)
    assert arming_reasons(bad) == ["RTL mode not armable", "Radio failsafe on", "GCS failsafe on"]


def test_a_mode_without_position_needs_none() -> None:
    assert pre_arm_reasons(replace(READY, mode_needs_position=False, position_ok=False)) == []


def test_pre_arm_does_not_look_at_the_mode() -> None:
    assert pre_arm_reasons(replace(READY, mode_arms=False)) == []
