from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.picture.film.course import Course
from hawk.picture.film.motion import BETWEEN_S, expected, measure
from hawk.picture.film.video import Video
from hawk.picture.reconstruction.camera_pose import CameraPose
from tests.unit.picture.film.films import FPS, HEIGHT, LENS

ANGLES = st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-3.0, 3.0))


def test_a_film_moves_as_the_drone_did(straight_film: Path) -> None:
    video = Video(straight_film)
    found = measure(video, LENS)
    video.close()
    assert found.between == pytest.approx(BETWEEN_S)
    assert len(found.time) >= 24
    assert found.time[:3] == pytest.approx([0.0, 3 / FPS, 6 / FPS])
    assert found.shift[:, 1] == pytest.approx(5.0 * BETWEEN_S / HEIGHT, abs=0.004)  # the ground runs down the picture
    assert found.shift[:, 0] == pytest.approx(0.0, abs=0.004)


@given(first=ANGLES, second=ANGLES, north=st.floats(-3, 3), east=st.floats(-3, 3), climb=st.floats(-2, 2))
def test_the_expected_shift_is_where_the_middle_of_the_picture_goes(
    first: tuple[float, float, float], second: tuple[float, float, float], north: float, east: float, climb: float
) -> None:
    metres = 111_194.9
    course = Course(
        np.array([0.0, 0.3]), 46.0 + np.array([0.0, north]) / metres,
        8.0 + np.array([0.0, east]) / metres / math.cos(math.radians(46.0)), np.zeros(2),
        np.array([40.0, 40.0 + climb]), np.array([first, second]),
    )  # fmt: skip
    posed = [
        CameraPose(LENS, float(place[0]), float(place[1]), float(height), angles)
        for place, height, angles in zip(course.metres(), course.height, (first, second), strict=True)
    ]
    middle = np.array([[LENS.cx, LENS.cy]])
    moved = (posed[1].pixels(posed[0].ground(middle)) - middle)[0] / LENS.fx
    assert expected(course, np.array([0.0]), 0.3)[0] == pytest.approx(moved, abs=1e-6)


def test_a_camera_that_looks_at_the_horizon_expects_nothing() -> None:
    flat = np.array([[0.0, 1.5, 0.0], [0.0, 1.5, 0.0]])
    course = Course(np.array([0.0, 1.0]), np.full(2, 46.0), np.full(2, 8.0), np.zeros(2), np.full(2, 40.0), flat)
    assert np.isnan(expected(course, np.array([0.2]), 0.3)).all()
