from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.algo.path_plan.course import to_and_fro
from hawk.algo.path_plan.footprint import Footprint, Singles
from hawk.algo.path_plan.tour import length_of

FOOT = Footprint(40.0, 24.0)


def ground(north: tuple[float, float], east: tuple[float, float], step: float = 2.0) -> Singles:
    """Return cells (N, 2) over a rectangle."""
    rows, columns = np.arange(*north, step), np.arange(*east, step)
    return np.stack(np.meshgrid(rows, columns, indexing="ij"), -1).reshape(-1, 2).astype(np.float32)


def shown(cells: Singles, places: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> float:
    """Return the share of the cells that the legs of a tour show."""
    return float(FOOT.shown(cells, places[:-1], places[1:]).any(0).mean())


@pytest.mark.slow
@given(st.floats(0, math.pi), st.floats(60, 160), st.floats(60, 160), st.tuples(st.floats(-90, 90), st.floats(-90, 90)))
@settings(max_examples=40, deadline=None)
def test_lanes_in_any_direction_show_nearly_all_of_a_rectangle(
    heading: float, height: float, width: float, start: tuple[float, float]
) -> None:
    cells = ground((0.0, height), (0.0, width))
    places = to_and_fro(cells, FOOT, start, heading)
    assert places[0] == pytest.approx(start)
    assert shown(cells, places) > 0.93  # two lanes may be 5 % too narrow, and their ends are cut straight


def test_the_path_is_that_of_lanes_flown_to_and_fro_from_the_near_end() -> None:
    """120 m by 120 m take three lanes of 40 m, each shorter than the ground by a picture's depth."""
    cells = ground((0.5, 120.5), (0.5, 120.5), 1.0)
    places = to_and_fro(cells, FOOT, (12.0, 100.0), 0.0)
    assert places[1] == pytest.approx((12.5, 100.3), abs=1.0)
    assert len(places) == 7
    assert length_of(places) == pytest.approx(3 * 95 + 2 * 40, abs=3.0)


def test_ground_that_a_picture_shows_takes_one_place() -> None:
    places = to_and_fro(ground((0.0, 10.0), (0.0, 30.0)), FOOT, (50.0, 0.0), 0.0)
    assert places == pytest.approx(np.array([[50.0, 0.0], [4.0, 14.0]]), abs=1.5)


def test_one_cell_is_flown_to() -> None:
    places = to_and_fro(np.array([[7.0, 9.0]], np.float32), FOOT, (0.0, 0.0), 1.0)
    assert places[-1] == pytest.approx((7.0, 9.0), abs=1e-6)


def test_a_gap_without_cells_has_no_lane() -> None:
    cells = np.concatenate([ground((0.0, 100.0), (0.0, 40.0)), ground((0.0, 100.0), (160.0, 200.0))])
    places = to_and_fro(cells, FOOT, (0.0, 20.0), 0.0)
    assert len(places) == 5
    assert not ((places[:, 1] > 45) & (places[:, 1] < 155)).any()
