from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from hawk.picture.film.course import Course
from hawk.picture.film.pace import Due, plan, sharpest, sharpness
from tests.unit.picture.film.films import LENS

QUARTER = 0.25 * 40.0 * LENS.height / LENS.fx


def _course(north: np.ndarray, rate: float = 10.0, yaw: np.ndarray | None = None, height: float = 40.0) -> Course:
    count = len(north)
    turned = np.zeros(count) if yaw is None else yaw
    flat = np.ones(count)
    attitude = np.column_stack([np.zeros(count), np.zeros(count), turned])
    return Course(np.arange(count) / rate, 46.8 + north / 111_194.9, -91.9 * flat, 240 * flat, height * flat, attitude)


def _middles(course: Course) -> list[int]:
    every = np.ones(len(course.time), np.bool_)
    return [each.candidates[len(each.candidates) // 2] for each in plan(course, every, LENS).due]


def test_a_frame_is_due_each_quarter_of_the_picture_at_any_speed() -> None:
    for speed in (1.0, 4.0, 9.0):
        north = np.arange(0.0, 60.0, speed / 10.0)
        steps = np.diff(north[_middles(_course(north))])[:-1]
        assert steps == pytest.approx(QUARTER, abs=max(0.3 * QUARTER, speed / 10.0))


def test_no_frame_is_due_while_the_drone_stands_though_its_place_wanders() -> None:
    wander = np.random.default_rng(1).normal(0.0, 0.8, 600)
    assert len(_middles(_course(wander))) <= 2


def test_no_frame_is_due_while_it_turns_fast() -> None:
    north = np.arange(0.0, 60.0, 0.4)
    yaw = np.clip((np.arange(len(north)) - 50) * math.radians(6.0), 0.0, math.pi)
    chosen = np.array(_middles(_course(north, yaw=np.angle(np.exp(1j * yaw)))))
    assert not ((chosen > 52) & (chosen < 78)).any()
    assert (chosen < 50).any()
    assert (chosen > 82).any()


def test_frames_without_a_place_near_the_ground_or_askew_are_counted_by_reason() -> None:
    course = _course(np.arange(0.0, 60.0, 0.5))
    covered = np.arange(len(course.time)) >= 10
    course.height[10:30] = 1.0
    course.attitude[30:60, 1] = math.radians(40.0)
    found = plan(course, covered, LENS)
    assert sorted(found.left_out.values()) == [10, 20, 30]
    assert all(each.candidates[0] >= 60 for each in found.due)
    nothing = plan(course, np.zeros(len(course.time), np.bool_), LENS)
    assert (nothing.due, list(nothing.left_out.values())) == ((), [120])


def test_the_sharpest_of_those_that_may_stand_is_taken_and_lost_ones_are_passed_over() -> None:
    rng = np.random.default_rng(2)
    sharp = rng.integers(0, 255, (80, 120, 3), np.uint8)
    pictures = {k: cv2.GaussianBlur(sharp, (0, 0), 0.5 + abs(k - 4)) for k in range(3, 8)}
    pictures[20] = sharp
    asked: list[int] = []

    def frames_of(numbers):  # type: ignore[no-untyped-def]
        asked.extend(numbers)
        return ((number, pictures[number]) for number in numbers if number in pictures)

    assert sharpest((Due((3, 4, 5, 6, 7)), Due((20, 21)), Due((30,))), frames_of) == ([4, 20], 1)
    assert asked == sorted(asked)


def test_blur_is_less_sharp_at_any_size() -> None:
    picture = np.random.default_rng(1).integers(0, 255, (900, 1600, 3), np.uint8)
    assert sharpness(picture) > 2.0 * sharpness(np.asarray(cv2.GaussianBlur(picture, (0, 0), 4.0), np.uint8))
