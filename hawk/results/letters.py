"""Words in pictures, in the letters of any language: the font "sans" that OpenCV 5 brings along."""

from __future__ import annotations

from typing import Final, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Colour = tuple[int, int, int]
_FONT: Final = "sans"
_REGULAR: Final = 400
_NO_WRAP: Final = (0, 1_000_000)
"""Columns within which words stay in one line: OpenCV wraps them at the picture's edge."""
_HALO: Final = tuple((x, y) for x in (-2, 0, 2) for y in (-2, 0, 2) if x or y)


def write(
    picture: Picture,
    text: str,
    at: tuple[float, float],
    size: int,
    colour: Colour,
    *,
    anchor: Literal["left", "middle", "right"] = "left",
    halo: Colour | None = None,
) -> None:
    """Write a line of text into a picture (H, W, 3), BGR.

    ``at``: column and row of the left end, the middle or the right end of its base line, pixels; ``size``: that of the
    font, pixels. ``halo``: colour of an edge of 2 pixels around the letters.
    """
    font = cv2.FontFace(_FONT)
    left = round(at[0] - {"left": 0.0, "middle": 0.5, "right": 1.0}[anchor] * width_of(text, size))
    base = round(at[1])
    if halo is not None:
        for x, y in _HALO:
            cv2.putText(picture, text, (left + x, base + y), halo, font, size, _REGULAR, wrap=_NO_WRAP)
    cv2.putText(picture, text, (left, base), colour, font, size, _REGULAR, wrap=_NO_WRAP)


def width_of(text: str, size: int) -> int:
    """Return the width of a line of text, pixels."""
    *_, wide, _ = cv2.getTextSize((0, 0), text, (0, 0), cv2.FontFace(_FONT), size, _REGULAR, wrap=_NO_WRAP)
    return int(wide)
