"""The drain that a flight measures, and what the next flight believes of it."""

from __future__ import annotations

import pytest

from hawk.ddc.battery.energy import DRAIN_AGE_S, FASTEST, LEAST_S, SLOWEST, DrainMeter, known_drain
from hawk.model.operation import FlightDrain

NOW = 1_700_000_000.0


def flight(meter: DrainMeter, seconds: int, drain: float, begin: float = 95.0) -> FlightDrain | None:
    for second in range(seconds):
        meter.update(begin - drain * second, float(second), NOW, airborne=True, armed=True)
    assert meter.update(begin, float(seconds), NOW, airborne=False, armed=True) is None
    return meter.update(begin, seconds + 1.0, NOW, airborne=False, armed=False)


def test_a_flight_measures_its_drain_once() -> None:
    meter = DrainMeter()
    found = flight(meter, 200, 0.1)
    assert found is not None
    assert found.drain == pytest.approx(0.1)
    assert found.seconds == 199
    assert found.at == NOW
    assert meter.update(95.0, 300.0, NOW, airborne=False, armed=False) is None


def test_a_gauge_that_corrects_itself_is_no_drain() -> None:
    meter = DrainMeter()
    for second in range(200):
        charge = 95.0 - 0.1 * second - (40.0 if second >= 100 else 0.0)
        meter.update(charge, float(second), NOW, airborne=True, armed=True)
    found = meter.update(30.0, 201.0, NOW, airborne=False, armed=False)
    assert found is not None
    assert found.drain == pytest.approx(0.1)


@pytest.mark.parametrize(("seconds", "drain"), [(int(LEAST_S) - 5, 0.1), (200, 0.0), (200, SLOWEST / 2)])
def test_a_flight_that_says_nothing_is_not_kept(seconds: int, drain: float) -> None:
    assert flight(DrainMeter(), seconds, drain) is None


def kept(drain: float, *, seconds: float = 300.0, age: float = 600.0) -> FlightDrain:
    return FlightDrain(drain, seconds, NOW - age)


def test_the_worst_of_the_last_flights_counts() -> None:
    assert known_drain([kept(0.08), kept(0.14), kept(0.09)], NOW) == 0.14
    assert known_drain([kept(0.3), kept(0.08), kept(0.1), kept(0.09)], NOW) == 0.1  # older than the last three


@pytest.mark.parametrize(
    "bad",
    [
        kept(0.1, age=DRAIN_AGE_S + 1),
        kept(0.1, age=-2 * 86_400.0),
        kept(2 * FASTEST),
        kept(SLOWEST / 2),
        kept(float("nan")),
        kept(0.1, seconds=10.0),
    ],
)
def test_what_is_old_short_or_implausible_is_not_believed(bad: FlightDrain) -> None:
    assert known_drain([bad], NOW) is None
    assert known_drain([bad, kept(0.09)], NOW) == 0.09
    assert known_drain([], NOW) is None
