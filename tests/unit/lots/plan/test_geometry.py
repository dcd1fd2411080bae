from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from hawk.lots.plan.geometry import (
    Row,
    ShapeError,
    checked_ring,
    corners,
    normal,
    overlaps,
    overlaps_between,
    parts,
    polygons,
    row_shapes,
    turned,
    within,
)
from hawk.lots.plan.values import Floats
from tests.golden import check_values

ROW = Row((0.0, 0.0), (0.0, 25.0), (5.0, 3.0), 10)


def shapes(*given: tuple[float, float, float, float, float]) -> Floats:
    return np.array(given, float)


def test_a_square_row_fills_the_front_and_reaches_the_far_side() -> None:
    found = row_shapes(ROW)
    assert found[:, :2] == pytest.approx(np.array([(2.5, 1.25 + 2.5 * n) for n in range(10)]))
    assert found[:, 2:] == pytest.approx(np.tile((0.0, 2.5, 5.0), (10, 1)))
    assert shapely.union_all(polygons(found)).equals(shapely.box(0, 0, 5, 25))


def test_a_row_lies_on_the_side_of_the_far_place() -> None:
    assert row_shapes(Row((0.0, 0.0), (0.0, 25.0), (-5.0, 0.0), 10))[:, 0] == pytest.approx(np.full(10, -2.5))


def test_a_double_row_has_two_rows_back_to_back() -> None:
    found = row_shapes(Row((0.0, 0.0), (0.0, 25.0), (10.0, 0.0), 10, is_double=True))
    assert found[:10] == pytest.approx(row_shapes(ROW))
    assert found[10:, :2] == pytest.approx(found[:10, :2] + [5.0, 0.0])
    assert shapely.union_all(polygons(found)).equals(shapely.box(0, 0, 10, 25))


def test_a_row_of_cars_along_the_front_has_long_stalls_along_it() -> None:
    found = row_shapes(Row((0.0, 0.0), (0.0, 24.0), (2.0, 0.0), 4))
    assert found[:, 2:] == pytest.approx(np.tile((math.pi / 2, 2.0, 6.0), (4, 1)))


@pytest.mark.slow
@given(
    st.floats(-1.1, 1.1),
    st.floats(-3.0, 3.0),
    st.integers(1, 40),
    st.booleans(),
    st.sampled_from([-1.0, 1.0]),
)
def test_stalls_of_a_row_touch_reach_from_front_to_far_side_and_overlap_nowhere(
    lean: float, heading: float, count: int, is_double: bool, side: float
) -> None:
    along = np.array([math.cos(heading), math.sin(heading)])
    across = side * np.array([-along[1], along[0]])
    end, far = along * count * 2.5, across * (14.0 if is_double else 7.0)
    found = row_shapes(Row((0.0, 0.0), tuple(end), tuple(far), count, lean, is_double))
    assert len(found) == count * (1 + is_double)
    drawn = polygons(found)
    reach = shapely.get_coordinates(drawn) @ across
    assert (reach.min(), reach.max()) == pytest.approx((0.0, 14.0 if is_double else 7.0), abs=1e-6)
    assert overlaps(found, found[:0], 1e-5) == []
    if count > 1:
        assert shapely.distance(drawn[0], drawn[1]) == pytest.approx(0.0, abs=1e-6)
    assert np.all(found[:, 3] <= found[:, 4])
    assert np.all((found[:, 2] >= 0) & (found[:, 2] < math.pi))


@pytest.mark.slow
def test_stalls_that_touch_overlap_in_no_direction_of_the_row() -> None:
    for heading in np.linspace(-3.0, 3.0, 200).tolist():
        along = np.array([math.cos(heading), math.sin(heading)]) * 22.5
        found = row_shapes(Row((0.0, 0.0), (along[0], along[1]), (-along[1], along[0]), 9))
        assert overlaps(found, found[:0], 1e-6) == []


@pytest.mark.parametrize(
    ("row", "field"),
    [
        (Row((0.0, 0.0), (0.0, 0.1), (5.0, 0.0), 1), "front"),
        (Row((0.0, 0.0), (0.0, 25.0), (0.1, 90.0), 10), "far"),
        (Row((0.0, 0.0), (0.0, 25.0), (1.2, 0.0), 10, lean=1.0), "far"),
    ],
)
def test_a_row_that_cannot_be_drawn_names_the_place_to_move(row: Row, field: str) -> None:
    with pytest.raises(ShapeError) as refused:
        row_shapes(row)
    assert refused.value.field == field


def test_a_wide_shape_is_the_long_one_that_is_turned() -> None:
    assert normal(shapes((1, 2, 3.0, 6, 2))) == pytest.approx(shapes((1, 2, 3.0 - math.pi / 2, 2, 6)))


def test_shapes_turn_about_the_middle_of_all_or_each_about_its_own() -> None:
    pair = shapes((0, -1, 0, 2, 4), (0, 1, 0, 2, 4))
    assert turned(pair, math.pi / 2, about_each=True)[:, :3] == pytest.approx(
        np.array([(0, -1, math.pi / 2), (0, 1, math.pi / 2)])
    )
    about_all = turned(pair, math.pi / 2, about_each=False)
    assert about_all[:, :2] == pytest.approx(np.array([(1, 0), (-1, 0)]))  # east turns clockwise to south


def test_parts_of_a_stall_fill_it() -> None:
    whole = shapes((3, 4, 0.5, 6, 7))
    found = parts(whole[0], 3)
    assert shapely.union_all(polygons(found)).symmetric_difference(polygons(whole)[0]).area == pytest.approx(
        0, abs=1e-9
    )
    assert found[:, 3] == pytest.approx(np.full(3, 2.0))


def test_overlaps_are_shares_of_the_smaller_one_the_largest_first() -> None:
    moved = shapes((0, 0, 0, 2, 4), (0, 1.5, 0, 2, 4))
    kept = shapes((0, 1.0, 0, 1, 1), (50, 0, 0, 2, 4))
    assert overlaps(moved, kept, 0.1) == [(1, 2, 1.0), (0, 2, 0.5), (0, 1, 0.25)]
    assert overlaps(moved, kept, 0.4) == [(1, 2, 1.0), (0, 2, 0.5)]


@pytest.mark.parametrize(
    "ring", [[(0, 0), (2, 2), (2, 0), (0, 2)], [(0, 0), (0, 5), (0, 9)], [(0, 0), (0.1, 0), (0, 1)]]
)
def test_an_area_that_crosses_itself_or_is_none_is_refused(ring: list[tuple[float, float]]) -> None:
    with pytest.raises(ShapeError, match=r"crosses or touches itself|has 0\.05 m²"):
        checked_ring(ring)


def test_shapes_of_drawn_rows_to_the_micrometre() -> None:
    """Every number of the geometry: rows that lean to both sides, back to back, their parts, turns and overlaps."""
    rows = {
        "square": row_shapes(ROW),
        "leaning": row_shapes(Row((1.0, 2.0), (4.0, 12.0), (9.0, 3.0), 4, lean=0.5)),
        "leaning back": row_shapes(Row((1.0, 2.0), (4.0, 12.0), (9.0, 3.0), 4, lean=-0.5)),
        "on the other side": row_shapes(Row((1.0, 2.0), (4.0, 12.0), (-9.0, 5.0), 3, lean=0.3)),
        "double": row_shapes(Row((1.0, 2.0), (4.0, 12.0), (13.0, 3.0), 3, lean=0.4, is_double=True)),
        "steep": row_shapes(Row((0.0, 0.0), (0.0, 20.0), (5.5, 0.0), 4, lean=1.1)),
    }
    found: dict[str, object] = {name: shapes.round(6).tolist() for name, shapes in rows.items()}
    found["parts"] = [parts(shape, count).round(6).tolist() for shape in rows["leaning"][:2] for count in (2, 5)]
    found["turned"] = [turned(rows["double"], 0.7, about_each=each).round(6).tolist() for each in (True, False)]
    found["corners"] = corners(rows["leaning"]).round(6).tolist()
    beside = turned(rows["leaning"], 0.3, about_each=False)
    moved = rows["leaning"] + [0.4, 0.3, 0.0, 0.0, 0.0]
    found["overlaps"] = [[*pair[:2], round(pair[2], 6)] for pair in overlaps(moved, beside, 0.05)]
    found["between"] = [[*pair[:2], round(pair[2], 6)] for pair in overlaps_between(moved, beside, 0.05)]
    found["within"] = [within(((0.0, 0.0), (0.0, 9.0), (9.0, 9.0)), shapes[:, :2]) for shapes in rows.values()]
    check_values(Path(__file__).parent / "operations" / "shapes.json", found, digits=6)


def test_limits_of_a_row_and_an_area() -> None:
    assert len(row_shapes(Row((0.0, 0.0), (0.0, 0.5), (0.5, 0.0), 1))) == 1
    for short in (Row((0.0, 0.0), (0.0, 0.4999), (5.0, 0.0), 1), Row((0.0, 0.0), (0.0, 5.0), (0.4999, 0.0), 1)):
        with pytest.raises(ShapeError):
            row_shapes(short)
    assert checked_ring([(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)])
    with pytest.raises(ShapeError, match=r"has 1\.00 m²: draw an area of 1 m² or more"):
        checked_ring([(0.0, 0.0), (0.0, 0.999), (1.0, 0.999), (1.0, 0.0)])
    nothing = shapes().reshape(-1, 5)
    assert overlaps(nothing, row_shapes(ROW), 0.1) == overlaps_between(nothing, row_shapes(ROW), 0.1) == []
    assert overlaps_between(row_shapes(ROW), nothing, 0.1) == []
