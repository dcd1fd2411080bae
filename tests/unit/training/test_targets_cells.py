"""Targets drawn for a crop, cell by cell, and back through the decoder."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from hawk.algo.vision import decode, quads
from hawk.algo.vision.network import CELL_PIXELS, CORE_SHARE, maps_from_output
from training import targets as targets_module
from training.targets import (
    CAR,
    CELL_M,
    CORE,
    CORE_WEIGHT,
    COSINE,
    LABELS,
    LENGTH,
    LOT,
    OFFSET_COLUMN,
    OFFSET_ROW,
    PLACE_WEIGHT,
    SINE,
    TAKEN,
    WIDTH,
    draw_targets,
)

SIDE = 240
KNOWN = np.ones((SIDE, SIDE), np.uint8)
BLANK = np.zeros((SIDE, SIDE, LABELS), np.uint8)
ONE_CELL = CELL_PIXELS / CORE_SHARE
"""A stall's width and length are exact to one cell of its core, pixels."""


def quad(x: float, y: float, angle: float, width: float = 26.0, length: float = 52.0) -> NDArray[np.float64]:
    return quads.corners(*(np.array([value]) for value in (x, y, angle, width, length)))


def drawn(corners: NDArray[np.float64], *, taken: bool = False, judged: bool = True) -> NDArray[np.float32]:
    count = len(corners)
    return draw_targets(BLANK, KNOWN, corners, np.full(count, taken), np.full(count, judged))


def answer(target: NDArray[np.float32]) -> NDArray[np.float32]:
    said = target[:12].copy()
    for channel in (LOT, CORE, CAR, TAKEN):
        said[channel] = np.where(target[channel] > 0.5, 6.0, -6.0)
    return said


@settings(max_examples=12)
@given(st.floats(80, 160), st.floats(80, 160), st.floats(0, math.pi), st.floats(20, 34), st.floats(44, 64))
def test_one_stall_survives_drawing_and_decoding(x: float, y: float, angle: float, width: float, length: float) -> None:
    target = drawn(quad(x, y, angle, width, length))
    found = decode.vote(maps_from_output(answer(target)), CELL_M)
    assert len(found) == 1
    assert (found.column[0] * 2, found.row[0] * 2) == pytest.approx((x, y), abs=0.6)
    assert quads.angle_between(found.angle[0], angle) < 0.02
    assert found.width[0] * 2 == pytest.approx(width, abs=ONE_CELL)
    assert found.length[0] * 2 == pytest.approx(length, abs=ONE_CELL)


@settings(max_examples=12)
@given(st.floats(80, 160), st.floats(80, 160), st.floats(0, math.pi))
def test_the_core_is_the_inner_part_of_the_stall(x: float, y: float, angle: float) -> None:
    core = drawn(quad(x, y, angle))[CORE] > 0.5
    assert core.sum() * 4 == pytest.approx(26 * 52 * CORE_SHARE**2, rel=0.15)
    rows, columns = np.nonzero(core)
    assert (2 * columns.mean(), 2 * rows.mean()) == pytest.approx((x, y), abs=1.0)


@settings(max_examples=12)
@given(st.floats(80, 160), st.floats(80, 160), st.floats(0, math.pi))
def test_every_core_cell_knows_its_stall(x: float, y: float, angle: float) -> None:
    target = drawn(quad(x, y, angle))
    rows, columns = np.nonzero(target[CORE] > 0.5)
    assert columns + 10 * target[OFFSET_COLUMN, rows, columns] == pytest.approx(np.full(len(rows), x / 2), abs=1e-4)
    assert rows + 10 * target[OFFSET_ROW, rows, columns] == pytest.approx(np.full(len(rows), y / 2), abs=1e-4)
    assert target[SINE, rows, columns] == pytest.approx(np.full(len(rows), math.sin(2 * angle)), abs=1e-4)
    assert target[COSINE, rows, columns] == pytest.approx(np.full(len(rows), math.cos(2 * angle)), abs=1e-4)
    assert target[WIDTH, rows, columns] == pytest.approx(np.zeros(len(rows)), abs=1e-4), "26 pixels are 2.6 m"
    assert target[LENGTH, rows, columns] == pytest.approx(np.zeros(len(rows)), abs=1e-4)


def test_angles_are_the_same_for_a_stall_seen_from_its_other_end() -> None:
    one, other = drawn(quad(120, 120, 0.4)), drawn(quad(120, 120, 0.4)[:, [2, 3, 0, 1]])
    np.testing.assert_allclose(one, other, atol=1e-5)


@pytest.mark.parametrize("taken", [True, False])
def test_the_state_is_drawn_on_the_core_alone(taken: bool) -> None:
    target = drawn(quad(120, 120, 0.4), taken=taken)
    assert (target[TAKEN] == target[CORE] * taken).all()


def test_a_stall_that_is_not_judged_takes_its_whole_ground_out_of_judgement() -> None:
    target = drawn(quad(120, 120, 0.4), judged=False)
    assert not target[CORE].any()
    assert (target[CORE_WEIGHT] == 0).sum() * 4 == pytest.approx(26 * 52, rel=0.08)
    assert (target[PLACE_WEIGHT] == 1).all(), "lot and cars are judged there"


def test_labels_are_taken_at_every_second_pixel() -> None:
    labels = np.zeros((SIDE, SIDE, LABELS), np.uint8)
    labels[100:140, 60:100, 0] = 1
    labels[110:120, 70:80, 1] = 1
    known = KNOWN.copy()
    known[:, :20] = 0
    empty = np.zeros(0, np.bool_)
    target = draw_targets(labels, known, np.zeros((0, 4, 2)), empty, empty)
    assert target[LOT].sum() == 20 * 20
    assert target[LOT, 50:70, 30:50].all()
    assert target[CAR].sum() == 5 * 5
    assert not target[PLACE_WEIGHT, :, :10].any()
    assert target[PLACE_WEIGHT, :, 10:].all()


@pytest.mark.parametrize("centre", [(-100.0, 120.0), (120.0, 500.0)])
def test_a_stall_outside_the_crop_leaves_no_trace(centre: tuple[float, float]) -> None:
    assert not drawn(quad(*centre, 0.3))[CORE].any()


def test_a_stall_at_the_edge_points_outside() -> None:
    target = drawn(quad(-4.0, 120.0, 0.0, 26.0, 52.0))
    rows, columns = np.nonzero(target[CORE] > 0.5)
    assert len(rows)
    assert columns + 10 * target[OFFSET_COLUMN, rows, columns] == pytest.approx(np.full(len(rows), -2.0), abs=1e-4)


def test_neighbours_have_cells_of_their_own() -> None:
    pair = np.concatenate([quad(107, 120, math.pi / 2), quad(133, 120, math.pi / 2)])
    target = draw_targets(BLANK, KNOWN, pair, np.array([True, False]), np.array([True, True]))
    owners = target[TAKEN][target[CORE] > 0.5]
    assert owners.mean() == pytest.approx(0.5, abs=0.06)
    columns = np.nonzero(target[CORE].any(axis=0))[0]
    assert np.diff(columns).max() > 1, "a gap between the cores"


@given(st.floats(5, 35), st.floats(5, 35), st.floats(-4, 4), st.floats(1, 12), st.floats(1, 20))
def test_marking_a_rectangle_marks_the_cells_whose_middle_is_inside(
    x: float, y: float, angle: float, width: float, length: float
) -> None:
    canvas = np.zeros((40, 40), np.int16)
    targets_module._mark(canvas, np.array([x, y]), angle, width, length, 3)
    rows, columns = np.mgrid[0:40, 0:40]
    along = (columns - x) * math.cos(angle) + (rows - y) * math.sin(angle)
    across = (rows - y) * math.cos(angle) - (columns - x) * math.sin(angle)
    inside = (np.abs(along) <= length / 2) & (np.abs(across) <= width / 2)
    assert ((canvas == 3) == inside).all()
