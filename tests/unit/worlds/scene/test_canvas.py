from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from hawk.worlds.scene.canvas import Canvas, noise
from tests.unit.worlds.builders import generator, square

METRES = st.floats(1, 18)


def canvas(metres_per_pixel: float = 0.1) -> Canvas:
    return Canvas(0.0, 0.0, round(20 / metres_per_pixel), round(20 / metres_per_pixel), metres_per_pixel)


@settings(max_examples=40)
@given(METRES, METRES, st.floats(0.5, 8), st.floats(0.5, 8), st.floats(0, 3.2))
def test_a_patch_has_its_polygon_s_area_and_middle(x: float, y: float, width: float, depth: float, turn: float) -> None:
    across = np.array([math.cos(turn), math.sin(turn)]) * width / 2
    along = np.array([-math.sin(turn), math.cos(turn)]) * depth / 2
    polygon = np.array([x, y]) + np.array([-across - along, across - along, across + along, along - across])
    inside = shapely.Polygon(polygon).intersection(shapely.box(0, 0, 20, 20))
    patch = canvas().patch(polygon)
    assert patch is not None
    half_a_pixel = 0.05 * inside.length
    assert patch.mask.sum() * 0.01 == pytest.approx(inside.area, abs=half_a_pixel)
    rows, columns = np.mgrid[patch.rows, patch.columns]
    weight = patch.mask.sum()
    middle = ((columns * patch.mask).sum() / weight + 0.5, (rows * patch.mask).sum() / weight + 0.5)
    assert (middle[0] * 0.1, middle[1] * 0.1) == pytest.approx((inside.centroid.x, inside.centroid.y), abs=0.08)


@given(st.floats(-50, 50), st.floats(-50, 50), st.floats(0.02, 0.5), METRES, METRES)
def test_pixel_coordinates_have_pixel_centres_at_whole_numbers(
    x0: float, y0: float, metres_per_pixel: float, dx: float, dy: float
) -> None:
    ground = Canvas(x0, y0, 10, 10, metres_per_pixel)
    column, row = ground.to_px(np.array([x0 + dx, y0 + dy]))
    assert (column + 0.5) * metres_per_pixel == pytest.approx(dx)
    assert (row + 0.5) * metres_per_pixel == pytest.approx(dy)
    assert ground.box == pytest.approx((x0, y0, x0 + 10 * metres_per_pixel, y0 + 10 * metres_per_pixel))


@pytest.mark.parametrize("width", [0.15, 0.4, 1.0])
def test_a_strip_is_as_wide_as_asked_but_for_two_pixels_of_smooth_edge(width: float) -> None:
    patch = canvas(0.05).strip(np.array([[2.0, 10.0], [18.0, 10.0]]), width)
    assert patch is not None
    middle = patch.mask[:, patch.mask.shape[1] // 2]
    assert width - 0.01 <= middle.sum() * 0.05 <= width + 0.14


def test_a_strip_thinner_than_a_pixel_is_faint() -> None:
    patch = canvas(0.2).strip(np.array([[2.0, 10.0], [18.0, 10.0]]), 0.05)
    assert patch is not None
    assert 0.15 < patch.mask.max() < 0.5


def test_softened_edges_keep_the_area_and_rounded_ones_lose_their_corners() -> None:
    sharp, soft, round_ = (
        canvas().patch(square(5, 5, 6), **options) for options in ({}, {"soften": 0.5}, {"round_m": 2.0})
    )
    assert sharp is not None
    assert soft is not None
    assert round_ is not None
    assert soft.mask.sum() == pytest.approx(sharp.mask.sum(), rel=0.03)
    assert ((soft.mask > 0.1) & (soft.mask < 0.9)).sum() > 5 * ((sharp.mask > 0.1) & (sharp.mask < 0.9)).sum()
    full = np.zeros((200, 200), np.float32)
    full[round_.rows, round_.columns] = round_.mask
    assert full[80, 80] == pytest.approx(1.0, abs=0.02)
    assert full[52, 52] < 0.3, "a corner"
    assert full[52, 80] > 0.7, "the middle of a side"


@pytest.mark.parametrize("strength", [0.0, 0.3, 1.0])
def test_covering_blends_by_its_strength(strength: float) -> None:
    ground = canvas()
    ground.image[:] = 100
    ground.cover(ground.patch(square(5, 5, 5)), (200.0, 150.0, 100.0), strength)
    assert ground.image[75, 75] == pytest.approx((100 + 100 * strength, 100 + 50 * strength, 100), abs=0.5)
    assert (ground.image[20, 20] == 100).all()


def test_a_gain_multiplies_each_channel() -> None:
    ground = canvas()
    ground.image[:] = 100
    ground.gain(ground.patch(square(5, 5, 5)), (0.5, 1.0, 1.5))
    assert ground.image[75, 75] == pytest.approx((50, 100, 150), abs=0.5)


def test_what_is_outside_changes_nothing() -> None:
    ground = canvas()
    ground.image[:] = 100
    ground.cover(ground.patch(square(50, 50, 5)), (0.0, 0.0, 0.0))
    ground.gain(ground.strip(square(50, 50, 5), 0.3), 0.1)
    assert (ground.image == 100).all()


@pytest.mark.parametrize(("margin", "meets"), [(0.0, False), (4.9, False), (5.1, True)])
def test_touching_takes_a_margin(margin: float, meets: bool) -> None:
    assert canvas().touches(square(25, 5, 2), margin) is meets


@settings(max_examples=20)
@given(st.integers(0, 1000), st.integers(5, 80), st.integers(5, 80), st.floats(0.5, 30))
def test_noise_has_its_size_and_follows_from_its_generator(seed: int, height: int, width: int, cell: float) -> None:
    one, two = (noise(generator(seed), height, width, [cell], [1.0]) for _ in range(2))
    assert one.shape == (height, width)
    assert one.dtype == np.float32
    assert np.array_equal(one, two)
    assert np.isfinite(one).all()


def test_octaves_add_up() -> None:
    assert noise(generator(), 300, 300, [1.0, 1.0], [0.3, 0.4]).std() == pytest.approx(0.5, rel=0.05)
    with pytest.raises(ValueError, match="zip"):
        noise(generator(), 10, 10, [1.0], [0.3, 0.4])
