from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from hawk.sim.autopilot.failsafes import Failsafes, Fallback, Watched
from hawk.sim.autopilot.fence import FenceType
from hawk.sim.autopilot.parameters import copter_parameters

FLYING = Watched(
    time=0.0,
    armed=True,
    landed=False,
    mode=4,
    pilot_flies=False,
    needs_position=True,
    gcs_silent_s=0.5,
    radio_present=True,
    position_ok=True,
    voltage=12.0,
    used_mah=500.0,
    breaches=FenceType.NONE,
)


class Bench:
    """Failsafes with what they said and did."""

    def __init__(self, factor: float = 1.0, **parameters: float) -> None:
        self.parameters = copter_parameters()
        for name, value in parameters.items():
            self.parameters.set(name, value)
        self.said: list[str] = []
        self.done: list[Fallback] = []
        self.unit = Failsafes(
            self.parameters, lambda _, text: self.said.append(text), self.done.append, real_time_factor=factor
        )
        self.time = 0.0

    def pass_time(self, seconds: float, **changes: Any) -> None:
        for _ in range(round(seconds * 10)):
            self.time += 0.1
            self.unit.step(replace(FLYING, time=self.time, **changes))


def test_nothing_happens_while_all_is_well() -> None:
    bench = Bench(FS_GCS_ENABLE=1, BATT_FS_LOW_ACT=2, FENCE_ENABLE=1)
    bench.pass_time(60.0)
    assert bench.done == []
    assert bench.said == []


@pytest.mark.parametrize(
    ("enable", "reaction"),
    [(1, Fallback.RTL), (3, Fallback.RTL), (5, Fallback.LAND), (7, Fallback.BRAKE)],
)
def test_a_silent_ground_station(enable: int, reaction: Fallback) -> None:
    bench = Bench(FS_GCS_ENABLE=enable)
    bench.pass_time(1.0, gcs_silent_s=4.9)
    assert bench.done == []
    bench.pass_time(1.0, gcs_silent_s=5.1)
    assert bench.done == [reaction]
    assert bench.unit.gcs
    bench.pass_time(1.0)
    assert bench.said[-1] == "GCS Failsafe Cleared"
    assert not bench.unit.gcs


def test_switched_off_while_it_acts_the_failsafe_is_never_cleared() -> None:
    bench = Bench(FS_GCS_ENABLE=1)
    bench.pass_time(1.0, gcs_silent_s=5.1)
    bench.parameters.set("FS_GCS_ENABLE", 0)
    bench.pass_time(10.0)
    assert bench.unit.gcs
    assert "GCS Failsafe Cleared" not in bench.said


def test_a_ground_station_that_never_was_is_not_missed() -> None:
    bench = Bench(FS_GCS_ENABLE=1)
    bench.pass_time(20.0, gcs_silent_s=None)
    assert bench.done == []


def test_a_pilot_goes_on_without_a_ground_station() -> None:
    bench = Bench(FS_GCS_ENABLE=1)
    bench.pass_time(1.0, gcs_silent_s=9.0, pilot_flies=True, mode=5)
    assert bench.done == []
    assert bench.said == ["GCS Failsafe - Continuing Pilot Control"]
    strict = Bench(FS_GCS_ENABLE=1, FS_OPTIONS=0)
    strict.pass_time(1.0, gcs_silent_s=9.0, pilot_flies=True, mode=5)
    assert strict.done == [Fallback.RTL]


def test_a_landing_goes_on_when_the_options_say_so() -> None:
    bench = Bench(FS_GCS_ENABLE=1, FS_OPTIONS=8)
    bench.pass_time(1.0, gcs_silent_s=9.0, mode=9)
    assert bench.done == []
    assert bench.said == ["GCS Failsafe - Continuing Landing"]


def test_disarmed_it_only_says_so() -> None:
    bench = Bench(FS_GCS_ENABLE=1)
    bench.pass_time(1.0, gcs_silent_s=9.0, armed=False, landed=True)
    assert bench.done == []
    assert bench.unit.gcs


@pytest.mark.parametrize(
    ("parameters", "done"),
    [
        ({}, [Fallback.RTL]),
        ({"FS_THR_ENABLE": 0}, []),
        ({"FS_THR_ENABLE": 3}, [Fallback.LAND]),
        ({"FS_OPTIONS": 4}, []),
    ],
)
def test_a_lost_radio(parameters: dict[str, float], done: list[Fallback]) -> None:
    bench = Bench(**parameters)
    bench.pass_time(0.4, radio_present=False)
    assert bench.done == []
    bench.pass_time(2.0, radio_present=False)
    assert bench.done == done


def test_battery_low_then_critical() -> None:
    bench = Bench(BATT_FS_LOW_ACT=2, BATT_CRT_VOLT=10.0, BATT_FS_CRT_ACT=1)
    bench.pass_time(9.5, voltage=10.3)
    assert bench.done == []
    bench.pass_time(1.0, voltage=10.3)
    assert bench.done == [Fallback.RTL]
    bench.pass_time(20.0, voltage=10.3)
    assert bench.done == [Fallback.RTL]
    bench.pass_time(10.5, voltage=9.9)
    assert bench.done == [Fallback.RTL, Fallback.LAND]
    assert any(text.startswith("Battery 1 is critical 9.90V used 500 mAh") for text in bench.said)


def test_a_short_sag_is_no_failsafe() -> None:
    bench = Bench(BATT_FS_LOW_ACT=2)
    for _ in range(3):
        bench.pass_time(8.0, voltage=10.3)
        bench.pass_time(1.0)
    assert bench.done == []


def test_charge_counts_too() -> None:
    bench = Bench(BATT_FS_LOW_ACT=2, BATT_LOW_MAH=1000)
    bench.pass_time(11.0, used_mah=4100.0)
    assert bench.done == [Fallback.RTL]


def test_without_an_action_a_low_battery_is_only_reported() -> None:
    bench = Bench()
    bench.pass_time(11.0, voltage=10.3)
    assert bench.done == [Fallback.NOTHING]
    assert bench.unit.battery


def test_a_lost_position_lands_after_a_second() -> None:
    bench = Bench()
    bench.pass_time(0.9, position_ok=False)
    assert bench.done == []
    bench.pass_time(0.5, position_ok=False)
    assert bench.done == [Fallback.LAND]
    assert bench.said[-1] == "EKF Failsafe: changed to LAND Mode"


@pytest.mark.parametrize("changes", [{"needs_position": False}, {"armed": False}])
def test_a_position_that_nobody_needs_is_not_missed(changes: dict[str, Any]) -> None:
    bench = Bench()
    bench.pass_time(5.0, position_ok=False, **changes)
    assert bench.done == []


@pytest.mark.parametrize(
    ("action", "reaction"),
    [(0, Fallback.NOTHING), (1, Fallback.RTL), (2, Fallback.LAND), (4, Fallback.BRAKE)],
)
def test_a_breached_fence_acts_once(action: int, reaction: Fallback) -> None:
    bench = Bench(FENCE_ACTION=action)
    bench.pass_time(5.0, breaches=FenceType.POLYGON)
    assert bench.done == [reaction]
    assert bench.said == ["Polygon fence breached"]
    bench.pass_time(1.0)
    assert bench.said[-1] == "Fence breach cleared"


def test_a_fence_does_not_act_on_the_ground_or_while_landing() -> None:
    bench = Bench()
    bench.pass_time(1.0, breaches=FenceType.POLYGON, landed=True)
    assert bench.said == []
    bench = Bench()
    bench.pass_time(1.0, breaches=FenceType.POLYGON, mode=9)
    assert bench.done == []
