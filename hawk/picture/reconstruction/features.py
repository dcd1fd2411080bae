"""Features of photographs, and ties: the same place in two of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.quads import near_pairs
from hawk.picture.reconstruction.camera_pose import CameraPose, FloatArray

MOST: Final = 3000
"""Features of a photograph; over a lot at 60 m they lie some 1.5 m apart."""
SIDE: Final = 1200
"""Pixels of the longer side of the picture in which features are looked for: finer ones are leaves and gravel."""
RATIO: Final = 0.8
"""Greatest distance of a feature's descriptor by that of the second best (Lowe 2004, 7.1)."""
LEAST_TIES: Final = 15
"""Ties of two photographs; fewer may agree by chance."""
WIDE_M: Final = 6.0
DENSE_SHARE: Final = 0.03
"""Share of all pairs from which all are compared at once: from low a photograph has thousands of features near each."""
MOST_WIDE: Final = 2500
"""Features that are compared over more ground than `WIDE_M`: the strongest ones suffice."""
CELL: Final = 16
"""Cells a side of a raster over the picture; ties of each are few, so that one corner does not outweigh the rest."""
LEAST_LIKENESS: Final = 0.5
"""Least cosine of two descriptors that are one place."""
_CHUNK: Final = 65_536
_UNIT: Final = 512.0
"""A descriptor's length in whole numbers of one byte: features of thousands of photographs fit in memory."""
PLANE_PIXELS: Final = 8.0
"""Distance from one homography, pixels of the picture in which features are looked for: crowns, roofs and the time
between two lines leave more than a plane's ground would."""


Numbers = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Features:
    """Features of a photograph, the strongest first: ``pixels`` (N, 2) of the whole picture, and ``descriptors``
    (N, 128) of length `_UNIT`.
    """

    pixels: FloatArray = field(repr=False)
    descriptors: NDArray[np.uint8] = field(repr=False)

    def strongest(self, most: int) -> Features:
        """Return the ``most`` strongest ones."""
        return Features(self.pixels[:most], self.descriptors[:most])

    def units(self) -> NDArray[np.float32]:
        """Return the descriptors with length one."""
        return self.descriptors.astype(np.float32) / _UNIT


@dataclass(frozen=True, slots=True)
class Search:
    """Features ``within_m`` of each other on the ground are compared; one counts whose distance is below ``ratio`` of
    the next one's. ``share`` of these must agree on how two photographs lie.
    """

    within_m: float
    ratio: float
    share: float


@dataclass(frozen=True, slots=True)
class Ties:
    """Ties of two photographs: feature ``here`` (M,) of ``first`` and ``there`` (M,) of ``second`` are one place."""

    first: int
    second: int
    here: NDArray[np.intp] = field(repr=False)
    there: NDArray[np.intp] = field(repr=False)


def features(image: NDArray[np.uint8]) -> Features:
    """Return the features of a picture (H, W, 3), BGR: SIFT's, compared by square roots (Arandjelovic 2012)."""
    shrink = max(1.0, max(image.shape[:2]) / SIDE)
    small = cv2.resize(image, None, fx=1 / shrink, fy=1 / shrink, interpolation=cv2.INTER_AREA)
    grey = cv2.createCLAHE(2.0, (8, 8)).apply(cv2.cvtColor(small, cv2.COLOR_BGR2GRAY))
    keys, found = cv2.SIFT.create(MOST, contrastThreshold=0.02).detectAndCompute(grey, None)
    if not keys:
        return Features(np.zeros((0, 2)), np.zeros((0, 128), np.uint8))
    order = np.argsort([-key.response for key in keys], kind="stable")
    places = (np.array([key.pt for key in keys])[order] + 0.5) * shrink - 0.5
    found = found[order]
    shares = found / np.maximum(found.sum(axis=1, keepdims=True), 1e-6)
    return Features(places, np.rint(np.sqrt(shares) * _UNIT).clip(0, 255).astype(np.uint8))


def neighbours(posed: Sequence[CameraPose], most: int = 12) -> list[tuple[int, int]]:
    """Return pairs of photographs that show common ground by their poses, the nearest ``most`` of each."""
    feet = np.array([(one.north, one.east) for one in posed])
    reach = np.array([one.reach() for one in posed])
    pairs: set[tuple[int, int]] = set()
    for number in range(len(posed)):
        apart = np.hypot(*(feet - feet[number]).T)
        near = np.flatnonzero(apart < 0.8 * (reach + reach[number]))
        for other in near[np.argsort(apart[near], kind="stable")][: most + 1].tolist():
            if other != number:
                pairs.add((min(number, other), max(number, other)))
    return sorted(pairs)


def match(
    pair: tuple[int, int], posed: Sequence[CameraPose], found: Callable[[int], Features], search: Search
) -> Ties | None:
    """Return the ties of two photographs; None where fewer than `LEAST_TIES` agree.

    Only features whose ground, by the poses, lies within the search's reach of each other are compared.
    """
    within_m, ratio = search.within_m, search.ratio
    first, second = (found(number) for number in pair)
    if min(len(first.pixels), len(second.pixels)) < LEAST_TIES:
        return None
    if within_m > WIDE_M:
        first, second = first.strongest(MOST_WIDE), second.strongest(MOST_WIDE)
    here_m, there_m = (posed[number].ground(one.pixels) for number, one in zip(pair, (first, second), strict=True))
    if within_m > WIDE_M or _share_within(there_m, within_m) > DENSE_SHARE:
        here, there = alike(first, second, ratio, _squares(here_m, there_m) < within_m**2)
    else:
        here, there = alike_near(first, second, near_pairs(here_m, there_m, within_m), ratio)
    if len(here) < LEAST_TIES:
        return None
    side = max(posed[pair[0]].camera.width, posed[pair[0]].camera.height)
    tolerance = PLANE_PIXELS * max(1.0, side / SIDE)
    _, inlier = cv2.findHomography(
        first.pixels[here], second.pixels[there], cv2.USAC_MAGSAC, tolerance, maxIters=5000, confidence=0.9999
    )
    good = np.zeros(len(here), np.bool_) if inlier is None else np.ravel(inlier) > 0
    if good.sum() < max(LEAST_TIES, search.share * len(good)):
        return None
    here, there = here[good], there[good]
    kept = _spread(first.pixels[here], posed[pair[0]].camera.width, posed[pair[0]].camera.height)
    return Ties(*pair, here[kept], there[kept])


def _share_within(places: FloatArray, within_m: float) -> float:
    """Return about which share of places (N, 2) lies within a distance of one of them."""
    box = float(np.prod(np.maximum(np.ptp(places, axis=0), within_m)))
    return math.pi * within_m**2 / box


def _squares(first: FloatArray, second: FloatArray) -> NDArray[np.float32]:
    """Return the squares of the distances (N, M) between places (N, 2) and (M, 2)."""
    middle = first.mean(axis=0)
    a, b = (np.asarray(places - middle, np.float32) for places in (first, second))
    return np.asarray((a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1)[None] - 2 * (a @ b.T))


def alike_near(
    first: Features, second: Features, candidates: tuple[Numbers, Numbers], ratio: float
) -> tuple[Numbers, Numbers]:
    """Return the features that are each other's best among candidates (i, j), clearly better than the next.

    For candidates that are a small part of all pairs.
    """
    i, j = candidates
    if not len(i):
        return i, j
    here, there = first.units(), second.units()
    likeness = np.concatenate(
        [
            np.einsum("nk,nk->n", here[i[at : at + _CHUNK]], there[j[at : at + _CHUNK]])
            for at in range(0, len(i), _CHUNK)
        ]
    )
    order = np.lexsort((-likeness, i))
    begins = np.flatnonzero(np.diff(i[order], prepend=-1))
    best = order[begins]
    has_next = np.append(begins[1:], len(order)) - begins > 1
    next_best = np.where(has_next, likeness[order[np.minimum(begins + 1, len(order) - 1)]], 0.0)
    top = np.full(len(second.pixels), -1.0)
    np.maximum.at(top, j, likeness)
    good = (likeness[best] >= top[j[best]]) & _is_clear(likeness[best], next_best, ratio)
    return i[best[good]], j[best[good]]


def alike(
    first: Features, second: Features, ratio: float, may_be: NDArray[np.bool_] | None = None
) -> tuple[Numbers, Numbers]:
    """Return the same among all pairs, or those that ``may_be`` (N, M)."""
    likeness = first.units() @ second.units().T
    if may_be is not None:
        likeness[~may_be] = -1.0
    rows, best = np.arange(len(likeness)), likeness.argmax(axis=1)
    top, back = likeness[rows, best], likeness.argmax(axis=0)
    likeness[rows, best] = -1.0
    good = (back[best] == rows) & _is_clear(top, likeness.max(axis=1), ratio)
    return rows[good], best[good]


def _is_clear(best: NDArray[Any], next_best: NDArray[Any], ratio: float) -> NDArray[np.bool_]:
    """Return which features have a best that is like them, and whose distance is below ``ratio`` of the next one's."""
    distance, other = (np.sqrt(np.maximum(2 - 2 * value, 0)) for value in (best, np.maximum(next_best, 0.0)))
    return np.asarray((best > LEAST_LIKENESS) & (distance < ratio * other))


def _spread(pixels: FloatArray, width: int, height: int, most: int = 3) -> NDArray[np.intp]:
    """Return the indices of at most ``most`` pixels (N, 2) of each cell of the picture, the first ones."""
    cells = (pixels / (width, height) * CELL).astype(int).clip(0, CELL - 1) @ (CELL, 1)
    order = np.argsort(cells, kind="stable")
    run = np.arange(len(order)) - np.searchsorted(cells[order], cells[order])
    return np.sort(order[run < most])
