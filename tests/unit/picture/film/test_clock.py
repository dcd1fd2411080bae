from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.picture.film.clock import fit
from hawk.picture.film.course import Course
from hawk.picture.film.motion import BETWEEN_S, Motion, expected
from hawk.picture.values import PictureError
from tests.unit.picture.film.films import START

LENGTH = 30.0


def _course(seed: int = 1, seconds: float = 120.0, unix: float = START.timestamp()) -> Course:
    """Return a flight whose speed and heading wander."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, seconds, 0.2)
    fast, slow = np.arange(0.0, seconds + 5.0, 5.0), np.arange(0.0, seconds + 8.0, 8.0)
    speed = np.interp(time, fast, rng.uniform(0.0, 8.0, len(fast)))
    yaw = np.cumsum(np.interp(time, slow, rng.normal(0.0, 0.02, len(slow))))
    north, east = np.cumsum(speed * np.cos(yaw)) * 0.2, np.cumsum(speed * np.sin(yaw)) * 0.2
    attitude = np.column_stack([0 * yaw, -0.02 * np.gradient(speed, 0.2), np.angle(np.exp(1j * yaw))])
    flat = np.ones(len(time))
    return Course(
        unix + time, 46.8 + north / 111_194.9, -91.9 + east / (111_194.9 * math.cos(math.radians(46.8))),
        250 * flat, 50 * flat, attitude, epoch=0.0,
    )  # fmt: skip


def _motion(course: Course, begin: float, lens: float = 1.0, noise: float = 0.0) -> Motion:
    times = np.arange(0.0, LENGTH, BETWEEN_S)
    shift = expected(course, times + begin, BETWEEN_S) * lens
    return Motion(times, shift + np.random.default_rng(3).normal(0.0, noise, shift.shape), BETWEEN_S)


@pytest.mark.nightly
@settings(max_examples=8, deadline=None)
@given(seed=st.integers(1, 60), begin=st.floats(2.0, 80.0), lens=st.floats(0.92, 1.08))
def test_the_begin_is_found_anywhere_in_a_log(seed: int, begin: float, lens: float) -> None:
    course = _course(seed)
    truth = START.timestamp() + begin
    fitted = fit("a.MP4", _motion(course, truth, lens, 0.002), LENGTH, course, None, None)
    assert fitted.begin == pytest.approx(truth, abs=0.08)
    assert fitted.note.startswith(f"The film begins {fitted.begin - START.timestamp():.2f} s after the log's first")


def test_the_motion_of_another_flight_is_refused() -> None:
    motion = _motion(_course(2), START.timestamp() + 40.0)
    with pytest.raises(PictureError, match=r"a.MP4: the motion that it shows agrees with the log nowhere: give"):
        fit("a.MP4", motion, LENGTH, _course(1), None, None)


def test_a_film_that_stands_needs_an_offset_or_its_own_clock() -> None:
    course = _course(1)
    still = Motion(np.arange(0.0, LENGTH, BETWEEN_S), np.zeros((100, 2)), BETWEEN_S)
    with pytest.raises(PictureError, match="shows no motion by which its clock is fitted"):
        fit("a.MP4", still, LENGTH, course, None, None)
    assert fit("a.MP4", still, LENGTH, course, 12.0, None).begin == START.timestamp() + 12.0
    created = fit("a.MP4", still, LENGTH, course, None, START.timestamp() + 7.0)
    assert created.begin == START.timestamp() + 7.0
    assert created.note.endswith("it shows no motion that would check it")


@pytest.mark.slow
def test_the_time_of_the_file_chooses_between_places_that_fit_alike() -> None:
    once = _course(4, 60.0)
    moved = replace(once.shifted(60.0), epoch=0.0)
    names = ("time", "latitude", "longitude", "altitude", "height", "attitude")
    time, latitude, longitude, altitude, height, attitude = (
        np.concatenate([getattr(once, name), getattr(moved, name)]) for name in names
    )
    twice = Course(time, latitude, longitude, altitude, height, attitude, epoch=0.0)
    second = START.timestamp() + 75.0
    motion = _motion(twice, second)
    with pytest.raises(PictureError, match="several parts of the log"):
        fit("a.MP4", motion, LENGTH, twice, None, None)
    assert fit("a.MP4", motion, LENGTH, twice, None, second + 3.0).begin == pytest.approx(second, abs=0.05)


def test_the_log_of_a_camera_that_is_held_level_does_not_fit_a_fixed_one() -> None:
    course = _course(5)
    begin = START.timestamp() + 33.0
    motion = _motion(course.levelled(), begin)
    level = fit("a.MP4", motion, LENGTH, course.levelled(), None, None)
    assert level.begin == pytest.approx(begin, abs=0.05)
    try:
        swaying = fit("a.MP4", motion, LENGTH, course, None, None).off
    except PictureError:
        swaying = 1.0
    assert level.off < 0.5 * swaying
