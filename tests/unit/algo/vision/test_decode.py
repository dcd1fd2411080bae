from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from hawk.algo.vision import decode, quads
from hawk.algo.vision.decode import Stalls
from hawk.algo.vision.detection import FloatArray, GroundImage
from hawk.algo.vision.network import NetworkMaps
from training.targets import shape_of

CELL = 0.2
Numbers = tuple[float, float, float, float, float]
SIZE = (160, 240)


def ideal_maps(stalls: list[Numbers], taken: Collection[int] = (), noise: float = 0.0) -> NetworkMaps:
    """Return the output of a perfect network for stalls (column, row, angle, width, length) in cells."""
    rng = np.random.default_rng(3)
    maps: dict[str, Any] = {name: np.zeros(SIZE, np.float32) for name in NetworkMaps.__slots__ if name != "vehicles"}
    maps["width"][:], maps["length"][:] = 2.6, 5.2
    rows, columns = np.indices(SIZE, dtype=float)
    for k, (column, row, angle, width, length) in enumerate(stalls):
        dx, dy = columns - column, rows - row
        along, across = dx * math.cos(angle) + dy * math.sin(angle), dy * math.cos(angle) - dx * math.sin(angle)
        inside = (np.abs(along) < length * 0.37) & (np.abs(across) < width * 0.37)
        maps["core"][inside] = 0.95
        maps["sine"][inside], maps["cosine"][inside] = math.sin(2 * angle), math.cos(2 * angle)
        maps["offset_column"][inside], maps["offset_row"][inside] = -dx[inside], -dy[inside]
        maps["width"][inside], maps["length"][inside] = width * CELL, length * CELL
        maps["taken"][inside] = 0.97 if k in taken else 0.03
        if k in taken:
            maps["car"][(np.abs(along) < length * 0.42) & (np.abs(across) < width * 0.36)] = 0.9
    for name in ("offset_column", "offset_row"):
        maps[name] += rng.normal(0, noise, SIZE).astype(np.float32)
    return NetworkMaps(**maps)


def row_of(count: int, angle: float, pitch: float = 13.0, start: tuple[float, float] = (60, 70)) -> list[Numbers]:
    side = np.array([-math.sin(angle), math.cos(angle)]) * pitch
    return [(*(np.array(start) + k * side), angle, pitch, 26.0) for k in range(count)]


def order(found: Stalls, stalls: list[Numbers]) -> Stalls:
    wanted = np.array(stalls)
    apart = np.hypot(found.column[:, None] - wanted[:, 0], found.row[:, None] - wanted[:, 1])
    return found[apart.argmin(axis=0)]


@pytest.mark.slow
@given(
    st.floats(60, 180),
    st.floats(50, 110),
    st.floats(0, math.pi),
    st.floats(11, 17),
    st.floats(22, 30),
)
@settings(max_examples=40)
def test_one_stall_is_found_as_it_is(column: float, row: float, angle: float, width: float, length: float) -> None:
    found = decode.vote(ideal_maps([(column, row, angle, width, length)], noise=0.3), CELL)
    assert len(found) == 1
    assert math.hypot(found.column[0] - column, found.row[0] - row) < 0.7
    assert quads.angle_between(found.angle[0], angle) < 0.03
    assert found.width[0] == pytest.approx(width, rel=0.12)
    assert found.length[0] == pytest.approx(length, rel=0.12)
    assert found.score[0] > 0.8


@pytest.mark.parametrize("angle", [0.0, 0.6, 1.3, math.pi / 2, 2.5])
def test_neighbours_in_a_row_are_distinguished(angle: float) -> None:
    stalls = row_of(5, angle, start=(110, 60) if angle < 1.5 else (170, 80))
    found = decode.vote(ideal_maps(stalls, noise=0.5), CELL)
    assert len(found) == 5
    found = order(found, stalls)
    np.testing.assert_allclose(np.column_stack([found.column, found.row]), np.array(stalls)[:, :2], atol=0.8)


def test_taken_and_free_are_distinguished_with_the_middle_at_one_half() -> None:
    stalls = row_of(4, 1.2, start=(150, 70))
    maps = ideal_maps(stalls, taken={1, 3})
    found = order(decode.vote(maps, CELL), stalls)
    taken = decode.occupancy(maps, found)
    assert (taken[[1, 3]] > 0.9).all()
    assert (taken[[0, 2]] < 0.1).all()


def test_a_car_that_leans_in_from_the_side_speaks_less_for_taken_than_one_in_the_middle() -> None:
    stalls = row_of(3, 0.0, start=(60, 70))
    maps = ideal_maps(stalls)
    found = order(decode.vote(maps, CELL), stalls)
    maps.taken[:] = 0.5
    grid = decode.sample_points(found)
    for k, share in ((0, np.abs(decode.sample_grid()[:, 0]) < 0.16), (1, decode.sample_grid()[:, 0] < -0.16)):
        column, row = np.rint(grid[k][share]).astype(int).T
        maps.car[row, column] = 1.0
    features = decode.state_features(maps, found)
    middle = decode.STATE_FEATURES.index("middle")
    assert features[0, middle] == pytest.approx(1.0)
    assert features[1, middle] == pytest.approx(0.0, abs=0.05)
    assert features[:, decode.STATE_FEATURES.index("said")] == pytest.approx(0.0, abs=1e-6)
    in_middle, aside, bare = decode.occupancy(maps, found)
    assert in_middle > 0.75
    assert in_middle > aside
    assert aside < 0.5
    assert bare < 0.5


@pytest.mark.slow
@given(said=st.floats(0.0, 1.0), car=st.floats(0.0, 1.0))
@settings(max_examples=30)
def test_the_probability_of_taken_rises_with_what_the_network_says(said: float, car: float) -> None:
    stalls = row_of(1, 0.4, start=(60, 70))
    maps = ideal_maps(stalls)
    found = decode.vote(maps, CELL)
    maps.car[:] = car
    probabilities = []
    for value in (0.0, said, 1.0):
        maps.taken[:] = value
        probabilities.append(float(decode.occupancy(maps, found)[0]))
    assert 0 < probabilities[0] <= probabilities[1] <= probabilities[2] < 1


def test_cars_are_shares_of_what_the_picture_shows_of_a_stall() -> None:
    stalls = [(0.0, 60.0, 0.0, 13.0, 26.0)]
    maps = ideal_maps(stalls, taken={0})
    maps.car[:] = 1.0
    found = Stalls(*(np.array([value]) for value in (*stalls[0], 1.0)))
    assert decode.state_features(maps, found)[0, 1:] == pytest.approx(1.0)


def test_nothing_to_see_gives_nothing() -> None:
    maps = ideal_maps([])
    found = decode.vote(maps, CELL)
    assert len(found) == 0
    assert decode.occupancy(maps, found).shape == (0,)
    ground = GroundImage(maps.core, np.eye(2, 3), np.ones(SIZE, np.bool_))
    assert decode.to_seen(found, np.zeros(0), ground) == ()


def test_specks_and_things_of_another_size_are_no_stalls() -> None:
    stalls = [(40.0, 40.0, 0.3, 4.0, 6.0), (120.0, 80.0, 0.3, 30.0, 70.0)]
    assert len(decode.vote(ideal_maps(stalls), CELL)) == 0


def test_what_cannot_be_seen_does_not_vote() -> None:
    stalls = row_of(3, 1.2, start=(150, 70))
    shown = np.ones(SIZE, np.float32)
    shown[:, :140] = 0
    assert 0 < len(decode.vote(ideal_maps(stalls), CELL, shown)) < 3


@pytest.mark.parametrize("edge", [0, 100])
@pytest.mark.parametrize("centre", [-2.0, 0.0, 2.0])
def test_a_stall_that_is_cut_off_is_judged_by_what_is_shown_of_it(edge: int, centre: float) -> None:
    """Cut off by the edge of the maps, or by that of what could be seen within them."""
    maps = ideal_maps([(edge + centre, 60.0, 0.0, 13.0, 26.0)], noise=0.3)
    shown = np.ones(SIZE, np.float32)
    shown[:, :edge] = 0
    found = decode.vote(maps, CELL, shown)
    assert found.score.tolist() == [pytest.approx(1.0, abs=0.3)]
    assert (found.column[0], found.row[0]) == pytest.approx((edge + centre, 60.0), abs=1.0)


def test_of_a_stall_that_is_all_but_cut_off_nothing_is_made() -> None:
    maps = ideal_maps([(-7.0, 60.0, 0.0, 13.0, 26.0)])
    assert (decode.vote(maps, CELL).score < 0.5).all()


def test_votes_far_outside_the_picture_do_no_harm() -> None:
    maps = ideal_maps([(3.0, 3.0, 0.4, 13.0, 26.0), (239.0, 80.0, 0.4, 13.0, 26.0)])
    maps.offset_column[:20] -= 500
    found = decode.vote(maps, CELL)
    assert np.isfinite(found.corners()).all()


def test_stalls_are_placed_on_the_map_turned_and_moved() -> None:
    heading = 0.7
    right, back = np.array([-math.sin(heading), math.cos(heading)]), -np.array([math.cos(heading), math.sin(heading)])
    to_map = np.column_stack([right * CELL, back * CELL, [100.0, -50.0]])
    ground = GroundImage(np.zeros(SIZE, np.float32), to_map, np.ones(SIZE, np.bool_))
    # the long side points along the picture's columns, that is to the right of the heading
    stall = Stalls(*(np.array([v]) for v in (100.0, 60.0, 0.0, 13.0, 26.0, 0.9)))
    (seen,) = decode.to_seen(stall, np.array([0.25]), ground)
    assert (seen.north, seen.east) == pytest.approx(tuple(to_map @ (100.0, 60.0, 1.0)))
    assert seen.angle == pytest.approx((heading + math.pi / 2) % math.pi)
    assert (seen.width, seen.length, seen.score, seen.taken, seen.visible) == pytest.approx((2.6, 5.2, 0.9, 0.25, 1.0))


def test_the_visible_share_is_what_the_camera_saw() -> None:
    valid = np.ones(SIZE, np.bool_)
    valid[:, :100] = False
    ground = GroundImage(np.zeros(SIZE, np.float32), np.array([[0, -CELL, 0], [CELL, 0, 0]]), valid)
    stalls = Stalls(
        np.array([50.0, 99.5, 150.0, 239.5]),
        np.full(4, 80.0),
        np.zeros(4),
        np.full(4, 13.0),
        np.full(4, 26.0),
        np.ones(4),
    )
    seen = decode.to_seen(stalls, np.zeros(4), ground)
    assert [s.visible for s in seen] == pytest.approx([0.0, 0.5, 1.0, 0.5], abs=0.06)


def test_a_network_cell_lies_at_every_second_picture_pixel() -> None:
    picture = GroundImage(
        np.zeros((40, 60, 3), np.uint8), np.array([[0, -0.1, 7], [0.1, 0, 9]]), np.ones((40, 60), np.bool_)
    )
    cells = decode.cell_raster(picture, np.zeros((20, 30)))
    np.testing.assert_allclose(cells.map_points(np.array([5.0, 6.0])), picture.map_points(np.array([10.0, 12.0])))
    assert cells.metres_per_pixel == pytest.approx(0.2)
    assert cells.valid.shape == (20, 30)


def clipped_area(first: FloatArray, second: FloatArray) -> float:
    """Area shared by convex polygons, by counting points of a fine grid."""
    grid = np.stack(np.meshgrid(*[np.linspace(-6, 6, 500)] * 2), -1).reshape(-1, 2)

    def inside(quad: FloatArray) -> NDArray[np.bool_]:
        sides = np.roll(quad, -1, axis=0) - quad
        turn = [
            np.sign(s[0] * (grid[:, 1] - p[1]) - s[1] * (grid[:, 0] - p[0])) for p, s in zip(quad, sides, strict=True)
        ]
        return np.asarray(np.abs(np.sum(turn, axis=0)) == 4)

    return float((inside(first) & inside(second)).mean() / (inside(first) | inside(second)).mean())


@pytest.mark.nightly
@given(st.floats(-2, 2), st.floats(-2, 2), st.floats(0, math.pi))
@settings(max_examples=15)
def test_overlaps_agree_with_counting(x: float, y: float, angle: float) -> None:
    pair = quads.corners(
        np.array([0.0, x]), np.array([0.0, y]), np.array([0.2, angle]), np.array([2.6, 3.0]), np.array([5.2, 5.0])
    )
    assert quads.overlaps(pair[:1], pair[1:])[0] == pytest.approx(clipped_area(pair[0], pair[1]), abs=0.02)


@given(st.floats(-9, 9), st.floats(-9, 9), st.floats(0, math.pi - 1e-6), st.floats(1, 3), st.floats(3.5, 6))
def test_shape_undoes_corners(x: float, y: float, angle: float, width: float, length: float) -> None:
    quad = quads.corners(*(np.array([v]) for v in (x, y, angle, width, length)))
    for turned in (quad, np.roll(quad, 1, axis=1), quad[:, ::-1]):
        centre, found, wide, long = shape_of(turned)
        np.testing.assert_allclose([*centre[0], wide[0], long[0]], [x, y, width, length], atol=1e-9)
        assert quads.angle_between(found[0], angle) < 1e-6


def test_suppression_keeps_the_better_of_two_and_does_not_chain() -> None:
    x = np.array([0.0, 1.0, 2.0, 20.0])
    boxes = quads.corners(x, np.zeros(4), np.full(4, math.pi / 2), np.full(4, 2.6), np.full(4, 5.2))
    assert quads.suppress(boxes, np.array([0.9, 0.8, 0.7, 0.1]), 0.3).tolist() == [True, False, True, True]
    assert quads.suppress(boxes, np.array([0.8, 0.9, 0.7, 0.1]), 0.3).tolist() == [False, True, False, True]
    assert quads.suppress(boxes[:0], np.zeros(0), 0.3).tolist() == []


def test_neighbours_that_share_a_side_but_for_rounding_do_not_overlap() -> None:
    first = np.array([(22.95508045411016, -1.9075736721816918), (21.698756119200702, -4.183897279561429)])
    first = np.vstack([first, [(17.146108904441228, -1.6712486097425063), (18.402433239350685, 0.6050749976372309)]])
    second = np.array([(24.211404789019625, 0.3687499351980457), (22.95508045411016, -1.9075736721816916)])
    second = np.vstack([second, [(18.402433239350685, 0.6050749976372309), (19.65875757426015, 2.881398605016968)]])
    assert quads.overlaps(first[None], second[None])[0] < 1e-6
    assert quads.overlaps(second[None], first[None])[0] < 1e-6


@pytest.mark.slow
@given(st.floats(0, math.pi), st.floats(-500, 500), st.floats(-500, 500), st.floats(2, 4), st.floats(4, 6))
def test_a_row_of_touching_stalls_never_overlaps(angle: float, x: float, y: float, width: float, length: float) -> None:
    steps, ones = np.arange(12) * width, np.ones(12)
    along = np.asarray(x - math.sin(angle) * steps, np.float64)
    across = np.asarray(y + math.cos(angle) * steps, np.float64)
    boxes = quads.corners(along, across, angle * ones, width * ones, length * ones)
    assert quads.overlaps(boxes[:-1], boxes[1:]).max() < 1e-6
    assert quads.overlaps(boxes, boxes).min() > 1 - 1e-6
    assert quads.suppress(boxes, ones, 0.25).all()
