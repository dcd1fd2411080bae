"""Strokes of paint along one direction: the picture is turned so that they stand upright, and ridges are followed."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Any

import cv2
import numpy as np

from hawk.algo.vision.classical.paint import Map
from hawk.algo.vision.seen import FloatArray

_FLANK_M = 0.3
_CAP = 1.0
_MEAN_M = 1.4
_APART_M = 0.5
_LEAST = 0.22
_BRIDGE_M = 1.0
_LENGTH_M = (1.8, 40.0)
_WIDEST_M = 1.1
_SLACK_M = 0.15


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
    along, ``slope`` (u over v) and ``strength`` 0..1."""

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

    Limited, lest one bright spot outweigh a metre of nothing; below both flanks counts against it.
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
