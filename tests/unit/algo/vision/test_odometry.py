"""The drone's motion over ground by the camera, on drawn pictures: a witness of what the poses report."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from hawk.algo.frame import FrameInput
from hawk.algo.vision.odometry import LONGEST_S, Odometry
from hawk.algo.vision.rectify import scaled_camera
from hawk.model.operation import StateName
from hawk.model.pictures import GroundStep
from hawk.model.plans import HeightParameters
from hawk.model.poses import MapPose
from hawk.sim.camera.camera import default_intrinsics
from hawk.worlds.camera import WorldCamera
from hawk.worlds.world import World
from tests.drawn_worlds import drawn_world
from tests.examples import nightly

CAMERA = scaled_camera(default_intrinsics(), 640, 360)
"""Odometry makes pictures of 320 pixels; drawing them costs most of these tests."""
STILL = MapPose(0.0, 0.0, 25.0, 0.0, 0.0, 0.0)
STEP_S = 0.4


@pytest.fixture(scope="module")
def world() -> World:
    return drawn_world(3)


class Eye:
    """Pictures of the lot's middle."""

    def __init__(self, world: World) -> None:
        self._camera = WorldCamera(world, CAMERA)
        self._middle = np.mean([stall.corners.mean(0) for stall in world.stalls], 0)
        self._rng = np.random.default_rng(1)
        self.odometry = Odometry()

    def look(self, time: float, true: MapPose, reported: MapPose | None, speed: float = 2.0) -> GroundStep | None:
        picture = self._camera.render(
            float(self._middle[0] + true.east),
            float(self._middle[1] - true.north),
            true.height,
            true.roll,
            true.pitch,
            true.yaw,
            rng=self._rng,
        )
        return self.odometry.look(frame(time, reported, speed), picture)

    def fly(
        self, true: Callable[[int], MapPose], reported: Callable[[int], MapPose], steps: int, step_s: float = STEP_S
    ) -> list[GroundStep]:
        found = [self.look(k * step_s, true(k), reported(k)) for k in range(steps + 1)]
        assert found[0] is None
        return [step for step in found if step is not None]


@pytest.fixture
def eye(world: World) -> Eye:
    return Eye(world)


def frame(time: float, reported: MapPose | None, speed: float = 2.0) -> FrameInput:
    hover = StateName.HOVER
    return FrameInput(1, time, b"x", CAMERA, reported, speed, hover, None, HeightParameters(), None, None)


def summed(pairs: Iterable[tuple[float, float]]) -> tuple[float, float]:
    north, east = np.sum(list(pairs), 0)
    return float(north), float(east)


@pytest.mark.slow
@pytest.mark.fault(
    "GNSS walks away and takes the estimate with it, all flags good (0.7 m/s), in a task",
    "reported at 3 m within 10 s, the task ends by Hover, the camera holds the true place within 1.5 m; new "
    "tasks are refused; nothing is mapped",
)
def test_a_walk_of_the_position_that_the_drone_follows_is_seen(eye: Eye) -> None:
    """GNSS walks north by 0.7 m/s and the autopilot holds: the drone flies south, and nothing is reported."""
    steps = eye.fly(lambda k: replace(STILL, north=-0.7 * STEP_S * k, roll=0.03 * math.sin(k)), lambda k: STILL, 25)
    # the roll is not reported either: it moves the picture by 0.75 m to and fro, and adds up to nothing
    assert len(steps) == 25
    assert summed(step.beyond for step in steps) == pytest.approx((-7.0, 0.0), abs=0.9)
    assert summed(step.reported for step in steps) == (0.0, 0.0)
    assert steps[0].since == 0.0
    assert all(step.since == before.until for before, step in pairwise(steps))


@pytest.mark.nightly
def test_a_flight_is_seen_as_it_was_flown(eye: Eye) -> None:
    def pose(k: int) -> MapPose:
        return replace(STILL, north=1.6 * k - 12, east=0.4 * k, roll=0.05 * math.sin(k), pitch=-0.08, yaw=0.1 * k)

    steps = eye.fly(pose, pose, 15)
    assert len(steps) == 15
    assert summed(step.reported for step in steps) == pytest.approx((24.0, 6.0))
    assert summed(step.beyond for step in steps) == pytest.approx((0.0, 0.0), abs=1.2)
    assert sum(step.turn for step in steps) == pytest.approx(0.0, abs=math.radians(5))
    assert sum(step.stretch for step in steps) == pytest.approx(0.0, abs=0.06)


ROOF_END_M = 24.0
"""The world's long building, 10 m high, is flown along at 25 m: its roof moves 1.7 times as fast as the ground."""


@pytest.mark.slow
@pytest.mark.parametrize(("north", "pace"), [(45.0, 1.2), *nightly((44.0, 1.2), (46.0, 2.0))])
def test_a_roof_that_fills_most_of_the_picture_is_not_taken_for_the_ground(eye: Eye, north: float, pace: float) -> None:
    def pose(k: int) -> MapPose:
        return replace(STILL, north=north, east=pace * k - ROOF_END_M)

    steps = eye.fly(pose, pose, round(2 * ROOF_END_M / pace))
    assert sum(step.until - step.since for step in steps) > 0.9 * len(steps) * STEP_S
    assert max(abs(complex(*step.beyond)) for step in steps) < 0.4
    assert summed(step.beyond for step in steps) == pytest.approx((0.0, 0.0), abs=1.0)


@pytest.mark.nightly
@pytest.mark.parametrize("walk_m_s", [-1.5, 0.7, *nightly(-0.7, 1.5)])
def test_a_walk_of_the_position_is_seen_beside_a_roof(eye: Eye, walk_m_s: float) -> None:
    """The true drone is faster, or slower, than reported, along its flight."""
    walk = walk_m_s * STEP_S

    def true(k: int) -> MapPose:
        return replace(STILL, north=36.0, east=(2.0 + walk) * k - ROOF_END_M)

    steps = eye.fly(true, lambda k: replace(true(k), east=2.0 * k - ROOF_END_M), 20)
    seen = len(steps) * walk
    assert len(steps) > 12
    assert summed(step.beyond for step in steps) == pytest.approx((0.0, seen), abs=0.25 * abs(seen))


@pytest.mark.nightly
@pytest.mark.parametrize("step_s", [3 * STEP_S, *nightly(STEP_S)])
@pytest.mark.parametrize("factor", [1.3, 2.2, *nightly(1.7)])
def test_a_drone_that_is_faster_than_reported_is_no_roof(eye: Eye, factor: float, step_s: float) -> None:
    """No ground anywhere moves as reported, however slowly the pictures come."""
    steps = eye.fly(
        lambda k: replace(STILL, east=1.2 * factor * k - 15), lambda k: replace(STILL, east=1.2 * k - 15), 12, step_s
    )
    assert len(steps) == 12
    assert summed(step.beyond for step in steps) == pytest.approx((0.0, 14.4 * (factor - 1)), rel=0.15, abs=0.3)


@pytest.mark.nightly
def test_a_sinking_that_the_height_does_not_show_stretches_the_ground(eye: Eye) -> None:
    steps = eye.fly(lambda k: replace(STILL, height=25.0 - 0.5 * k), lambda k: STILL, 20)
    assert sum(step.stretch for step in steps) == pytest.approx(math.log(25 / 15), abs=0.04)
    assert summed(step.beyond for step in steps) == pytest.approx((0.0, 0.0), abs=0.5)


@pytest.mark.nightly
def test_a_turn_that_the_heading_does_not_show_is_seen(eye: Eye) -> None:
    steps = eye.fly(lambda k: replace(STILL, yaw=0.04 * k), lambda k: STILL, 15)
    assert sum(step.turn for step in steps) == pytest.approx(0.6, abs=0.03)


@pytest.mark.nightly
def test_a_climb_and_a_turn_that_the_pose_shows_change_nothing(eye: Eye) -> None:
    def pose(k: int) -> MapPose:
        return replace(STILL, height=15 + 1.2 * k, yaw=0.35 * k)

    steps = eye.fly(pose, pose, 15)
    assert len(steps) == 15
    assert sum(step.turn for step in steps) == pytest.approx(0.0, abs=0.06)
    assert sum(step.stretch for step in steps) == pytest.approx(0.0, abs=0.06)
    assert summed(step.beyond for step in steps) == pytest.approx((0.0, 0.0), abs=0.8)


@pytest.mark.slow
def test_pictures_are_compared_at_an_interval_and_not_over_a_long_one(eye: Eye) -> None:
    assert eye.look(0.0, STILL, STILL) is None
    assert eye.look(0.2, STILL, STILL) is None
    step = eye.look(0.3, STILL, STILL)
    assert step is not None
    assert (step.since, step.until, step.height) == (0.0, 0.3, 25.0)
    assert eye.look(0.4 + LONGEST_S, STILL, STILL) is None
    assert eye.look(0.8 + LONGEST_S, STILL, STILL) is not None
    assert eye.look(0.5, STILL, STILL) is None, "an older picture"


@pytest.mark.nightly
@pytest.mark.parametrize(
    "reported",
    [None, replace(STILL, height=3.9), replace(STILL, yaw=math.nan)],
    ids=["no pose", "too low", "not finite"],
)
def test_nothing_is_measured_without_a_pose_to_measure_by(eye: Eye, reported: MapPose | None) -> None:
    assert eye.look(0.0, STILL, STILL) is None
    assert eye.look(0.4, STILL, reported) is None
    assert eye.look(0.8, STILL, STILL) is None
    assert eye.look(1.2, STILL, STILL) is not None


@pytest.mark.slow
def test_a_leap_of_the_report_is_no_motion(eye: Eye) -> None:
    leapt = replace(STILL, north=25.0)
    assert eye.look(0.0, STILL, STILL) is None
    assert eye.look(0.4, STILL, leapt) is None
    step = eye.look(0.8, STILL, leapt)
    assert step is not None
    assert math.hypot(*step.beyond) < 0.3


@pytest.mark.slow
def test_a_picture_that_is_not_known_or_of_other_ground_gives_no_step(eye: Eye) -> None:
    assert eye.look(0.0, STILL, STILL) is None
    assert eye.odometry.look(frame(0.4, STILL), None) is None
    assert (
        eye.odometry.look(replace(frame(0.4, STILL), mount_problem="no gimbal"), np.zeros((72, 128, 3), np.uint8))
        is None
    )
    assert eye.look(0.8, STILL, STILL) is None
    grey = np.full((720, 1280, 3), 90, np.uint8)
    assert eye.odometry.look(frame(1.2, STILL), grey) is None
    step = eye.look(1.6, STILL, STILL)
    assert step is not None
    assert step.since == 0.8, "one bad picture is passed over"
    for k in range(3):
        assert eye.odometry.look(frame(2.0 + 0.4 * k, STILL), grey) is None
    assert eye.look(3.2, STILL, STILL) is None, "after a second of them it begins again"
    assert eye.look(3.6, STILL, STILL) is not None
    noise = np.random.default_rng(2).integers(0, 255, (720, 1280, 3), np.uint8)
    assert eye.odometry.look(frame(4.0, STILL), noise) is None
