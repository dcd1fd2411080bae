"""Strokes of paint: pixels that stand out from the ground in a colour of paint, and the strokes that they form.

The picture is turned so that strokes of one direction stand upright, and their ridges are followed. Lengths are metres,
``side`` is that of a pixel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.seen import FloatArray

Map = NDArray[np.float32]

_STROKE_M = 0.7
_GRAIN = 3.0
_MOST = np.float32(3.0)
_SURROUNDINGS_M = 3.0
_EDGE_M = 0.5
_TENSOR_M = 0.4
_MOST_DIRECTIONS = 4
_LEAST_SHARE = 0.2
_APART_DEGREES = 9
_FLANK_M = 0.3
_CAP = 1.0
_MEAN_M = 1.4
_APART_M = 0.5
_LEAST = 0.22
_BRIDGE_M = 1.0
_LENGTH_M = (1.8, 40.0)
_WIDEST_M = 1.1
_SLACK_M = 0.15


def paint_map(image: NDArray[np.uint8], valid: NDArray[np.bool_], side: float) -> Map:
    """Return how much each pixel (H, W) stands out as a stroke of white, yellow or blue paint would.

    The top-hat of lightness and of both ends of Lab's b axis, in units of what is usual around the pixel, so that worn
    paint on smooth ground has the value of fresh paint on rough ground.
    """
    lightness, _, b = cv2.split(cv2.cvtColor(image, cv2.COLOR_BGR2LAB))
    size = 2 * round(_STROKE_M / side / 2) + 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    hats = [cv2.morphologyEx(c, cv2.MORPH_TOPHAT, kernel) for c in (lightness, b, cv2.bitwise_not(b))]
    hat = cv2.max(hats[0], cv2.max(hats[1], hats[2])).astype(np.float32)
    hat[eroded(valid, _EDGE_M / side) == 0] = 0
    around = cv2.blur(hat, (2 * round(_SURROUNDINGS_M / side) + 1,) * 2)
    return np.asarray(hat / (_GRAIN + around), np.float32)


def directions(paint: Map, side: float) -> list[float]:
    """Return the directions, radians [0, pi), in which most strokes run (atan2 of row over column), strongest first.

    The strongest one's perpendicular is always among them: rows along a lot's sides stand across those in its middle.
    """
    sigma = _TENSOR_M / side
    soft = cv2.GaussianBlur(np.minimum(paint, _MOST), (0, 0), 1.0)
    gx, gy = cv2.Sobel(soft, cv2.CV_32F, 1, 0), cv2.Sobel(soft, cv2.CV_32F, 0, 1)
    xx, yy, xy = (cv2.GaussianBlur(v, (0, 0), sigma)[::2, ::2] for v in (gx * gx, gy * gy, gx * gy))
    apart = np.hypot(xx - yy, 2 * xy)
    coherence = apart / (xx + yy + 1e-2)
    degrees = np.rad2deg(0.5 * np.arctan2(2 * xy, xx - yy)) + 90
    share = np.histogram(degrees % 180, 180, (0, 180), weights=np.sqrt(apart) * coherence**4)[0]
    return _peaks(share)


def eroded(valid: NDArray[np.bool_], pixels: float) -> NDArray[np.uint8]:
    """Return the mask without what lies within ``pixels`` of ground that is not seen (the picture's border is)."""
    kernel = np.ones((2 * math.ceil(pixels) + 1,) * 2, np.uint8)
    return np.asarray(cv2.erode(valid.astype(np.uint8), kernel, borderValue=(1,)), np.uint8)


def _peaks(share: FloatArray) -> list[float]:
    """Return the directions of the highest peaks of a histogram of 180 degrees."""
    offsets = np.arange(-5, 6)
    smooth = sum(np.roll(share, k) * math.exp(-(k**2) / 4) for k in offsets.tolist())
    smooth = np.asarray(smooth) - np.median(np.asarray(smooth))
    found: list[float] = []
    order = np.argsort(-smooth, kind="stable").tolist()
    across = max(((order[0] + k) % 180 for k in range(80, 101)), key=lambda degree: float(smooth[degree]))
    for degree in (order[0], across, *order[1:]):
        if len(found) == _MOST_DIRECTIONS or (len(found) > 1 and smooth[degree] <= _LEAST_SHARE * smooth.max()):
            break
        if all(abs((degree - other + 90) % 180 - 90) > _APART_DEGREES for other in found):
            found.append(degree)
    return [math.radians(degree + 0.5) for degree in found]


@dataclass(frozen=True, slots=True)
class View:
    """The picture turned so that strokes of one direction stand upright.

    ``to_picture`` (2, 3) takes (u, v, 1), the view's column and row, to the picture's. ``ridge`` (H, W), 0..1, is how
    surely an upright stroke runs through a pixel, averaged along it, the best within a hand's breadth.
    """

    to_picture: FloatArray
    side: float
    ridge: Map = field(repr=False)
    sharp: Map = field(repr=False)


@dataclass(frozen=True, slots=True)
class Strokes:
    """Upright strokes as arrays (N,), metres in the view: place ``u`` across at the middle, ends ``low`` < ``high``
    along, ``slope`` (u over v) and ``strength`` 0..1.
    """

    u: FloatArray
    low: FloatArray
    high: FloatArray
    slope: FloatArray
    strength: FloatArray

    def __len__(self) -> int:
        return len(self.u)

    def __getitem__(self, which: Any) -> Strokes:
        return Strokes(*(getattr(self, f.name)[which] for f in fields(self)))


def turn(paint: Map, direction: float, side: float) -> View:
    """Return the view in which ``direction`` (radians, atan2 of row over column) is upright."""
    rows, columns = paint.shape
    c, s = math.cos(direction), math.sin(direction)
    linear = np.array([[s, c], [-c, s]])  # view (u, v) to picture (column, row): v runs along the direction
    corners = np.array([[0, 0], [columns, 0], [columns, rows], [0, rows]], float) @ linear
    first, last = corners.min(axis=0), corners.max(axis=0)
    width, height = np.ceil(last - first).astype(int) + 1
    to_picture = np.column_stack([linear, linear @ first])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    turned = cv2.warpAffine(paint, to_picture, (int(width), int(height)), flags=flags)
    sharp = _ridge(np.asarray(turned, np.float32), side)
    wide = 2 * round(_SLACK_M / side) + 1
    ridge = cv2.dilate(sharp, np.ones((1, wide), np.uint8))
    return View(to_picture, side, np.asarray(ridge, np.float32), sharp)


def _ridge(paint: Map, side: float) -> Map:
    """Return how much brighter than *both* flanks a pixel is, limited and averaged upright.

    The limit keeps one bright spot from outweighing a metre of nothing; pixels darker than both flanks are negative.
    """
    soft = cv2.GaussianBlur(paint, (3, 1), 0.8)
    flank = round(_FLANK_M / side)
    padded = cv2.copyMakeBorder(soft, 0, 0, flank, flank, cv2.BORDER_REPLICATE)
    above = soft - cv2.max(padded[:, : -2 * flank], padded[:, 2 * flank :])
    return np.asarray(cv2.blur(np.clip(above, -_CAP, _CAP), (1, 2 * round(_MEAN_M / side / 2) + 1)), np.float32)


def strokes(view: View) -> Strokes:
    """Return the upright strokes of a view."""
    side, sharp = view.side, view.sharp
    near = np.ones((1, 2 * round(_APART_M / side / 2) + 1), np.uint8)
    tops = ((sharp >= cv2.dilate(sharp, near)) & (sharp > _LEAST)).astype(np.uint8)
    wide_tops = cv2.dilate(tops, np.ones((1, 3), np.uint8))
    crest = cv2.morphologyEx(wide_tops, cv2.MORPH_CLOSE, np.ones((round(_BRIDGE_M / side), 1), np.uint8))
    count, label, stats, middle = cv2.connectedComponentsWithStats(crest, connectivity=8)
    high, wide = stats[:, cv2.CC_STAT_HEIGHT] * side, stats[:, cv2.CC_STAT_WIDTH] * side
    good = (high > _LENGTH_M[0]) & (high < _LENGTH_M[1]) & (wide < _WIDEST_M)
    good[0] = False
    rows, columns = np.nonzero(crest)
    owner = label[rows, columns]
    number = np.maximum(np.bincount(owner, minlength=count), 1)
    du, dv = columns - middle[owner, 0], rows - middle[owner, 1]
    slope = np.bincount(owner, du * dv, count) / np.maximum(np.bincount(owner, dv * dv, count), 1)
    strength = np.bincount(owner, np.maximum(sharp[rows, columns], 0), count) / number * 1.5
    top = stats[:, cv2.CC_STAT_TOP] * side
    u = np.asarray(middle[:, 0] * side, np.float64)
    found = Strokes(
        u, np.asarray(top, np.float64), np.asarray(top + high, np.float64), slope, np.minimum(strength, 1.0)
    )
    return found[good]
