"""Headings and heights of photographs from their neighbours: for files without one, turned pictures, wrong heights.

Where the middle of one photograph shows in another one, and where both were taken, say how the other one is turned, and
how high both were: the middle shows so far from the other one's as they are apart, by their height.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import cv2
import numpy as np
from scipy.spatial import cKDTree

from hawk.picture.reconstruction.camera_pose import CameraPose, FloatArray
from hawk.picture.reconstruction.features import RATIO, Features, alike

NEIGHBOURS: Final = 5
MOST: Final = 1200
"""The strongest features are compared with each other, wherever they are."""
LEAST: Final = 12
"""Features that must agree on how two photographs lie."""
TURNED: Final = math.radians(45)
"""A heading that differs by more than this from the file's replaces it."""
_AGREE: Final = 0.03
_LEAST_SURE: Final = 0.8
_LEAST_MIDDLE: Final = 0.05
LEAST_COUPLES: Final = 2
"""Couples that say a height: one may be a mistake."""


@dataclass(frozen=True, slots=True)
class Couple:
    """Two photographs, by their ``numbers`` and poses: the ``second`` may show the middle of the ``first``."""

    numbers: tuple[int, int]
    first: CameraPose
    second: CameraPose


Middles = list[complex | None]
"""Of each couple where the middle of the first shows in the second: ahead and right of its middle, by its height."""
KeepMiddles = Callable[[Sequence[Couple], Callable[[], Middles]], Middles]


@dataclass(frozen=True, slots=True)
class NeighbourHeadings:
    """``headings`` (radians) of photographs by their numbers, as far as neighbours show them. ``heights``: metres above
    the ground that couples show by the distance of their places, with that distance, metres.
    """

    headings: dict[int, float]
    heights: tuple[tuple[float, float], ...]

    @property
    def height(self) -> float | None:
        """The middle one of the heights, each as heavy as its places are apart; None of fewer than `LEAST_COUPLES`."""
        if len(self.heights) < LEAST_COUPLES:
            return None
        heights, weights = np.array(sorted(self.heights)).T
        return float(heights[np.searchsorted(weights.cumsum(), weights.sum() / 2)])


def neighbour_headings(
    posed: Sequence[CameraPose],
    error_m: float,
    found: Callable[[int], Features],
    keep: KeepMiddles = lambda _, make: make(),
) -> NeighbourHeadings:
    """Return the headings of photographs, and their height, as far as neighbours show them.

    Args:
        posed: All photographs by their files.
        error_m: Standard deviation of where their middles lie on the ground, by place and attitude, metres.
        found: Gives the features of a photograph by its number.
        keep: Gives the middles of couples that an earlier run has kept, or makes and keeps them.
    """
    feet = np.array([(one.north, one.east) for one in posed])
    tree = cKDTree(feet)
    result, heights = {}, []
    for number in range(len(posed)):
        near = np.atleast_1d(tree.query(feet[number], min(NEIGHBOURS + 1, len(feet)))[1]).tolist()
        apart = {other: complex(*(feet[other] - feet[number])) for other in near if other != number}
        asked = [
            Couple((other, number), posed[other], posed[number])
            for other, metres in apart.items()
            if abs(metres) >= 3 * error_m
        ]
        middles = keep(asked, partial(_middles, asked, found)) if asked else []
        seen = [
            (apart[couple.numbers[0]], middle)
            for couple, middle in zip(asked, middles, strict=True)
            if middle is not None and abs(middle) > _LEAST_MIDDLE
        ]
        heights += [(abs(metres) / abs(middle), abs(metres)) for metres, middle in seen]
        votes = [cmath.rect(1.0, cmath.phase(metres) - cmath.phase(middle)) for metres, middle in seen]
        if votes and abs(sum(votes)) >= _LEAST_SURE * len(votes):
            result[number] = cmath.phase(sum(votes))
    return NeighbourHeadings(result, tuple(heights))


def correct_headings(posed: Sequence[CameraPose], found: dict[int, float]) -> dict[int, CameraPose]:
    """Return the photographs whose heading differs from their file's by more than `TURNED`, with that heading."""
    return {
        number: replace(posed[number], attitude=(0.0, 0.0, heading))
        for number, heading in found.items()
        if abs(math.remainder(heading - posed[number].attitude[2], math.tau)) > TURNED
    }


def _middles(asked: Sequence[Couple], found: Callable[[int], Features]) -> Middles:
    return [_middle(one.first, one.second, *(found(number) for number in one.numbers)) for one in asked]


def _middle(first: CameraPose, second: CameraPose, here: Features, there: Features) -> complex | None:
    here, there = here.strongest(MOST), there.strongest(MOST)
    if min(len(here.pixels), len(there.pixels)) < LEAST:
        return None
    one, other = alike(here, there, RATIO)
    if len(one) < LEAST:
        return None
    a, b = _ahead_right(first, here.pixels[one]), _ahead_right(second, there.pixels[other])
    similar, inlier = cv2.estimateAffinePartial2D(a, b, method=cv2.RANSAC, ransacReprojThreshold=_AGREE)
    if similar is None or int(inlier.sum()) < LEAST:
        return None
    return complex(float(similar[0, 2]), float(similar[1, 2]))


def _ahead_right(posed: CameraPose, pixels: FloatArray) -> FloatArray:
    """Return pixels as (N, 2) ahead and right of straight down, by the height, without a heading."""
    level = replace(
        posed, north=0.0, east=0.0, height=1.0, level=0.0, slope=(0.0, 0.0), attitude=(*posed.attitude[:2], 0.0)
    )
    return level.ground(pixels)
