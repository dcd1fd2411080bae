from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest

from hawk.picture.reconstruction.normal_equations import Normal, Slopes

POSE, LENS, POINTS = 4, 2, 5
SHOT = np.array([0, 0, 0, 0, 2, 2, 2, 2, 2, 3, 3, 3])
"""Photograph 1 shows nothing."""
AT = np.array([0, 1, 2, 3, 0, 1, 2, 3, 4, 1, 3, 4])
COUNT = 4
ENDS = np.searchsorted(SHOT, np.arange(COUNT + 1))


def slopes() -> Slopes:
    rng = np.random.default_rng(2)
    size = len(SHOT)
    return Slopes(
        0, *(rng.normal(0, 1, shape) for shape in ((size, 2), (size, 2, POSE), (size, 2, LENS), (size, 2, 3)))
    )


def runs(whole: Slopes, cuts: tuple[int, ...]) -> Iterator[Slopes]:
    """Yield the slopes cut between photographs."""
    bounds = [int(ENDS[cut]) for cut in cuts]
    for begin, end in pairwise(bounds):
        if end > begin:
            part = slice(begin, end)
            yield Slopes(begin, whole.errors[part], whole.pose[part], whole.lens[part], whole.point[part])


def trusted(normal: Normal) -> None:
    axis = np.arange(POSE)
    normal.poses[:, axis, axis] += 1.0
    normal.lens[np.arange(LENS), np.arange(LENS)] += 1.0
    normal.own[:, np.arange(3), np.arange(3)] += 1.0


@pytest.mark.parametrize("cuts", [(0, 4), (0, 1, 2, 3, 4), (0, 3, 4)])
def test_a_step_is_that_of_the_whole_equations(cuts: tuple[int, ...]) -> None:
    whole = slopes()
    normal = Normal(ENDS, AT, POINTS)
    normal.add(runs(whole, cuts), POSE, LENS)
    trusted(normal)
    normal.damp(0.5)
    pose, lens, point = normal.solve()

    front = COUNT * POSE + LENS
    full = np.zeros((2 * len(SHOT), front + 3 * POINTS))
    for k, (shot, at) in enumerate(zip(SHOT.tolist(), AT.tolist(), strict=True)):
        rows = slice(2 * k, 2 * k + 2)
        full[rows, POSE * shot : POSE * (shot + 1)] = whole.pose[k]
        full[rows, COUNT * POSE : front] = whole.lens[k]
        full[rows, front + 3 * at : front + 3 * at + 3] = whole.point[k]
    equations = full.T @ full + np.eye(full.shape[1])
    equations += 0.5 * np.diag(equations.diagonal())
    wanted = np.linalg.solve(equations, -full.T @ whole.errors.ravel())
    assert np.concatenate([pose.ravel(), lens, point.ravel()]) == pytest.approx(wanted, abs=1e-8)
    assert pose[1] == pytest.approx(0.0)
