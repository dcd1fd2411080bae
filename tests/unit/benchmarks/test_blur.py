from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks import blur
from hawk.algo.vision.blur import BLURRED
from hawk.algo.vision.network import StallNetwork


@pytest.mark.parametrize(("angle", "axis"), [(0.0, 1), (math.pi / 2, 0)])
def test_a_smear_spreads_light_over_its_length_and_loses_none(angle: float, axis: int) -> None:
    picture = np.zeros((41, 41, 3), np.uint8)
    picture[20, 20] = 240
    found = blur.smeared(picture, 8.0, angle)[..., 0].astype(float)
    lit = np.flatnonzero(found.sum(axis=1 - axis) > 4)
    assert lit.max() - lit.min() in (7, 8, 9)
    assert found.sum() == pytest.approx(240, rel=0.1)
    assert (blur.smeared(picture, 0.0, angle) == picture).all()


@pytest.mark.slow
@pytest.mark.nightly
def test_pictures_are_found_blurred_before_the_network_loses_stalls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blur, "SMEARS_M", (0.0, 1.8))
    monkeypatch.setattr(blur, "SOFT_M", (0.4,))
    sharp, smeared, soft = blur.measure([1], 1, StallNetwork.load())
    assert sharp.blur[2] < BLURRED < min(smeared.blur[0], soft.blur[0])
    assert sharp.found > 0.9
