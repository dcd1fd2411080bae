from __future__ import annotations

import numpy as np
import pytest

from hawk.algo.ground import COARSE_M, Window
from hawk.algo.path_plan.field import InformationField, gathered, share_of
from hawk.algo.path_plan.footprint import Footprint
from hawk.algo.path_plan.tour import Wanted

WINDOW = Window(-40, -40, 80, 80, COARSE_M)
PICTURE = Footprint(40.0, 24.0)
AREA = COARSE_M**2


def field(gain: float = 0.0, lot: float = 0.0, well: float = 0.0, rows: slice = slice(30, 50)) -> InformationField:
    """Some rows have these values a cell, the others nothing; the drone may be everywhere."""
    layers = [np.zeros(WINDOW.shape, np.float32) for _ in range(3)]
    for layer, value in zip(layers, (gain * AREA, lot, well), strict=True):
        layer[rows, 20:60] = value
    free = np.ones(WINDOW.shape, np.uint8)
    return InformationField(WINDOW, layers[0], free, free, layers[1], layers[2], np.ones_like(layers[0]))


def wanted_of(field: InformationField, least: float, border: float) -> Wanted:
    return Wanted(*gathered(share_of(field, PICTURE, least, border), field.window), 0.0)


def test_lot_seen_at_a_picture_s_edge_only_counts_whole() -> None:
    wanted = wanted_of(field(lot=1.0), 15.0, 0.0)
    assert wanted.total == pytest.approx(20 * 40 * AREA)
    assert np.abs(wanted.cells.mean(0)).max() < COARSE_M


def test_lot_that_was_seen_well_is_not_wanted() -> None:
    assert wanted_of(field(lot=1.0, well=1.0), 15.0, 0.0).total == 0


def test_the_likelier_the_more_and_what_is_unlikely_not_at_all() -> None:
    sure, maybe, hardly = (wanted_of(field(gain=p), 15.0, 0.0).total for p in (1.0, 0.6, 0.3))
    assert sure == pytest.approx(20 * 40 * AREA)
    assert 0 < maybe < sure / 2
    assert hardly == 0


def test_small_patches_are_left_out() -> None:
    small = field(lot=1.0, rows=slice(30, 31))
    assert wanted_of(small, 40 * AREA - 1, 0.0).total > 0
    assert wanted_of(small, 40 * AREA + 1, 0.0).total == 0


def test_the_border_of_a_lot_is_wanted_with_it() -> None:
    all_seen = field(lot=1.0)
    rim = wanted_of(all_seen, 15.0, 0.4).total - wanted_of(all_seen, 15.0, 0.0).total
    assert rim == pytest.approx(0.4 * AREA * (22 * 42 - 20 * 40), rel=1e-5)


def lane_that_ends_unseen(width: int) -> InformationField:
    """A lane of ``width`` cells, all of it seen; nobody saw the ground before its end: 2 rows of it may be lot."""
    base = field()
    column = slice(38, 38 + width)
    for layer in (base.lot, base.well):
        layer[30:50, column] = 1.0
    base.seen[:30] = 0.0
    base.gain[28:30, column] = 0.6 * AREA
    return base


def test_the_open_end_of_a_lane_counts_when_asked_though_it_is_little() -> None:
    lane = lane_that_ends_unseen(4)
    assert wanted_of(lane, 15.0, 0.0).total == 0
    wanted = Wanted(*gathered(share_of(lane, PICTURE, 15.0, 0.0, 60.0), WINDOW), 0.0)
    assert wanted.total == pytest.approx(60.0)
    assert np.abs(wanted.cells - ((40 - 29.0) * COARSE_M, 0.0)).max() <= 2 * COARSE_M


def test_a_narrow_gap_between_pictures_is_no_open_end() -> None:
    gap = lane_that_ends_unseen(2)
    assert not share_of(gap, PICTURE, 15.0, 0.0, 60.0).any()


def test_what_lies_before_a_lane_and_was_looked_at_is_no_open_end() -> None:
    """Known for what it is, or looked at well and unclear still."""
    for layer in ("seen", "well"):
        lane = lane_that_ends_unseen(4)
        getattr(lane, layer)[:30] = 1.0
        assert not share_of(lane, PICTURE, 15.0, 0.0, 60.0).any()


def test_what_no_picture_from_inside_the_fence_shows_is_not_wanted() -> None:
    free = np.zeros(WINDOW.shape, np.uint8)
    free[:30] = 1
    base = field(lot=1.0)
    fenced = InformationField(WINDOW, base.gain, free, free, base.lot, base.well, base.seen)
    wanted = wanted_of(fenced, 15.0, 0.0)
    beyond = -wanted.cells[:, 0] - (WINDOW.row + 30) * COARSE_M
    assert 0 < beyond.max() <= PICTURE.depth / 2 + COARSE_M
    nowhere = InformationField(WINDOW, base.gain, free * 0, free * 0, base.lot, base.well, base.seen)
    assert wanted_of(nowhere, 15.0, 0.0).total == 0


def test_places_are_allowed_where_the_field_says_so_and_nowhere_else() -> None:
    free = np.zeros(WINDOW.shape, np.uint8)
    free[:, 40:] = 1
    base = field()
    half = InformationField(WINDOW, base.gain, free, free, base.lot, base.well, base.seen)
    places = np.array([[0.0, 10.0], [0.0, -10.0], [0.0, 1e4], [-1e4, 0.0]])
    assert half.are_allowed(places).tolist() == [True, False, False, False]
