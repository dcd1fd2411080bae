"""Distance on the ground between photographs of the same place: what a seam between them shows.

Squares of both are compared by phase correlation (Kuglin and Hines 1975), as they lie on the ground by their adjusted
poses. What stands up, trees and roofs, is seen from two sides and lies apart, whatever the poses are.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.seen import GroundImage
from hawk.picture.orthorectification import orthorectify
from hawk.picture.photos import PhotoSurvey
from hawk.picture.shot_detections import Files

SIDE: Final = 128
"""Pixels of a square's side: 12.8 m."""
LEAST_RESPONSE: Final = 0.2
"""A square whose correlation has no higher peak than this shows nothing that both have: moved shade, or a lawn."""
_LEAST_SPREAD: Final = 6.0


def seams(survey: PhotoSurvey) -> NDArray[np.float64]:
    """Return how far squares (N,) of adjusted photographs lie apart, metres."""
    pictures = Files()
    on_ground = [
        grey(ground)
        for shot, posed, is_adjusted in zip(
            survey.shots, survey.adjusted.posed, survey.adjusted.is_adjusted.tolist(), strict=True
        )
        if is_adjusted and (ground := orthorectify(pictures.picture(shot), posed)) is not None
    ]
    return shifts(on_ground)


def grey(ground: GroundImage) -> GroundImage:
    """Return a picture on the ground without colours and without what it was sampled from."""
    return GroundImage(cv2.cvtColor(ground.values, cv2.COLOR_BGR2GRAY).astype(np.float32), ground.to_map, ground.valid)


def shifts(pictures: Sequence[GroundImage]) -> NDArray[np.float64]:
    """Return how far squares (N,) lie apart, metres, of each two of pictures (H, W) that lie north up."""
    found = [far for first, second in combinations(pictures, 2) for far in _shifts(first, second)]
    return np.array(found, np.float64)


def _shifts(first: GroundImage, second: GroundImage) -> Iterator[float]:
    side = first.metres_per_pixel
    exact = (second.to_map[:, 2] - first.to_map[:, 2]) / side * (-1, 1)  # rows run south
    row, column = np.rint(exact).astype(int).tolist()
    rest = exact - (row, column)
    window = cv2.createHanningWindow((SIDE, SIDE), cv2.CV_32F)
    top, left = max(0, row), max(0, column)
    low, right = (
        min(a, b + off) for a, b, off in zip(first.valid.shape, second.valid.shape, (row, column), strict=True)
    )
    for y in range(top, low - SIDE + 1, SIDE):
        for x in range(left, right - SIDE + 1, SIDE):
            here = slice(y, y + SIDE), slice(x, x + SIDE)
            there = slice(y - row, y - row + SIDE), slice(x - column, x - column + SIDE)
            if not (first.valid[here].all() and second.valid[there].all()):
                continue
            if first.values[here].std() < _LEAST_SPREAD:
                continue
            (dx, dy), response = cv2.phaseCorrelate(first.values[here], second.values[there].copy(), window)
            if response >= LEAST_RESPONSE:
                yield float(np.hypot(dx + rest[1], dy + rest[0]) * side)
