from __future__ import annotations

import numpy as np
import pytest

from hawk.algo.rows.evidence import FEATURES
from tests.unit.training.test_agreement import BrightStalls, picture
from training.rows import Places, fit, joined, places
from training.targets import LABELS, TrainingScene


def scene(judged: tuple[bool, ...] = (True, True, True)) -> TrainingScene:
    """A row of three bright stalls side by side, of which one is not labelled as a stall."""
    image = np.full((201, 261, 3), 40, np.uint8)
    quads = []
    for left in (60, 90, 120):
        image[70:122, left : left + 26] = 200
        quads.append([(left, 70), (left + 26, 70), (left + 26, 122), (left, 122)])
    labels = np.zeros((201, 261, LABELS), np.uint8)
    return TrainingScene(image, labels, np.array(quads, np.float32), np.zeros(3, bool), np.array(judged))


def test_the_places_of_a_row_are_stalls_where_the_labels_have_one() -> None:
    found = places(scene(), BrightStalls(), 0.5)  # type: ignore[arg-type]
    assert found.features.shape == (len(found.weight), len(FEATURES))
    assert 3 <= found.is_stall.sum() < len(found.is_stall)
    core = found.features[:, FEATURES.index("core")]
    assert core[found.is_stall > 0].min() > core[found.is_stall == 0].mean()
    assert set(found.weight) == {0.5}


def test_places_that_touch_what_nobody_can_judge_are_left_out() -> None:
    all_of_them = places(scene(), BrightStalls(), 1.0)  # type: ignore[arg-type]
    some = places(scene((True, True, False)), BrightStalls(), 1.0)  # type: ignore[arg-type]
    assert len(some.weight) < len(all_of_them.weight)
    assert some.is_stall.sum() < all_of_them.is_stall.sum()


def test_a_scene_without_stalls_gives_places_that_are_none() -> None:
    empty = TrainingScene(
        picture(), scene().labels, np.zeros((0, 4, 2), np.float32), np.zeros(0, bool), np.zeros(0, bool)
    )
    found = places(empty, BrightStalls(), 1.0)  # type: ignore[arg-type]
    assert len(found.weight)
    assert not found.is_stall.any()


def test_the_fit_finds_the_weights_that_made_the_stalls() -> None:
    rng = np.random.default_rng(0)
    features = rng.normal(size=(4000, 3))
    true = np.array([-1.0, 2.0, 0.0, -0.5])
    is_stall = (rng.random(4000) < 1 / (1 + np.exp(-(true[0] + features @ true[1:])))).astype(float)
    np.testing.assert_allclose(fit(Places(features, is_stall, np.ones(4000))), true, atol=0.2)


def test_nothing_joined_is_nothing() -> None:
    assert len(joined([]).weight) == 0
    assert len(joined([places(scene(), BrightStalls(), 1.0)] * 2).weight) % 2 == 0  # type: ignore[arg-type]


@pytest.mark.parametrize("weight", [0.1, 2.0])
def test_what_weighs_more_decides_more(weight: float) -> None:
    features = np.array([[1.0], [1.0], [-1.0], [-1.0]])
    is_stall = np.array([1.0, 0.0, 0.0, 0.0])
    found = fit(Places(features, is_stall, np.array([weight, 1, 1, 1])))
    said = 1 / (1 + np.exp(-(found[0] + found[1])))
    assert (said > 0.5) == (weight > 1)
