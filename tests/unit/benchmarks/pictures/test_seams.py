"""Pictures on the ground that lie apart by a known distance."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.pictures.seams import shifts
from hawk.algo.vision.detection import GroundImage

M = 0.1


def ground(seed: int = 1) -> NDArray[np.float32]:
    """Return 60 m a side of stains."""
    noise = np.random.default_rng(seed).integers(0, 255, (600, 600), dtype=np.uint8)
    return cv2.GaussianBlur(noise, (0, 0), 3).astype(np.float32) * 4


def at(values: NDArray[np.float32], north: float, east: float) -> GroundImage:
    to_map = np.array([[0.0, -M, north], [M, 0.0, east]])
    return GroundImage(np.ascontiguousarray(values), to_map, np.ones(values.shape, np.bool_))


def test_two_that_lie_right_are_not_apart() -> None:
    whole = ground()
    found = shifts([at(whole[:400, :400], 60.0, 0.0), at(whole[100:, 150:], 50.0, 15.0)])
    assert len(found) == 2
    assert found == pytest.approx(0.0, abs=0.01)


def test_a_pose_off_by_half_a_metre_is_seen() -> None:
    whole = ground()
    found = shifts([at(whole[:400, :400], 60.0, 0.0), at(whole[100:, 150:], 50.3, 14.6)])
    assert found == pytest.approx(0.5, abs=0.03)


def test_a_part_of_a_pixel_counts() -> None:
    whole = ground()
    moved = cv2.warpAffine(whole, np.array([[1.0, 0.0, -0.4], [0.0, 1.0, 0.0]]), (600, 600))
    assert shifts([at(whole, 60.0, 0.0), at(moved.astype(np.float32), 60.0, 0.04)]) == pytest.approx(0.0, abs=0.03)


def test_what_differs_is_not_compared() -> None:
    assert len(shifts([at(ground(1), 60.0, 0.0), at(ground(2), 60.0, 0.0)])) == 0
    assert len(shifts([at(ground(1)[:200, :200], 60.0, 0.0), at(ground(1)[:200, :200], 10.0, 0.0)])) == 0
