from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from training import augment
from training.augment import SCALE, in_shade, light, outside_shade, retextured, sample, shadow_depth
from training.targets import (
    CAR,
    CAR_WEIGHT,
    CORE,
    CORE_WEIGHT,
    COSINE,
    COVER_WEIGHT,
    LABELS,
    LOT,
    OFFSET_COLUMN,
    OFFSET_ROW,
    PLACE_WEIGHT,
    SHADE_WEIGHT,
    SINE,
    TAKEN,
    TAKEN_WEIGHT,
    TARGET_CHANNELS,
    UNKNOWN,
    TrainingScene,
)

SEEDS = st.integers(0, 10_000)


def scene(side: int = 300) -> TrainingScene:
    """A lot on the left half, a bright car in the first of two stalls in its middle."""
    image = np.full((side, side, 3), 90, np.uint8)
    labels = np.zeros((side, side, LABELS), np.uint8)
    labels[:, : side // 2, 0] = 1
    quads = np.array(
        [[(100, 120), (126, 120), (126, 172), (100, 172)], [(126, 120), (152, 120), (152, 172), (126, 172)]], np.float32
    )
    image[125:167, 103:123] = 250
    labels[125:167, 103:123, 1] = 1
    return TrainingScene(image, labels, quads, np.array([True, False]), np.array([True, True]))


def level(image: float, shape: tuple[int, int] = (64, 64)) -> NDArray[np.float32]:
    return np.full((*shape, 3), image, np.float32)


@settings(max_examples=15)
@given(SEEDS)
def test_labels_stay_on_the_pixels_that_they_name(seed: int) -> None:
    given_scene = scene()
    rng = np.random.default_rng(seed)
    taken = sample(given_scene, rng, 192)
    picture, target = taken.picture, taken.target
    car = target[CAR] > 0.5
    if car.sum() < 60:
        return  # the car is outside the crop
    values = picture.mean(axis=0)[::2, ::2]
    bare = (target[CAR] < 0.5) & (target[PLACE_WEIGHT] > 0.5)
    inner = car.copy()
    inner[1:-1, 1:-1] &= car[:-2, 1:-1] & car[2:, 1:-1] & car[1:-1, :-2] & car[1:-1, 2:]
    if inner[1:-1, 1:-1].sum() > 20 and bare.sum() > 20:
        assert np.median(values[inner]) > np.median(values[bare])


@settings(max_examples=15)
@given(SEEDS)
def test_every_core_cell_points_at_the_middle_of_a_stall(seed: int) -> None:
    given_scene = scene()
    target = sample(given_scene, np.random.default_rng(seed), 192).target
    rows, columns = np.nonzero(target[CORE] > 0.5)
    centres = np.column_stack(
        [columns + 10 * target[OFFSET_COLUMN, rows, columns], rows + 10 * target[OFFSET_ROW, rows, columns]]
    )
    for taken in (True, False):
        mine = centres[(target[TAKEN, rows, columns] > 0.5) == taken]
        if len(mine):
            assert np.ptp(mine, axis=0).max() < 1e-3, "all cells of one stall name one middle"


@pytest.mark.slow
@settings(max_examples=15)
@given(SEEDS)
def test_angles_turn_with_the_picture_and_sizes_with_its_scale(seed: int) -> None:
    target = sample(scene(), np.random.default_rng(seed), 192).target
    core = target[CORE] > 0.5
    if not core.any():
        return
    sine, cosine = target[SINE][core], target[COSINE][core]
    assert np.hypot(sine, cosine) == pytest.approx(np.ones(core.sum()), abs=1e-5)
    assert np.ptp(sine) < 1e-4, "two stalls side by side have one direction"
    width, length = np.exp(target[7][core]) * 2.6 / 0.1, np.exp(target[8][core]) * 5.2 / 0.1
    assert length / width == pytest.approx(np.full(core.sum(), 2.0), rel=0.01), "52 by 26 pixels at any scale"
    assert (width > 26 * SCALE[0] * 0.99).all()
    assert (width < 26 * SCALE[1] * 1.01).all()


@settings(max_examples=15)
@given(SEEDS, st.sampled_from([64, 96, 160]))
def test_samples_have_the_size_and_the_range_of_the_network_s_input(seed: int, side: int) -> None:
    taken = sample(scene(), np.random.default_rng(seed), side)
    picture, target = taken.picture, taken.target
    assert picture.shape == (3, side, side)
    assert target.shape == (TARGET_CHANNELS, side // 2, side // 2)
    assert picture.min() >= -0.5
    assert picture.max() <= 0.5
    assert np.isfinite(target).all()
    assert set(np.unique(target[[LOT, CORE, CAR, TAKEN, PLACE_WEIGHT, CORE_WEIGHT]])) <= {0.0, 1.0}


@pytest.mark.slow
@settings(max_examples=15)
@given(SEEDS)
def test_what_is_outside_the_scene_is_not_judged(seed: int) -> None:
    small = scene(200)
    taken = sample(small, np.random.default_rng(seed), 256)
    picture, target = taken.picture, taken.target
    unknown = target[PLACE_WEIGHT] == 0
    assert (target[CORE_WEIGHT][unknown] == 0).all()
    assert target[LOT][unknown].sum() <= 0.01 * unknown.size, "but for the rounding of its edge"
    assert picture.shape == (3, 256, 256)


def test_samples_come_in_every_direction_both_mirrored_and_not() -> None:
    turns, mirrored = [], []
    for seed in range(60):
        placed = augment._placement(np.random.default_rng(seed), (300, 300), 1.0, 128)
        turns.append(math.atan2(placed[1, 1], placed[0, 1]))
        mirrored.append(np.linalg.det(placed[:, :2]) < 0)
    assert np.histogram(turns, 4, (-math.pi, math.pi))[0].min() >= 5
    assert 0.25 < np.mean(mirrored) < 0.75


@pytest.mark.slow
@given(SEEDS, st.floats(*SCALE), st.sampled_from([96, 192]))
def test_a_crop_is_inside_its_scene_and_of_its_scale(seed: int, scale: float, side: int) -> None:
    placed = augment._placement(np.random.default_rng(seed), (400, 500), scale, side)
    assert abs(np.linalg.det(placed[:, :2])) == pytest.approx(scale**2)
    inverse = np.linalg.inv(np.vstack([placed, [0, 0, 1]]))
    middle = inverse[:2, :2] @ np.array([side / 2, side / 2]) + inverse[:2, 2]
    assert (middle >= side / 2 / scale - 1e-6).all()
    assert (middle <= np.array([400, 500]) - side / 2 / scale + 1e-6).all()


def test_smaller_pictures_are_softened_and_larger_ones_are_not() -> None:
    noisy = np.random.default_rng(0).integers(0, 255, (64, 64, 3)).astype(np.uint8)
    assert augment._softened(noisy, 1.2) is noisy
    assert augment._softened(noisy, 0.65).std() < 0.8 * noisy.std()


@settings(max_examples=30)
@given(SEEDS, st.floats(0, 255))
def test_light_keeps_a_picture_in_its_range(seed: int, tone: float) -> None:
    lit = light(level(tone), np.random.default_rng(seed))
    assert lit.dtype == np.float32
    assert 0 <= lit.min() <= lit.max() <= 255


def test_light_changes_brightness_in_both_directions_and_some_pictures_not_at_all() -> None:
    means = [light(level(120.0), np.random.default_rng(seed)).mean() for seed in range(80)]
    assert min(means) < 105
    assert max(means) > 135
    assert sum(mean == 120 for mean in means) >= 1


@settings(max_examples=20)
@given(SEEDS)
def test_shade_and_shadows_never_brighten(seed: int) -> None:
    image = np.random.default_rng(1).uniform(0, 255, (80, 80, 3)).astype(np.float32)
    free = np.array([[(10.0, 10.0), (36.0, 10.0), (36.0, 62.0), (10.0, 62.0)]])
    rng = np.random.default_rng(seed)
    assert (in_shade(image, outside_shade((80, 80), rng), rng) <= image + 1e-3).all()
    assert (in_shade(image, shadow_depth(free, (80, 80), rng), rng) <= image + 1e-3).all()


@pytest.mark.parametrize("depth", [0.0, 0.5, 1.0])
def test_dimming_goes_with_its_depth_and_keeps_the_blue(depth: float) -> None:
    for seed in range(10):
        dim = in_shade(level(100.0), np.full((64, 64), depth, np.float32), np.random.default_rng(seed))
        blue, green, red = dim[0, 0]
        assert red <= green <= blue <= 100
        assert green == pytest.approx(100, abs=1e-3) if depth == 0 else green < 90


@pytest.mark.parametrize("size", [1.0, 5.0, 40.0])
def test_grain_is_as_coarse_as_asked(size: float) -> None:
    noise = augment._grain((200, 240), size, np.random.default_rng(0))
    assert noise.shape == (200, 240)
    assert noise.std() == pytest.approx(1.0, abs=1e-3)
    step = np.abs(np.diff(noise, axis=1)).mean()
    assert 0.3 / size < step < 3.0 / size


def test_textures_keep_the_mean_colour_nearly() -> None:
    changes = [retextured(level(110.0), np.random.default_rng(seed)).mean() - 110 for seed in range(40)]
    assert max(map(abs, changes)) < 40
    assert np.median(np.abs(changes)) < 3


def test_a_scene_without_stalls_can_be_sampled() -> None:
    empty = TrainingScene(
        scene().image, scene().labels, np.zeros((0, 4, 2), np.float32), np.zeros(0, np.bool_), np.zeros(0, np.bool_)
    )
    target = sample(empty, np.random.default_rng(3), 96).target
    assert not target[CORE].any()


def test_the_sun_turns_with_the_picture_and_is_often_left_out() -> None:
    shadow = np.array([0.0, 1.2])
    lit = replace(scene(), cast=shadow)
    suns = np.array([sample(lit, np.random.default_rng(seed), 64).sun for seed in range(60)])
    given_ = np.hypot(*suns.T) > 0
    assert 0.4 < given_.mean() < 0.8
    assert np.hypot(*suns[given_].T) == pytest.approx(np.tanh(0.6), abs=1e-5)
    assert np.ptp(np.arctan2(suns[given_, 1], suns[given_, 0])) > 3
    assert not sample(scene(), np.random.default_rng(0), 64).sun.any()


@pytest.mark.slow
@settings(max_examples=30)
@given(SEEDS)
def test_a_shadow_points_from_the_taken_stall_to_the_free_one_in_every_picture(seed: int) -> None:
    lit = replace(scene(), cast=np.array([1.5, 0.0]))  # the free stall is on the right of the taken one
    taken = sample(lit, np.random.default_rng(seed), 192)
    rows, columns = np.nonzero(taken.target[CORE] > 0.5)
    centres = np.column_stack(
        [columns + 10 * taken.target[OFFSET_COLUMN, rows, columns], rows + 10 * taken.target[OFFSET_ROW, rows, columns]]
    )
    is_taken = taken.target[TAKEN, rows, columns] > 0.5
    if not taken.sun.any() or is_taken.all() or not is_taken.any():
        return
    across = centres[~is_taken].mean(0) - centres[is_taken].mean(0)
    assert across / np.hypot(*across) == pytest.approx(taken.sun / np.hypot(*taken.sun), abs=0.01)


def test_what_is_not_known_of_real_ground_has_no_weight() -> None:
    real = scene()
    real.labels[:] = UNKNOWN
    missing = np.ones(real.image.shape[:2], np.uint8)
    missing[:, 150:] = 0
    known = replace(real, unclear=np.array([True, False]), seen=missing)
    for seed in range(8):
        target = sample(known, np.random.default_rng(seed), 192).target
        assert not target[[PLACE_WEIGHT, CAR_WEIGHT, SHADE_WEIGHT, COVER_WEIGHT]].any()
        assert not target[[LOT, CAR]].any()
        states = target[TAKEN_WEIGHT][target[CORE] > 0]
        assert set(np.unique(states)) <= {0.0, 1.0}
        taken = target[TAKEN][target[CORE] > 0]
        assert not states[taken > 0].any(), "the taken one is the unclear one"
