"""Paint on the ground: strokes of the plan, worn by traffic and weather, buried by what is laid over them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.worlds.canvas import Bytes, Canvas, Patch, Points, as_bytes, noise
from hawk.worlds.materials import Colour
from hawk.worlds.plan import Stroke

_SHIFT = 4
_FINE_M = 0.027
"""Strokes are drawn at least this finely (metres per pixel) and averaged: OpenCV's own smoothing of edges would make
a line of one pixel more than two wide."""


@dataclass(frozen=True, slots=True)
class _Waiting:
    stroke: Stroke
    quad: Points
    low: NDArray[np.int64]
    high: NDArray[np.int64]


class Paint:
    """The strokes of a plan on a canvas: put on in order, buried by surfaces, blended into the picture at the end."""

    def __init__(self, canvas: Canvas, strokes: Sequence[Stroke]) -> None:
        self._canvas = canvas
        self._fine = max(1, math.ceil(canvas.metres_per_pixel / _FINE_M))
        self._masks: dict[int, Bytes] = {}
        self._waiting: list[_Waiting] = []
        if not strokes:
            return
        quads = canvas.to_px(np.array([stroke.polygon for stroke in strokes])) + 0.5
        low, high = np.floor(quads.min(1)).astype(int) - 1, np.ceil(quads.max(1)).astype(int) + 1
        inside = (high > 0).all(1) & (low[:, 0] < canvas.width) & (low[:, 1] < canvas.height)
        fine = _narrowed(quads * self._fine, 0.5)
        # the last stroke comes first, so that the next one is popped from the end
        self._waiting = [_Waiting(strokes[k], fine[k], low[k], high[k]) for k in np.nonzero(inside)[0][::-1].tolist()]

    def put_on(self, order: int) -> None:
        """Paint the strokes that were made when ``order`` surfaces or fewer had been laid."""
        groups: dict[int, list[_Waiting]] = {}
        while self._waiting and self._waiting[-1].stroke.order <= order:
            one = self._waiting.pop()
            groups.setdefault(one.stroke.colour, []).append(one)
        for colour, group in groups.items():
            self._put_on(colour, group)

    def _put_on(self, colour: int, group: list[_Waiting]) -> None:
        size = (self._canvas.width, self._canvas.height)
        low = np.maximum(np.min([one.low for one in group], axis=0), 0)
        high = np.minimum(np.max([one.high for one in group], axis=0), size)
        width, height = (high - low).tolist()
        sheet = np.zeros((height * self._fine, width * self._fine), np.uint8)
        for one in group:
            corners = np.round((one.quad - low * self._fine - 0.5) * (1 << _SHIFT)).astype(np.int32)
            cv2.fillConvexPoly(sheet, corners, float(255 * one.stroke.strength), cv2.LINE_8, _SHIFT)
        if colour not in self._masks:
            self._masks[colour] = np.zeros(size[::-1], np.uint8)
        target = self._masks[colour][low[1] : high[1], low[0] : high[0]]
        np.maximum(target, as_bytes(cv2.resize(sheet, (width, height), interpolation=cv2.INTER_AREA)), out=target)

    def bury(self, patch: Patch) -> None:
        """Cover what has been painted where a surface is laid."""
        for mask in self._masks.values():
            part = mask[patch.rows, patch.columns]
            if part.any():
                part[:] = as_bytes(part * (1 - patch.mask))

    def blend(self, palette: Sequence[Colour], wear: float, rng: np.random.Generator) -> None:
        """Blend everything into the picture; ``wear`` (0..1) is how patchy the paint is."""
        if not self._masks:
            return
        per_metre = 1 / self._canvas.metres_per_pixel
        cells = [6 * per_metre, 1.2 * per_metre, 0.3 * per_metre, 0.12 * per_metre]
        patchy = noise(rng, self._canvas.height, self._canvas.width, cells, [0.22, 0.15, 0.15, 0.12])
        patchy *= np.float32(0.2 + 1.3 * wear)
        patchy += 1
        np.clip(patchy, 0.1, 1.15, out=patchy)
        for number, mask in sorted(self._masks.items()):
            alpha = np.minimum(mask.astype(np.float32) * (patchy / 255), 1)[..., None]
            self._canvas.image += (np.asarray(palette[number], np.float32) - self._canvas.image) * alpha


def _narrowed(quads: Points, by: float) -> Points:
    """Move the sides of parallelograms (N, 4, 2) inwards: OpenCV fills every pixel that an edge touches."""
    first, second = quads[:, 1] - quads[:, 0], quads[:, 3] - quads[:, 0]
    area = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) + 1e-9
    shrunk = []
    for side, other in ((first, second), (second, first)):
        across = area / (np.linalg.norm(other, axis=1) + 1e-9)
        shrunk.append(side * np.clip(1 - 2 * by / across, 0.05, 1)[:, None] / 2)
    middle = quads.mean(1)
    a, b = shrunk
    return np.stack([middle - a - b, middle + a - b, middle + a + b, middle - a + b], axis=1)
