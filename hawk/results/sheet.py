"""The picture of a lot as a sheet that stands alone: below it lot and date, legend with counts, scale and north."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.model.lot_map import StallState
from hawk.results.survey_map import draw_stall

Picture = NDArray[np.uint8]
_PAPER: Final = (255, 255, 255)
_INK: Final = (40, 34, 28)
_GREY: Final = (120, 112, 104)
_FONT: Final = cv2.FONT_HERSHEY_SIMPLEX
_STRIP: Final = 96
"""Height of the strip below the picture, pixels."""
_LEAST_WIDTH: Final = 900
"""A narrower picture gets white beside it: the strip needs the room."""
_BARS_M: Final = (1, 2, 5, 10, 20, 50, 100, 200)
_BAR_SHARE: Final = 0.14
"""Greatest length of the scale bar, of the sheet's width."""
_LEGEND: Final = (StallState.FREE, StallState.TAKEN, StallState.UNKNOWN)
_BOX: Final = (22, 38)


@dataclass(frozen=True, slots=True)
class Caption:
    """Words of a sheet: a ``title``, ``lines`` below it, and the stalls by state."""

    title: str
    lines: tuple[str, ...]
    counts: Mapping[StallState, int] = field(repr=False)


def sheet(picture: Picture, metres_per_pixel: float, caption: Caption) -> Picture:
    """Return a BGR picture, north up, above its strip.

    Args:
        picture: (H, W, 3) BGR.
        metres_per_pixel: Its scale.
        caption: Words of the strip.
    """
    height, width = picture.shape[:2]
    wide = max(width, _LEAST_WIDTH)
    paper = np.full((height + _STRIP, wide, 3), _PAPER, np.uint8)
    left = (wide - width) // 2
    paper[:height, left : left + width] = picture
    strip = paper[height:]
    _write(strip, caption.title, (16, 30), 0.66, _INK)
    for number, line in enumerate(caption.lines[:2]):
        _write(strip, line, (16, 56 + 22 * number), 0.45, _GREY)
    _draw_legend(strip, caption, round(wide * 0.46))
    _draw_scale(strip, metres_per_pixel, wide)
    _draw_north(strip, (wide - 40, _STRIP // 2))
    return paper


def scale_bar_m(metres_per_pixel: float, wide: int) -> int:
    """Return the length of the scale bar of a sheet that is ``wide`` pixels: a round number of metres."""
    most = wide * _BAR_SHARE * metres_per_pixel
    return max((bar for bar in _BARS_M if bar <= most), default=_BARS_M[0])


def _write(strip: Picture, text: str, at: tuple[int, int], size: float, colour: tuple[int, int, int]) -> None:
    cv2.putText(strip, text, at, _FONT, size, colour, 1, cv2.LINE_AA)


def _draw_legend(strip: Picture, caption: Caption, left: int) -> None:
    wide, high = _BOX
    for number, state in enumerate(_LEGEND):
        x = left + number * 120
        corners = np.array([(x, 28), (x + wide, 28), (x + wide, 28 + high), (x, 28 + high)], np.float64)
        draw_stall(strip, corners, state)
        _write(strip, str(caption.counts.get(state, 0)), (x + wide + 10, 46), 0.55, _INK)
        _write(strip, state.value, (x + wide + 10, 64), 0.45, _GREY)


def _draw_scale(strip: Picture, metres_per_pixel: float, wide: int) -> None:
    metres = scale_bar_m(metres_per_pixel, wide)
    right = wide - 90
    left = right - round(metres / metres_per_pixel)
    cv2.rectangle(strip, (left, 44), (right, 49), _INK, 1)
    cv2.rectangle(strip, (left, 44), ((left + right) // 2, 49), _INK, cv2.FILLED)
    _write(strip, "0", (left - 4, 68), 0.45, _GREY)
    _write(strip, f"{metres} m", (right - 20, 68), 0.45, _GREY)


def _draw_north(strip: Picture, middle: tuple[int, int]) -> None:
    x, y = middle
    arrow = np.array([(x, y - 30), (x + 10, y + 4), (x, y - 4), (x - 10, y + 4)], np.int32)
    cv2.fillPoly(strip, [arrow], _INK, cv2.LINE_AA)
    _write(strip, "N", (x - 7, y + 28), 0.6, _INK)
