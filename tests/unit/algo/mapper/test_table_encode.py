from __future__ import annotations

import zlib

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.mapper.grid import EvidenceGrid, EvidenceTile
from hawk.algo.mapper.published import StallIndex, TileEncoder
from hawk.algo.mapper.table import FREE, STALL_DTYPE, TAKEN, UNKNOWN, Rows, to_stall
from hawk.model.lot_map import TILE_CELLS, Cell, EncodedTile


def grid_of(*keys: tuple[int, int]) -> EvidenceGrid:
    grid = EvidenceGrid()
    for key in keys:
        tile = grid.tiles[key] = EvidenceTile()
        tile.layers.shown[:] = Cell.LOT
    return grid


def stalls(*places: tuple[float, float, int]) -> Rows:
    rows = np.zeros(len(places), STALL_DTYPE)
    for row, (north, east, state) in zip(rows, places, strict=True):
        row["north"], row["east"], row["state"] = north, east, state
        row["cos2"], row["width"], row["length"], row["confirmed"] = 1.0, 2.6, 5.2, True
    return rows


def cells(tile: EncodedTile) -> NDArray[np.uint8]:
    return np.frombuffer(zlib.decompress(tile.data), np.uint8).reshape(TILE_CELLS, TILE_CELLS)


def encoded(grid: EvidenceGrid, rows: Rows) -> TileEncoder:
    encoder = TileEncoder()
    encoder.mark(set(grid.tiles))
    encoder.encode(grid, rows, 99, 1, (0.0, 0.0))
    return encoder


def test_stalls_are_drawn_in_their_state_and_place() -> None:
    rows = stalls((-5.0, 5.0, FREE), (-5.0, 15.0, TAKEN), (-15.0, 5.0, UNKNOWN))
    tile = cells(encoded(grid_of((0, 0)), rows).encoded[0, 0])
    assert tile[50, 50] == Cell.FREE
    assert tile[50, 150] == Cell.TAKEN
    assert tile[150, 50] == Cell.LOT
    rows_with_free = np.flatnonzero((tile == Cell.FREE).any(1))
    assert np.abs(rows_with_free[[0, -1]] - (24, 75)).max() <= 1  # 5.2 m long, north to south, about 5 m south


def test_a_stall_of_which_only_the_car_was_seen_is_published_as_large_as_the_smallest_stalls() -> None:
    rows = stalls((-5.0, 5.0, TAKEN), (-15.0, 15.0, TAKEN))
    rows["id"], rows["width"], rows["length"] = (1, 2), (1.9, 2.7), (4.1, 5.5)
    assert [(stall.width, stall.length) for stall in map(to_stall, rows)] == [(2.3, 4.8), (2.7, 5.5)]
    tile = cells(encoded(grid_of((0, 0)), rows).encoded[0, 0])
    near = tile[:100] == Cell.TAKEN
    assert (near.any(0).sum(), near.any(1).sum()) == pytest.approx((23, 48), abs=1)
    published = StallIndex()
    published.update(rows, np.arange(2), [], 1)
    assert not len(published.update(rows, np.arange(2), [], 2)), "nothing changed"
    assert (rows["version"] == 1).all()


def test_a_stall_over_a_border_is_drawn_in_both_tiles() -> None:
    encoder = encoded(grid_of((0, 0), (0, 1)), stalls((-5.0, 25.6, TAKEN)))
    assert (cells(encoder.encoded[0, 0])[50, -10:] == Cell.TAKEN).all()
    assert (cells(encoder.encoded[0, 1])[50, :10] == Cell.TAKEN).all()


def test_a_version_rises_only_when_something_shown_changes() -> None:
    grid = grid_of((0, 0))
    encoder = encoded(grid, stalls((-5.0, 5.0, FREE)))
    first = encoder.encoded[0, 0]
    encoder.mark({(0, 0)})
    assert not encoder.encode(grid, stalls((-5.0, 5.0, FREE)), 9, 2, (0, 0))
    assert encoder.encoded[0, 0] is first
    encoder.mark({(0, 0)})
    assert encoder.encode(grid, stalls((-5.0, 5.0, TAKEN)), 9, 3, (0, 0))
    assert encoder.encoded[0, 0].version == 3


def test_work_is_bounded_and_the_nearest_goes_first() -> None:
    grid = grid_of(*((0, c) for c in range(10)))
    encoder = TileEncoder()
    encoder.mark(set(grid.tiles))
    encoder.encode(grid, stalls(), 2, 1, (-12.8, 25.6 * 7 + 12.8))
    assert (0, 7) in encoder.encoded
    assert len(encoder.encoded) == 2
    for version in range(2, 6):
        encoder.encode(grid, stalls(), 2, version, (0, 0))
    assert len(encoder.encoded) == 10


def test_a_tile_that_was_never_seen_is_not_made_by_a_stall_that_reaches_into_it() -> None:
    encoder = TileEncoder()
    encoder.mark_around(np.array([[[-5.0, 25.0], [-5.0, 26.0], [-6.0, 26.0], [-6.0, 25.0]]]))
    encoder.encode(grid_of((0, 0)), stalls(), 9, 1, (0, 0))
    assert set(encoder.encoded) == {(0, 0)}


def test_a_moved_stall_marks_both_places() -> None:
    encoder, grid = TileEncoder(), grid_of((0, 0), (0, 3))
    there = np.array([[[-5.0, 5.0], [-5.0, 6.0], [-6.0, 6.0], [-6.0, 5.0]]])
    encoder.mark_around(np.concatenate([there, there + np.array([0, 25.6 * 3])]))
    encoder.encode(grid, stalls(), 9, 1, (0, 0))
    assert set(encoder.encoded) == {(0, 0), (0, 3)}
