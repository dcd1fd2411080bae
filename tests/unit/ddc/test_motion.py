from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.ddc.motion import (
    Carrot,
    Goal,
    Progress,
    Roaming,
    maximum_target_distance,
    stopping_distance,
    stopping_point,
)
from hawk.model.poses import GlobalPose, MapPose, VehiclePose

SPEED = 4.0


def at(north: float = 0, east: float = 0, height: float = 30, yaw: float = 1.0) -> MapPose:
    return MapPose(north, east, height, 0, 0, yaw)


def moving(velocity: tuple[float, float, float], pose: MapPose | None) -> VehiclePose:
    return VehiclePose(0, GlobalPose(0, 0, 0), 30, None, pose, velocity, 0, 0, 1.0)


def test_stopping_distance_is_reaction_and_braking() -> None:
    assert stopping_distance(4) == pytest.approx(1.2 + 4)
    assert maximum_target_distance(4) == pytest.approx(12 + 5.2)


def test_the_stopping_point_lies_ahead() -> None:
    goal = stopping_point(moving((3, 4, -2), at()))
    assert goal is not None
    ahead = stopping_distance(5)
    assert (goal.north, goal.east) == pytest.approx((0.6 * ahead, 0.8 * ahead))
    assert goal.height == pytest.approx(30 + stopping_distance(2))
    assert goal.yaw == 1.0


def test_a_drone_at_rest_stops_where_it_is() -> None:
    assert stopping_point(moving((0, 0, 0), at(3, 4))) == Goal(3, 4, 30, 1.0)


@pytest.mark.parametrize("pose", [None, at(math.nan), at(height=math.inf)])
def test_no_stopping_point_without_a_finite_pose(pose: MapPose | None) -> None:
    assert stopping_point(moving((1, 0, 0), pose)) is None


def test_a_drone_that_all_but_rests_stops_where_it_is() -> None:
    goal = stopping_point(moving((0.05, -0.05, 0), at(3, 4)))
    assert goal == Goal(3, 4, 30, 1.0)


def test_a_velocity_that_is_not_finite_counts_as_rest() -> None:
    assert stopping_point(moving((math.nan, math.inf, math.nan), at())) == Goal(0, 0, 30, 1.0)


@pytest.mark.nightly
@given(
    st.lists(st.tuples(st.floats(-80, 80), st.floats(-80, 80), st.floats(0, 80)), min_size=1, max_size=4),
    st.floats(0, 1.5),
)
@settings(max_examples=30)
def test_the_carrot_never_leads_too_far_and_a_following_drone_arrives(
    goals: list[tuple[float, float, float]], lag: float
) -> None:
    carrot, pose, now = Carrot(SPEED), at(height=20), 0.0
    for north, east, height in goals:
        goal = Goal(north, east, min(max(height, 15), 60), 0.0)
        for _ in range(800):
            now += 0.1
            target = carrot.step(goal, pose, now, 15, 60)
            aside = math.hypot(target.north - pose.north, target.east - pose.east)
            assert aside <= maximum_target_distance(SPEED)
            share = 0.1 / (lag + 0.1)
            pose = at(
                pose.north + (target.north - pose.north) * share,
                pose.east + (target.east - pose.east) * share,
                pose.height + (target.height - pose.height) * share,
            )
        assert math.dist((pose.north, pose.east, pose.height), (goal.north, goal.east, goal.height)) < 0.5


def test_the_carrot_goes_at_travel_speed() -> None:
    carrot, goal = Carrot(SPEED), Goal(100, 0, 30, 0)
    carrot.step(goal, at(), 0.0, 15, 60)
    for tick in range(1, 21):
        target = carrot.step(goal, at(), tick * 0.05, 15, 60)
    assert target.north == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("speed", "flown"), [(1.0, 1.0), (9.0, SPEED), (0.0, SPEED), (-1.0, SPEED), (math.nan, SPEED), (math.inf, SPEED)]
)
def test_the_carrot_may_be_slowed_down_and_never_sped_up(speed: float, flown: float) -> None:
    carrot, goal = Carrot(SPEED), Goal(100, 0, 30, 0)
    carrot.step(goal, at(), 0.0, 15, 60, speed)
    for tick in range(1, 21):
        target = carrot.step(goal, at(), tick * 0.05, 15, 60, speed)
    assert target.north == pytest.approx(flown)


def test_the_carrot_waits_for_a_drone_that_does_not_come() -> None:
    carrot, goal = Carrot(SPEED), Goal(100, 0, 30, 0)
    for tick in range(400):
        target = carrot.step(goal, at(), tick * 0.05, 15, 60)
    assert target.north < maximum_target_distance(SPEED)


def test_the_carrot_waits_a_second_and_a_half_and_the_stopping_distance_ahead() -> None:
    carrot, goal = Carrot(SPEED), Goal(100, 0, 30, 0)
    for tick in range(400):
        target = carrot.step(goal, at(), tick * 0.05, 15, 60)
    assert target.north == pytest.approx(1.5 * SPEED + stopping_distance(SPEED), abs=0.2)
    back = carrot.step(Goal(0, 0, 30, 0), at(-1.0), 20.0, 15, 60)
    assert back.north == pytest.approx(target.north - 0.2), "one that comes nearer does not wait"


def test_the_carrot_climbs_and_sinks_at_two_metres_a_second() -> None:
    for height in (50.0, 20.0):
        carrot = Carrot(SPEED)
        carrot.step(Goal(0, 0, height, 0), at(), 0.0, 15, 60)
        for tick in range(1, 21):
            target = carrot.step(Goal(0, 0, height, 0), at(), tick * 0.05, 15, 60)
        assert target.height == pytest.approx(30.0 + math.copysign(2.0, height - 30.0))
    lead = 1.5 * SPEED + stopping_distance(SPEED)
    for height in (90.0, -30.0):
        carrot = Carrot(SPEED)
        for tick in range(400):
            target = carrot.step(Goal(0, 0, height, 0), at(), tick * 0.05, 15, 60)
        assert target.height == pytest.approx(30.0 + math.copysign(lead, height - 30.0)), "it waits for the drone"


def test_the_carrot_arrives_and_stays() -> None:
    carrot, goal = Carrot(SPEED), Goal(0.9, 0, 30, 2.0)
    carrot.step(goal, at(), 0.0, 15, 60)
    assert carrot.step(goal, at(), 0.05, 15, 60).north == pytest.approx(0.2)
    assert carrot.step(goal, at(), 0.0, 15, 60).north == pytest.approx(0.2), "a clock that goes back moves nothing"
    for tick in range(1, 10):
        carrot.step(goal, at(), tick * 0.05, 15, 60)
    assert carrot.place == goal
    assert carrot.step(goal, at(), 0.45, 15, 60) == goal


def test_to_every_side_alike() -> None:
    carrot, goal = Carrot(SPEED), Goal(-30, 40, 30, 0)
    carrot.step(goal, at(), 0.0, 15, 60)
    target = carrot.step(goal, at(), 0.5, 15, 60)
    assert (target.north, target.east) == pytest.approx((-1.2, 1.6))


@pytest.mark.parametrize(("height", "moves"), [(14.5, True), (14.4, False), (60.5, True), (60.6, False)])
def test_half_a_metre_beyond_min_and_max_it_still_flies_across(height: float, moves: bool) -> None:
    carrot, goal = Carrot(SPEED), Goal(50, 0, 30, 0)
    carrot.step(goal, at(height=height), 0.0, 15, 60)
    assert (carrot.step(goal, at(height=height), 0.5, 15, 60).north > 0) is moves


def test_after_a_hiccup_the_carrot_does_not_leap() -> None:
    carrot, goal = Carrot(SPEED), Goal(100, 0, 30, 0)
    carrot.step(goal, at(), 0.0, 15, 60)
    assert carrot.step(goal, at(), 10.0, 15, 60).north <= 2.0


@pytest.mark.parametrize(("height", "goal_height"), [(5, 20), (80, 50)])
def test_outside_min_and_max_it_is_height_first(height: float, goal_height: float) -> None:
    carrot, goal = Carrot(SPEED), Goal(50, 0, goal_height, 0)
    for tick in range(40):
        target = carrot.step(goal, at(height=height), tick * 0.05, 15, 60)
    assert (target.north, target.east) == (0, 0)
    assert abs(target.height - goal_height) < abs(height - goal_height)


def test_a_drone_blown_off_gets_a_new_carrot() -> None:
    carrot, goal = Carrot(SPEED), Goal(100, 0, 30, 0)
    carrot.step(goal, at(), 0.0, 15, 60)
    beyond = 1.5 * SPEED + stopping_distance(SPEED) + 2.0
    assert carrot.step(goal, at(east=beyond), 0.0, 15, 60).east == 0
    assert carrot.step(goal, at(east=beyond + 0.1), 0.0, 15, 60).east == beyond + 0.1
    assert carrot.step(goal, at(east=40), 0.05, 15, 60).east == 40


def test_no_progress_for_ten_seconds_is_reported() -> None:
    progress, goal = Progress(), Goal(50, 0, 30, 0)
    assert not progress.is_stuck(at(), goal, 0.0)
    assert not progress.is_stuck(at(0.9), goal, 9.9)
    assert progress.is_stuck(at(0.9), goal, 10.0)


def test_a_metre_of_progress_is_enough_and_going_away_is_none() -> None:
    progress, goal = Progress(), Goal(50, 0, 30, 0)
    progress.is_stuck(at(), goal, 0.0)
    assert not progress.is_stuck(at(1.0), goal, 9.0)
    assert not progress.is_stuck(at(-9.0), goal, 18.9)
    assert progress.is_stuck(at(-9.0), goal, 19.0)


def test_a_climb_is_progress_and_a_new_goal_starts_again() -> None:
    progress = Progress()
    progress.is_stuck(at(height=20), Goal(0, 0, 30, 0), 0.0)
    assert not progress.is_stuck(at(height=22), Goal(0, 0, 30, 0), 9.0)
    assert not progress.is_stuck(at(height=22), Goal(9, 0, 30, 0), 30.0)


def test_roaming_within_a_metre_is_no_progress() -> None:
    roaming = Roaming()
    assert not roaming.is_stuck(at(), 0.0)
    assert not roaming.is_stuck(at(1.2), 8.0)
    assert not roaming.is_stuck(at(0.8), 17.9)
    assert roaming.is_stuck(at(0.8), 18.0)


def test_a_goal_that_moves_in_height_by_more_than_a_metre_starts_again() -> None:
    progress = Progress()
    progress.is_stuck(at(), Goal(50, 0, 30, 0), 0.0)
    assert progress.is_stuck(at(), Goal(50, 0, 31, 0), 10.0)
    assert not progress.is_stuck(at(), Goal(50, 0, 31.1, 0), 10.0)


def test_roaming_a_metre_away_is_progress() -> None:
    roaming = Roaming()
    roaming.is_stuck(at(), 5.0)
    assert roaming.is_stuck(at(0.99), 15.0)
    assert not roaming.is_stuck(at(1.0), 15.0)
    assert not roaming.is_stuck(at(1.0, height=31.0), 24.0)
    assert roaming.is_stuck(at(1.0, height=31.0), 34.0)


def test_a_goal_with_a_number_that_is_not_finite() -> None:
    assert Goal(1, 2, 3, 0).is_finite()
    for field in range(4):
        numbers = [1.0] * 4
        numbers[field] = math.nan
        assert not Goal(*numbers).is_finite()
