"""The ground of a survey in the lot's frame: its mosaic, north up, with the stalls over it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.exports.values import ExportRecord
from hawk.lots.registration.frames import Move
from hawk.lots.registration.georeference import about
from hawk.lots.survey.pictures import drawn, extent
from hawk.lots.survey.source import SourceKind
from hawk.lots.values import LotStoreError, utc
from hawk.model.lot_map import CELL_M, StallState, TileKey
from hawk.results.map_picture import Caption, draw_stall, sheet

_AROUND_M: Final = 4.0
"""Ground about the stalls where a survey has no picture."""
_FEATHER_M: Final = 1.0
"""The picture fades over this width at its edge."""
_MARGIN: Final = 10
"""Pixels about what was seen."""
_PAPER: Final = 236
_LARGEST: Final = 16_000
"""Pixels a side; a larger lot is shown at a coarser scale."""
OCCUPANCY: Final = {"free": 1, "taken": 2, "unknown": 3}
"""Values of the raster of occupancy; 0 is no stall."""


@dataclass(frozen=True, slots=True)
class Ground:
    """A picture of ground, north up. ``image`` (H, W, 3) BGR; ``seen`` (H, W), 0 to 255; ``north`` and ``east`` of the
    upper left corner, metres in the lot's frame; ``metres`` a pixel.
    """

    image: NDArray[np.uint8] = field(repr=False)
    seen: NDArray[np.uint8] = field(repr=False)
    north: float
    east: float
    metres: float

    def pixels(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return places (N, 2) of (north, east) as (column, row)."""
        return np.column_stack([(places[:, 1] - self.east) / self.metres, (self.north - places[:, 0]) / self.metres])


def ground_of(survey: ExportRecord, tiles: Mapping[TileKey, bytes], move: Move) -> Ground:
    """Return the mosaic of a survey in the lot's frame; empty ground about the stalls where there is none.

    Args:
        survey: The survey.
        tiles: The tiles of its picture, in its own frame.
        move: Brings that frame onto the lot's.

    Raises:
        LotStoreError: A tile is no picture, or there is neither a picture nor a stall.
    """
    if not tiles:
        return _empty(survey)
    box = extent(tiles)
    try:
        shown = drawn(tiles, box)
    except ValueError as error:
        raise LotStoreError(f"the picture of survey {survey.survey} cannot be read: {error}") from error
    if shown is None:
        return _empty(survey)
    south, west, north, east = box
    corners = move.of(np.array([(south, west), (south, east), (north, west), (north, east)]))
    (low_north, low_east), (top, right) = corners.min(0), corners.max(0)
    metres, size = _size(top - low_north, right - low_east)
    three = np.array([(0.0, 0.0), (100.0, 0.0), (0.0, 100.0)], np.float32)  # (column, row) of the survey's picture
    there = move.of(np.column_stack([shown.north - three[:, 1] * CELL_M, shown.east + three[:, 0] * CELL_M]))
    onto = np.column_stack([(there[:, 1] - low_east) / metres, (top - there[:, 0]) / metres]).astype(np.float32)
    matrix = cv2.getAffineTransform(three, onto)
    image = cv2.warpAffine(shown.image, matrix, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    seen = cv2.warpAffine(shown.seen.astype(np.uint8) * 255, matrix, size, flags=cv2.INTER_NEAREST)
    whole = Ground(np.asarray(image, np.uint8), np.asarray(seen, np.uint8), float(top), float(low_east), metres)
    return _cropped(whole, corners_of(survey).reshape(-1, 2))


def _cropped(ground: Ground, stalls: NDArray[np.float64]) -> Ground:
    """Return the part about what was seen and the stalls (N, 2) that lie in the picture."""
    rows, columns = (np.flatnonzero(ground.seen.any(axis=axis)) for axis in (1, 0))
    height, width = ground.seen.shape
    at = ground.pixels(stalls)
    at = at[(at >= 0).all(1) & (at < (width, height)).all(1)]
    left, top = np.floor(np.vstack([at, [(columns[0], rows[0])]]).min(0)).astype(int) - _MARGIN
    right, bottom = np.ceil(np.vstack([at, [(columns[-1], rows[-1])]]).max(0)).astype(int) + 1 + _MARGIN
    part = slice(max(top, 0), min(bottom, height)), slice(max(left, 0), min(right, width))
    north, east = ground.north - part[0].start * ground.metres, ground.east + part[1].start * ground.metres
    return Ground(ground.image[part], ground.seen[part], north, east, ground.metres)


def _empty(survey: ExportRecord) -> Ground:
    places = corners_of(survey).reshape(-1, 2)
    if not len(places):
        raise LotStoreError(f"survey {survey.survey} has neither a picture nor a stall: there is nothing to draw")
    (south, west), (north, east) = places.min(0) - _AROUND_M, places.max(0) + _AROUND_M
    metres, (columns, rows) = _size(north - south, east - west)
    image, seen = np.zeros((rows, columns, 3), np.uint8), np.zeros((rows, columns), np.uint8)
    return Ground(image, seen, float(north), float(west), metres)


def _size(high_m: float, wide_m: float) -> tuple[float, tuple[int, int]]:
    """Return metres a pixel, and the columns and rows of ground of this extent."""
    metres = max(CELL_M, high_m / _LARGEST, wide_m / _LARGEST)
    return metres, (math.ceil(wide_m / metres), math.ceil(high_m / metres))


def corners_of(survey: ExportRecord) -> NDArray[np.float64]:
    """Return the corners of the stalls (N, 4, 2) as (north, east), metres about the survey's origin."""
    corners = np.array([stall.corners for stall in survey.stalls], np.float64).reshape(-1, 2)
    return about(survey.origin, corners)[:, :2].reshape(-1, 4, 2)


def on_paper(ground: Ground) -> NDArray[np.uint8]:
    """Return the picture (H, W, 3), BGR, of ground that fades to paper at its edge."""
    sigma = _FEATHER_M / ground.metres / 2
    soft = cv2.GaussianBlur(cv2.erode(ground.seen, _disc(sigma)), (0, 0), sigma, borderType=cv2.BORDER_CONSTANT)
    share = (np.asarray(soft, np.float32) / 255)[..., None]
    return np.asarray(ground.image * share + _PAPER * (1 - share), np.uint8)


def lot_picture(survey: ExportRecord, ground: Ground) -> NDArray[np.uint8]:
    """Return the sheet of a survey: its ground fades to paper at the edge, the stalls over it, words below."""
    picture = on_paper(ground)
    for stall, corners in zip(survey.stalls, corners_of(survey), strict=True):
        draw_stall(picture, ground.pixels(corners), StallState(stall.state))
    counts = {state: survey.count(state) for state in (StallState.FREE, StallState.TAKEN, StallState.UNKNOWN)}
    known = f"{survey.software}, survey {survey.survey[:8]}" + (", simulated" if survey.is_simulated else "")
    doubt = f" ({survey.doubt})" if survey.doubt else ""
    return sheet(picture, ground.metres, Caption(f"{survey.lot}{doubt}", (time_words(survey), known), counts))


def time_words(survey: ExportRecord) -> str:
    """Return when a survey was taken, what is not sure of that, and the pictures that it was made of.

    An orthophoto without a sure time has that of its file, which is no time of its pictures: it is not shown.
    """
    pictures, time = survey.pictures, utc(survey.ended)
    if not survey.time_is_sure:
        if pictures is None:
            time += " (the clock was not set)"
        else:
            time = "time not known" if pictures.kind is SourceKind.ORTHOPHOTO else f"{time} (time zone not known)"
    return time if pictures is None else f"{time}, from {pictures.words}"


def _disc(sigma: float) -> NDArray[np.uint8]:
    side = 2 * math.ceil(sigma) + 1
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side)), np.uint8)


def occupancy(survey: ExportRecord, ground: Ground) -> NDArray[np.uint8]:
    """Return the stalls as a raster (H, W) of the values of `OCCUPANCY` over the ground."""
    raster = np.zeros(ground.seen.shape, np.uint8)
    for stall, corners in zip(survey.stalls, corners_of(survey), strict=True):
        cv2.fillPoly(raster, [np.floor(ground.pixels(corners)).astype(np.int32)], OCCUPANCY[stall.state])
    return raster


def thinned(ground: Ground) -> Ground:
    """Return the ground without colour where nothing was seen."""
    return replace(ground, image=np.asarray(ground.image * (ground.seen > 0)[..., None], np.uint8))
