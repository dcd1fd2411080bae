"""Pictures of a lot: the map, and a sheet that stands alone, with lot and date, legend, scale and north below it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.model.lot_map import Cell, StallState
from hawk.results.letters import write
from hawk.results.survey_map import SurveyMap

Picture = NDArray[np.uint8]
_CELL_COLOURS = {Cell.UNKNOWN: (235, 231, 227), Cell.NON_LOT: (205, 205, 205), Cell.LOT: (150, 150, 150)}
FREE: Final = (255, 143, 47)
_FREE_LINE = (255, 241, 227)
TAKEN: Final = (26, 122, 255)
_TAKEN_LINE = (0, 90, 224)
_PLATE = (28, 22, 16)
_PAPER: Final = (255, 255, 255)
_INK: Final = (40, 34, 28)
_GREY: Final = (120, 112, 104)
_STRIP: Final = 96
"""Height of the strip below the picture, pixels."""
_LEAST_WIDTH: Final = 900
"""A narrower picture gets white beside it: the strip needs the room."""
_BARS_M: Final = (1, 2, 5, 10, 20, 50, 100, 200)
_BAR_SHARE: Final = 0.1
"""Greatest length of the scale bar, of the sheet's width."""
_LEGEND: Final = (StallState.FREE, StallState.TAKEN, StallState.UNKNOWN)
_BOX: Final = (22, 38)
_SMALL: Final = 14
"""Size of small words, pixels."""


def map_picture(survey: SurveyMap) -> NDArray[np.uint8]:
    """Return the map as a BGR picture, north up, 10 cm a pixel: the mosaic where there is one, stalls drawn over it.

    Free is blue and plain, taken orange and hatched, unknown dark with a question mark, suggested only has corners: no
    state rests on colour alone.
    """
    mosaic, opacity, cells = survey.picture()
    colours = np.array([_CELL_COLOURS.get(cell, _CELL_COLOURS[Cell.LOT]) for cell in Cell], np.uint8)
    share = (opacity / np.float32(255)).astype(np.float32)
    picture = np.asarray(cv2.blendLinear(mosaic, colours[cells.values], share, 1 - share), np.uint8)
    for key in sorted(survey.stalls):
        draw_stall(picture, cells.to_pixels(survey.stalls[key].corners()), survey.stalls[key].state)
    return picture


def draw_stall(picture: NDArray[np.uint8], corners: NDArray[np.float64], state: StallState) -> None:
    """Draw a stall into a BGR picture by its corners (4, 2) as (column, row)."""
    pixels = corners.astype(np.int32)
    if state is StallState.SUGGESTED:
        _draw_corners(picture, pixels)
        return
    left, top = np.maximum(pixels.min(axis=0), 0)
    right, bottom = pixels.max(axis=0) + 1
    part = picture[top:bottom, left:right]
    if part.size == 0:
        return
    inside = np.zeros(part.shape[:2], np.uint8)
    cv2.fillPoly(inside, [pixels - (left, top)], 255)
    colour, line, share = {
        StallState.FREE: (FREE, _FREE_LINE, 0.46),
        StallState.TAKEN: (TAKEN, _TAKEN_LINE, 0.6),
        StallState.UNKNOWN: (_PLATE, (255, 255, 255), 0.45),
    }[state]
    tint = np.empty(part.shape, np.float32)
    tint[:] = colour
    if state is StallState.TAKEN:
        rows, columns = np.indices(inside.shape)
        tint[(rows + columns + left + top) % 9 > 4] = _PLATE
    tinted = part * (1 - share) + tint * share
    part[inside > 0] = tinted[inside > 0].astype(np.uint8)
    cv2.polylines(picture, [pixels], True, line, 1, cv2.LINE_AA)
    if state is StallState.UNKNOWN:
        centre = (int(pixels[:, 0].mean()) - 5, int(pixels[:, 1].mean()) + 5)
        cv2.putText(picture, "?", centre, cv2.FONT_HERSHEY_SIMPLEX, 0.5, (255, 255, 255), 1, cv2.LINE_AA)


def _draw_corners(picture: NDArray[np.uint8], pixels: NDArray[np.int32]) -> None:
    """Draw a quarter of each side from its ends: a suggested stall has no lines on the ground."""
    for start, end in zip(pixels, np.roll(pixels, -1, axis=0), strict=True):
        for near, far in ((start, end), (end, start)):
            cv2.line(picture, near.tolist(), (near + (far - near) // 4).tolist(), (255, 255, 255), 1, cv2.LINE_AA)


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
    write(strip, caption.title, (16, 30), 20, _INK)
    for number, line in enumerate(caption.lines[:2]):
        write(strip, line, (16, 56 + 22 * number), _SMALL, _GREY)
    _draw_legend(strip, caption, round(wide * 0.46))
    _draw_scale(strip, metres_per_pixel, wide)
    _draw_north(strip, (wide - 40, _STRIP // 2))
    return paper


def scale_bar_m(metres_per_pixel: float, wide: int) -> int:
    """Return the length of the scale bar of a sheet that is ``wide`` pixels: a round number of metres."""
    most = wide * _BAR_SHARE * metres_per_pixel
    return max((bar for bar in _BARS_M if bar <= most), default=_BARS_M[0])


def _draw_legend(strip: Picture, caption: Caption, left: int) -> None:
    wide, high = _BOX
    for number, state in enumerate(_LEGEND):
        x = left + number * 120
        corners = np.array([(x, 28), (x + wide, 28), (x + wide, 28 + high), (x, 28 + high)], np.float64)
        draw_stall(strip, corners, state)
        write(strip, str(caption.counts.get(state, 0)), (x + wide + 10, 46), 17, _INK)
        write(strip, state.value, (x + wide + 10, 64), _SMALL, _GREY)


def _draw_scale(strip: Picture, metres_per_pixel: float, wide: int) -> None:
    metres = scale_bar_m(metres_per_pixel, wide)
    right = wide - 90
    left = right - round(metres / metres_per_pixel)
    cv2.rectangle(strip, (left, 44), (right, 49), _INK, 1)
    cv2.rectangle(strip, (left, 44), ((left + right) // 2, 49), _INK, cv2.FILLED)
    write(strip, "0", (left, 68), _SMALL, _GREY, anchor="middle")
    write(strip, f"{metres} m", (right, 68), _SMALL, _GREY, anchor="middle")


def _draw_north(strip: Picture, middle: tuple[int, int]) -> None:
    x, y = middle
    arrow = np.array([(x, y - 30), (x + 10, y + 4), (x, y - 4), (x - 10, y + 4)], np.int32)
    cv2.fillPoly(strip, [arrow], _INK, cv2.LINE_AA)
    write(strip, "N", (x, y + 28), 18, _INK, anchor="middle")
