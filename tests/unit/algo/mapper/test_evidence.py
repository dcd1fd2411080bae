from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.algo.mapper.evidence import MOST_STILL, TURN, Novelty
from hawk.model.poses import MapPose

HERE = MapPose(0.0, 0.0, 30.0, 0.0, 0.0, 0.0)
LOOK_M, STILL = 5.0, 0.02


def novelty() -> Novelty:
    made = Novelty(LOOK_M, STILL)
    assert made.of(HERE) == 1.0
    return made


def test_a_drone_that_hovers_in_the_wind_learns_a_bounded_amount_and_then_nothing() -> None:
    made, rng = novelty(), np.random.default_rng(1)
    sway = 0.5 * np.sin(np.arange(6000) * 0.07)
    shares = [made.of(replace(HERE, north=float(n), yaw=float(0.01 * rng.uniform()))) for n in sway]
    assert sum(shares) < MOST_STILL + 0.5 / LOOK_M + 0.01 / TURN + 1e-6
    assert sum(shares[3000:]) == 0.0


@pytest.mark.parametrize("step", [0.1, 0.5, 2.0])
def test_on_a_straight_path_every_look_distance_counts_once(step: float) -> None:
    made = novelty()
    count = round(50 / step)
    total = sum(made.of(replace(HERE, east=step * k)) for k in range(1, count + 1))
    assert 9 <= total <= 10 * (1 + MOST_STILL) + 1


def test_a_turn_on_the_spot_shows_other_ground() -> None:
    made = novelty()
    assert sum(made.of(replace(HERE, yaw=0.1 * k)) for k in range(1, 63)) > 9


def test_a_climb_counts_as_a_path_does() -> None:
    made = novelty()
    assert made.of(replace(HERE, height=30.0 + LOOK_M)) == 1.0


def test_back_at_a_place_after_an_independent_look_it_counts_again() -> None:
    made = novelty()
    there = replace(HERE, north=LOOK_M)
    assert made.of(there) == 1.0
    assert made.of(HERE) == 1.0


@given(st.lists(st.tuples(st.floats(-40, 40), st.floats(-40, 40), st.floats(-math.pi, math.pi)), max_size=60))
def test_shares_are_between_nothing_and_a_whole_look(steps: list[tuple[float, float, float]]) -> None:
    made = Novelty(LOOK_M, STILL)
    assert all(0.0 <= made.of(MapPose(n, e, 30.0, 0.0, 0.0, yaw)) <= 1.0 for n, e, yaw in steps)
