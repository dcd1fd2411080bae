from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from hawk.algo.ground import COARSE_M, Grid, Window
from hawk.algo.path_plan.beyond import Unlooked
from hawk.algo.path_plan.field import InformationField
from hawk.algo.path_plan.overview import (
    AROUND_TILES,
    BLOCK,
    MOST_LUMPS,
    NEAR_M,
    GroundPart,
    Overview,
    near_tiles,
    with_margin,
)
from hawk.model.lot_map import TILE_M

EXTENT = np.array([[-600.0, -500.0], [400.0, 500.0]])


def part_of(tiles: Window, wanted: float = 0.0) -> tuple[GroundPart, Grid]:
    """Known lot west of the origin, half of it seen well; the same share is wanted everywhere."""
    window = with_margin(tiles)
    east = (window.column + np.arange(window.columns) + 0.5) * window.cell_m
    lot = np.broadcast_to((east < 0).astype(np.float32), window.shape).copy()
    allowed = (lot > 0).astype(np.uint8)
    half, seen = lot * np.float32(0.5), np.ones_like(lot)
    field = InformationField(window, np.zeros_like(lot), allowed, allowed, lot, half, seen)
    return GroundPart(tiles, field), np.full(window.shape, wanted, np.float32)


def filled(overview: Overview, place: tuple[float, float], wanted: float = 0.0) -> int:
    """Make everything, block by block; return how many frames that took."""
    frames = 0
    while not overview.is_complete:
        near = near_tiles(overview.whole(EXTENT), place)
        block = overview.missing(place, near)
        overview.take(*part_of(near, wanted))
        if block is not None:
            assert block.rows <= BLOCK
            assert block.columns <= BLOCK
            overview.take(*part_of(block, wanted))
        frames += 1
    return frames


def test_the_near_tiles_reach_far_enough_and_do_not_grow_with_the_map() -> None:
    whole = Overview().whole(EXTENT)
    assert whole.rows * TILE_M >= 1000 + 2 * AROUND_TILES * TILE_M
    near = near_tiles(whole, (0.0, 0.0))
    assert near.rows * TILE_M <= 2 * NEAR_M + 2 * TILE_M
    assert -near.row * TILE_M >= NEAR_M
    corner = near_tiles(whole, (2000.0, 2000.0))
    assert corner.row == whole.row
    assert corner.rows >= NEAR_M / TILE_M


def test_everything_is_made_once_a_block_a_frame() -> None:
    overview = Overview()
    whole = overview.whole(EXTENT)
    frames = filled(overview, (0.0, 0.0))
    assert math.ceil(whole.rows / BLOCK) ** 2 / 2 <= frames <= math.ceil(whole.rows / BLOCK) ** 2 + 1
    window = with_margin(whole).grown(-25)
    west = float(-window.column * COARSE_M)
    assert overview.lot_m2 == pytest.approx(west * window.rows * COARSE_M)
    assert overview.well_m2 == pytest.approx(overview.lot_m2 / 2)
    assert overview.seen_share == pytest.approx(0.5)
    assert overview.missing((0.0, 0.0), near_tiles(whole, (0.0, 0.0))) is None


def test_what_is_made_stays_as_the_map_grows() -> None:
    overview = Overview()
    filled(overview, (0.0, 0.0))
    lot = overview.lot_m2
    overview.whole(np.vstack([EXTENT, [[0.0, 700.0]]]))
    assert overview.lot_m2 == pytest.approx(lot)
    assert not overview.is_complete


def test_near_ground_is_wanted_in_detail_and_far_ground_in_lumps() -> None:
    overview = Overview()
    filled(overview, (0.0, 0.0), wanted=0.5)
    near = near_tiles(overview.whole(EXTENT), (0.0, 0.0))
    part, share = part_of(near, wanted=0.5)
    wanted = overview.wanted(part, share, 7.0)
    detail = near.rows * near.columns * (TILE_M / COARSE_M / 2) ** 2
    assert len(wanted.cells) == detail + MOST_LUMPS
    assert wanted.weights[: int(detail)] == pytest.approx(0.5 * (2 * COARSE_M) ** 2)
    assert wanted.weights[int(detail) :] == pytest.approx(0.5 * (8 * COARSE_M) ** 2)
    assert wanted.spare == 7.0
    apart = np.abs(wanted.cells[int(detail) :]).max(1)
    assert apart.min() > NEAR_M
    assert apart.max() < 250  # the nearest of them


def test_a_map_that_is_near_as_a_whole_is_wanted_in_detail_only() -> None:
    overview = Overview()
    near = near_tiles(overview.whole(EXTENT / 10), (0.0, 0.0))
    part, share = part_of(near, wanted=1.0)
    overview.take(part, share)
    assert overview.is_complete
    wanted = overview.wanted(part, share, 0.0)
    assert wanted.total == pytest.approx(near.rows * near.columns * TILE_M**2)
    assert len(np.unique(wanted.weights)) == 1


def test_far_places_are_allowed_as_they_were_made() -> None:
    overview = Overview()
    filled(overview, (0.0, 0.0))
    places = np.array([[300.0, -400.0], [300.0, 400.0], [5000.0, -400.0]])
    assert overview.are_allowed(places).tolist() == [True, False, False]


def test_a_path_leads_round_what_is_not_allowed_far_away() -> None:
    overview = Overview()
    filled(overview, (0.0, 0.0))
    corner = overview.corner_towards((300.0, -400.0), (-500.0, -10.0))
    assert corner is not None
    assert overview.are_allowed(np.array([corner]))[0]
    assert math.dist(corner, (-500.0, -10.0)) < math.dist((300.0, -400.0), (-500.0, -10.0)) - 100


def test_ground_beyond_the_lot_is_no_part_of_what_a_tour_may_leave_out() -> None:
    """East of the known lot nothing was looked at; the eight tiles beside it are wanted for what may lie there."""
    overview = Overview()
    near = near_tiles(overview.whole(np.array([[-80.0, -80.0], [80.0, 80.0]])), (0.0, 0.0))
    part, wanted = part_of(near, 0.5)
    other = (part.field.lot == 0).astype(np.uint8)
    beside = other.copy()
    beside[:, part.field.window.columns // 2 + 20 :] = 0
    field = replace(part.field, beyond=Unlooked(other, beside, np.ones_like(other)))
    left = np.zeros((4, *field.lot.shape))
    left[3] = beside
    overview.take(replace(part, field=field), wanted, left)
    inner, area = part.inner, COARSE_M**2
    assert overview.unlooked_m2 == pytest.approx(other[inner].sum() * area)
    assert overview.wanted_lot_m2 == pytest.approx(0.5 * (1 - beside[inner]).sum() * area)
    assert overview.found_share == pytest.approx(overview.lot_m2 / (overview.lot_m2 + overview.unlooked_m2))
    assert overview.left_out.beside_m2 == pytest.approx(beside[inner].sum(), abs=0.1)
    assert overview.left_out.outside_m2 == 0


def test_without_a_lot_nothing_of_the_ground_was_found() -> None:
    assert Overview().found_share == 0
