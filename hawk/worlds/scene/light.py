"""The sun, the shadows that things cast on the ground, and lamp light."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from hawk.worlds.scene.canvas import Bytes, Canvas, Floats, Patch, Points, as_floats
from hawk.worlds.scene.facets import HeightLayer

_COARSE_M = 0.5
LOW_SUN_SHARE = 0.25
"""Share of the suns that stand low, where any sun is possible."""
_LOW_SUN = (8.0, 20.0)
"""Height of a low sun above the horizon, degrees."""
LOW_REACH = 2.5
"""Metres of shadow per metre of height from which a sun counts as low: 22 degrees above the horizon."""
SKY = (0.8, 0.7)
"""Blue that shade gains and red that it loses per unit of the sky's coldness, relative to green. In real lots blue by
green is 1.32 and red by green 0.72 of lit ground (measured over the places of docs/model-card.md): a coldness of
0.4."""
_CROWN_STAMPS = (0.45, 0.65, 0.85)
_MOST_STAMPS = 14


@dataclass(frozen=True, slots=True)
class Sun:
    """``shadow``: (x, y) metres of shadow per metre of height; ``gain``: share of B, G, R left in it."""

    shadow: tuple[float, float]
    gain: tuple[float, float, float]
    soften: float

    @property
    def reach(self) -> float:
        """Metres of shadow per metre of height."""
        return math.hypot(*self.shadow)

    @property
    def is_low(self) -> bool:
        """True for a sun whose shadows are long."""
        return self.reach > LOW_REACH

    def cast(self, height: float) -> Points:
        """Return the shadow's offset (metres) for a height."""
        return np.array(self.shadow) * height


def sample_sun(rng: np.random.Generator, *, calm: bool = False) -> Sun:
    """Draw a sun; ``calm`` leaves out very low and hidden suns."""
    direction = rng.uniform(0, 2 * math.pi)
    reach = rng.uniform(0.35, 1.1) if calm else float(rng.choice([rng.uniform(0.1, 0.7), rng.uniform(0.5, 1.8)]))
    left = rng.uniform(0.3, 0.62) if calm else rng.uniform(0.2, 0.75)
    if not calm and rng.random() < LOW_SUN_SHARE:
        reach, left = 1 / math.tan(math.radians(rng.uniform(*_LOW_SUN))), rng.uniform(0.26, 0.55)
    if not calm and rng.random() < 0.12:  # overcast
        left, reach = rng.uniform(0.8, 0.97), min(reach * 0.5, 1.0)
    return Sun(
        (math.cos(direction) * reach, math.sin(direction) * reach),
        shade_gain(left, rng.uniform(0.25, 0.55) if calm else rng.uniform(0.05, 0.6)),
        rng.uniform(0.04, 0.13),
    )


def shade_gain(left: float, cold: float) -> tuple[float, float, float]:
    """Return the share of blue, green and red that shade leaves, of which ``left`` of green, under a ``cold`` sky."""
    return min(1.0, left * (1 + SKY[0] * cold)), left, left * (1 - SKY[1] * cold)


class Shadows:
    """Shadow on the ground, 0..1: ``low`` of cars and posts, ``tall`` of trees and buildings (also on cars)."""

    def __init__(self, canvas: Canvas, sun: Sun) -> None:
        self._canvas = canvas
        self._sun = sun
        self.low: Floats = np.zeros((canvas.height, canvas.width), np.float32)
        self.tall: Floats = np.zeros((canvas.height, canvas.width), np.float32)

    def add_block(self, footprint: Points, height: float, *, tall: bool = False) -> None:
        """Add the shadow of a block that stands on its footprint (convex, metres)."""
        swept = np.concatenate([footprint, footprint + self._sun.cast(height)]).astype(np.float32)
        hull = cv2.convexHull(swept)[:, 0].astype(np.float64)
        self._add(self._canvas.patch(hull), self.tall if tall else self.low)

    def add_pole(self, x: float, y: float, height: float, width: float) -> None:
        """Add the shadow of a thin pole."""
        foot = np.array([x, y])
        self._add(self._canvas.strip(np.array([foot, foot + self._sun.cast(height)]), width), self.low)

    def add_crown(self, x: float, y: float, radius: float, height: float, crown: Bytes) -> None:
        """Add the shadow of a crown, whose square alpha is 2 x radius wide, and of its trunk."""
        shares: Sequence[float] = _CROWN_STAMPS
        if self._sun.is_low:
            span = (_CROWN_STAMPS[-1] - _CROWN_STAMPS[0]) * height * self._sun.reach
            shares = np.linspace(0.4, 0.95, min(_MOST_STAMPS, math.ceil(span / (0.7 * radius)) + 1)).tolist()
        for share in shares:
            centre = np.array([x, y]) + self._sun.cast(height * share)
            self._stamp(centre, radius * (1.1 - 0.3 * abs(share - 0.6)), crown)
        self.add_pole(x, y, height * 0.5, 0.25)

    def apply(self, *, rng: np.random.Generator) -> Floats:
        """Darken the canvas; return the depth of the shadow, 0..1."""
        sigma = self._sun.soften / self._canvas.metres_per_pixel
        both = np.maximum(self.low, self.tall)
        if sigma > 0.25:
            both = np.asarray(cv2.GaussianBlur(both, (0, 0), sigma), np.float32)
        both *= np.float32(rng.uniform(0.94, 1.0))
        lost = 1 - np.array(self._sun.gain, np.float32)
        for channel in range(3):
            self._canvas.image[..., channel] *= 1 - both * lost[channel]
        return both

    def shade_at(self, points: Points, height: float = 0.0) -> Floats:
        """Return the gain (N, 3) that tall things' shadows leave at points (metres) above the ground.

        ``height`` counts under a low sun only: there the ray to the sun leaves the ground far beside the point.
        """
        if self._sun.is_low:
            points = points + self._sun.cast(height)
        pixels = np.round(self._canvas.to_px(points)).astype(int)
        columns = np.clip(pixels[..., 0], 0, self._canvas.width - 1)
        rows = np.clip(pixels[..., 1], 0, self._canvas.height - 1)
        lost = 1 - np.array(self._sun.gain, np.float32)
        shade: Floats = 1 - self.tall[rows, columns][..., None] * lost
        return shade

    @staticmethod
    def _add(patch: Patch | None, shadow: Floats) -> None:
        if patch is not None:
            target = shadow[patch.rows, patch.columns]
            np.maximum(target, patch.mask, out=target)

    def _stamp(self, centre: Points, radius: float, crown: Bytes) -> None:
        size = max(2, round(2 * radius / self._canvas.metres_per_pixel))
        column, row = np.round(self._canvas.to_px(centre) - size / 2).astype(int)
        x0, y0 = max(0, column), max(0, row)
        x1, y1 = min(self._canvas.width, column + size), min(self._canvas.height, row + size)
        if x1 <= x0 or y1 <= y0:
            return
        stamp = cv2.resize(crown, (size, size), interpolation=cv2.INTER_AREA)[
            y0 - row : y1 - row, x0 - column : x1 - column
        ]
        target = self.tall[y0:y1, x0:x1]
        np.maximum(target, stamp.astype(np.float32) / 255, out=target)


@dataclass(frozen=True, slots=True)
class LampLight:
    """Light without a sun: ``ambient`` (blue, green, red; 1 is day), and lamps (N, 3): x, y, height, metres, each of
    ``colour`` and ``strength`` (what it adds on the ground below it).
    """

    ambient: tuple[float, float, float]
    lamps: Points
    colour: tuple[float, float, float]
    strength: float

    def at(self, points: Points) -> Floats:
        """Return the gain (..., 3) at ground points (..., 2), metres: lamps fall off as the light of a point source
        over a plane does, (1 + d^2 / h^2)^-3/2.
        """
        gain = np.zeros((*points.shape[:-1], 1))
        for x, y, height in self.lamps.tolist():
            away = ((points - (x, y)) ** 2).sum(-1, keepdims=True) / height**2
            gain += (1 + away) ** -1.5
        return as_floats(np.array(self.ambient) + gain * self.strength * np.array(self.colour))

    def light(self, canvas: Canvas) -> None:
        """Light a canvas's picture."""
        x0, y0, x1, y1 = canvas.box
        columns = np.linspace(x0, x1, max(2, round((x1 - x0) / _COARSE_M)))
        rows = np.linspace(y0, y1, max(2, round((y1 - y0) / _COARSE_M)))
        coarse = self.at(np.stack(np.meshgrid(columns, rows), -1))
        canvas.image *= as_floats(cv2.resize(coarse, (canvas.width, canvas.height), interpolation=cv2.INTER_LINEAR))

    def light_layers(self, layers: Sequence[HeightLayer]) -> list[HeightLayer]:
        """Return layers as the lamps show them, each by the light at its middle."""
        return [replace(layer, pixels=self._lit(layer)) for layer in layers]

    def _lit(self, layer: HeightLayer) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
        pixels = layer.pixels.copy()
        gain = self.at(layer.corners[:, :2].mean(0))
        pixels[..., :3] = np.clip(pixels[..., :3] * gain, 0, 255).astype(np.uint8)
        return pixels
