"""The fit of the probability of vehicles to labels by hand."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.perception.measures import Judged
from training.vehicles import fit


def test_the_fit_finds_the_weights_that_made_the_labels() -> None:
    rng = np.random.default_rng(2)
    score = rng.uniform(0.02, 0.98, 8000)
    odds = -0.7 + 1.6 * np.log(score / (1 - score))
    true = rng.random(8000) < 1 / (1 + np.exp(-odds))
    assert fit([Judged(score[:4000], true[:4000]), Judged(score[4000:], true[4000:])]) == pytest.approx(
        [-0.7, 1.6], abs=0.1
    )
