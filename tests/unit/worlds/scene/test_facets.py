from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.worlds.scene.facets import (
    FacetSet,
    HeightLayer,
    VisiblePlain,
    draw_layers,
    flat_layer,
    ground_projection,
    with_rim,
)

COORDINATE = st.floats(-50, 50)
NORTH_UP = ground_projection((0.0, 0.0), 0.1)


def opaque(side: int, colour: tuple[int, int, int] = (0, 0, 255)) -> np.ndarray:
    pixels = np.full((side, side, 4), 255, np.uint8)
    pixels[..., :3] = colour
    return pixels


def picture() -> np.ndarray:
    return np.full((200, 200, 4), 90, np.uint8)


def projected(projection: np.ndarray, x: float, y: float, z: float) -> np.ndarray:
    column, row, depth = projection @ [x, y, z, 1.0]
    return np.array([column / depth, row / depth])


@given(COORDINATE, COORDINATE, st.floats(0, 20))
def test_from_straight_above_height_makes_no_difference(x: float, y: float, z: float) -> None:
    assert projected(NORTH_UP, x, y, z) == pytest.approx((x / 0.1 - 0.5, y / 0.1 - 0.5), abs=1e-6)


@pytest.mark.slow
@given(COORDINATE, COORDINATE, st.floats(0, 15), COORDINATE, COORDINATE, st.floats(20, 80))
def test_seen_from_a_viewer_things_lean_away_by_their_height(
    x: float, y: float, z: float, vx: float, vy: float, height: float
) -> None:
    projection = ground_projection((0.0, 0.0), 0.1, (vx, vy, height))
    seen = (projected(projection, x, y, z) + 0.5) * 0.1
    lean = height / (height - z)
    assert seen == pytest.approx((vx + (x - vx) * lean, vy + (y - vy) * lean), abs=1e-6)


@settings(max_examples=40)
@given(COORDINATE, COORDINATE, st.floats(-7, 7), st.floats(0.5, 9), st.floats(0.5, 9))
def test_a_flat_layer_has_its_size_centre_and_heading(
    x: float, y: float, heading: float, length: float, width: float
) -> None:
    layer = flat_layer(opaque(4), (x, y), heading, (length, width), 1.5, "car")
    first, second, third, fourth = layer.corners
    assert layer.corners.mean(axis=0) == pytest.approx((x, y, 1.5), abs=1e-9)
    assert math.dist(first, second) == pytest.approx(length)
    assert math.dist(second, third) == pytest.approx(width)
    assert math.remainder(math.atan2(*(second - first)[1::-1]) - heading, math.tau) == pytest.approx(0, abs=1e-9)
    assert fourth - first == pytest.approx(third - second, abs=1e-9)
    x0, y0, x1, y1 = layer.box
    assert x0 <= x <= x1
    assert y0 <= y <= y1
    assert layer.height == 1.5


@settings(max_examples=20)
@given(st.floats(6, 14), st.floats(6, 14), st.floats(-3, 3), st.floats(2, 5), st.floats(1, 4))
def test_a_layer_is_drawn_where_its_corners_are(
    x: float, y: float, heading: float, length: float, width: float
) -> None:
    layer = flat_layer(opaque(40), (x, y), heading, (length, width), 1.0, "car")
    image = picture()
    draw_layers(image, FacetSet([layer]), NORTH_UP)
    drawn = (image[..., 2] == 255).astype(np.uint8)
    expected = np.zeros_like(drawn)
    corners = np.round((layer.corners[:, :2] / 0.1 - 0.5) * 16).astype(np.int32)
    cv2.fillConvexPoly(expected, corners, 1, shift=4)
    assert drawn.sum() * 0.01 == pytest.approx(length * width, rel=0.08)
    assert (drawn & expected).sum() > 0.97 * drawn.sum()


def test_higher_layers_are_drawn_over_lower_ones_in_whatever_order_they_come() -> None:
    low = flat_layer(opaque(8, (0, 0, 200)), (10.0, 10.0), 0.0, (4.0, 4.0), 1.0, "car")
    high = flat_layer(opaque(8, (200, 0, 0)), (10.0, 10.0), 0.0, (2.0, 2.0), 3.0, "roof")
    for layers in ([low, high], [high, low]):
        image = picture()
        facets = FacetSet(layers)
        draw_layers(image, facets, NORTH_UP)
        assert facets.labels == ["car", "roof"]
        assert image[100, 100, :3].tolist() == [200, 0, 0]
        assert image[85, 100, :3].tolist() == [0, 0, 200]


def test_transparent_parts_show_what_is_below() -> None:
    pixels = opaque(20)
    pixels[:, :10, 3] = 0
    image = picture()
    draw_layers(image, FacetSet([flat_layer(pixels, (10.0, 10.0), 0.0, (4.0, 4.0), 1.0, "tree")]), NORTH_UP)
    assert (image[100, 85, :3] == 90).all()
    assert image[100, 115, :3].tolist() == [0, 0, 255]


def test_a_wall_of_one_colour_is_a_polygon_and_marks_masks() -> None:
    corners = np.array([[5.0, 5.0, 4.0], [15.0, 5.0, 4.0], [15.0, 5.0, 0.0], [5.0, 5.0, 0.0]])
    wall = HeightLayer(corners, np.array([[[0, 0, 255, 255]]], np.uint8), "wall")
    projection = ground_projection((0.0, 0.0), 0.1, (10.0, 18.0, 30.0))
    (seen,) = FacetSet([wall]).seen(projection, 200, 200)
    assert isinstance(seen, VisiblePlain)
    mask = np.zeros((200, 200), np.uint8)
    seen.mark(mask, 7)
    rows, columns = np.nonzero(mask == 7)
    assert 27 <= rows.min() < rows.max() <= 51, "it leans away from the viewer, to the north"
    assert 35 <= columns.min() < columns.max() <= 165
    image = picture()
    seen.paint(image)
    assert ((image[..., 2] == 255) == (mask == 7)).all()


def test_marks_are_where_a_layer_is_opaque() -> None:
    pixels = opaque(20)
    pixels[:10, :, 3] = 0
    (seen,) = FacetSet([flat_layer(pixels, (10.0, 10.0), 0.0, (4.0, 4.0), 1.0, "car")]).seen(NORTH_UP, 200, 200)
    mask = np.zeros((200, 200), np.uint8)
    seen.mark(mask, 1)
    assert seen.label == "car"
    assert mask.sum() * 0.01 == pytest.approx(8.0, rel=0.08)
    assert not mask[:100].any()


@pytest.mark.parametrize(("centre", "height"), [((-30.0, 10.0), 1.0), ((10.0, 60.0), 1.0), ((10.0, 10.0), 40.0)])
def test_layers_outside_and_behind_the_viewer_do_not_appear(centre: tuple[float, float], height: float) -> None:
    facets = FacetSet([flat_layer(opaque(8), centre, 0.0, (2.0, 2.0), height, "roof")])
    projection = ground_projection((0.0, 0.0), 0.1, (10.0, 10.0, 30.0))
    assert list(facets.seen(projection, 200, 200)) == []
    assert len(facets) == 1


def test_a_layer_at_the_edge_is_cut() -> None:
    image = picture()
    draw_layers(image, FacetSet([flat_layer(opaque(8), (0.0, 10.0), 0.0, (4.0, 4.0), 1.0, "car")]), NORTH_UP)
    assert (image[100, :19, 2] == 255).all()
    assert (image[100, 22:, 2] == 90).all()


def test_no_layers_draw_nothing() -> None:
    image = picture()
    draw_layers(image, FacetSet([]), NORTH_UP)
    assert (image == 90).all()


@pytest.mark.parametrize("metres_per_pixel", [0.02, 0.1, 0.4])
def test_a_layer_keeps_its_size_and_colour_at_any_scale(metres_per_pixel: float) -> None:
    side = round(20 / metres_per_pixel)
    image = np.full((side, side, 4), 90, np.uint8)
    layer = flat_layer(opaque(64), (10.0, 10.0), 0.6, (6.0, 3.0), 1.0, "car")
    draw_layers(image, FacetSet([layer]), ground_projection((0.0, 0.0), metres_per_pixel))
    drawn = image[..., 2] == 255
    assert drawn.sum() * metres_per_pixel**2 == pytest.approx(18, rel=0.08)
    assert (image[drawn][:, :2] == 0).all(), "its edge is not darkened"


@pytest.mark.parametrize(("fine_from", "shown"), [(0.0, 1), (5.0, 1), (20.0, 0)])
def test_fine_layers_need_pixels(fine_from: float, shown: int) -> None:
    layer = flat_layer(opaque(8), (10.0, 10.0), 0.0, (4.0, 4.0), 1.0, "tree", fine=True)
    assert len(list(FacetSet([layer]).seen(NORTH_UP, 200, 200, fine_from=fine_from))) == shown


def test_the_rim_is_transparent_and_has_the_colours_beside_it() -> None:
    rimmed = with_rim(opaque(3, (10, 20, 30)))
    assert rimmed.shape == (5, 5, 4)
    assert (rimmed[..., :3] == (10, 20, 30)).all()
    assert (rimmed[1:-1, 1:-1, 3] == 255).all()
    assert rimmed[..., 3].sum() == 9 * 255
