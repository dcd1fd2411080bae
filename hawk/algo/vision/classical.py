"""Classical line geometry: finds stalls without the network, by pairs of parallel painted lines at a stall's distance.

It is the fallback only: it sees a share of the stalls, and of the lot just their surroundings.
"""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision import decode, quads
from hawk.algo.vision.decode import Stalls
from hawk.algo.vision.finder import Found
from hawk.algo.vision.network import CELL_PIXELS, CORE_SHARE
from hawk.algo.vision.seen import FloatArray, GroundImage

_LINE_M = (2.5, 7.5)
_PITCH_M = (2.1, 3.6)
_PARALLEL = math.radians(6.0)
_SHIFT_M = 1.6
_BRIGHTER = 6.0
_REACH_M = 4.0
_SCORE = 0.55
_BUSY = 16.0


class ClassicalFinder:
    """Finds stalls by LSD line segments (Grompone von Gioi et al. 2012) on the paint's top-hat."""

    def find(self, picture: GroundImage) -> Found:
        """Return stalls between parallel lines; taken where the ground between them is not plain."""
        grey = cv2.cvtColor(picture.values, cv2.COLOR_BGR2GRAY)
        side = picture.metres_per_pixel
        pairs = _pairs(_segments(grey, picture.valid, side), side)
        stalls = pairs[quads.suppress(pairs.corners(), pairs.score, 0.3)] if len(pairs) else pairs
        taken = _taken(grey, stalls)
        cells = decode.cell_raster(picture, picture.valid[::CELL_PIXELS, ::CELL_PIXELS])
        core, lot, car = _rasters(stalls, taken, cells)
        return Found(
            stalls=decode.to_seen(stalls, taken, picture),
            lot=GroundImage(lot, cells.to_map, cells.valid),
            car=GroundImage(car, cells.to_map, cells.valid),
            core=GroundImage(core, cells.to_map, cells.valid),
        )


def _segments(grey: NDArray[Any], valid: NDArray[np.bool_], side: float) -> FloatArray:
    """Return the middle lines of paint (N, 4): x0, y0, x1, y1 in pixels, as long as a stall's line may be."""
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (7, 7))
    paint = cv2.morphologyEx(cv2.GaussianBlur(grey, (3, 3), 0), cv2.MORPH_TOPHAT, kernel)
    paint[cv2.erode(valid.astype(np.uint8), np.ones((9, 9), np.uint8), borderValue=(1,)) == 0] = 0
    bright = (paint > max(_BRIGHTER, float(np.percentile(paint, 90)))).astype(np.uint8) * 255
    lines = cv2.HoughLinesP(bright, 1, math.pi / 180, 20, minLineLength=_LINE_M[0] / side, maxLineGap=0.6 / side)
    if lines is None:
        return np.zeros((0, 4))
    found = np.asarray(lines, float).reshape(-1, 4)
    length = np.hypot(found[:, 2] - found[:, 0], found[:, 3] - found[:, 1]) * side
    return _distinct(found[(length > _LINE_M[0]) & (length < _LINE_M[1])], side)


def _distinct(lines: FloatArray, side: float) -> FloatArray:
    """Drop lines that repeat a longer one (Hough gives several for each stroke of paint)."""
    length = np.hypot(lines[:, 2] - lines[:, 0], lines[:, 3] - lines[:, 1])
    lines = lines[np.argsort(-length, kind="stable")]
    middle = (lines[:, :2] + lines[:, 2:]) / 2
    angle = np.arctan2(lines[:, 3] - lines[:, 1], lines[:, 2] - lines[:, 0])
    first, second = quads.near_pairs(middle, middle, 2.5 / side)
    across = np.abs(quads.cross(angle[first], middle[second] - middle[first])) * side
    same = (first < second) & (across < 0.5) & (quads.angle_between(angle[first], angle[second]) < 0.2)
    keep = np.ones(len(lines), np.bool_)
    keep[second[same]] = False
    return lines[keep]


def _pairs(lines: FloatArray, side: float) -> Stalls:
    """Return the rectangles between parallel lines that lie a stall's width apart and side by side."""
    middle = (lines[:, :2] + lines[:, 2:]) / 2
    along = lines[:, 2:] - lines[:, :2]
    angle, length = np.arctan2(along[:, 1], along[:, 0]), np.hypot(*along.T)
    i, j = quads.near_pairs(middle, middle, (_PITCH_M[1] + _SHIFT_M) / side)
    between = middle[j] - middle[i]
    apart = np.abs(quads.cross(angle[i], between)) * side
    shift = np.abs(between[:, 0] * np.cos(angle[i]) + between[:, 1] * np.sin(angle[i])) * side
    turn = quads.angle_between(angle[i], angle[j])
    fits = (i < j) & (apart > _PITCH_M[0]) & (apart < _PITCH_M[1]) & (shift < _SHIFT_M) & (turn < _PARALLEL)
    i, j, apart, turn = i[fits], j[fits], apart[fits], turn[fits]
    long = np.maximum(length[i], length[j])
    centre = (middle[i] + middle[j]) / 2
    score = _SCORE * (1 - turn / _PARALLEL / 4) * np.minimum(length[i], length[j]) / np.maximum(long, 1e-9)
    return Stalls(centre[:, 0], centre[:, 1], angle[i], apart / side, long, score)


def _taken(grey: NDArray[Any], stalls: Stalls) -> FloatArray:
    """Return the probability (N,) of being taken from the contrast within each stall's inner part."""
    if not len(stalls):
        return np.zeros(0)
    inner = np.abs(decode.sample_grid()).max(axis=1) <= CORE_SHARE / 2
    values = decode.sample(grey, decode.sample_points(stalls)[:, inner]).astype(np.float64)
    return np.asarray(1 / (1 + np.exp(-(values.std(axis=1) - _BUSY) / 4)))


def _rasters(
    stalls: Stalls, taken: FloatArray, cells: GroundImage
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Return core, lot and car maps drawn from the stalls; 0.5 where nothing can be said."""
    size = cells.valid.shape
    core, stall, car = (np.zeros(size, np.uint8) for _ in range(3))
    corners = stalls.corners() / CELL_PIXELS
    middle = corners.mean(axis=1, keepdims=True) if len(stalls) else corners
    for picture, which in ((core, slice(None)), (stall, slice(None)), (car, taken > 0.5)):
        share = 1.0 if picture is stall else CORE_SHARE
        inner = (middle + (corners - middle) * share)[which]
        cv2.fillPoly(picture, list(np.rint(inner).astype(np.int32)), (255,))
    reach = round(_REACH_M / cells.metres_per_pixel)
    near = cv2.dilate(stall, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1,) * 2)) > 0
    lot = np.where(stall > 0, 0.9, np.where(near, 0.65, 0.5)).astype(np.float32)
    return (core > 0) * np.float32(_SCORE), lot, (car > 0) * np.float32(0.7)
