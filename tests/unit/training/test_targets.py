from __future__ import annotations

import contextlib
import math
import os
import select
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from hawk.algo.vision import decode, quads
from hawk.algo.vision.network import maps_from_output
from training import pool as pool_module
from training.augment import in_shade, light, outside_shade, retextured, sample, shadow_depth
from training.pool import ScenePool, training_scene
from training.scenes import Scene, SceneStall, draw_scene
from training.targets import (
    CAR,
    CORE,
    CORE_WEIGHT,
    LABELS,
    LOT,
    PLACE_WEIGHT,
    TAKEN,
    TARGET_CHANNELS,
    TrainingScene,
    draw_targets,
    shape_of,
)


def answer_of(target: NDArray[np.float32]) -> NDArray[np.float32]:
    """The answer of a network that has learnt a target perfectly."""
    answer = target[:12].copy()
    for channel in (LOT, CORE, CAR, TAKEN):
        answer[channel] = np.where(target[channel] > 0.5, 6.0, -6.0)
    return answer


def scene(count: int = 6, angle: float = 0.5) -> TrainingScene:
    across = np.array([-math.sin(angle), math.cos(angle)]) * 26
    centre = np.array([260.0, 130.0]) + np.arange(count)[:, None] * across
    boxes = quads.corners(centre[:, 0], centre[:, 1], np.full(count, angle), np.full(count, 26.0), np.full(count, 52.0))
    taken = np.arange(count) % 2 == 0
    labels = np.zeros((400, 400, LABELS), np.uint8)
    labels[:, :200, 0] = 1
    image = np.full((400, 400, 3), 100, np.uint8)
    return TrainingScene(image, labels, boxes.astype(np.float32), taken, np.ones(count, np.bool_))


def test_targets_decode_to_the_stalls_they_were_drawn_from() -> None:
    given = scene()
    target = draw_targets(given.labels, np.ones((400, 400), np.uint8), given.quads, given.taken, given.judged)
    assert target.shape == (TARGET_CHANNELS, 200, 200)
    maps = maps_from_output(answer_of(target))
    found = decode.vote(maps, 0.2)
    centre, angle, width, length = shape_of(given.quads / 2)
    nearest = np.hypot(found.column - centre[:, :1], found.row - centre[:, 1:]).argmin(axis=1)
    assert len(found) == len(given.quads)
    np.testing.assert_allclose(found.column[nearest], centre[:, 0], atol=0.3)
    np.testing.assert_allclose(found.row[nearest], centre[:, 1], atol=0.3)
    np.testing.assert_allclose(found.width[nearest], width, rtol=0.08)
    np.testing.assert_allclose(found.length[nearest], length, rtol=0.08)
    assert (quads.angle_between(found.angle[nearest], angle) < 0.02).all()
    # the car map of the scene is empty here: the network's own word alone is worth one half
    taken = decode.occupancy(maps, found[nearest])
    assert (taken[given.taken] > taken[~given.taken].max() + 0.3).all()


def test_a_stall_of_unclear_state_is_not_judged() -> None:
    given = scene(2)
    judged = np.array([True, False])
    target = draw_targets(given.labels, np.ones((400, 400), np.uint8), given.quads, given.taken, judged)
    row, column = np.rint(given.quads[1].mean(axis=0)[::-1] / 2).astype(int)
    assert target[CORE, row, column] == 0
    assert target[CORE_WEIGHT, row, column] == 0
    assert target[PLACE_WEIGHT, row, column] == 1
    row, column = np.rint(given.quads[0].mean(axis=0)[::-1] / 2).astype(int)
    assert target[CORE, row, column] == target[CORE_WEIGHT, row, column] == 1


def test_a_scene_without_stalls_has_targets_too() -> None:
    empty = np.zeros((0, 4, 2))
    target = draw_targets(
        np.ones((64, 64, LABELS), np.uint8),
        np.ones((64, 64), np.uint8),
        empty,
        np.zeros(0, np.bool_),
        np.zeros(0, np.bool_),
    )
    assert target[LOT].all()
    assert not target[CORE].any()


@pytest.mark.parametrize("seed", range(6))
def test_turned_and_scaled_samples_keep_picture_and_stalls_together(seed: int) -> None:
    given = scene()
    image = given.image.copy()
    for quad in given.quads:  # a bright square in the middle of each stall
        column, row = np.rint(quad.mean(axis=0)).astype(int)
        image[row - 4 : row + 5, column - 4 : column + 5] = 255
    marked = TrainingScene(image, given.labels, given.quads, given.taken, given.judged)
    taken = sample(marked, np.random.default_rng(seed), 256)
    picture, target = taken.picture, taken.target
    assert picture.shape == (3, 256, 256)
    assert picture.dtype == target.dtype == np.float32
    assert np.abs(picture).max() <= 0.5
    found = decode.vote(maps_from_output(answer_of(target)), 0.2)
    contrast = [
        picture[:, r - 1 : r + 2, c - 1 : c + 2].mean() - np.median(picture)
        for c, r in np.rint(np.column_stack([found.column, found.row]) * 2).astype(int)
        if 10 < c < 246 and 10 < r < 246
    ]
    assert all(c > 0.05 for c in contrast)


def test_the_same_seed_gives_the_same_sample() -> None:
    one, two = (sample(scene(), np.random.default_rng(9), 128) for _ in range(2))
    np.testing.assert_array_equal(one.picture, two.picture)
    np.testing.assert_array_equal(one.target, two.target)
    np.testing.assert_array_equal(one.sun, two.sun)


def test_light_stays_within_the_range_of_a_picture() -> None:
    rng = np.random.default_rng(0)
    image = rng.uniform(0, 255, (32, 32, 3))
    for _ in range(40):
        lit = light(image, rng)
        assert lit.min() >= 0
        assert lit.max() <= 255
        assert np.isfinite(lit).all()


@pytest.mark.slow
def test_a_drawn_scene_becomes_a_training_scene() -> None:
    drawn = next(s for s in (draw_scene(np.random.default_rng(k), 160) for k in range(20)) if s.stalls)
    kept = training_scene(drawn)
    assert kept.labels.shape == (160, 160, LABELS)
    np.testing.assert_array_equal(kept.labels[..., 3], drawn.cover)
    np.testing.assert_array_equal(kept.cast, drawn.cast)
    assert len(kept.quads) == len(kept.taken) == len(kept.judged) == len(drawn.stalls)
    unseen = np.array([s.hidden and not s.implied for s in drawn.stalls])
    assert not kept.judged[unseen].any()


def test_a_stall_under_a_crown_is_judged_where_its_row_shows_it() -> None:
    stall = SceneStall(np.zeros((4, 2)), False, True, False, True, 1.0, 0.9, "perpendicular")
    stalls = (stall, replace(stall, implied=True), replace(stall, implied=True, lines_visible=False))
    blank = np.zeros((64, 64), np.uint8)
    kept = training_scene(
        Scene(np.zeros((64, 64, 3), np.uint8), blank, blank, blank, blank, stalls, (), 0.1, np.zeros(2))
    )
    assert kept.judged.tolist() == [False, True, False]


def test_shade_darkens_a_part_and_keeps_the_rest() -> None:
    image = np.full((96, 96, 3), 160, np.float32)
    drawn = [in_shade(image, outside_shade((96, 96), rng), rng) for rng in map(np.random.default_rng, range(30))]
    assert all((one <= image + 0.01).all() for one in drawn)
    changed = [one for one in drawn if (one < 150).any()]
    assert 4 <= len(changed) <= 20
    assert np.mean([(one < 150).any(axis=2).mean() < 0.98 for one in changed]) > 0.7
    assert all(one[..., 0].sum() >= one[..., 2].sum() for one in changed), "shade is blue"


def test_shadows_of_lorries_lie_over_free_stalls_alone() -> None:
    image = np.full((120, 200, 3), 160.0, np.float32)
    quads = np.array([[(x, 40.0), (x + 26, 40.0), (x + 26, 92.0), (x, 92.0)] for x in (20.0, 130.0)])
    rngs = [np.random.default_rng(seed) for seed in range(60)]
    drawn = [in_shade(image, shadow_depth(quads, (120, 200), rng), rng) for rng in rngs]
    dark = [one[..., 1] < 150 for one in drawn]
    assert 8 <= sum(one.any() for one in dark) <= 30
    assert all((one <= image + 0.01).all() for one in drawn)
    beside = np.ones(image.shape[:2], np.bool_)
    for x in (20, 130):
        beside[20:112, x - 8 : x + 34] = False
    assert not any((one & beside).any() for one in dark)
    assert max(one[50:80, 20:46].mean() for one in dark) > 0.9
    assert not shadow_depth(quads[:0], (120, 200), np.random.default_rng(0)).any()


@pytest.mark.nightly
@pytest.mark.slow
def test_the_pool_holds_what_its_seed_draws() -> None:
    pool = ScenePool(seed=4, capacity=1)
    try:
        for drawn in (1, 2):
            pool.take_until(drawn)
            assert pool.drawn == drawn
            expected = training_scene(draw_scene(np.random.default_rng((4, drawn - 1)), 400))
            np.testing.assert_array_equal(pool[0].image, expected.image)
        assert len(pool) == 1
    finally:
        pool.close()


def test_a_painter_does_not_outlive_its_trainer(monkeypatch: pytest.MonkeyPatch) -> None:
    class Gone:
        def is_alive(self) -> bool:
            return False

    monkeypatch.setattr("multiprocessing.parent_process", Gone)
    handed_over: list[object] = []

    class Never:
        def put(self, value: object, timeout: float) -> None:
            handed_over.append(value)

    assert not pool_module._hand_over(Never(), scene())  # type: ignore[arg-type]
    assert handed_over == []


@pytest.mark.nightly
@pytest.mark.slow
def test_a_painter_ends_when_its_trainer_was_killed_with_a_full_pipe() -> None:
    code = (
        "import os, time; from training.pool import ScenePool; pool = ScenePool(3, 1, side=400)\n"
        "while pool._queue.qsize() < 3: time.sleep(0.02)\n"
        "print(pool._painters[0].pid, flush=True); os._exit(0)"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True).stdout
    try:
        painter = os.pidfd_open(int(said))
    except ProcessLookupError:
        return
    try:
        assert select.select([painter], [], [], 45)[0], "the painter goes on"
    finally:
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(painter, signal.SIGKILL)
        os.close(painter)


def test_other_textures_leave_the_picture_where_it_is() -> None:
    rng = np.random.default_rng(2)
    image = np.full((96, 96, 3), 90, np.float32)
    image[30:60, 40:50] = 220
    for _ in range(30):
        changed = retextured(image, rng)
        assert changed.shape == image.shape
        assert np.isfinite(changed).all()
        inside, outside = changed[32:58, 42:48].mean(), changed[:25].mean()
        assert inside > outside + 60
