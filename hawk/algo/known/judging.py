"""States of stalls whose place is known: what one frame shows of each."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hawk.algo.rows.fit import Rectangles
from hawk.algo.vision.decode import Stalls, occupancy, sample, sample_points
from hawk.algo.vision.detection import FloatArray, Found, GroundImage
from hawk.algo.vision.network import MapArray


@dataclass(frozen=True, slots=True)
class _Layers:
    core: MapArray = field(repr=False)
    taken: MapArray = field(repr=False)
    car: MapArray = field(repr=False)


def judge(found: Found, stalls: Rectangles) -> tuple[FloatArray, FloatArray]:
    """Return the probability (N,) that each stall is taken, and the share (N,) of each that the picture shows.

    ``stalls``: metres (north, east), wherever vision found any itself.
    """
    if not len(stalls):
        return np.zeros(0), np.zeros(0)
    cells = _in_cells(stalls, found.core)
    layers = _Layers(found.core.values, found.taken.values, found.car.values)
    visible = sample(found.core.valid, sample_points(cells)).mean(axis=1)
    return occupancy(layers, cells), np.asarray(visible, np.float64)


def _in_cells(stalls: Rectangles, ground: GroundImage) -> Stalls:
    column, row = ground.pixel_points(stalls.centres).T
    along = np.column_stack([np.cos(stalls.angle), np.sin(stalls.angle)]) @ np.linalg.inv(ground.to_map[:, :2]).T
    side = ground.metres_per_pixel
    size = stalls.width / side, stalls.length / side
    return Stalls(column, row, np.arctan2(along[:, 1], along[:, 0]), *size, np.ones(len(stalls)))
