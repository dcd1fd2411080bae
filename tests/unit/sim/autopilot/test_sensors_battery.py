from __future__ import annotations

import pytest

from hawk.sim.autopilot.sensors import EMPTY_V, FULL_V, Battery


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


def test_charge_and_counter_may_disagree() -> None:
    battery = Battery(10.0)
    battery.charge = 0.4
    assert battery.remaining == 1.0
    assert battery.voltage == pytest.approx(EMPTY_V + 0.4 * (FULL_V - EMPTY_V), abs=0.02)
    battery.counts = False
    hover(battery, 2.0)
    assert battery.remaining == 1.0
    assert battery.charge == pytest.approx(0.2, abs=0.02)
    battery.counts = True
    hover(battery, 1.0)
    assert battery.remaining == pytest.approx(0.9, abs=0.02)
    battery.restart_counter()
    assert battery.used_mah == 0.0
    battery.remaining = 0.5
    assert battery.charge == 0.5


def test_resistance_sags_under_load_and_recovers_at_rest() -> None:
    battery = Battery(10.0)
    battery.resistance = 0.06
    battery.step(True, 1.0, 1.0)
    assert battery.voltage < FULL_V - 1.5
    battery.step(False, 1.0, 1.0)
    assert battery.voltage > FULL_V - 0.1


@pytest.mark.parametrize("cells", [2, 4, 6])
def test_other_cells_make_another_voltage(cells: int) -> None:
    battery = Battery(10.0, cells)
    assert battery.voltage == pytest.approx(4.2 * cells, abs=0.02)
    battery.charge = 0.0
    assert battery.voltage == pytest.approx(3.3 * cells, abs=0.02)


def test_the_voltage_may_be_whatever_is_asked_for() -> None:
    battery = Battery(10.0)
    battery.rest_v, battery.error_v = 9.3, 0.4
    assert battery.voltage == pytest.approx(9.7, abs=0.02)
    battery.rest_v, battery.error_v = 0.001, -5.0
    assert battery.voltage == 0.0
