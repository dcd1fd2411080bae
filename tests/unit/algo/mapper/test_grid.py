from __future__ import annotations

import numpy as np
import pytest

from hawk.algo.ground import COARSE_M, Window, tile_window
from hawk.algo.mapper.evidence import EVIDENCE_M, CellEvidence, log_odds
from hawk.algo.mapper.grid import EvidenceGrid
from hawk.model.lot_map import TILE_M, Cell


def evidence(probability: float, mask: int = 2, window: Window | None = None) -> CellEvidence:
    window = window or Window(100, 100, 60, 60, EVIDENCE_M)
    layer = np.full(window.shape, probability, np.float32)
    return CellEvidence(window, log_odds(layer), layer, layer, np.full(window.shape, mask, np.uint8))


def lot_at(grid: EvidenceGrid, row: int = 130, column: int = 130) -> float:
    return float(grid.layer(Window(row, column, 1, 1, EVIDENCE_M), "lot")[0, 0])


def test_a_window_over_four_tiles_makes_four_tiles() -> None:
    grid = EvidenceGrid()
    assert sorted(grid.fuse(evidence(0.9), 1.0, 1)) == [(0, 0), (0, 1), (1, 0), (1, 1)]


def test_tiles_are_made_only_where_the_picture_has_something_to_say() -> None:
    grid = EvidenceGrid()
    assert grid.fuse(evidence(0.9, mask=0), 1.0, 1) == []
    assert not grid.tiles


def test_frames_from_one_place_add_little() -> None:
    once, often = EvidenceGrid(), EvidenceGrid()
    once.fuse(evidence(0.8), 1.0, 1)
    for version in range(20):
        often.fuse(evidence(0.8), 0.02, version)
    assert lot_at(often) == pytest.approx(lot_at(once) * (1 + 19 * 0.02), rel=0.01)


def test_evidence_is_clamped_so_that_a_cell_can_still_turn() -> None:
    grid = EvidenceGrid()
    for version in range(100):
        grid.fuse(evidence(0.99), 1.0, version)
    for version in range(100, 103):
        grid.fuse(evidence(0.02), 1.0, version)
    assert lot_at(grid) < 0


def test_one_frame_is_never_wholly_believed() -> None:
    assert np.isfinite(log_odds(np.array([0.0, 1.0], np.float32))).all()
    assert np.abs(log_odds(np.array([0.0, 1.0], np.float32))).max() < 3


def test_means_follow_what_is_seen() -> None:
    grid = EvidenceGrid()
    for version in range(30):
        grid.fuse(evidence(0.2), 1.0, version)
    for version in range(30):
        grid.fuse(evidence(0.7), 1.0, version)
    core = grid.layer(Window(130, 130, 1, 1, EVIDENCE_M), "core")[0, 0]
    assert core == pytest.approx(0.7, abs=0.03)


def test_only_the_good_part_counts_as_seen_well() -> None:
    grid = EvidenceGrid()
    grid.fuse(evidence(0.8, mask=1), 1.0, 1)
    assert grid.layer(Window(130, 130, 1, 1, EVIDENCE_M), "well")[0, 0] == 0
    grid.fuse(evidence(0.8, mask=2), 1.0, 2)
    assert grid.layer(Window(130, 130, 1, 1, EVIDENCE_M), "well")[0, 0] == 1


def test_unseen_ground_reads_zero() -> None:
    assert not EvidenceGrid().layer(Window(-5, -5, 9, 9, EVIDENCE_M), "lot").any()


def test_coarse_layers_are_shares_of_their_cells() -> None:
    grid = EvidenceGrid()
    grid.fuse(evidence(0.8, window=tile_window((0, 0), EVIDENCE_M)), 1.0, 1)
    tile = grid.tiles[0, 0]
    tile.layers.shown[:, :64] = Cell.LOT
    tile.layers.shown[:, 64:] = Cell.NON_LOT
    tile.layers.shown[:4] = Cell.UNKNOWN
    grid.summarise((0, 0))
    layers = grid.coarse(tile_window((0, 0), COARSE_M))
    assert layers.lot[4, 0] == 1
    assert layers.lot[4, 15] == 0
    assert layers.seen[4, 15] == 1
    assert layers.seen[0, 0] == pytest.approx(0.5)
    assert grid.lot_area_m2 == pytest.approx((TILE_M - 0.8) * TILE_M / 2)


def test_a_hectare_stays_within_its_memory() -> None:
    grid = EvidenceGrid()
    side = round(100 / EVIDENCE_M)
    grid.fuse(evidence(0.8, window=Window(0, 0, side, side, EVIDENCE_M)), 1.0, 1)
    layers, coarse = ("lot", "looks", "core", "car", "well", "shown"), ("coarse_lot", "coarse_seen", "coarse_well")
    size = sum(getattr(tile.layers, name).nbytes for tile in grid.tiles.values() for name in layers)
    size += sum(getattr(tile, name).nbytes for tile in grid.tiles.values() for name in coarse)
    assert size < 4.2e6  # the mosaic, kept as JPEG, needs less than the rest of 5 MB
