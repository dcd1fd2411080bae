"""Paint on the ground: strokes of the plan, worn by traffic and weather."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from hawk.worlds.canvas import Bytes, Canvas, noise
from hawk.worlds.materials import Colour
from hawk.worlds.plan import Stroke

_SHIFT = 4


def draw_paint(
    canvas: Canvas, strokes: Sequence[Stroke], palette: Sequence[Colour], wear: float, rng: np.random.Generator
) -> None:
    """Paint all strokes, colour by colour; ``wear`` (0..1) is how patchy the paint is."""
    if not strokes:
        return
    quads = np.array([stroke.polygon for stroke in strokes])
    pixels = canvas.to_px(quads)
    low, high = pixels.min(1), pixels.max(1)
    inside = (high > 0).all(1) & (low[:, 0] < canvas.width) & (low[:, 1] < canvas.height)
    if not inside.any():
        return
    per_metre = 1 / canvas.metres_per_pixel
    cells = [6 * per_metre, 1.2 * per_metre, 0.3 * per_metre, 0.12 * per_metre]
    patchy = noise(rng, canvas.height, canvas.width, cells, [0.22, 0.15, 0.15, 0.12])
    patchy *= np.float32(0.2 + 1.3 * wear)
    patchy += 1
    np.clip(patchy, 0.1, 1.15, out=patchy)
    for number, colour in enumerate(palette):
        mask = _mask(canvas, strokes, pixels, inside, number)
        if mask is not None:
            alpha = np.minimum(mask.astype(np.float32) * (patchy / 255), 1)[..., None]
            canvas.image += (np.asarray(colour, np.float32) - canvas.image) * alpha


def _mask(
    canvas: Canvas,
    strokes: Sequence[Stroke],
    pixels: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
    inside: np.ndarray[tuple[int, ...], np.dtype[np.bool_]],
    number: int,
) -> Bytes | None:
    mask: Bytes | None = None
    for k in np.nonzero(inside)[0]:
        stroke = strokes[int(k)]
        if stroke.colour != number:
            continue
        if mask is None:
            mask = np.zeros((canvas.height, canvas.width), np.uint8)
        corners = np.round(np.clip(pixels[k], -30000, 30000) * (1 << _SHIFT)).astype(np.int32)
        cv2.fillConvexPoly(mask, corners, float(255 * stroke.strength), cv2.LINE_AA, _SHIFT)
    return mask
