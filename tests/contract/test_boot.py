"""Rows: streams, autopilot reboot, health, health flags."""

from __future__ import annotations

import pytest
from mavsdk.plugins.telemetry import TelemetryError

from tests.contract.conftest import Boot
from tests.contract.vehicle import Vehicle

pytestmark = pytest.mark.contract
ASKED_FOR = {"LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "ATTITUDE", "SYS_STATUS", "BATTERY_STATUS", "GPS_RAW_INT"}


def test_only_a_few_messages_come_unasked(boot: Boot) -> None:
    assert {"HEARTBEAT", "EXTENDED_SYS_STATE"} <= boot.first_messages
    assert not boot.first_messages & ASKED_FOR


def test_a_boot_keeps_mavsdk_connected_and_its_cache_as_it_was(boot: Boot) -> None:
    assert boot.connected_through
    assert boot.cached_health
    assert boot.cached_position


def test_the_health_flags_are_false_until_sys_status_is_asked_for(boot: Boot) -> None:
    assert not boot.all_ok_at_first
    assert boot.all_ok_at > 0.0


def test_it_seems_armable_before_all_is_well(boot: Boot) -> None:
    assert boot.all_ok_at - boot.armable_at > 1.0


def test_the_rate_of_altitude_is_denied_and_ned_needs_its_own(vehicle: Vehicle) -> None:
    with pytest.raises(TelemetryError, match="DENIED"):
        vehicle.pilot.telemetry.set_rate_altitude(5.0)
    before = vehicle.pilot.counts["LOCAL_POSITION_NED"]
    vehicle.wait(lambda: vehicle.pilot.counts["LOCAL_POSITION_NED"] > before + 5, 5.0)
