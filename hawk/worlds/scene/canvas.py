"""A float raster over a rectangle of ground, and how shapes are drawn on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Bytes = NDArray[np.uint8]
Points = NDArray[np.float64]

_SHIFT = 4  # fractional bits of polygon corners
_SMALL_PX = 20000  # shapes in a box up to this size get smooth edges


@dataclass(frozen=True, slots=True)
class Patch:
    """A mask (0..1, float32) over the part of a canvas that a shape touches."""

    rows: slice
    columns: slice
    mask: Floats


class Canvas:
    """A BGR float32 picture (0..255) of the ground from ``(x0, y0)`` metres on.

    Ground frame: x east, y south, metres. Pixel (column c, row r) covers [c, c + 1) x [r, r + 1) pixels, so the
    centre of pixel (0, 0) is half a pixel inside the corner.
    """

    def __init__(self, x0: float, y0: float, width: int, height: int, metres_per_pixel: float) -> None:
        self.origin = np.array([x0, y0], dtype=np.float64)
        self.width = width
        self.height = height
        self.metres_per_pixel = metres_per_pixel
        self.image: Floats = np.zeros((height, width, 3), np.float32)

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Return (x0, y0, x1, y1) in metres."""
        x0, y0 = self.origin
        return x0, y0, x0 + self.width * self.metres_per_pixel, y0 + self.height * self.metres_per_pixel

    def to_px(self, points: Points) -> Points:
        """Turn (..., 2) ground metres into pixel coordinates where pixel centres are whole numbers."""
        pixels: Points = (np.asarray(points, np.float64) - self.origin) / self.metres_per_pixel - 0.5
        return pixels

    def touches(self, points: Points, margin: float = 0.0) -> bool:
        """Return True when the bounding box of the points, grown by ``margin`` metres, meets the canvas."""
        x0, y0, x1, y1 = self.box
        low, high = points.min(0), points.max(0)
        return bool(high[0] > x0 - margin and low[0] < x1 + margin and high[1] > y0 - margin and low[1] < y1 + margin)

    def patch(self, polygon: Points, *, soften: float = 0.0, round_m: float = 0.0) -> Patch | None:
        """Rasterise a polygon (metres); ``soften`` blurs its edge, ``round_m`` rounds its corners (both metres)."""
        reach = int(np.ceil((2.5 * soften + round_m) / self.metres_per_pixel))
        roi = self._roi(polygon, reach + 1)
        if roi is None:
            return None
        rows, columns = roi
        height, width = rows.stop - rows.start, columns.stop - columns.start
        corners = self.to_px(polygon) - (columns.start, rows.start)
        fine = 4 if height * width < _SMALL_PX else 1
        mask = np.zeros((height * fine, width * fine), np.uint8)
        cv2.fillPoly(mask, [_fixed((corners + 0.5) * fine - 0.5)], 255, cv2.LINE_8, _SHIFT)
        if fine > 1:
            mask = as_bytes(cv2.resize(mask, (width, height), interpolation=cv2.INTER_AREA))
        return Patch(rows, columns, self._softened(mask, soften, round_m))

    def strip(self, points: Points, width: float, *, soften: float = 0.0) -> Patch | None:
        """Rasterise a polyline of ``width`` metres."""
        thick = width / self.metres_per_pixel
        roi = self._roi(points, int(np.ceil(thick + 2.5 * soften / self.metres_per_pixel)) + 2)
        if roi is None:
            return None
        rows, columns = roi
        mask = np.zeros((rows.stop - rows.start, columns.stop - columns.start), np.uint8)
        corners = self.to_px(points) - (columns.start, rows.start)
        value = 255 if thick >= 1 else int(255 * max(0.15, thick))
        cv2.polylines(mask, [_fixed(corners)], False, value, max(1, round(thick)), cv2.LINE_AA, _SHIFT)
        return Patch(rows, columns, self._softened(mask, soften, 0.0))

    def cover(self, patch: Patch | None, texture: Floats | Sequence[float], strength: float = 1.0) -> None:
        """Blend a texture of the patch's size, or one colour, over the patch; nothing for None."""
        if patch is None:
            return
        target = self.image[patch.rows, patch.columns]
        alpha, over = patch.mask * np.float32(strength), np.asarray(texture, np.float32)
        for channel in range(3):  # several times as quick as all three at once
            part = target[..., channel]
            part += (over[..., channel] - part) * alpha

    def gain(self, patch: Patch | None, gain: float | Sequence[float]) -> None:
        """Multiply the patch by a gain (one number, or one for each of B, G and R); nothing for None."""
        if patch is None:
            return
        target = self.image[patch.rows, patch.columns]
        change = np.broadcast_to(np.asarray(gain, np.float32) - 1, 3)
        for channel in range(3):
            target[..., channel] *= 1 + patch.mask * change[channel]

    def _roi(self, points: Points, reach: int) -> tuple[slice, slice] | None:
        pixels = self.to_px(points)
        x0, y0 = np.floor(pixels.min(0)).astype(int) - reach
        x1, y1 = np.ceil(pixels.max(0)).astype(int) + reach + 1
        x0, y0, x1, y1 = max(x0, 0), max(y0, 0), min(x1, self.width), min(y1, self.height)
        return None if x1 <= x0 or y1 <= y0 else (slice(int(y0), int(y1)), slice(int(x0), int(x1)))

    def _softened(self, mask: Bytes, soften: float, round_m: float) -> Floats:
        values = as_floats(mask.astype(np.float32) / 255)
        if round_m > self.metres_per_pixel:
            blurred = cv2.GaussianBlur(values, (0, 0), round_m / self.metres_per_pixel / 2)
            values = as_floats(np.clip((blurred - 0.5) * 4 + 0.5, 0, 1))
        if soften > 0.3 * self.metres_per_pixel:
            values = np.asarray(cv2.GaussianBlur(values, (0, 0), soften / self.metres_per_pixel), np.float32)
        return values


def noise(
    rng: np.random.Generator, height: int, width: int, cells: Sequence[float], weights: Sequence[float]
) -> Floats:
    """Return smooth noise (height, width): a sum of octaves, each with its cell size in pixels and its deviation."""
    total = np.zeros((height, width), np.float32)
    for cell, weight in zip(cells, weights, strict=True):
        if cell < 1.3:
            total += rng.standard_normal((height, width), np.float32) * np.float32(weight)
            continue
        coarse = rng.standard_normal((int(height / cell) + 3, int(width / cell) + 3), np.float32) * np.float32(weight)
        size = (int(coarse.shape[1] * cell) + 1, int(coarse.shape[0] * cell) + 1)
        fine = cv2.resize(coarse, size, interpolation=cv2.INTER_CUBIC if cell > 3 else cv2.INTER_LINEAR)
        total += fine[:height, :width]
    return total


def as_bytes(values: NDArray[Any]) -> Bytes:
    """Return the values as uint8: OpenCV's own types do not name it."""
    return np.asarray(values, np.uint8)


def as_floats(values: NDArray[Any]) -> Floats:
    """Return the values as float32: OpenCV's own types do not name it."""
    return np.asarray(values, np.float32)


def _fixed(points: Points) -> NDArray[np.int32]:
    return np.round(np.clip(points, -30000, 30000) * (1 << _SHIFT)).astype(np.int32)
