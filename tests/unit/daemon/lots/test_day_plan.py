"""The rounds of a day: what is flown together, and the first hour that wind, rain, light and batteries allow."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.daemon.lots.day_plan import (
    FORECAST_S,
    SWAP_S,
    DayLimits,
    DueLot,
    RoundFlight,
    day_plan,
    day_rounds,
    flight_seconds,
    light,
)
from hawk.daemon.lots.schedule import EARLY, LATE
from hawk.ddc.battery import energy
from hawk.ddc.battery.survey import Battery, Sweep, need_on_ground
from hawk.model.day_plan import DayRound, Forecast, WeatherHour
from hawk.model.known_lot import LotAhead
from hawk.model.plans import Outline
from tests.examples import examples
from tests.unit.lots.surveys import box

NOON = datetime(2026, 5, 4, 12, 0, tzinfo=UTC)
PLACE = (52.0, 5.0)
HOUR_S = 3600.0


def due_lot(name: str, north: float = 0.0, at: datetime = NOON, stalls: int = 20) -> DueLot:
    return DueLot(LotAhead(f"id of {name}", name, stalls, 0.0, box(north, 0.0, 40.0, 40.0)), at)


def flight(*lots: DueLot, minutes: float = 20.0, batteries: int = 1) -> RoundFlight:
    return RoundFlight(lots or (due_lot("North"),), PLACE, 500.0, minutes * 60.0, batteries)


CALM = WeatherHour(0.0, HOUR_S, wind=3.0, gust=5.0, cloud=0.2, rain=0.0)


def weather(begin: datetime = NOON, hours: int = 8, **changed: float) -> tuple[WeatherHour, ...]:
    """Return hours of one weather."""
    times = [begin.timestamp() + HOUR_S * number for number in range(hours)]
    return tuple(replace(CALM, begin=at, end=at + HOUR_S, **changed) for at in times)


def limits(*hours: WeatherHour, now: datetime = NOON, batteries: int = 4, age_h: float = 1.0) -> DayLimits:
    issued = now.timestamp() - age_h * HOUR_S
    return DayLimits(now.timestamp(), batteries, 10.0, Forecast(issued, hours or weather(now)))


def only_round(of: RoundFlight, within: DayLimits) -> DayRound:
    (found,) = day_plan([of], within).rounds
    return found


def reasons(of: DayRound) -> dict[str, list[str]]:
    return {f"{hour.at:%H:%M}": list(hour.reasons) for hour in of.hours}


def test_a_round_starts_when_it_is_due_where_the_day_is_calm_dry_and_light() -> None:
    found = only_round(flight(), limits())
    assert (found.start, found.end) == (NOON, NOON + timedelta(minutes=20))
    assert (found.batteries, found.problem, reasons(found)) == (1, "", {"12:00": []})


@pytest.mark.parametrize(
    ("gust", "rain", "reason"),
    [
        (12.0, 0.0, "wind of 3 m/s with gusts of 12 m/s, limit 10 m/s"),
        (5.0, 0.3, "0.3 mm of rain"),
    ],
)
def test_an_hour_of_wind_or_rain_is_left_out_with_its_reason(gust: float, rain: float, reason: str) -> None:
    hours = (*weather(hours=2, gust=gust, rain=rain), *weather(NOON + timedelta(hours=2)))
    found = only_round(flight(), limits(*hours))
    assert found.start == NOON + timedelta(hours=2)
    assert reasons(found) == {"12:00": [reason], "13:00": [reason], "14:00": []}


def test_wind_that_comes_before_the_landing_counts() -> None:
    hours = (*weather(hours=1), *weather(NOON + timedelta(hours=1), gust=11.0))
    assert only_round(flight(minutes=61.0), limits(*hours)).start is None
    assert only_round(flight(minutes=60.0), limits(*hours)).start == NOON


def test_all_day_of_strong_wind_proposes_no_start() -> None:
    found = only_round(flight(), limits(*weather(gust=10.1)))
    assert (found.start, found.end) == (None, None)
    assert len(found.hours) == LATE / timedelta(hours=1)
    assert all("limit 10 m/s" in hour.reasons[0] for hour in found.hours)


def test_a_round_at_night_has_no_start_and_says_how_high_the_sun_is() -> None:
    night = NOON.replace(hour=20)
    found = only_round(flight(due_lot("North", at=night)), limits(*weather(night), now=night))
    assert found.start is None
    assert found.hours[0].reasons == ("too dark: sun at -10°, 20 % of cloud",)


def test_the_light_at_the_landing_counts_and_cloud_takes_of_it() -> None:
    evening = NOON.replace(hour=18)
    of = flight(due_lot("North", at=evening))
    within = limits(*weather(evening), now=evening)
    assert only_round(of, within).start == evening
    assert only_round(replace(of, seconds=5400.0), within).start is None
    dull = limits(*weather(evening, cloud=1.0), now=evening)
    assert only_round(of, dull).start is None


def test_a_night_between_start_and_landing_is_too_dark() -> None:
    found = only_round(flight(minutes=22 * 60.0), limits(*weather(hours=40)))
    assert found.start is None
    assert "too dark" in reasons(found)["12:00"][0]


def test_a_round_over_the_end_of_summer_time_ends_after_its_seconds() -> None:
    due = datetime(2026, 10, 25, 0, 30, tzinfo=ZoneInfo("America/St_Johns"))
    begun = NOON.replace(month=10, day=24)
    at = (due.timestamp() - begun.timestamp()) / HOUR_S
    light_there = RoundFlight((due_lot("North", at=due),), (-30.0, 150.0), 500.0, 3 * HOUR_S)
    found = only_round(light_there, limits(*weather(begun, hours=int(at) + 12), now=begun))
    assert found.start is not None
    assert found.end is not None
    assert found.end.timestamp() - found.start.timestamp() == 3 * HOUR_S


def test_light_by_the_model_of_kasten_and_czeplak() -> None:
    assert light(90.0, 0.0) == pytest.approx(880.0 * 110.0)
    assert light(30.0, 1.0) == pytest.approx(425.0 / 4 * 110.0)
    assert light(-10.0, 0.0) == light(1.0, 0.0) == 0.0


def test_too_few_batteries_propose_no_start() -> None:
    found = only_round(flight(batteries=5), limits())
    assert (found.start, found.hours) == (None, ())
    assert found.problem == "It needs 5 batteries; left: 4."


def test_a_forecast_that_is_old_missing_or_of_the_future_is_not_believed() -> None:
    cases = {
        limits(age_h=FORECAST_S / HOUR_S + 0.6): "The forecast is 13 h old: enter one of the last 12 h.",
        replace(limits(), forecast=None): "There is no forecast: enter one.",
        limits(age_h=-1.0): "The forecast was issued in the future: look at its time and at the computer's clock.",
    }
    for within, words in cases.items():
        plan = day_plan([flight()], within)
        assert plan.rounds[0].start is None
        assert (plan.rounds[0].problem, plan.problems) == (words, (words,))
    assert only_round(flight(), limits(age_h=FORECAST_S / HOUR_S)).start == NOON


def test_an_hour_of_which_the_forecast_says_nothing_is_left_out() -> None:
    found = only_round(flight(), limits(*weather(NOON + timedelta(hours=1))))
    assert found.start == NOON + timedelta(hours=1)
    assert found.hours[0].reasons == ("the forecast says nothing of 12:00",)


def test_rounds_are_flown_one_after_the_other_with_the_batteries_that_are_left() -> None:
    flights = [flight(due_lot(name), minutes=50.0, batteries=2) for name in ("North", "South", "West")]
    first, second, third = day_plan(flights, limits(batteries=4)).rounds
    assert first.start == NOON
    assert second.start == NOON + timedelta(minutes=50, seconds=SWAP_S)
    assert (third.start, third.problem) == (None, "It needs 2 batteries; left: 0.")


def test_a_round_without_a_flight_says_why_and_takes_no_battery() -> None:
    plan = day_plan([replace(flight(), problem="no stalls"), flight()], limits(batteries=1), ["schedule: words"])
    assert [each.start for each in plan.rounds] == [None, NOON]
    assert (plan.rounds[0].problem, plan.problems) == ("no stalls", ("schedule: words",))


def test_a_round_that_no_time_is_left_for_says_so() -> None:
    long = flight(minutes=6 * 60)
    first, second = day_plan([long, flight(due_lot("South"))], limits(*weather(hours=12))).rounds
    assert (first.start, second.start) == (NOON, None)
    assert second.problem == "An earlier round takes until it is due no more."


def test_lots_that_are_near_and_due_about_the_same_time_are_one_round() -> None:
    lots = [due_lot("North"), due_lot("South", 100.0, NOON + EARLY), due_lot("Late", 200.0, NOON + 2 * EARLY)]
    assert [[each.lot.name for each in mine] for mine in day_rounds(lots)] == [["North", "South"], ["Late"]]
    assert flight(*lots[:2]).due == NOON + EARLY


@pytest.mark.parametrize(
    "other",
    [
        due_lot("Far", 500.0), due_lot("Over it", 20.0), due_lot("Empty", 100.0, stalls=0), due_lot("North"),
        DueLot(replace(due_lot("Wide").lot, outline=Outline((((52.0, 5.0), (54.0, 5.0), (54.0, 9.0)),))), NOON),
    ],
)  # fmt: skip
def test_lots_that_cannot_be_one_flight_are_rounds_of_their_own(other: DueLot) -> None:
    assert len(day_rounds([due_lot("North"), other])) == 2


def test_a_round_takes_twelve_lots_at_most() -> None:
    lots = [due_lot(f"{number:02d}", 45.0 * (number % 4)) for number in range(4)]
    many = [DueLot(replace(lot.lot, id=f"{k}", outline=box(45.0 * (k % 5), 45.0 * (k // 5), 40, 40)), NOON)
            for k, lot in enumerate(lots * 4)]  # fmt: skip
    assert [len(mine) for mine in day_rounds(many)] == [12, 4]


def test_the_time_of_a_round_has_climb_home_and_each_swap() -> None:
    sweep, heights = Sweep.of(4.0, 35.0, 1.4), (35.0, 60.0)

    def seconds(distance: float, charge: float) -> tuple[int, float, float]:
        battery = Battery(charge, 20.0, energy.ASSUMED_DRAIN, is_measured=True)
        need = need_on_ground("outline", 5000.0, distance, sweep, heights, battery)
        return need.batteries, flight_seconds(need, battery, 35.0), need.seconds

    batteries, whole, survey = seconds(300.0, 100.0)
    assert batteries == 1
    home = whole - survey - 35.0 / energy.CLIMB_M_S
    assert home == pytest.approx(energy.seconds_home(0.71 * 5000.0**0.5, 35.0, 60.0, 4.0))
    batteries, whole, survey = seconds(3000.0, 100.0)
    assert batteries > 1
    assert whole == pytest.approx(survey + 35.0 / 2.0 + home + (batteries - 1) * (SWAP_S + 2 * home))


@settings(max_examples=examples(100), deadline=None)
@given(
    st.lists(st.tuples(st.floats(0, 20), st.floats(0, 1), st.sampled_from([0.0, 0.0, 0.4])), min_size=1, max_size=12),
    st.floats(1, 200), st.integers(1, 6), st.integers(0, 4), st.integers(0, 23),
)  # fmt: skip
def test_no_start_is_proposed_into_weather_or_darkness(
    drawn: list[tuple[float, float, float]], minutes: float, needed: int, ready: int, hour: int
) -> None:
    now = NOON.replace(hour=hour)
    times = [now.timestamp() + HOUR_S * number for number in range(len(drawn))]
    hours = [
        WeatherHour(at, at + HOUR_S, gust / 2, gust, cloud, rain)
        for at, (gust, cloud, rain) in zip(times, drawn, strict=True)
    ]
    of = flight(due_lot("North", at=now), minutes=minutes, batteries=needed)
    found = only_round(of, limits(*hours, now=now, batteries=ready))
    if found.start is None or found.end is None:
        assert found.problem or all(each.reasons for each in found.hours)
        return
    begin, end = found.start.timestamp(), found.end.timestamp()
    during = [each for each in hours if each.begin < end and each.end > begin]
    assert needed <= ready
    assert all(each.gust <= 10.0 and each.rain == 0.0 for each in during)
    assert sum(min(each.end, end) - max(each.begin, begin) for each in during) == pytest.approx(end - begin)
    assert 4 <= found.start.hour <= 20
