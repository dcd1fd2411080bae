from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.known_lot import judge
from hawk.algo.rows.fit import Rectangles
from hawk.algo.vision.detection import Found, GroundImage

CELL_M = 0.2
SHAPE = (150, 200)


def ground(values: NDArray[np.float32], turn: float) -> GroundImage:
    """A raster about (10, -5) whose top is turned by ``turn`` clockwise from north."""
    forward = np.array([math.cos(turn), math.sin(turn)])
    right = np.array([-math.sin(turn), math.cos(turn)])
    linear = np.column_stack([right, -forward]) * CELL_M
    middle = np.array([(SHAPE[1] - 1) / 2, (SHAPE[0] - 1) / 2])
    return GroundImage(values, np.column_stack([linear, (10.0, -5.0) - linear @ middle]), np.ones(SHAPE, np.bool_))


def row_of(turn: float, count: int = 6) -> Rectangles:
    """Stalls side by side along the raster's columns, their long sides towards its top."""
    right = np.array([-math.sin(turn), math.cos(turn)])
    centres = np.array([10.0, -5.0]) + np.outer((np.arange(count) - 2.5) * 2.6, right)
    return Rectangles(centres, np.full(count, turn % math.pi), np.full(count, 2.6), np.full(count, 5.2))


def seen(stalls: Rectangles, taken: list[bool], turn: float) -> Found:
    image = ground(np.zeros(SHAPE, np.float32), turn)
    core, car = np.zeros((2, *SHAPE), np.float32)
    corners = image.pixel_points(stalls.corners())
    inner = corners.mean(1, keepdims=True) + (corners - corners.mean(1, keepdims=True)) * 0.74
    for quad, has_car in zip(np.round(inner).astype(np.int32), taken, strict=True):
        cv2.fillConvexPoly(core, quad, (0.9,))
        if has_car:
            cv2.fillConvexPoly(car, quad, (0.95,))
    full = np.full(SHAPE, 0.95, np.float32)
    return Found((), *(ground(values, turn) for values in (full, car, core, car)))


@pytest.mark.parametrize("turn", [0.0, 0.7, 2.4, -1.9])
def test_the_state_of_each_stall_is_read_at_its_place_however_the_camera_is_turned(turn: float) -> None:
    stalls, taken = row_of(turn), [True, False, False, True, True, False]
    probability, visible = judge(seen(stalls, taken, turn), stalls)
    assert (probability > 0.5).tolist() == taken
    assert visible.tolist() == [1.0] * 6


def test_a_stall_that_the_picture_shows_in_part_says_how_much_of_it() -> None:
    stalls = row_of(0.0)
    image = seen(stalls, [False] * 6, 0.0)
    edge = np.array([[10.0, -5.0 + SHAPE[1] * CELL_M / 2], [100.0, 0.0]])
    some = Rectangles(edge, *(v[:2] for v in (stalls.angle, stalls.width, stalls.length)))
    _, visible = judge(image, some)
    assert 0.4 < visible[0] < 0.6
    assert visible[1] == 0.0


def test_no_stall_gives_nothing() -> None:
    none = row_of(0.0)[np.zeros(6, np.bool_)]
    probability, visible = judge(seen(row_of(0.0), [False] * 6, 0.0), none)
    assert len(probability) == len(visible) == 0
