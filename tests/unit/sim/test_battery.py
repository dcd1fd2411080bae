from __future__ import annotations

import pytest

from hawk.sim.vehicle import EMPTY_V, FULL_V, Battery


def hover(battery: Battery, minutes: float) -> None:
    for _ in range(round(minutes * 60)):
        battery.step(lifting=True, effort=1.0, dt=1.0)


def test_lasts_about_as_long_as_promised() -> None:
    battery = Battery(10.0)
    hover(battery, 9.0)
    assert 0.02 < battery.remaining < 0.1
    hover(battery, 1.0)
    assert battery.is_empty
    assert battery.remaining == 0.0


def test_climbing_costs_more_and_resting_little() -> None:
    climbing, resting, hovering = Battery(10.0), Battery(10.0), Battery(10.0)
    climbing.step(True, 1.2, 60.0)
    hovering.step(True, 1.0, 60.0)
    resting.step(False, 1.0, 60.0)
    assert climbing.remaining < hovering.remaining < resting.remaining
    assert resting.remaining > 0.99


def test_voltage_falls_with_charge_and_load() -> None:
    battery = Battery(10.0)
    assert battery.voltage == pytest.approx(FULL_V, abs=0.02)
    battery.step(True, 1.0, 1.0)
    assert battery.voltage < FULL_V - 0.2
    battery.remaining = 0.0
    battery.step(False, 1.0, 1.0)
    assert battery.voltage == pytest.approx(EMPTY_V, abs=0.02)
    assert battery.used_mah == pytest.approx(5000.0)
