from __future__ import annotations

import numpy as np
import pytest

from hawk.algo.ground import COARSE_M, CoarseLayers, Window
from hawk.algo.path_plan.field import InformationField, guessed, information_field

WINDOW = Window(-40, -40, 80, 80, COARSE_M)


def layers(lot: slice, seen: slice, likely: slice = slice(0), well: slice | None = None) -> CoarseLayers:
    """Rows ``lot`` are known lot, of the rows ``seen``; everything else is unknown."""
    made = [np.zeros(WINDOW.shape, np.float32) for _ in range(4)]
    for layer, rows in zip(made, (lot, seen, seen if well is None else well, likely), strict=True):
        layer[rows] = 1.0
    made[3] = np.maximum(made[3], made[0])
    return CoarseLayers(WINDOW, *made)


def field_of(*args: slice, **kwargs: slice) -> InformationField:
    return information_field(layers(*args, **kwargs), np.ones(WINDOW.shape, np.uint8), 10.0)


def seen_share(field: InformationField) -> float:
    """Return the share of the known lot that was seen well, 0 when none is known."""
    area = float(field.lot.sum())
    return 0.0 if area == 0 else float(np.minimum(field.lot, field.well).sum()) / area


def test_nothing_is_gained_where_all_was_seen_well() -> None:
    field = field_of(slice(20, 60), slice(0, 80))
    assert field.gain.max() == 0
    assert seen_share(field) == 1.0


def test_beyond_known_lot_more_is_expected_the_nearer_the_more() -> None:
    gain = field_of(slice(20, 40), slice(20, 40)).gain[40:60, 40]
    assert gain[0] > 0.8 * COARSE_M**2
    assert (np.diff(gain) < 0).all()


def test_beyond_ground_that_is_no_lot_little_is_expected() -> None:
    closed = field_of(slice(20, 40), slice(20, 44)).gain[44:60, 40]
    open_ = field_of(slice(20, 40), slice(20, 40)).gain[40:56, 40]
    assert closed.max() < 0.1 * open_.max()


def test_ground_that_looks_alike_without_stalls_leads_on_a_little_less() -> None:
    alike = field_of(slice(20, 40), slice(20, 50), likely=slice(40, 50)).gain[50, 40]
    lot = field_of(slice(20, 50), slice(20, 50)).gain[50, 40]
    none = field_of(slice(20, 40), slice(20, 50)).gain[50, 40]
    assert none < alike < lot


def test_a_second_look_at_a_picture_s_border_is_worth_less_than_a_first_look() -> None:
    field = field_of(slice(20, 60), slice(20, 60), well=slice(20, 50))
    assert 0 < field.gain[55, 40] < 0.3 * field.gain[60, 40]
    assert seen_share(field) == pytest.approx(0.75)


def test_the_drone_stays_near_the_lot_and_inside_the_fence() -> None:
    fenced = np.ones(WINDOW.shape, np.uint8)
    fenced[:, :30] = 0
    field = information_field(layers(slice(20, 40), slice(0, 80)), fenced, 10.0)
    assert field.allowed[30, 40] == 1
    assert field.allowed[45, 40] == 1  # 9.6 m from the lot
    assert field.allowed[48, 40] == 0
    assert not field.allowed[:, :30].any()
    assert not field.passable[:, :30].any()


def test_without_a_lot_nothing_is_allowed() -> None:
    field = field_of(slice(0), slice(20, 40))
    assert not field.allowed.any()
    assert seen_share(field) == 0.0


def test_parts_of_the_lot_across_a_road_are_joined_for_the_path_but_nothing_is_wanted_there() -> None:
    parted = layers(slice(5, 20), slice(0, 80))
    parted.lot[55:70] = 1.0
    field = information_field(parted, np.ones(WINDOW.shape, np.uint8), 10.0)
    assert not field.allowed[37].any()
    assert field.passable[37].any()


def test_while_no_lot_is_known_what_looks_like_one_stands_in_for_it() -> None:
    seen = layers(slice(0), slice(20, 40), likely=slice(25, 30))
    assert (guessed(seen, (0.0, 0.0)).lot == seen.likely).all()


def test_where_nothing_looks_like_a_lot_the_ground_below_the_drone_stands_in() -> None:
    north, east = WINDOW.cell_m * 6.2, -WINDOW.cell_m * 3.3
    lot = guessed(layers(slice(0), slice(20, 40)), (north, east)).lot
    rows, columns = np.nonzero(lot)
    assert len(rows) == 1
    assert abs(-(WINDOW.row + rows[0] + 0.5) * WINDOW.cell_m - north) <= WINDOW.cell_m / 2
    assert abs((WINDOW.column + columns[0] + 0.5) * WINDOW.cell_m - east) <= WINDOW.cell_m / 2


def test_a_drone_beyond_the_window_stands_on_no_ground_of_it() -> None:
    far = WINDOW.cell_m * WINDOW.rows
    for place in ((far, 0.0), (-far, 0.0), (0.0, far), (0.0, -far)):
        assert not guessed(layers(slice(0), slice(20, 40)), place).lot.any()
