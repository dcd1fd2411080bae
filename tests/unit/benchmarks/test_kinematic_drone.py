from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.kinematic_drone import STEP_S, Drone, goal_of
from hawk.ddc.fence.geometry import polygon_fence
from hawk.ddc.motion import Goal
from hawk.model.plans import PathPlan
from hawk.model.poses import MapPoint, MapPose

FENCE = polygon_fence([(-60.0, -60.0), (60.0, -60.0), (60.0, 60.0), (-60.0, 60.0)], 5.0, 100.0, 3.0)
START = MapPose(0.0, 0.0, 35.0, 0.0, 0.0, 0.0)


def drone(sigma: float = 0.0) -> Drone:
    return Drone(START, FENCE, np.random.default_rng(1), sigma)


def fly(one: Drone, goal: Goal, seconds: float) -> float:
    """Return the greatest lean of the flight, radians."""
    most = 0.0
    for _ in range(round(seconds / STEP_S)):
        one.step(goal)
        most = max(most, math.hypot(one.true.roll, one.true.pitch))
    return most


def test_it_flies_to_a_goal_leans_meanwhile_and_counts_its_distance() -> None:
    one = drone()
    lean = fly(one, Goal(20.0, 10.0, 35.0, math.pi / 2), 20.0)
    assert (one.true.north, one.true.east, one.true.height) == pytest.approx((20.0, 10.0, 35.0), abs=0.3)
    assert one.true.yaw == pytest.approx(math.pi / 2, abs=0.02)
    assert math.radians(5) < lean < math.radians(25)
    assert one.distance_m == pytest.approx(math.hypot(20.0, 10.0), abs=1.0)
    assert one.seconds == pytest.approx(20.0)


def test_it_does_not_follow_a_goal_beyond_the_fence() -> None:
    one = drone()
    fly(one, Goal(0.0, 80.0, 35.0, 0.0), 10.0)
    assert one.distance_m < 1.0


@pytest.mark.slow
def test_a_drifting_position_takes_it_where_it_believes_the_goal_is() -> None:
    one = drone(2.0)
    fly(one, Goal(20.0, 0.0, 35.0, 0.0), 60.0)
    assert (one.believed.north, one.believed.east) == pytest.approx((20.0, 0.0), abs=0.5)
    assert math.hypot(one.true.north - one.believed.north, one.true.east - one.believed.east) > 0.1


def test_a_plan_becomes_a_goal_and_one_without_a_target_leaves_the_last() -> None:
    goal = goal_of(PathPlan(MapPoint(3.0, 4.0), 30.0, 1.0), START, None)
    assert goal == Goal(3.0, 4.0, 30.0, 1.0)
    assert goal_of(PathPlan(), START, goal) is goal
    assert goal_of(PathPlan(MapPoint(3.0, 4.0)), START, None) == Goal(3.0, 4.0, START.height, START.yaw)
