"""Paint on the ground: strokes of the plan, worn by traffic and weather, buried by what is laid over them."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from hawk.worlds.canvas import Bytes, Canvas, Patch, as_bytes, noise
from hawk.worlds.materials import Colour
from hawk.worlds.plan import Stroke

_SHIFT = 4


class Paint:
    """The strokes of a plan on a canvas: put on in order, buried by surfaces, blended into the picture at the end."""

    def __init__(self, canvas: Canvas, strokes: Sequence[Stroke]) -> None:
        self._canvas = canvas
        self._masks: dict[int, Bytes] = {}
        self._waiting: list[tuple[Stroke, np.ndarray[tuple[int, ...], np.dtype[np.int32]]]] = []
        if not strokes:
            return
        pixels = canvas.to_px(np.array([stroke.polygon for stroke in strokes]))
        low, high = pixels.min(1), pixels.max(1)
        inside = (high > 0).all(1) & (low[:, 0] < canvas.width) & (low[:, 1] < canvas.height)
        fixed = np.round(np.clip(pixels, -30000, 30000) * (1 << _SHIFT)).astype(np.int32)
        # the last stroke comes first, so that the next one is popped from the end
        self._waiting = [(strokes[k], fixed[k]) for k in np.nonzero(inside)[0][::-1].tolist()]

    def put_on(self, order: int) -> None:
        """Paint the strokes that were made when ``order`` surfaces or fewer had been laid."""
        while self._waiting and self._waiting[-1][0].order <= order:
            stroke, corners = self._waiting.pop()
            mask = self._masks.get(stroke.colour)
            if mask is None:
                mask = self._masks[stroke.colour] = np.zeros((self._canvas.height, self._canvas.width), np.uint8)
            cv2.fillConvexPoly(mask, corners, float(255 * stroke.strength), cv2.LINE_AA, _SHIFT)

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
