"""Finds stalls without a network: paint, strokes, rows of strokes, the bays between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision import decode, quads
from hawk.algo.vision.classical import ground as ground_of
from hawk.algo.vision.classical.ground import Ground
from hawk.algo.vision.classical.rows import Bays, Row, bays_of, joined, rows_of, scores
from hawk.algo.vision.classical.strokes import Map, View, directions, paint_map, strokes, turn
from hawk.algo.vision.decode import Stalls
from hawk.algo.vision.network import CELL_PIXELS, CORE_SHARE
from hawk.algo.vision.seen import Found, GroundImage

_LEAST_SCORE = 0.5
_OVERLAP_LIMIT = 0.25
_ALONG_M = 2.6
_SURE = 0.4
_BETWEEN = 0.3
_PAINT_ALONE = 0.6


class ClassicalFinder:
    """Finds stalls by painted lines that stand side by side at a stall's pitch."""

    def find(self, picture: GroundImage) -> Found:
        """Return stalls between painted lines; taken where the ground between them is not bare."""
        cells = decode.cell_raster(picture, picture.valid[::CELL_PIXELS, ::CELL_PIXELS])
        views, rows, bays, ground = survey(picture)
        taken = ground_of.taken(ground, bays.stalls)
        stalls = replace(bays.stalls, score=scores(bays, taken))
        car = ground_of.car_map(ground, cells.metres_per_pixel)
        core = core_map(views, rows, stalls, car)
        good = stalls.score >= _LEAST_SCORE
        stalls, taken = stalls[good], taken[good]
        kept = quads.suppress(stalls.corners(), stalls.score, _OVERLAP_LIMIT)
        stalls, taken = stalls[kept], taken[kept]
        lot = ground_of.lot_map(ground, stalls, cells.metres_per_pixel)
        return Found(
            stalls=decode.to_seen(stalls, taken, picture),
            lot=replace(cells, values=lot),
            car=replace(cells, values=car),
            core=replace(cells, values=core),
        )


def survey(picture: GroundImage) -> tuple[list[View], list[list[Row]], Bays, Ground]:
    """Return the views of the paint, the rows in each, all bays between their strokes, and the ground about them."""
    side = picture.metres_per_pixel
    paint = paint_map(picture.values, picture.valid, side)
    views = [turn(paint, direction, side) for direction in directions(paint, side)]
    rows = [rows_of(strokes(view)) for view in views]
    bays = joined([p for view, some in zip(views, rows, strict=True) for row in some for p in bays_of(view, row)])
    bays = bays[_in_sight(bays.stalls, picture)]
    within = bays.stalls[bays.past == 0]
    return views, rows, bays, ground_of.survey_ground(picture.values, picture.valid, within, side)


def _in_sight(stalls: Stalls, picture: GroundImage) -> NDArray[np.bool_]:
    """Return which stalls (N,), pixels, have their middle in the valid picture."""
    return np.asarray(decode.sample(picture.valid, np.stack([stalls.column, stalls.row], -1)), np.bool_)


def core_map(views: Sequence[View], rows: Sequence[Sequence[Row]], stalls: Stalls, car: Map) -> Map:
    """Return the probability (H, W), in the cells of ``car``, that a cell lies in a stall's inner part.

    ``rows`` are those of each view, ``stalls`` (pixels) the candidates with their scores.
    """
    core = _drawn(stalls, car.shape)
    for view, some in zip(views, rows, strict=True):
        if some:
            pitch = float(np.median([row.pitch for row in some]))
            core = np.maximum(core, _between_lines(view, pitch, car))
    return core


def _drawn(stalls: Stalls, shape: tuple[int, ...]) -> Map:
    """Return the inner parts of stalls, each with its score; where two meet, the surer one."""
    core = np.zeros(shape, np.float32)
    order = np.argsort(stalls.score, kind="stable")
    corners = stalls.corners()[order] / CELL_PIXELS
    middle = corners.mean(axis=1, keepdims=True)
    inner = np.rint((middle + (corners - middle) * CORE_SHARE) * 16).astype(np.int32)
    for quad, score in zip(inner, stalls.score[order].tolist(), strict=True):
        cv2.fillConvexPoly(core, quad, score, shift=4)
    return core


def _between_lines(view: View, pitch: float, car: Map) -> Map:
    """Return the dense evidence of one view at one pitch, in cells of the picture."""
    ridge = cv2.resize(view.ridge, None, fx=1 / CELL_PIXELS, fy=1 / CELL_PIXELS, interpolation=cv2.INTER_AREA)
    cell = view.side * CELL_PIXELS
    ridge = cv2.blur(np.maximum(ridge, 0), (1, 2 * round(_ALONG_M / cell / 2) + 1))
    half = round(pitch / cell / 2)
    padded = cv2.copyMakeBorder(ridge, 0, 0, half, half, cv2.BORDER_CONSTANT, value=(0,))
    left, right = padded[:, : -2 * half], padded[:, 2 * half :]
    lines = (0.7 * np.minimum(left, right) + 0.3 * np.maximum(left, right)) / _SURE
    said = np.minimum(lines, 1) * (1 - np.minimum(ridge / _BETWEEN, 1)) * np.float32(_PAINT_ALONE)
    reach = (2 * round(CORE_SHARE * pitch / cell / 2) + 1, 2 * round(_ALONG_M / cell / 4) + 1)
    said = cv2.dilate(said, np.ones(reach[::-1], np.uint8))
    to_cells = view.to_picture.copy()
    to_cells[:, 2] /= CELL_PIXELS
    size = (car.shape[1], car.shape[0])
    return np.asarray(cv2.warpAffine(said, to_cells, size, flags=cv2.INTER_LINEAR), np.float32)
