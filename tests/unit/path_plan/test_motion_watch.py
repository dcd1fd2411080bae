from __future__ import annotations

import math

import numpy as np
import pytest

from hawk.algo.path_plan.following import Motion
from hawk.algo.path_plan.motion_watch import MotionWatch
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.model import MapPose

SETTINGS = PathPlanSettings()


def at(north: float, east: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> MapPose:
    return MapPose(north, east, 35.0, 0.0, pitch, yaw)


def watched(places: list[float], target: tuple[float, float] | None, frame_s: float = 0.25) -> Motion:
    watch = MotionWatch(SETTINGS)
    for number, north in enumerate(places):
        motion = watch.take(at(north), number * frame_s, 0.0)
        watch.tell(target)
    return motion


def test_at_first_the_drone_stands_and_so_does_the_carrot() -> None:
    motion = MotionWatch(SETTINGS).take(at(3.0, 4.0), 10.0, 1.0)
    assert motion.velocity == pytest.approx((0.0, 0.0))
    assert motion.carrot == pytest.approx((3.0, 4.0))
    assert motion.before == pytest.approx((3.0, 4.0))
    assert motion.yaw == 1.0


def test_velocity_comes_of_two_places() -> None:
    motion = watched([0.0, 1.0, 2.0], (50.0, 0.0))
    assert motion.velocity == pytest.approx((4.0, 0.0))
    assert motion.before == pytest.approx((50.0, 0.0))


def test_a_position_that_leaps_is_no_speed() -> None:
    assert watched([0.0, 0.0, 30.0], (50.0, 0.0)).velocity == pytest.approx((6.0, 0.0))


def test_the_lean_tells_the_acceleration() -> None:
    watch = MotionWatch(SETTINGS)
    watch.take(at(0.0), 0.0, 0.0)
    yaw = math.pi / 2  # nose down, east ahead: it speeds up to the east
    motion = watch.take(at(0.0, 0.0, pitch=-math.atan(2.0 / 9.80665), yaw=yaw), 0.25, yaw)
    assert motion.pull == pytest.approx((0.0, 2.0), abs=1e-9)


def test_a_plan_leads_the_carrot_from_the_next_frame_on() -> None:
    assert watched([0.0, 0.0], (50.0, 0.0)).carrot == pytest.approx((0.0, 0.0))
    assert watched([0.0, 0.0, 0.0], (50.0, 0.0)).carrot == pytest.approx((1.0, 0.0))


def test_the_carrot_waits_for_the_drone() -> None:
    motion = watched([0.0] * 40, (50.0, 0.0))
    assert SETTINGS.lead_m - 1.0 <= motion.carrot[0] <= SETTINGS.lead_m
    assert watched([0.0] * 40, (5.0, 0.0)).carrot == pytest.approx((5.0, 0.0))


def test_without_a_target_the_drone_goes_on_to_the_last_one() -> None:
    watch = MotionWatch(SETTINGS)
    watch.take(at(0.0), 0.0, 0.0)
    watch.tell((50.0, 0.0))
    watch.take(at(0.0), 0.25, 0.0)
    watch.tell(None)
    assert watch.take(at(0.0), 0.5, 0.0).before == pytest.approx((50.0, 0.0))


@pytest.mark.parametrize("gap", [-1.0, 0.0, 5.0])
def test_after_a_gap_in_time_nothing_is_known_of_the_motion(gap: float) -> None:
    watch = MotionWatch(SETTINGS)
    watch.take(at(0.0), 10.0, 0.0)
    watch.tell((50.0, 0.0))
    motion = watch.take(at(30.0), 10.0 + gap, 0.0)
    assert np.array_equal(motion.velocity, (0.0, 0.0))
    assert motion.carrot == pytest.approx((30.0, 0.0))
    assert motion.before == pytest.approx((30.0, 0.0))
