"""Pairs of a shifted picture, and by how much answers to them differ."""

from __future__ import annotations

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="training needs the training extra")

from training.steady import MOST_CELLS, draw_pair, unsteadiness  # noqa: E402 - after torch
from training.targets import ANSWER_CHANNELS, CORE, LABELS, VEHICLE, TrainingScene  # noqa: E402


def scene() -> TrainingScene:
    image = np.random.default_rng(0).integers(0, 255, (300, 300, 3)).astype(np.uint8)
    quads = np.array([[(100, 100), (126, 100), (126, 152), (100, 152)]], np.float32)
    return TrainingScene(image, np.zeros((300, 300, LABELS), np.uint8), quads, np.array([True]), np.array([True]))


@pytest.mark.parametrize("seed", range(4))
def test_a_pair_shows_the_same_ground_shifted(seed: int) -> None:
    pair = draw_pair(scene(), np.random.default_rng(seed), 128)
    columns, rows = pair.cells
    assert 1 <= min(pair.cells) <= max(pair.cells) <= MOST_CELLS
    np.testing.assert_array_equal(
        pair.first.picture[:, 2 * rows :, 2 * columns :],
        pair.second.picture[:, : 128 - 2 * rows, : 128 - 2 * columns],
    )
    np.testing.assert_array_equal(
        pair.first.target[:, rows:, columns:], pair.second.target[:, : 64 - rows, : 64 - columns]
    )


def test_answers_that_move_with_the_picture_are_steady_and_others_are_not() -> None:
    answer = torch.zeros(2, ANSWER_CHANNELS, 64, 64)
    answer[0, [CORE, VEHICLE], 30:40, 30:40] = 9.0
    answer[1, [CORE, VEHICLE], 25:35, 27:37] = 9.0
    assert float(unsteadiness(answer, (3, 5))) < 1e-6
    assert float(unsteadiness(answer, (0, 0))) > 1e-3
