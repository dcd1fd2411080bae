from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hawk.algo.vision.relief import NO_RELIEF, Relief
from hawk.algo.vision.seen import StallSeen
from hawk.model import MapPose

POSE = MapPose(100.0, -50.0, 40.0, 0.1, -0.2, 1.0)
RELIEF = Relief(0.1, 0.4)


def stall(north: float, east: float, taken: float) -> StallSeen:
    return StallSeen(north, east, 0.3, 2.5, 5.0, 0.9, taken, 1.0)


def test_a_taken_stall_comes_nearer_to_the_point_below_the_camera_by_its_height() -> None:
    """At 20 m out and 40 m up, 0.4 m of height show 0.2 m too far out."""
    (moved,) = RELIEF.taken_out([stall(120.0, -50.0, 1.0)], POSE)
    assert (moved.north, moved.east) == pytest.approx((119.8, -50.0))
    (free,) = RELIEF.taken_out([stall(100.0, -30.0, 0.0)], POSE)
    assert (free.north, free.east) == pytest.approx((100.0, -30.05))


def test_without_relief_nothing_moves() -> None:
    one = stall(120.0, -30.0, 0.7)
    assert NO_RELIEF.taken_out([one], POSE) == (one,)


@given(st.floats(-30, 30), st.floats(-30, 30), st.floats(0, 1), st.floats(15, 60))
def test_it_undoes_the_projection_of_a_point_at_that_height(
    north: float, east: float, taken: float, height: float
) -> None:
    """A point at height h is projected to where the ray through it meets the ground: r H / (H - h) from below."""
    pose = MapPose(5.0, 7.0, height, 0.0, 0.0, 0.0)
    h = RELIEF.free_m + (RELIEF.taken_m - RELIEF.free_m) * taken
    out = height / (height - h)
    (moved,) = RELIEF.taken_out([stall(5.0 + north * out, 7.0 + east * out, taken)], pose)
    assert math.hypot(moved.north - 5.0 - north, moved.east - 7.0 - east) < 1e-9
    assert (moved.angle, moved.width, moved.score) == (0.3, 2.5, 0.9)
