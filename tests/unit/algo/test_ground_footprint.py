from __future__ import annotations

import math
from dataclasses import replace

import pytest

from hawk.algo.vision.rectify import ground_footprint
from tests.unit.algo.synthetic import CAMERA, pose_at


def test_a_level_picture_shows_a_rectangle_with_its_top_ahead() -> None:
    upper_left, upper_right, lower_right, lower_left = ground_footprint(CAMERA, pose_at(10.0, 20.0, math.pi / 2))
    half_width, half_depth = 35 * 640 / 914, 35 * 360 / 914
    assert (upper_left.north, upper_left.east) == pytest.approx((10 + half_width, 20 + half_depth), abs=0.01)
    assert (upper_right.north, upper_right.east) == pytest.approx((10 - half_width, 20 + half_depth), abs=0.01)
    assert (lower_right.north, lower_right.east) == pytest.approx((10 - half_width, 20 - half_depth), abs=0.01)
    assert (lower_left.north, lower_left.east) == pytest.approx((10 + half_width, 20 - half_depth), abs=0.01)


def test_nose_up_looks_ahead() -> None:
    level = ground_footprint(CAMERA, pose_at(0, 0))
    tilted = ground_footprint(CAMERA, replace(pose_at(0, 0), pitch=0.2))
    assert all(t.north > p.north + 5 for t, p in zip(tilted, level, strict=True))


def test_a_view_of_the_horizon_stays_finite() -> None:
    corners = ground_footprint(CAMERA, replace(pose_at(0, 0), pitch=1.3))
    assert all(math.hypot(p.north, p.east) < 200 for p in corners)


@pytest.mark.parametrize("height", [0.0, -2.0, math.nan, math.inf])
def test_on_the_ground_or_nowhere_there_is_none(height: float) -> None:
    assert ground_footprint(CAMERA, pose_at(0, 0, height=height)) == ()
