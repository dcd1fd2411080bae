"""An eye for nadir pictures: `hawk.picture.orthophoto.tile_detector`, its finds cut off at the edges as labels are."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import shapely
from numpy.typing import NDArray

from benchmarks.perception.places import state_array
from hawk.algo.rows.fit import Rectangles
from hawk.algo.vision import quads
from hawk.algo.vision.detection import GroundImage
from hawk.algo.vision.network import NetworkMaps, StallNetwork
from hawk.model.lot_map import StallState
from hawk.picture.orthophoto.tile_detector import CELL_M, GROUND_M, LOT_M, found_in, resized, stalls_of
from hawk.survey.accuracy import Finding, FloatArray

SLIVER_M2 = 2.0
"""A stall at a picture's edge with a smaller part in the picture is left out."""


@dataclass(frozen=True, slots=True)
class Result:
    """Findings in a place: stalls in metres from its upper left corner (x right, y down), the probability (N,) that
    each is taken, and the lot as a mask whose cells are ``lot_m`` metres a side. ``suggested`` are quads (M, 4, 2)
    about the cars that stand where nothing was found, as the mapper would suggest them after several passes. ``score``
    (N,): the probability that each is a stall, empty where it is not known.
    """

    finding: Finding
    taken: FloatArray = field(repr=False)
    lot: NDArray[np.bool_] = field(repr=False)
    lot_m: float = LOT_M
    suggested: FloatArray = field(default_factory=lambda: np.zeros((0, 4, 2)), repr=False)
    score: FloatArray = field(default_factory=lambda: np.zeros(0), repr=False)


class Eye(Protocol):
    """Looks at pictures."""

    def look(self, image: NDArray[np.uint8], metres_per_pixel: float, *, scale: float = 1.0) -> Result:
        """Return the findings. The picture is shown larger by ``scale`` than ``metres_per_pixel`` says."""
        ...


class NetworkEye:
    """The network, its votes and the rows."""

    def __init__(self, network: StallNetwork) -> None:
        self._network = network

    def look(self, image: NDArray[np.uint8], metres_per_pixel: float, *, scale: float = 1.0) -> Result:
        """Find stalls and lot."""
        shown = _shown(image, metres_per_pixel, scale)
        found = found_in(self._network.run(shown))
        metres, is_shown = as_shown(found.stalls, (shown.shape[1] * GROUND_M, shown.shape[0] * GROUND_M))
        taken = found.taken[is_shown]
        states = [StallState.FREE if p < 0.5 else StallState.TAKEN for p in taken.tolist()]
        finding = Finding(metres / scale, state_array(states))
        return Result(finding, taken, found.lot, LOT_M / scale, found.suggested / scale, found.score[is_shown])


def boxes_of_maps(maps: NetworkMaps) -> tuple[Rectangles, FloatArray]:
    """Return the stalls that the maps show, rows completed, and their scores (N,); metres from the picture's corner."""
    stalls = stalls_of(maps)
    centres = np.column_stack([stalls.column, stalls.row]) * CELL_M + GROUND_M / 2
    return Rectangles(centres, stalls.angle, stalls.width * CELL_M, stalls.length * CELL_M), stalls.score


def north_up(image: NDArray[np.uint8], metres_per_pixel: float) -> GroundImage:
    """Return a nadir picture on the ground with north up: its (x, y) is (east, -north), metres."""
    shown = _shown(image, metres_per_pixel, 1.0)
    to_map = np.array([[0.0, -GROUND_M, 0.0], [GROUND_M, 0.0, 0.0]])
    return GroundImage(shown, to_map, np.ones(shown.shape[:2], np.bool_))


def _shown(image: NDArray[np.uint8], metres_per_pixel: float, scale: float) -> NDArray[np.uint8]:
    factor = metres_per_pixel / GROUND_M * scale
    return resized(image, factor, factor)


def as_shown(corners: FloatArray, size: tuple[float, float]) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Cut quads (N, 4, 2) of (x, y) off at the edges of a picture [0, width] x [0, height], as labels of it are cut.

    Returns the rectangles about what is left (M, 4, 2), and which quads (N,) of those given they are: those of which
    less than `SLIVER_M2` is left are left out.
    """
    corners, is_shown = corners.copy(), np.ones(len(corners), np.bool_)
    reaches_out = ((corners < 0) | (corners > size)).any((1, 2))
    for number in np.flatnonzero(reaches_out).tolist():
        left = shapely.box(0, 0, *size).intersection(shapely.Polygon(corners[number]))
        is_shown[number] = left.area >= SLIVER_M2
        if is_shown[number]:
            corners[number] = np.array(shapely.minimum_rotated_rectangle(left).exterior.coords)[:4]
    return corners[is_shown], is_shown


def boxes(table: FloatArray) -> FloatArray:
    """Return quads (N, 4, 2) of (x, y) for rows (N, 5) of north, east, angle, width, length."""
    corners = quads.corners(*(table[:, k] for k in range(5)))
    return np.stack([corners[..., 1], -corners[..., 0]], axis=-1)
