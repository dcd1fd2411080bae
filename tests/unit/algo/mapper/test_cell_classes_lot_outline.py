from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.mapper.cell_classes import lot_outline
from hawk.algo.vision import quads
from hawk.algo.vision.detection import FloatArray

CELL = 0.4
SIZE = (200, 250)  # 80 m x 100 m


def row(x: float, y: float, count: int = 10) -> FloatArray:
    """A row of stalls that runs along x, metres -> cells."""
    centres = np.asarray(x + 2.6 * np.arange(count), np.float64)
    ones = np.ones(count)
    return quads.corners(centres, y * ones, math.pi / 2 * ones, 2.6 * ones, 5.2 * ones) / CELL


def looks_like(*boxes: tuple[float, float, float, float]) -> NDArray[np.bool_]:
    """True in boxes (x0, y0, x1, y1), metres."""
    values = np.zeros(SIZE, np.bool_)
    for box in boxes:
        x0, y0, x1, y1 = (round(v / CELL) for v in box)
        values[y0:y1, x0:x1] = True
    return values


def at(area: NDArray[np.uint8], x: float, y: float) -> bool:
    return bool(area[round(y / CELL), round(x / CELL)])


def test_the_lot_is_what_looks_like_one_near_stalls() -> None:
    area = lot_outline(looks_like((10, 10, 90, 70)), row(30, 40), CELL)
    assert at(area, 40, 40)
    assert at(area, 40, 48)
    assert not at(area, 40, 55), "too far from any stall"
    assert not at(area, 80, 40)
    assert not at(area, 5, 5)


def test_a_road_without_stalls_is_no_lot() -> None:
    assert not lot_outline(looks_like((0, 30, 100, 40)), np.zeros((0, 4, 2)), CELL).any()
    lonely = row(50, 35, count=2)
    assert not lot_outline(looks_like((0, 30, 100, 40)), lonely, CELL).any(), "two stalls are no company"


def test_trees_and_islands_within_are_closed_over_and_a_large_building_is_not() -> None:
    stalls = np.concatenate([row(15, 15, 20), row(15, 30, 20), row(15, 45, 20), row(15, 60, 20)])
    values = looks_like((10, 10, 70, 70))
    crown = cv2.circle(np.zeros(SIZE, np.uint8), (round(40 / CELL), round(22 / CELL)), round(3 / CELL), (1.0,), -1)
    values &= crown == 0
    small = lot_outline(values, stalls, CELL)
    assert at(small, 40, 22)
    ring = np.concatenate([row(10, 12, 24), row(10, 68, 24)])
    ring = np.concatenate([ring, ring[:, :, ::-1]])
    values = looks_like((5, 5, 75, 75))
    values[round(20 / CELL) : round(60 / CELL), round(20 / CELL) : round(60 / CELL)] = False
    assert not at(lot_outline(values, ring, CELL), 40, 40)


def test_small_patches_around_false_alarms_are_dropped() -> None:
    stalls = np.concatenate([row(20, 20), row(85, 70, count=3)])
    values = looks_like((10, 10, 60, 35), (85, 68, 92, 73))
    area = lot_outline(values, stalls, CELL)
    assert at(area, 30, 20)
    assert not at(area, 87, 70)


def test_a_lot_that_goes_on_beyond_the_picture_reaches_its_edge() -> None:
    area = lot_outline(looks_like((0, 0, 100, 30)), row(1.3, 5, 38), CELL)
    assert area[round(5 / CELL), 0]
    assert area[0, 100]


def test_the_lot_reaches_one_aisle_beyond_its_stalls() -> None:
    area = lot_outline(looks_like((0, 0, 100, 80)), row(30, 40), CELL)
    rows = np.flatnonzero(area[:, round(42 / CELL)]) * CELL
    assert rows.max() == pytest.approx(40 + 2.6 + 9, abs=1.0)
