from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.algo.vision import quads
from hawk.algo.vision.detection import GroundImage
from hawk.algo.vision.network import VEHICLE_CELLS, VEHICLE_KINDS, VehicleMaps
from hawk.algo.vision.vehicles import probability_of, vehicles_of

CELL = 0.2
SIZE = (200, 260)
Box = tuple[float, float, float, float, float, str]
"""Column, row, angle, width and length in cells, kind."""


def ideal_maps(boxes: list[Box], hidden: float = 0.0) -> VehicleMaps:
    """Return the output of a perfect network; ``hidden`` is the share of each box, from its tail, that it misses."""
    size = SIZE[0] // VEHICLE_CELLS, SIZE[1] // VEHICLE_CELLS
    shapes = {name: np.zeros(size, np.float32) for name in VehicleMaps.__slots__ if name != "kinds"}
    shapes["width"][:], shapes["length"][:] = 1.9, 4.6
    kinds = np.full((len(VEHICLE_KINDS), *size), -4, np.float32)
    rows, columns = np.indices(size, dtype=float) * VEHICLE_CELLS + (VEHICLE_CELLS - 1) / 2
    for column, row, angle, width, length, kind in boxes:
        dx, dy = columns - column, rows - row
        along, across = dx * math.cos(angle) + dy * math.sin(angle), dy * math.cos(angle) - dx * math.sin(angle)
        inside = (np.abs(along) < length * 0.37) & (np.abs(across) < width * 0.37) & (along > (hidden - 0.5) * length)
        shapes["core"][inside] = 0.95
        shapes["sine"][inside], shapes["cosine"][inside] = math.sin(2 * angle), math.cos(2 * angle)
        shapes["offset_column"][inside], shapes["offset_row"][inside] = (
            -dx[inside] / VEHICLE_CELLS,
            -dy[inside] / VEHICLE_CELLS,
        )
        shapes["width"][inside], shapes["length"][inside] = width * CELL, length * CELL
        kinds[VEHICLE_KINDS.index(kind)][inside] = 4
    return VehicleMaps(**shapes, kinds=kinds)


@pytest.mark.slow
@given(st.floats(60, 200), st.floats(60, 140), st.floats(0, math.pi), st.sampled_from(VEHICLE_KINDS))
@settings(max_examples=30)
def test_a_vehicle_is_found_as_it_is(column: float, row: float, angle: float, kind: str) -> None:
    width, length = {"car": (9.0, 22.0), "van": (10.5, 29.0), "lorry": (12.5, 60.0), "trailer": (12.5, 66.0)}[kind]
    found = vehicles_of(ideal_maps([(column, row, angle, width, length, kind)]), CELL)
    assert len(found) == 1
    assert math.hypot(found.boxes.column[0] - column, found.boxes.row[0] - row) < 0.7
    assert quads.angle_between(found.boxes.angle[0], angle) < 0.03
    assert found.boxes.length[0] == pytest.approx(length, rel=0.03)
    assert VEHICLE_KINDS[int(found.kind[0])] == kind


@pytest.mark.parametrize("gap_cells", [1.5, 4.0])
def test_cars_bumper_to_bumper_stay_apart(gap_cells: float) -> None:
    pitch = 22 + gap_cells
    found = vehicles_of(ideal_maps([(40 + k * pitch, 100, 0.0, 9.0, 22.0, "car") for k in range(5)]), CELL)
    assert sorted(found.boxes.column.round()) == pytest.approx([40 + k * pitch for k in range(5)], abs=1)


def test_cars_side_by_side_stay_apart() -> None:
    found = vehicles_of(ideal_maps([(100, 40 + k * 10.5, 0.0, 9.0, 22.0, "car") for k in range(6)]), CELL)
    assert len(found) == 6


def test_a_car_that_is_hidden_in_part_keeps_its_size_and_place() -> None:
    found = vehicles_of(ideal_maps([(100, 90, 0.4, 9.0, 22.0, "car")], hidden=0.4), CELL)
    assert len(found) == 1
    assert found.boxes.length[0] == pytest.approx(22, rel=0.05)
    assert math.hypot(found.boxes.column[0] - 100, found.boxes.row[0] - 90) < 1


def test_a_queue_of_cars_is_no_lorry_and_nothing_is_nothing() -> None:
    assert len(vehicles_of(ideal_maps([]), CELL)) == 0
    assert vehicles_of(ideal_maps([]), CELL).on_ground(GroundImage(np.zeros(SIZE), np.eye(3)[:2], _all())) == ()


def test_vehicles_lie_on_the_ground_in_metres() -> None:
    north_up = np.array([[0.0, -CELL, 50.0], [CELL, 0.0, -20.0]])
    ground = GroundImage(np.zeros(SIZE), north_up, _all())
    (one,) = vehicles_of(ideal_maps([(100, 90, 0.0, 9.0, 22.0, "van")]), CELL).on_ground(ground)
    assert (one.north, one.east) == pytest.approx((50 - 18, 0), abs=0.1)
    assert one.angle == pytest.approx(math.pi / 2, abs=0.02)  # along columns: east
    assert one.kind == "van"
    assert one.length == pytest.approx(4.4, rel=0.03)
    assert 0 < one.probability < 1
    assert one.visible == 1


def test_a_surer_find_is_more_probable() -> None:
    said = probability_of(np.array([0.0, 0.2, 0.6, 0.99, 1.0]))
    assert (np.diff(said) >= 0).all()
    assert ((said > 0) & (said < 1)).all()


def _all() -> np.ndarray:
    return np.ones(SIZE, np.bool_)
