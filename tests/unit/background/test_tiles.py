from __future__ import annotations

import pytest

from hawk.background.tiles import HALF_M, Bounds, Tile, count_tiles, tile_side, tiles_of, zooms_for


def test_the_whole_world_is_one_tile() -> None:
    world = Bounds(-HALF_M, -HALF_M, HALF_M, HALF_M)
    assert Tile(0, 0, 0).bounds == world
    assert list(tiles_of(world, range(2))) == [Tile(0, 0, 0), *(Tile(1, x, y) for x in (0, 1) for y in (0, 1))]


def test_tiles_are_numbered_from_the_north_west() -> None:
    edges = Tile(1, 1, 0).bounds
    assert (edges.west, edges.north) == pytest.approx((0.0, HALF_M))
    assert (edges.east, edges.south) == pytest.approx((HALF_M, 0.0))


def test_a_tile_that_is_only_met_at_its_edge_is_left_out() -> None:
    edges = Tile(10, 500, 300).bounds
    assert list(tiles_of(edges, range(10, 11))) == [Tile(10, 500, 300)]


@pytest.mark.parametrize("zoom", [0, 15, 19, 23])
def test_the_deepest_zoom_is_as_fine_as_the_picture(zoom: int) -> None:
    metres_per_pixel = tile_side(zoom) / 256
    place = Bounds(0.0, 0.0, 1.0, 1.0)
    assert zooms_for(place, metres_per_pixel)[-1] == zoom
    assert zooms_for(place, metres_per_pixel * 0.9)[-1] == zoom, "a little coarser is good enough"


def test_no_zoom_is_deeper_than_the_page_shows() -> None:
    assert zooms_for(Bounds(0.0, 0.0, 10.0, 10.0), 0.001)[-1] == 23


def test_the_lowest_zoom_shows_the_picture_within_a_tile() -> None:
    side = tile_side(16)
    assert zooms_for(Bounds(0.0, 0.0, side, side / 2), 0.3)[0] == 16
    assert zooms_for(Bounds(0.0, 0.0, side / 2, side * 1.01), 0.3)[0] == 15
    assert zooms_for(Bounds(0.0, 0.0, 1.0, 1.0), 10.0) == range(14, 15), "one zoom of a picture of few pixels"


def test_counting_finds_what_is_listed() -> None:
    place = Bounds(-8_897_000.0, 5_350_000.0, -8_896_400.0, 5_350_500.0)
    zooms = range(14, 20)
    assert count_tiles(place, zooms) == len(list(tiles_of(place, zooms))) > 90
