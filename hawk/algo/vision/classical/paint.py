"""Where paint may be: small things that stand out from the ground in a colour of paint, and the directions they run in.

Lengths are metres, ``side`` is that of a pixel.
"""

from __future__ import annotations

import math

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


def paint_map(image: NDArray[np.uint8], valid: NDArray[np.bool_], side: float) -> Map:
    """Return how much each pixel (H, W) stands out as a stroke of white, yellow or blue paint would.

    The top-hat of lightness and of both ends of Lab's b axis, in units of what is usual around the pixel, so that worn
    paint on smooth ground counts as fresh paint on rough ground does.
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
