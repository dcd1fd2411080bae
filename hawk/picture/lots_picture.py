"""A picture of all lots of a survey: each in a colour by its share of free stalls, with its name."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.exports.values import ExportRecord
from hawk.lots.registration.georeference import about
from hawk.picture.lot_report import LotCount
from hawk.results.letters import width_of, write
from hawk.results.map_picture import FREE, TAKEN, scale_bar_m

Image = NDArray[np.uint8]
_LONGEST: Final = 1500
"""Pixels of the longer side of the ground."""
_FINEST_M: Final = 0.1
_EDGE: Final = 40
_STRIP: Final = 64
_PAPER: Final = 250
_NONE: Final = (200, 200, 200)
_INK: Final = (40, 34, 28)
_TEXT: Final = 15
"""Size of letters, pixels."""
_LINE: Final = 18
_MARGIN: Final = 4


def lots_picture(whole: ExportRecord, counts: Sequence[LotCount]) -> Image:
    """Return the lots (H, W, 3), BGR, north up: blue where all is free, orange where all is taken, grey without stalls.

    A lot in doubt has a thick edge. A name that has no room is left out; the larger lots have theirs first.
    """
    rings = [_rings(whole, each) for each in counts]
    places = np.concatenate([ring for several in rings for ring in several])
    (south, west), (north, east) = places.min(axis=0), places.max(axis=0)
    metres = max((north - south) / _LONGEST, (east - west) / _LONGEST, _FINEST_M)
    high, wide = (math.ceil(side / metres) + 2 * _EDGE for side in (north - south, east - west))
    canvas = np.full((high + _STRIP, max(wide, 640), 3), _PAPER, np.uint8)
    onto = [[_pixels(ring, (north, west), metres) for ring in several] for several in rings]
    for each, several in zip(counts, onto, strict=True):
        cv2.fillPoly(canvas, several, _colour(each), cv2.LINE_AA)
        cv2.polylines(canvas, several, True, _INK, 3 if each.survey.doubts else 1, cv2.LINE_AA)
    _write(canvas, counts, onto, _draw_bar(canvas, metres))
    return canvas


def _rings(whole: ExportRecord, count: LotCount) -> list[NDArray[np.float64]]:
    """Return the rings of a lot, (north, east) metres about the survey's origin."""
    outline = count.survey.mapped.survey.outline
    return [about(whole.origin, np.array(ring))[:, :2] for ring in (*outline.polygons, *outline.holes)]


def _pixels(ring: NDArray[np.float64], corner: tuple[float, float], metres: float) -> NDArray[np.int32]:
    north, west = corner
    places = np.column_stack([(ring[:, 1] - west) / metres, (north - ring[:, 0]) / metres]) + _EDGE
    return np.asarray(np.rint(places), np.int32)


def _colour(count: LotCount) -> tuple[int, ...]:
    record = count.survey.mapped.survey
    free, taken = record.count("free"), record.count("taken")
    if not free + taken:
        return _NONE
    share = free / (free + taken)
    return tuple(round(share * one + (1 - share) * other) for one, other in zip(FREE, TAKEN, strict=True))


def _draw_bar(canvas: Image, metres: float) -> str:
    """Draw the scale bar; return its length in words."""
    bar_m = scale_bar_m(metres, canvas.shape[1])
    right, y = canvas.shape[1] - 24, canvas.shape[0] - 20
    cv2.rectangle(canvas, (right - round(bar_m / metres), y), (right, y + 5), _INK, cv2.FILLED)
    return f"{bar_m} m"


def _counted(count: LotCount) -> str:
    """Return the free stalls of a lot in words, or the vehicles of one without stalls."""
    record, vehicles = count.survey.mapped.survey, count.survey.vehicles
    if record.stalls or vehicles is None:
        return f"{record.count('free')} of {len(record.stalls)} free"
    return f"{vehicles[0]} vehicles" + ("" if count.facts.capacity is None else f", {count.facts.capacity} places")


def _write(
    canvas: Image, counts: Sequence[LotCount], onto: Sequence[Sequence[NDArray[np.int32]]], bar: str
) -> None:  # fmt: skip
    """Write names and legend into the picture; ``bar``: length of the scale bar."""
    high, wide = canvas.shape[:2]
    used: list[tuple[float, float, float, float]] = []
    order = sorted(range(len(counts)), key=lambda k: (-cv2.contourArea(onto[k][0]), counts[k].facts.id))
    for k in order:
        lines = (counts[k].facts.name, _counted(counts[k]))
        half = max(width_of(line, _TEXT) for line in lines) / 2
        x, y = onto[k][0].mean(axis=0).tolist()
        x = min(max(x, half + _MARGIN), max(wide - half - _MARGIN, half + _MARGIN))
        left, top, right, bottom = x - half, y - _LINE, x + half, y + _LINE
        if any(left < other[2] and other[0] < right and top < other[3] and other[1] < bottom for other in used):
            continue
        used.append((left, top, right, bottom))
        for number, line in enumerate(lines):
            write(canvas, line, (x, y - 4 + number * _LINE), _TEXT, _INK, anchor="middle", halo=(255, 255, 255))
    legend = "Blue: free. Orange: taken. Grey: no stalls. Thick edge: in doubt (lots.csv). North is up."
    write(canvas, legend, (16, high - _STRIP + 26), _TEXT, _INK)
    write(canvas, bar, (wide - 24, high - _STRIP + 26), _TEXT, _INK, anchor="right")
