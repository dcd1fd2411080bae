"""The figures of drawn scenes with the true, no, and a wrong sun."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.perception.suns import looks
from hawk.algo.vision.network import Blob, NetworkMaps, StallNetwork, maps_from_output, sun_input
from hawk.survey.accuracy import FloatArray
from training.targets import CORE, COSINE, LABELS, LENGTH, OFFSET_COLUMN, OFFSET_ROW, TAKEN, WIDTH, TrainingScene

FIRST = np.array([[60, 40], [86, 40], [86, 92], [60, 92]], np.float32)
QUADS = FIRST + np.array([[[26 * k, 0]] for k in range(4)], np.float32)


class SunStruck(StallNetwork):
    """Finds the stalls of the scene; all are free but to a network that knows the sun."""

    def __init__(self, sun: Blob) -> None:
        self._known = sun

    def run(self, picture: NDArray[np.uint8], sun: Blob | None = None) -> NetworkMaps:
        raw = np.zeros((12, picture.shape[0] // 2, picture.shape[1] // 2), np.float32)
        raw[[0, CORE, 2, TAKEN, 10, 11]] = -9
        raw[COSINE], raw[WIDTH], raw[LENGTH] = -1, 0, 0
        knows = sun is not None and bool(np.allclose(sun, self._known))
        for quad in QUADS / 2:
            column, row = quad.mean(axis=0)
            columns, rows = np.meshgrid(np.arange(column - 4.5, column + 5), np.arange(row - 9.5, row + 10))
            c, r = columns.astype(int), rows.astype(int)
            raw[CORE, r, c] = 9
            raw[OFFSET_COLUMN, r, c], raw[OFFSET_ROW, r, c] = (column - c) / 10, (row - r) / 10
            raw[[[2], [TAKEN]], r.ravel(), c.ravel()] = 9 if knows else -9
        return maps_from_output(raw)


def scene(cast: FloatArray) -> TrainingScene:
    return TrainingScene(
        image=np.zeros((128, 224, 3), np.uint8),
        labels=np.zeros((128, 224, LABELS), np.uint8),
        quads=QUADS,
        taken=np.ones(4, np.bool_),
        judged=np.array([True, True, True, False]),
        cast=cast,
    )


@pytest.mark.parametrize(("cast", "is_long"), [((0.3, 0.4), False), ((0.9, -1.2), True)])
def test_each_sun_is_counted_by_itself_and_stalls_that_nobody_sees_are_not(
    cast: tuple[float, float], is_long: bool
) -> None:
    given = np.array(cast)
    counts = looks(SunStruck(sun_input(given)), scene(given))
    assert {name for name in counts if "long" in name} == (
        {"true, long shadows", "none, long shadows", "wrong, long shadows"} if is_long else set()
    )
    states = {name: counts[name].state_accuracy for name in ("true", "none", "wrong")}
    assert states == {"true": 1.0, "none": 0.0, "wrong": 0.0}
    assert [(counts[name].true, counts[name].found) for name in states] == [(3, 3)] * 3
