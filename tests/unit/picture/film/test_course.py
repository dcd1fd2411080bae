from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hawk.picture.film.course import Course


def _log(heights: np.ndarray, altitude: float = 100.0, speed: float = 0.0) -> Course:
    """Return a flight of a sample a second that goes north."""
    time = np.arange(float(len(heights)))
    north = speed * time / 111_194.9
    flat = np.ones(len(time))
    return Course(time, 46.8 + north, -91.9 * flat, altitude + heights, heights, np.zeros((len(time), 3)))


def _mostly_on_the_ground() -> np.ndarray:
    return np.asarray(np.interp(np.arange(1200.0), [0, 700, 740, 1160, 1200], [0, 0, 60, 60, 0]), np.float64)


@pytest.mark.parametrize("has_heights", [True, False])
def test_a_log_that_is_mostly_on_the_ground_has_the_height_of_its_flight(has_heights: bool) -> None:
    heights = _mostly_on_the_ground()
    course = _log(heights)
    if not has_heights:
        course = Course.of_rows(
            np.column_stack(
                [course.time, course.latitude, course.longitude, course.altitude, np.full(len(heights), np.nan)]
            ),
            course.attitude, course.sigma, None,
        )  # fmt: skip
    assert course.with_heights(50.0).height[900] == pytest.approx(50.0)
    assert course.with_heights(50.0).height[10] == pytest.approx(-10.0)


def test_a_low_part_of_the_flight_counts_where_the_drone_moves() -> None:
    heights = np.concatenate([np.full(80, 30.0), np.full(20, 60.0)])
    assert _log(heights, speed=5.0).with_heights(40.0).height[[0, 99]] == pytest.approx([40.0, 70.0])


def test_a_level_flight_and_one_without_any_level_have_the_height() -> None:
    assert _log(np.full(9, 55.0)).with_heights(40.0).height == pytest.approx(np.full(9, 40.0))
    assert _log(np.full(9, np.nan)).with_heights(40.0).height == pytest.approx(np.full(9, 40.0))


def test_without_a_given_height_nothing_changes() -> None:
    course = _log(_mostly_on_the_ground())
    assert course.with_heights(None) is course


def test_a_path_across_the_180th_meridian_takes_the_shorter_side() -> None:
    course = _log(np.full(3, 60.0))
    crossing = replace(course, longitude=np.array([179.9998, 180.0, -179.9998]))
    between = crossing.at(np.array([0.5, 1.5, 2.0]))
    assert between.longitude == pytest.approx([179.9999, -179.9999, -179.9998], abs=1e-9)
    assert np.ptp(between.metres()[:, 1]) < 30.0
