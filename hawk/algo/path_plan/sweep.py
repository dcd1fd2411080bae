"""What a straight way would show: the field is turned into each heading once and summed along the way.

The picture's wide side lies across the way, so that a way of length d shows a rectangle of the swath's width.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.path_plan.field import InformationField
from hawk.model import CameraModel

_TURN_M = 9.0  # what half a turn costs, metres of way: braking, yaw and speeding up again
_STOP_M = 4.0  # what every way costs for stopping at its end

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Swath:
    """Ground in the good part of a picture, metres: ``width`` across the heading, ``depth`` along it."""

    width: float
    depth: float

    @classmethod
    def of(cls, camera: CameraModel, height: float, good_share: float) -> Swath:
        """Return the swath of a level camera at a height."""
        return cls(height * camera.width / camera.fx * good_share, height * camera.height / camera.fy * good_share)


@dataclass(frozen=True, slots=True)
class Way:
    """A straight way: ``heading`` radians from north, ``length`` metres, what it would show, and how good it is.

    ``gain`` is square metres of expected new lot, ``score`` is worth per metre flown.
    """

    heading: float
    length: float
    gain: float
    score: float


def straight_ways(
    field: InformationField,
    place: tuple[float, float],
    heading: float,
    swath: Swath,
    headings: Floats,
    reach_m: float,
    mask: NDArray[np.uint8],
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return lengths (D,), and gains, scores and whether it may be flown, each (headings, D).

    ``mask`` is 1 where the drone may be on its way; a way ends before the first place where it may not.
    """
    cell = field.window.cell_m
    before = max(1, round(swath.depth / 2 / cell))
    steps = max(2, math.ceil(reach_m / cell))
    across = max(1, round(swath.width / cell))
    lengths = np.arange(steps, dtype=np.float64) * cell
    gains, worths, free = (np.zeros((len(headings), steps)) for _ in range(3))
    layers = np.dstack([field.gain, field.worth])
    for i, theta in enumerate(headings):
        turned = _turned(field, layers, place, theta, (across, steps + 2 * before), before)
        total = np.cumsum(turned.sum(1), axis=0)[2 * before :]
        gains[i], worths[i] = total[:steps, 0], total[:steps, 1]
        line = _turned(field, mask, place, theta, (1, steps), 0, cv2.INTER_NEAREST)
        free[i] = np.logical_and.accumulate(line[:, 0] > 0)
    turn = np.abs((headings - heading + math.pi) % (2 * math.pi) - math.pi) / math.pi * _TURN_M
    scores = worths / (lengths[None] + _STOP_M + turn[:, None])
    return lengths, gains, scores, free


def best_way(
    ways: tuple[Floats, Floats, Floats, Floats], headings: Floats, least_gain: float, least_m: float
) -> Way | None:
    """Return the way of the best score that shows at least so much and is at least so long, None without one."""
    lengths, gains, scores, free = ways
    usable = (free > 0) & (gains >= least_gain) & (lengths[None] >= least_m)
    if not usable.any():
        return None
    i, j = np.unravel_index(np.argmax(np.where(usable, scores, -1.0)), scores.shape)
    return Way(float(headings[i]), float(lengths[j]), float(gains[i, j]), float(scores[i, j]))


def end_of(place: tuple[float, float], heading: float, length: float) -> tuple[float, float]:
    """Return (north, east) at the end of a straight way."""
    return place[0] + length * math.cos(heading), place[1] + length * math.sin(heading)


def _turned(
    field: InformationField,
    values: NDArray[np.float32] | NDArray[np.uint8],
    place: tuple[float, float],
    theta: float,
    size: tuple[int, int],
    before: int,
    interpolation: int = cv2.INTER_LINEAR,
) -> NDArray[np.float32]:
    """Return ``values`` in a heading's own axes: rows along it from ``before`` cells behind, columns across it."""
    column, row = field.window.cells_of(np.array(place[0]), np.array(place[1]))
    along = np.array([math.sin(theta), -math.cos(theta)])  # one cell ahead, in (column, row)
    right = np.array([math.cos(theta), math.sin(theta)])
    origin = np.array([column, row]) - before * along - (size[0] - 1) / 2 * right
    affine = np.column_stack([right, along, origin])
    flags = interpolation | cv2.WARP_INVERSE_MAP
    return np.asarray(cv2.warpAffine(values, affine, size, flags=flags), dtype=np.float32)
