"""Finds stalls without a network: paint, strokes, rows of strokes, the bays between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision import decode, quads
from hawk.algo.vision.classical import ground as ground_of
from hawk.algo.vision.classical.bays import bays_of, joined, scores
from hawk.algo.vision.classical.core import core_map
from hawk.algo.vision.classical.lattice import rows_of
from hawk.algo.vision.classical.paint import directions, paint_map
from hawk.algo.vision.classical.strokes import strokes, turn
from hawk.algo.vision.decode import Stalls
from hawk.algo.vision.finder import Found
from hawk.algo.vision.network import CELL_PIXELS
from hawk.algo.vision.seen import GroundImage

_LEAST_SCORE = 0.5
_OVERLAP_LIMIT = 0.25


class ClassicalFinder:
    """Finds stalls by painted lines that stand side by side at a stall's pitch."""

    def find(self, picture: GroundImage) -> Found:
        """Return stalls between painted lines; taken where the ground between them is not bare."""
        side = picture.metres_per_pixel
        cells = decode.cell_raster(picture, picture.valid[::CELL_PIXELS, ::CELL_PIXELS])
        paint = paint_map(picture.values, picture.valid, side)
        views = [turn(paint, direction, side) for direction in directions(paint, side)]
        rows = [rows_of(strokes(view)) for view in views]
        parts = [p for view, some in zip(views, rows, strict=True) for row in some for p in bays_of(view, row)]
        bays = joined(parts)
        bays = bays[_in_sight(bays.stalls, picture)]
        within = bays.past == 0
        ground = ground_of.survey_ground(picture.values, picture.valid, bays.stalls[within], side)
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


def _in_sight(stalls: Stalls, picture: GroundImage) -> NDArray[np.bool_]:
    """Return which stalls (N,), pixels, have their middle in the valid picture."""
    return np.asarray(decode.sample(picture.valid, np.stack([stalls.column, stalls.row], -1)), np.bool_)
