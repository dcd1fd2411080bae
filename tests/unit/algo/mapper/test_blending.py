from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from hawk.algo.ground import Window
from hawk.algo.mapper.blending import Alignment, Exposure, Patch, View, blend_of, enlarged, view_cost
from hawk.model.lot_map import CELL_M

BLOCKS = Window(-30, -30, 60, 60, 0.8)
PIXELS = (480, 480)


def view(image: np.ndarray, pixel_m: float = CELL_M) -> View:
    """Return a picture that lies on the cells of `BLOCKS`, north up."""
    to_image = np.array([[0.0, 1 / CELL_M, 239.5], [-1 / CELL_M, 0.0, 239.5], [0.0, 0.0, 1.0]])
    return View(image, to_image, pixel_m)


def grey(value: float) -> np.ndarray:
    return np.full((*PIXELS, 3), value, np.uint8)


def texture() -> np.ndarray:
    noise = np.random.default_rng(5).normal(0, 1, PIXELS).astype(np.float32)
    soft = cv2.GaussianBlur(noise, (0, 0), 3)
    return np.repeat(np.clip(120 + 40 * soft / soft.std(), 0, 255).astype(np.uint8)[..., None], 3, axis=2)


def everywhere(value: float, kind: type = np.uint8) -> np.ndarray:
    return np.full(BLOCKS.shape, value, kind)


def test_a_view_samples_the_cells_that_it_shows() -> None:
    image = texture()
    part = Window(-100, -50, 80, 120, CELL_M)
    assert np.array_equal(view(image).sampled(part), image[140:220, 190:310])
    colours = view(image).colours(BLOCKS)
    assert np.abs(colours - cv2.resize(image, (60, 60), interpolation=cv2.INTER_AREA))[2:-2, 2:-2].max() <= 1.5


def test_moving_a_view_moves_what_it_shows() -> None:
    image, part = texture(), Window(-100, -50, 80, 120, CELL_M)
    assert np.array_equal(view(image).moved(0.3, 0.5).sampled(part), image[143:223, 185:305])


def test_parts_beside_each_other_are_enlarged_as_one() -> None:
    layer = np.random.default_rng(1).random((12, 12)).astype(np.float32)
    whole = enlarged(layer, (slice(2, 10), slice(2, 10)))
    right = enlarged(layer, (slice(2, 10), slice(6, 10)))
    assert np.allclose(whole[:, 32:], right, atol=1e-5)


@pytest.mark.parametrize("gain", [0.8, 1.25])
def test_exposure_is_measured_and_damped(gain: float) -> None:
    shown = np.full((60, 60, 3), round(120 * gain), np.uint8)
    found, colours = Exposure().matched(view(grey(120)), BLOCKS, everywhere(1, np.bool_), shown)
    level = float(found.image.mean()) / 120
    assert level == pytest.approx(gain, abs=0.02)
    assert abs(np.log(level)) < abs(np.log(gain))
    assert colours.mean() == pytest.approx(found.image.mean(), abs=1)


def test_a_picture_that_shares_little_with_the_mosaic_keeps_its_light() -> None:
    known = everywhere(0, np.bool_)
    known[:5, :5] = True
    shown = np.full((60, 60, 3), 200, np.uint8)
    found, _ = Exposure().matched(view(grey(120)), BLOCKS, known, shown)
    assert found.image.mean() == pytest.approx(120, abs=1)


def test_the_loss_of_light_in_corners_is_learned() -> None:
    exposure = Exposure()
    one = view(grey(200))
    squared = one.from_middle(BLOCKS)
    dark = cv2.resize(200 * (1 - 0.2 * squared), PIXELS).clip(0, 255).astype(np.uint8)
    dim = replace(one, image=np.repeat(dark[..., None], 3, axis=2))
    shown = np.full((60, 60, 3), 200, np.uint8)
    for _ in range(60):
        found, _ = exposure.matched(dim, BLOCKS, everywhere(1, np.bool_), shown)
    assert found.image.std() < 0.3 * dim.image.std()


def test_a_picture_is_moved_half_of_what_it_is_off() -> None:
    image = texture()
    window = Window(-80, -80, 160, 160, CELL_M)
    patch = Patch(window, np.ascontiguousarray(image[160:320, 160:320]))
    off = view(image).moved(0.2, -0.4)
    found = Alignment().aligned(off, patch)
    left = np.linalg.inv(found.to_image) @ view(image).to_image
    assert left[:2, 2] == pytest.approx([0.1, -0.2], abs=0.03)


def test_a_picture_is_not_moved_where_nothing_is_alike_or_too_far() -> None:
    image = texture()
    window = Window(-80, -80, 160, 160, CELL_M)
    noise = np.random.default_rng(9).integers(0, 255, (160, 160, 3)).astype(np.uint8)
    other = Alignment().aligned(view(image), Patch(window, noise))
    assert np.array_equal(other.to_image, view(image).to_image)
    far = view(image).moved(1.2, 0.0)
    same = Alignment().aligned(far, Patch(window, np.ascontiguousarray(image[160:320, 160:320])))
    assert np.array_equal(same.to_image, far.to_image)


def test_the_square_to_compare_lies_where_both_are_and_nearest_to_straight_below() -> None:
    both = everywhere(1, np.bool_)
    both[:, :30] = False
    window = Alignment.place(both, BLOCKS, (0.0, 0.0))
    assert window is not None
    assert window.rows == window.columns == Alignment.SIDE * 8
    assert window.middle[0] == pytest.approx(0.0, abs=0.8)
    assert 0.0 < window.middle[1] < 8.0
    assert Alignment.place(everywhere(0, np.bool_), BLOCKS, (0.0, 0.0)) is None


def test_a_view_is_worse_aside_at_its_edge_from_high_up_and_coarse() -> None:
    covered = everywhere(0)
    covered[5:55, 5:55] = 255
    cost = view_cost(view(grey(1)), BLOCKS, covered, (0.0, 0.0), 30.0)
    assert cost[30, 30] < cost[30, 45] < cost[30, 54] - 6
    assert np.isinf(cost[2, 30])
    assert view_cost(view(grey(1)), BLOCKS, covered, (0.0, 0.0), 60.0)[30, 30] > cost[30, 30] + 5
    assert view_cost(view(grey(1), 0.15), BLOCKS, covered, (0.0, 0.0), 30.0)[30, 30] > cost[30, 30] + 40


def test_fresh_ground_is_taken_and_what_is_better_by_little_is_not() -> None:
    known, cost = everywhere(10, np.float16), everywhere(6, np.float32)
    assert blend_of(known, everywhere(255), cost, everywhere(255)) is None
    half = everywhere(255)
    half[:, 30:] = 0
    known[:, 30:] = np.inf
    blend = blend_of(known, half, cost, everywhere(255))
    assert blend is not None
    assert (blend.weight[30, 40], blend.weight[30, 20]) == (1.0, 0.0)
    assert blend.used[:, 30:].all()


def test_once_it_is_better_by_far_somewhere_it_takes_all_that_it_shows_better() -> None:
    cost = np.tile(np.linspace(0, 40, 60, dtype=np.float32), (60, 1))
    known = cost[:, ::-1].astype(np.float16)
    blend = blend_of(known, everywhere(255), cost, everywhere(255))
    assert blend is not None
    assert (blend.weight[30, 10], blend.weight[30, 50]) == (1.0, 0.0)
    assert np.all(np.diff(blend.weight[30, 5:55]) <= 0)


def test_colours_meet_those_that_stay_and_keep_their_own_farther_in() -> None:
    known = everywhere(10, np.float16)
    known[:, 30:] = np.inf
    covered = everywhere(255)
    covered[:, 30:] = 0
    blend = blend_of(known, covered, everywhere(9, np.float32), everywhere(255))
    assert blend is not None
    shown, colour = np.full((60, 60, 3), 120, np.uint8), np.full((60, 60, 3), 100.0, np.float32)
    change = blend.change(shown, colour, covered == 255)[30, :, 0]
    assert change[28] == pytest.approx(20, abs=3)
    assert change[50] == pytest.approx(0, abs=1)
    assert np.abs(np.diff(change)).max() < 4
