from __future__ import annotations

import itertools
from datetime import date, datetime, timedelta

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.worlds.moment import clock_of
from hawk.worlds.stays import MEAN_STAY_S, NIGHT_SHARE, Demand, LotStays, Stay
from tests.examples import nightly

CLOCK = clock_of(-79.9)
SMALL = LotStays(7, {4: Demand(0.9), 9: Demand(0.1), 11: Demand(0.5, accessible=True)}, CLOCK)
LARGE = LotStays(3, {k: Demand(k / 199) for k in range(200)}, CLOCK)
MONDAY = datetime(2026, 5, 4, tzinfo=CLOCK)
HOURS = st.floats(-40, 400).map(lambda hours: MONDAY + timedelta(hours=hours))


@pytest.fixture(scope="module")
def week() -> list[Stay]:
    return LARGE.between(MONDAY, MONDAY + timedelta(days=7))


@pytest.mark.nightly
@settings(max_examples=40, deadline=None)
@given(HOURS, st.floats(0, 60), st.floats(0, 60), st.floats(0, 60))
def test_a_wider_question_gets_the_same_stays(begin: datetime, hours: float, before: float, after: float) -> None:
    end = begin + timedelta(hours=hours)
    narrow = SMALL.between(begin, end)
    wide = SMALL.between(begin - timedelta(hours=before), end + timedelta(hours=after))
    assert narrow == [stay for stay in wide if stay.begin <= end and stay.end > begin]


@pytest.mark.nightly
@settings(max_examples=40, deadline=None)
@given(HOURS)
def test_the_cars_of_a_moment_are_those_whose_stays_cover_it(moment: datetime) -> None:
    near = SMALL.between(moment - timedelta(days=2), moment + timedelta(days=2))
    assert SMALL.at(moment) == {stay.stall: stay for stay in near if stay.begin <= moment < stay.end}


@pytest.mark.nightly
def test_no_stall_has_two_cars_at_once(week: list[Stay]) -> None:
    for stall, stays in itertools.groupby(week, lambda stay: stay.stall):
        listed = list(stays)
        assert all(one.begin < one.end for one in listed), stall
        assert all(one.end < following.begin for one, following in itertools.pairwise(listed)), stall


def test_another_clock_asks_for_the_same_moments() -> None:
    moment = MONDAY + timedelta(hours=11)
    assert SMALL.at(moment.astimezone(clock_of(150.0))) == SMALL.at(moment)


def test_another_seed_has_other_stays() -> None:
    other = LotStays(8, {4: Demand(0.9)}, CLOCK)
    assert other.between(MONDAY, MONDAY + timedelta(days=1)) != LotStays(7, {4: Demand(0.9)}, CLOCK).between(
        MONDAY, MONDAY + timedelta(days=1)
    )


def test_a_stall_keeps_its_stays_whatever_other_stalls_there_are() -> None:
    alone = LotStays(7, {4: Demand(0.9)}, CLOCK).between(MONDAY, MONDAY + timedelta(days=3))
    assert alone == [s for s in SMALL.between(MONDAY, MONDAY + timedelta(days=3)) if s.stall == 4]


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("day", "hour"),
    [(4, 8), (4, 17), (9, 13), (10, 20), *nightly((4, 12), (4, 21), (9, 10), (9, 18), (10, 9), (10, 14))],
)
def test_the_share_of_taken_stalls_follows_the_curve(day: int, hour: int) -> None:
    moments = [datetime(2026, 5, day, hour, tzinfo=CLOCK) + timedelta(weeks=k) for k in range(4)]
    taken = np.mean([len(LARGE.at(moment)) / 200 for moment in moments])
    asked = np.mean([LARGE.share(stall, moments[0]) for stall in range(200)])
    # the curve is exact for exponential lengths; 800 draws have a standard error below .018
    assert taken == pytest.approx(asked, abs=0.13)


@pytest.mark.nightly
def test_noon_is_busier_than_evening_and_night_nearly_empty() -> None:
    counts = [len(LARGE.at(MONDAY + timedelta(hours=hour))) for hour in (27, 12, 20)]
    assert counts[0] < 3 * NIGHT_SHARE * 200 < counts[2] < counts[1]


@pytest.mark.nightly
def test_a_saturday_is_busier_than_a_sunday() -> None:
    saturday, sunday = (len(LARGE.at(datetime(2026, 5, day, 13, tzinfo=CLOCK))) for day in (9, 10))
    assert saturday > 1.5 * sunday


@pytest.mark.nightly
def test_stalls_near_the_building_fill_first() -> None:
    taken = [stall for day in range(5) for stall in LARGE.at(MONDAY + timedelta(days=day, hours=9))]
    assert sum(stall >= 100 for stall in taken) > 1.15 * sum(stall < 100 for stall in taken)


def test_accessible_stalls_are_sought_less() -> None:
    moment = MONDAY + timedelta(hours=12)
    lot = LotStays(1, {0: Demand(0.5), 1: Demand(0.5, accessible=True)}, CLOCK)
    assert lot.share(1, moment) < 0.6 * lot.share(0, moment)


def test_lengths_are_log_normal_with_some_that_last_all_day(week: list[Stay]) -> None:
    shopping = [s for s in week if s.begin.hour in range(10, 16)]
    lengths = np.array([(stay.end - stay.begin).total_seconds() for stay in shopping])
    # a car of the night may cut a stay, and the longest are cut at ten hours
    assert lengths.mean() == pytest.approx(MEAN_STAY_S, rel=0.06)
    assert np.log(lengths).std() == pytest.approx(0.8, abs=0.06)
    mornings = [s for s in week if s.begin.hour in range(6, 10) and s.begin.weekday() < 5]
    long = np.mean([(stay.end - stay.begin) > timedelta(hours=6) for stay in mornings])
    assert 0.07 < long < 0.2


def test_a_day_of_the_year_has_its_own_stays() -> None:
    days = [date(2026, 5, 4) + timedelta(weeks=k) for k in range(2)]
    times = [
        [(stay.begin.time(), stay.end.time()) for stay in SMALL.between(begin, begin + timedelta(days=1))]
        for begin in (datetime(day.year, day.month, day.day, tzinfo=CLOCK) for day in days)
    ]
    assert times[0] != times[1]
