from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from hawk.sim.flight_record import FlightRecord, WatchedFence

SQUARE = [(-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0)]


def move(station: Any, record: FlightRecord, *places: tuple[float, float, float]) -> None:
    """Put the true body somewhere, a tenth of a second apart."""
    for place in places:
        station.autopilot.body = replace(station.autopilot.body, position=place, on_ground=place[2] == 0.0)
        station.autopilot.time += 0.11
        record.step()


@pytest.mark.parametrize(
    ("place", "inside"),
    [
        ((12.9, 0.0, -10.0), True),
        ((13.1, 0.0, -10.0), False),
        ((0.0, 0.0, -32.9), True),
        ((0.0, 0.0, -33.1), False),
    ],
)
def test_the_margin_is_three_metres(place: tuple[float, float, float], inside: bool) -> None:
    assert WatchedFence.of(SQUARE, 30.0).holds(place) is inside


def test_each_excursion_counts_once(station: Any) -> None:
    record = FlightRecord(station.autopilot)
    record.watch(WatchedFence.of(SQUARE, 30.0))
    out, home = (20.0, 0.0, -10.0), (0.0, 0.0, -10.0)
    move(station, record, home, out, out, home, home, out, home)
    assert record.excursions == 2
    assert not record.summary()["outside"]


def test_a_new_fence_starts_counting_again(station: Any) -> None:
    record = FlightRecord(station.autopilot)
    record.watch(WatchedFence.of(SQUARE, 30.0))
    move(station, record, (20.0, 0.0, -10.0))
    record.watch(WatchedFence.of(SQUARE, 30.0))
    assert record.excursions == 0
    assert record.summary()["fence"]


def test_the_distance_is_over_the_ground_and_the_time_in_the_air(station: Any) -> None:
    record = FlightRecord(station.autopilot)
    move(station, record, (0.0, 0.0, -10.0), (3.0, 4.0, -10.0), (3.0, 4.0, -30.0), (3.0, 4.0, 0.0))
    summary = record.summary()
    assert summary["distance_flown_m"] == pytest.approx(5.0)
    assert summary["flown_s"] == pytest.approx(0.33)
    assert summary["highest_m"] == 30.0


def test_the_estimate_has_no_say(make_station: Any) -> None:
    station = make_station()
    station.fly()
    record = FlightRecord(station.autopilot)
    record.watch(WatchedFence.of(SQUARE, 30.0))
    station.autopilot.shift_ekf_origin((100.0, 0.0, 0.0))
    station.autopilot.time += 0.2
    record.step()
    assert record.excursions == 0


def test_the_summary_reports_how_it_ended(flying: Any) -> None:
    record = FlightRecord(flying.autopilot)
    before = record.summary()
    assert (before["landed"], before["disarmed"], before["crashed"]) == (False, False, False)
    flying.autopilot.terminate()
    flying.run(4.0)
    after = record.summary()
    assert (after["landed"], after["disarmed"], after["crashed"]) == (True, True, True)
    assert after["position"]["height"] == pytest.approx(0.0)
