from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import Window
from hawk.algo.mapper.cell_classes import classify
from hawk.algo.mapper.evidence import EVIDENCE_M, CellEvidence
from hawk.algo.mapper.grid import EvidenceGrid
from hawk.model.lot_map import Cell
from tests.unit.algo.synthetic import stall_corners

WINDOW = Window.around(np.array([[-40.0, -40.0], [40.0, 40.0]]), EVIDENCE_M).aligned(2)
ROW = stall_corners(np.array([[0.0, 2.6 * i - 13, 0.0, 2.6, 5.2] for i in range(10)]))


def grid_of(lot: NDArray[np.bool_], seen: NDArray[np.bool_] | None = None) -> EvidenceGrid:
    grid = EvidenceGrid()
    evidence = np.where(lot, 2.0, -2.0).astype(np.float32)
    mask = np.full(WINDOW.shape, 2, np.uint8) if seen is None else (seen * 2).astype(np.uint8)
    grid.fuse(CellEvidence(WINDOW, evidence, evidence * 0, evidence * 0, mask), 1.0, 1)
    return grid


def area(north: tuple[float, float], east: tuple[float, float]) -> NDArray[np.bool_]:
    rows, columns = np.indices(WINDOW.shape)
    n = -(rows + WINDOW.row + 0.5) * EVIDENCE_M
    e = (columns + WINDOW.column + 0.5) * EVIDENCE_M
    return np.asarray((n >= north[0]) & (n < north[1]) & (e >= east[0]) & (e < east[1]))


def test_ground_with_lot_evidence_near_stalls_is_lot() -> None:
    lot = area((-9, 9), (-18, 16))
    shown = classify(grid_of(lot), WINDOW, ROW)
    assert (shown[lot] == Cell.LOT).mean() > 0.97
    assert (shown[~lot] == Cell.NON_LOT).mean() > 0.97


def test_a_road_far_from_stalls_is_no_lot_however_much_it_looks_like_one() -> None:
    road = area((25, 32), (-40, 40))
    shown = classify(grid_of(area((-9, 9), (-20, 20)) | road), WINDOW, ROW)
    assert not (shown[road] == Cell.LOT).any()


def test_without_stalls_nothing_is_lot() -> None:
    everywhere = np.ones(WINDOW.shape, np.bool_)
    shown = classify(grid_of(everywhere), WINDOW, np.zeros((0, 4, 2)))
    assert (shown == Cell.NON_LOT).all()


def test_two_stalls_are_no_lot() -> None:
    shown = classify(grid_of(np.ones(WINDOW.shape, np.bool_)), WINDOW, ROW[:2])
    assert not (shown == Cell.LOT).any()


def test_a_tree_in_the_lot_is_closed_over() -> None:
    lot = area((-9, 9), (-20, 20))
    tree = area((4, 8), (2, 6))
    shown = classify(grid_of(lot & ~tree), WINDOW, ROW)
    assert (shown[tree] == Cell.LOT).all()


def test_what_was_not_seen_is_unknown_even_inside_the_lot() -> None:
    unseen = area((-9, 9), (10, 14))
    shown = classify(grid_of(area((-9, 9), (-20, 20)), ~unseen), WINDOW, ROW)
    assert (shown[unseen] == Cell.UNKNOWN).all()


def test_stalls_are_lot_whatever_the_ground_says() -> None:
    shown = classify(grid_of(np.zeros(WINDOW.shape, np.bool_)), WINDOW, ROW)
    assert (shown[area((-2, 2), (-12, 12))] == Cell.LOT).all()
