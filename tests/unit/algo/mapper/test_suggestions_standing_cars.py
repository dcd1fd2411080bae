from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from hawk.algo.ground import Window
from hawk.algo.mapper.evidence import EVIDENCE_M
from hawk.algo.mapper.suggestions import CAR_LENGTHS_M, CAR_WIDTHS_M, CarBoxes, car_boxes
from hawk.algo.vision import quads

WINDOW = Window(-150, -150, 300, 300, EVIDENCE_M)
Car = tuple[float, float, float, float, float]
"""North, east, angle, width, length."""


def drawn(*cars: Car, level: float = 0.9, bridge: float = 0.0) -> NDArray[np.float32]:
    """Car probability of the window, ``bridge`` where two cars nearly touch."""
    layer = np.zeros(WINDOW.shape, np.float32)
    for north, east, angle, width, length in cars:
        corners = quads.corners(*(np.array([v]) for v in (north, east, angle, width, length)))[0]
        cells = np.round(WINDOW.cells_of(corners[:, 0], corners[:, 1]) * 16).astype(np.int32)
        cv2.fillConvexPoly(layer, cells, [level], shift=4)
    if bridge:
        wide = cv2.dilate(layer, np.ones((5, 5), np.uint8))
        layer = np.where((layer == 0) & (wide > 0), np.float32(bridge), layer)
    return layer


def only(boxes: CarBoxes) -> Car:
    assert len(boxes) == 1
    return tuple(float(v[0]) for v in (boxes.north, boxes.east, boxes.angle, boxes.width, boxes.length))  # type: ignore[return-value]


@pytest.mark.slow
@given(st.floats(-20, 20), st.floats(-20, 20), st.floats(0, math.pi), st.floats(1.7, 2.1), st.floats(3.8, 5.2))
def test_a_car_is_found_where_it_stands(north: float, east: float, angle: float, width: float, length: float) -> None:
    box = only(car_boxes(drawn((north, east, angle, width, length)), WINDOW))
    assert math.dist(box[:2], (north, east)) < 1.5 * EVIDENCE_M
    assert float(quads.angle_between(box[2], angle)) < 0.15
    assert 0 <= box[2] < math.pi
    assert box[3:] == pytest.approx((width, length), abs=2.5 * EVIDENCE_M)


@pytest.mark.parametrize(
    ("width", "length"),
    [(0.9, 2.0), (CAR_WIDTHS_M[1] + 0.6, 5.0), (2.0, CAR_LENGTHS_M[1] + 0.6), (2.0, 2.4)],
    ids=["bicycle", "wide", "coach", "short"],
)
def test_what_has_another_size_is_no_car(width: float, length: float) -> None:
    assert len(car_boxes(drawn((3.0, -4.0, 0.6, width, length)), WINDOW)) == 0


def test_a_bent_part_of_a_cars_length_is_no_car() -> None:
    layer = drawn((0.0, 0.0, 0.0, 0.7, 4.4), (2.0, 0.9, math.pi / 2, 0.7, 2.4))
    assert len(car_boxes(layer, WINDOW)) == 0


def test_cars_that_touch_at_a_low_level_are_distinguished_at_a_higher_one() -> None:
    cars = [(0.0, east, 0.0, 1.8, 4.4) for east in (0.0, 2.4, 4.8)]
    boxes = car_boxes(drawn(*cars, bridge=0.6), WINDOW)
    assert sorted(boxes.east.round(1).tolist()) == pytest.approx([0.0, 2.4, 4.8], abs=0.2)


def test_faint_cars_are_none() -> None:
    assert len(car_boxes(drawn((0.0, 0.0, 0.3, 1.8, 4.4), level=0.45), WINDOW)) == 0


def test_a_car_that_the_window_cuts_is_none() -> None:
    assert len(car_boxes(drawn((30.0 - 1.0, 0.0, 0.0, 1.8, 4.4)), WINDOW)) == 0
    assert len(car_boxes(drawn((30.0 - 3.0, 0.0, 0.0, 1.8, 4.4)), WINDOW)) == 1


def test_a_map_without_cars_has_no_boxes() -> None:
    boxes = car_boxes(np.zeros(WINDOW.shape, np.float32), WINDOW)
    assert len(boxes) == 0
    assert len(boxes.take(np.zeros(0, np.bool_))) == 0
