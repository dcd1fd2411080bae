from __future__ import annotations

import math

import cv2
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hawk.algo.ground import Window, tile_window
from hawk.model.lot_map import TILE_CELLS, TILE_M

places = st.floats(-500, 500)


def test_a_tile_covers_what_the_model_says() -> None:
    window = tile_window((2, -3), 0.1)
    north, east = window.middle
    assert window.shape == (TILE_CELLS, TILE_CELLS)
    assert north == -2.5 * TILE_M
    assert math.isclose(east, -2.5 * TILE_M)


@given(places, places)
def test_the_centre_of_cell_zero_is_half_a_cell_inside_the_north_west_corner(north: float, east: float) -> None:
    window = Window.around(np.array([[north, east]]), 0.2)
    column, row = window.cells_of(np.array(north), np.array(east))
    assert -0.5 - 1e-6 <= column <= window.columns - 0.5 + 1e-6
    assert -0.5 - 1e-6 <= row <= window.rows - 0.5 + 1e-6


@given(places, places, st.floats(0.5, 60), st.floats(0.5, 60))
def test_the_tiles_of_a_window_cover_it_once(north: float, east: float, height: float, width: float) -> None:
    window = Window.around(np.array([[north, east], [north + height, east + width]]), 0.2, 1.0)
    covered = np.zeros(window.shape, int)
    for key, in_tile, in_window in window.tiles():
        covered[in_window] += 1
        tile = tile_window(key, 0.2)
        assert in_tile[0].start + tile.row == in_window[0].start + window.row
        assert in_tile[1].start + tile.column == in_window[1].start + window.column
    assert (covered == 1).all()


@given(st.integers(-50, 50), st.integers(-50, 50), st.integers(1, 60), st.integers(1, 60))
def test_aligned_bounds_are_multiples_and_hold_the_window(row: int, column: int, rows: int, columns: int) -> None:
    window = Window(row, column, rows, columns, 0.2)
    aligned = window.aligned(4)
    assert [v % 4 for v in (aligned.row, aligned.column, aligned.rows, aligned.columns)] == [0, 0, 0, 0]
    assert aligned.row <= row
    assert aligned.row + aligned.rows >= row + rows
    assert aligned.column <= column
    assert aligned.column + aligned.columns >= column + columns


def test_a_cell_is_found_at_its_centre_and_none_beyond_the_window() -> None:
    window = Window(3, -4, 10, 20, 1.6)
    rows, columns = np.array([0, 9, 4]), np.array([0, 19, 7])
    centres = np.column_stack(window.centres(rows, columns))
    found_rows, found_columns, inside = window.cells_at(np.concatenate([centres, centres + np.array([1e4, 0.0])]))
    assert found_rows.tolist() == [*rows, 0, 0, 0]
    assert found_columns.tolist() == [*columns, 0, 0, 0]
    assert inside.tolist() == [True] * 3 + [False] * 3


def test_joined_windows_hold_both() -> None:
    one, other = Window(3, 4, 10, 20, 0.2), Window(-5, 10, 2, 30, 0.2)
    joined = one.joined(other)
    assert joined == other.joined(one) == Window(-5, 4, 18, 36, 0.2)


def test_growing_keeps_the_middle() -> None:
    window = Window(3, 4, 10, 20, 0.2)
    assert window.grown(5).middle == window.middle
    assert window.grown(5).shape == (20, 30)


@given(st.floats(0, 6.2), places, places)
def test_a_picture_is_placed_where_its_pixels_say_they_are(yaw: float, north: float, east: float) -> None:
    """One bright pixel lands in the cell whose centre is nearest to its place."""
    c, s = math.cos(yaw), math.sin(yaw)
    to_map = np.array([[-s * 0.2, -c * 0.2, north], [c * 0.2, -s * 0.2, east]])
    corners = (to_map @ np.array([[0, 40, 40, 0], [0, 0, 30, 30], [1, 1, 1, 1.0]])).T
    window = Window.around(corners, 0.2, 2.0)
    picture = np.zeros((31, 41), np.float32)
    picture[20, 10] = 1.0
    placed = cv2.warpAffine(picture, window.affine(to_map), (window.columns, window.rows), flags=cv2.INTER_LINEAR)
    place = to_map @ (10, 20, 1)
    column, row = window.cells_of(np.array(place[0]), np.array(place[1]))
    weight = placed.sum()
    rows, columns = np.indices(placed.shape)
    assert abs((placed * columns).sum() / weight - column) < 0.35
    assert abs((placed * rows).sum() / weight - row) < 0.35


def test_a_part_is_where_the_same_cells_lie() -> None:
    whole, inner = Window(-3, 4, 6, 7, 1.6), Window(-1, 5, 2, 3, 1.6)
    cells = np.arange(whole.rows * whole.columns).reshape(whole.shape)
    assert cells[whole.part(inner)].tolist() == [[15, 16, 17], [22, 23, 24]]
    assert cells[whole.part(whole)].shape == whole.shape
