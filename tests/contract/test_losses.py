"""Rows: radio loss in GUIDED, GPS loss, battery failsafe, kill. The last ones need a boot or end in a fall."""

from __future__ import annotations

import pytest

from tests.contract.vehicle import HEIGHT, LAND, ON_GROUND, RTL, Vehicle

pytestmark = pytest.mark.contract


@pytest.mark.fault("link, radio, GPS or battery lost on hawk-sim and on a real ArduCopter")
def test_a_lost_radio_returns(flying: Vehicle) -> None:
    flying.set({"FS_THR_ENABLE": 1, "FS_OPTIONS": 0})
    flying.faults.radio(False)
    try:
        flying.wait(lambda: flying.mode == RTL, 10.0)
        flying.wait(lambda: flying.said("Radio Failsafe"), 3.0)
    finally:
        flying.faults.radio(True)


@pytest.mark.fault("link, radio, GPS or battery lost on hawk-sim and on a real ArduCopter")
def test_a_lost_gps_shows_within_ten_seconds_and_lands(flying: Vehicle) -> None:
    pilot = flying.pilot
    flying.faults.gps(False)
    try:
        assert flying.wait(lambda: not pilot.telemetry.health_all_ok(), 30.0) < 12.0
        flying.wait(lambda: flying.mode == LAND, 30.0)
        flying.wait(lambda: not flying.armed, 90.0)
    finally:
        flying.faults.gps(True)
    flying.wait(pilot.telemetry.health_all_ok, 90.0)


@pytest.mark.fault("link, radio, GPS or battery lost on hawk-sim and on a real ArduCopter")
def test_a_low_battery_returns_after_ten_seconds(flying: Vehicle) -> None:
    flying.set({"BATT_LOW_VOLT": 11.0, "BATT_FS_LOW_ACT": 2, "BATT_LOW_TIMER": 10})
    flying.go(15.0, 0.0, -HEIGHT)
    flying.faults.battery_low(True)
    try:
        assert 8.0 < flying.wait(lambda: flying.mode == RTL, 40.0) < 25.0
        flying.land()
    finally:
        flying.faults.battery_low(False)
    flying.reboot()  # until then the failsafe forbids to arm


@pytest.mark.parametrize("how", ["kill", "terminate"])
def test_the_motors_are_cut_at_once_in_the_air(flying: Vehicle, how: str) -> None:
    flying.go(0.0, 0.0, -3.0)
    getattr(flying.pilot.action, how)()
    flying.wait(lambda: not flying.armed, 3.0)
    flying.wait(lambda: flying.landed == ON_GROUND, 20.0)  # at once: it is said of every disarmed vehicle
    flying.wait(lambda: flying.place[2] > -1.0, 10.0)
    flying.let_pass(3.0)
    assert not flying.armed
    flying.faults.repair()
