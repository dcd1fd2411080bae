from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from hawk.algo.vision import quads
from hawk.algo.vision.classical import ClassicalFinder
from hawk.algo.vision.seen import FloatArray, GroundImage

NORTH_UP = np.array([[0.0, -0.1, 0.0], [0.1, 0.0, 0.0]])


def painted_row(angle: float, count: int = 7) -> tuple[GroundImage, FloatArray]:
    """A row of stalls painted on noisy asphalt, every second one with a car; returns it with the stalls' middles."""
    rng = np.random.default_rng(4)
    image = np.full((300, 360, 3), 90, np.uint8)
    along, across = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    start = np.array([180.0, 150.0]) - across * 26 * count / 2
    for k in range(count + 1):
        first, last = (np.rint((start + across * 26 * k + along * s) * 16).astype(int).tolist() for s in (-26, 26))
        cv2.line(image, first, last, (225, 225, 225), 1, cv2.LINE_AA, 4)
    middles = np.array([start + across * 26 * (k + 0.5) for k in range(count)])
    for k in range(1, count, 2):
        boxes = quads.corners(
            middles[k : k + 1, 0], middles[k : k + 1, 1], np.array([angle]), np.array([18.0]), np.array([45.0])
        )
        cv2.fillPoly(image, [np.rint(boxes[0]).astype(np.int32)], (40, 40, 160))
        cv2.fillPoly(
            image, [np.rint(boxes[0].mean(0) + (boxes[0] - boxes[0].mean(0)) * 0.5).astype(np.int32)], (20, 20, 20)
        )
    noisy = np.clip(image + rng.normal(0, 3, image.shape), 0, 255).astype(np.uint8)
    return GroundImage(noisy, NORTH_UP, np.ones(image.shape[:2], np.bool_)), middles


@pytest.mark.parametrize("angle", [0.0, 0.4, math.pi / 2, 2.2])
def test_stalls_between_painted_lines_are_found_with_their_states(angle: float) -> None:
    ground, middles = painted_row(angle)
    found = ClassicalFinder().find(ground)
    places = ground.map_points(middles)
    apart = np.array([[math.hypot(s.north - n, s.east - e) for s in found.stalls] for n, e in places])
    assert (apart.min(axis=1) < 0.6).mean() >= 0.85
    right = [found.stalls[j].taken > 0.5 for j in apart.argmin(axis=1)]
    wrong = sum(r != bool(k % 2) for k, r in enumerate(right))
    assert wrong <= 1
    assert len(found.stalls) <= len(middles) + 1


def test_it_speaks_of_lot_only_near_stalls() -> None:
    ground, middles = painted_row(0.0)
    found = ClassicalFinder().find(ground)
    at = np.rint(middles[3] / 2).astype(int)
    assert found.lot.values[at[1], at[0]] > 0.6
    assert found.lot.values[2, 2] == 0.5
    assert found.lot.values.shape == found.core.values.shape == found.car.values.shape == (150, 180)


def test_bare_ground_and_blackness_show_nothing() -> None:
    rng = np.random.default_rng(5)
    for image in (rng.normal(90, 4, (200, 200, 3)).astype(np.uint8), np.zeros((200, 200, 3), np.uint8)):
        found = ClassicalFinder().find(GroundImage(image, NORTH_UP, np.ones((200, 200), np.bool_)))
        assert found.stalls == ()
