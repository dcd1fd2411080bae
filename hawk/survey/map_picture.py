"""The picture that a survey leaves behind."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.model import Cell, Stall, StallState
from hawk.survey.survey_map import Raster, SurveyMap

_CELL_COLOURS = {Cell.UNKNOWN: (235, 231, 227), Cell.NON_LOT: (205, 205, 205), Cell.LOT: (150, 150, 150)}
_FREE = (255, 143, 47)
_FREE_LINE = (255, 241, 227)
_TAKEN = (26, 122, 255)
_TAKEN_LINE = (0, 90, 224)
_PLATE = (28, 22, 16)


def map_picture(survey: SurveyMap) -> NDArray[np.uint8]:
    """Return the map as a BGR picture, north up, 10 cm a pixel: the mosaic where there is one, stalls drawn over it.

    Free is blue and plain, taken orange and hatched, unknown dark with a question mark: no state rests on colour alone.
    """
    picture, cells = survey.picture()
    for cell, colour in _CELL_COLOURS.items():
        picture[(cells.values == cell) & ~picture.any(axis=2)] = colour
    bare = np.isin(cells.values, (Cell.FREE, Cell.TAKEN)) & ~picture.any(axis=2)
    picture[bare] = _CELL_COLOURS[Cell.LOT]
    for key in sorted(survey.stalls):
        _draw(picture, cells, survey.stalls[key])
    return picture


def _draw(picture: NDArray[np.uint8], cells: Raster, stall: Stall) -> None:
    pixels = cells.to_pixels(stall.corners()).astype(np.int32)
    left, top = np.maximum(pixels.min(axis=0), 0)
    right, bottom = pixels.max(axis=0) + 1
    part = picture[top:bottom, left:right]
    if part.size == 0:
        return
    inside = np.zeros(part.shape[:2], np.uint8)
    cv2.fillPoly(inside, [pixels - (left, top)], 255)
    colour, line, share = {
        StallState.FREE: (_FREE, _FREE_LINE, 0.46),
        StallState.TAKEN: (_TAKEN, _TAKEN_LINE, 0.6),
        StallState.UNKNOWN: (_PLATE, (255, 255, 255), 0.45),
    }[stall.state]
    tint = np.empty(part.shape, np.float32)
    tint[:] = colour
    if stall.state is StallState.TAKEN:
        rows, columns = np.indices(inside.shape)
        tint[(rows + columns + left + top) % 9 > 4] = _PLATE
    tinted = part * (1 - share) + tint * share
    part[inside > 0] = tinted[inside > 0].astype(np.uint8)
    cv2.polylines(picture, [pixels], True, line, 1, cv2.LINE_AA)
    if stall.state is StallState.UNKNOWN:
        centre = (int(pixels[:, 0].mean()) - 5, int(pixels[:, 1].mean()) + 5)
        cv2.putText(picture, "?", centre, cv2.FONT_HERSHEY_SIMPLEX, 0.5, (255, 255, 255), 1, cv2.LINE_AA)
