"""Limits of a target at their very value, without a drone."""

from __future__ import annotations

import pytest

from hawk.ddc.fence.geometry import inside_point, polygon_fence
from hawk.ddc.motion import Goal, maximum_target_distance
from hawk.ddc.requests.service_interface import ABOVE_M, ENTRANCE_M, Limits, target_refusal
from hawk.model.plans import HeightParameters
from hawk.model.poses import MapPoint, MapPose

SQUARE = polygon_fence(((-100, -100), (100, -100), (100, 100), (-100, 100)), 5.0, 100.0, 3.0)
REACH = maximum_target_distance(4.0)
HOLDS, TASK = True, False


def refused(
    to: tuple[float, float, float], of: tuple[float, float, float], holds: bool = TASK, speed: float = 4.0
) -> str:
    limits = Limits(SQUARE, HeightParameters(15, 35, 60), speed, holds)
    return target_refusal(Goal(*to, 0.0), MapPose(*of, 0.0, 0.0, 0.0), limits)


@pytest.mark.parametrize(
    ("height", "holds", "words"),
    [
        (15.0, TASK, ""),
        (14.99, TASK, "below Min, 15 m"),
        (14.99, HOLDS, "below Min, 15 m"),
        (60.0, TASK, ""),
        (60.01, TASK, "above Max, 60 m"),
        (60.01, HOLDS, ""),
    ],
)
def test_heights_at_their_limits(height: float, holds: bool, words: str) -> None:
    start = 20.0 if height < 20 else 58.0
    found = refused((3.0, 0.0, height), (0.0, 0.0, start), holds)
    assert words in found
    assert bool(words) is bool(found)


def test_below_min_only_the_straight_climb_is_free() -> None:
    low = (0.0, 0.0, 8.0)
    assert refused((ABOVE_M, 0.0, 9.0), low) == ""
    assert refused((ABOVE_M, 0.0, 8.0), low) == "", "level is no descent"
    assert "below Min" in refused((ABOVE_M, 0.0, 7.99), low)
    assert "below Min" in refused((ABOVE_M + 0.01, 0.0, 9.0), low)


def test_above_max_only_the_straight_descent_is_free() -> None:
    high = (0.0, 0.0, 70.0)
    assert refused((ABOVE_M, 0.0, 69.0), high) == ""
    assert refused((ABOVE_M, 0.0, 70.0), high) == ""
    assert "above Max" in refused((ABOVE_M, 0.0, 70.01), high)
    assert "above Max" in refused((ABOVE_M + 0.01, 0.0, 69.0), high)


def test_above_the_ceiling_only_a_hold_may_come_down() -> None:
    ceiling = SQUARE.ceiling
    above = (0.0, 0.0, ceiling + 2.0)
    assert refused((0.0, 0.0, ceiling + 1.0), above, HOLDS) == ""
    assert "above the ceiling" in refused((0.0, 0.0, ceiling + 1.0), above, TASK)
    assert "above the ceiling" in refused((ABOVE_M + 0.01, 0.0, ceiling + 1.0), above, HOLDS)
    assert "above the ceiling" in refused((0.0, 0.0, ceiling + 0.1), (0.0, 0.0, ceiling), HOLDS)
    assert refused((0.0, 0.0, ceiling), (0.0, 0.0, ceiling - 1.0), HOLDS) == ""


@pytest.mark.parametrize("axis", [0, 2])
def test_a_target_is_no_farther_than_the_longest_step(axis: int) -> None:
    here = (0.0, 0.0, 30.0)
    near, far = list(here), list(here)
    near[axis] += REACH - 1e-6
    far[axis] += REACH + 0.01
    assert refused((near[0], near[1], near[2]), here) == ""
    assert "away, more than" in refused((far[0], far[1], far[2]), here)


def test_a_task_outside_the_fence_is_not_led_and_a_hold_is_led_back_never_out() -> None:
    outside = (110.0, 0.0, 30.0)
    assert "outside the fence" in refused((109.0, 0.0, 30.0), outside, TASK)
    assert refused((109.0, 0.0, 30.0), outside, HOLDS) == ""
    assert refused((110.0, 0.0, 30.0), outside, HOLDS) == "", "no farther out"
    assert refused((95.5, 0.0, 30.0), outside, HOLDS) == "", "half a metre outside of our limit is nearer too"
    assert "outside the fence" in refused((110.01, 0.0, 30.0), outside, HOLDS)
    assert "outside the fence" in refused((101.0, 0.0, 30.0), (90.0, 0.0, 30.0), HOLDS), "inside it is never led out"


def test_a_hold_far_outside_may_go_to_the_nearest_place_inside_and_not_much_farther() -> None:
    outside = (150.0, 0.0, 30.0)
    inside = inside_point(SQUARE, MapPoint(150.0, 0.0))
    away = 150.0 - inside.north
    assert away > REACH
    assert refused((150.0 - away - ENTRANCE_M + 0.01, 0.0, 30.0), outside, HOLDS) == ""
    assert "away, more than" in refused((150.0 - away - ENTRANCE_M - 0.01, 0.0, 30.0), outside, HOLDS)
    assert "away, more than" in refused((inside.north, inside.east, 30.0 + REACH + 0.01), outside, HOLDS)
    assert refused((inside.north, inside.east, 30.0 + REACH - 1e-6), outside, HOLDS) == ""
    assert refused((inside.north, inside.east, 30.0), outside, TASK) != ""
