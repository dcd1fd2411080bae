"""Counts of sections: the interval against drawn worlds, and the room between vehicles."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.lots.plan.values import PlanSection
from hawk.lots.survey.section_counts import Sight, count_of, interval, room_in

KERB = PlanSection("k", "Elm Street", ((0.0, 0.0), (0.0, 55.0), (2.2, 55.0), (2.2, 0.0)), "parallel", 55, 10, False, "")


def cars(*easts: float) -> np.ndarray:
    """Return cars of 4.5 m along the kerb by their middles."""
    return np.array([(1.1, east, math.pi / 2, 1.8, 4.5) for east in easts], float).reshape(-1, 5)


def sight(*easts: float, p: float = 0.98, hidden: float = 0.0, seen: float = 1.0) -> Sight:
    return Sight("vehicles", cars(*easts), np.full(len(easts), p), hidden, seen)


def test_a_kerb_with_three_cars_has_room_in_its_gaps() -> None:
    """Gaps of 1.75, 8.5, 15.5 and 15.75 m: 0, 1, 2 and 2 places of 5.5 m."""
    found = count_of(KERB, sight(4.0, 17.0, 37.0))
    assert (found.parked, found.room) == (3, 5)
    assert found.least <= 3 <= found.most
    assert count_of(KERB, sight()).room == 10


def test_cars_beside_each_other_leave_one_gap_and_one_over_the_end_none_behind_it() -> None:
    assert room_in(KERB, cars(4.0, 4.2, 55.0)) == 8


def test_hidden_ground_widens_the_interval_and_from_a_third_on_says_no_room() -> None:
    seen, hidden = count_of(KERB, sight(4.0, 17.0)), count_of(KERB, sight(4.0, 17.0, hidden=0.2, seen=0.7))
    assert (hidden.parked, hidden.room) == (2, None)
    assert hidden.most >= seen.most + 3
    assert count_of(KERB, sight(4.0, seen=0.71)).room is not None


def test_more_cars_than_places_are_counted_as_they_are() -> None:
    found = count_of(KERB, sight(*np.arange(2.5, 55, 4.6).tolist()))
    assert (found.parked, found.room) == (12, 0)


def test_an_area_says_no_room_and_has_the_places_of_its_ground() -> None:
    yard = PlanSection("y", "Yard", ((0.0, 0.0), (0.0, 50.0), (25.0, 50.0), (25.0, 0.0)), "", 50, None, False, "")
    found = count_of(yard, sight(seen=0.5))
    assert (found.parked, found.least, found.room) == (0, 0, None)
    assert found.most == 48  # 0 to 50 alike: 5 % above


@given(
    st.lists(st.floats(0, 1), max_size=40),
    st.floats(0, 60),
    st.floats(0.5, 1.0),
)
def test_an_interval_has_an_order_and_grows_with_what_is_hidden(ps: list[float], unseen: float, recall: float) -> None:
    least, most = interval(np.array(ps), unseen, recall)
    assert 0 <= least <= most
    _, more = interval(np.array(ps), unseen + 5, recall)
    assert more >= most
    assert interval(np.array(ps), 0.0, 1.0)[1] <= len(ps)


@pytest.mark.parametrize(("count", "p", "unseen"), [(12, 0.95, 0), (30, 0.8, 6), (4, 0.6, 0), (60, 0.97, 20)])
def test_ninety_of_a_hundred_drawn_worlds_lie_in_the_interval(count: int, p: float, unseen: int) -> None:
    least, most = interval(np.full(count, p), unseen, 0.85)
    drawn = random.Random(3)
    rng = np.random.default_rng(3)
    held = 0
    for _ in range(2000):
        true = sum(drawn.random() < p for _ in range(count)) + rng.poisson(0.15 / 0.85 * p * count)
        held += least <= true + drawn.randint(0, unseen) <= most
    assert 0.89 <= held / 2000 <= 0.99  # whole numbers hold a little more


def test_a_section_of_a_thousand_cars_has_an_interval() -> None:
    least, most = interval(np.full(4500, 0.99), recall=0.85)
    assert (least + most) / 2 == pytest.approx(4500 * 0.99 / 0.85, rel=0.01)


@given(st.lists(st.floats(-5, 60), max_size=15), st.floats(-5, 60))
def test_one_more_car_never_makes_room(easts: list[float], more: float) -> None:
    before: Any = room_in(KERB, cars(*easts))
    after: Any = room_in(KERB, cars(*easts, more))
    assert after <= before
