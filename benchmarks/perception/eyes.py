"""An eye that looks at a nadir picture: the network with its votes, rows completed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Protocol

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from benchmarks.perception.places import state_array
from hawk.algo.ground import Window
from hawk.algo.mapper.shown import lot_outline
from hawk.algo.mapper.suggestions import WIDTH_M, car_boxes, length_about, on_stalls
from hawk.algo.mapper.table import published_size
from hawk.algo.rows.evidence import Ground
from hawk.algo.rows.fit import Finds, Rectangles
from hawk.algo.rows.lot import RowStalls, complete_rows
from hawk.algo.vision import decode, quads
from hawk.algo.vision.decode import Stalls
from hawk.algo.vision.network import CELL_PIXELS, Blob, NetworkMaps, StallNetwork
from hawk.algo.vision.seen import GroundImage
from hawk.model.lot_map import StallState
from hawk.survey.scoring import Finding, FloatArray

GROUND_M = 0.10
CELL_M = GROUND_M * CELL_PIXELS
LOT_M = 2 * CELL_M
"""Side of a cell of the found lot, metres by the scale that the eye was given."""
SLIVER_M2 = 2.0
"""A stall at a picture's edge with a smaller part in the picture is left out."""


@dataclass(frozen=True, slots=True)
class Result:
    """Findings in a place: stalls in metres from its upper left corner (x right, y down), the probability (N,) that
    each is taken, and the lot as a mask whose cells are ``lot_m`` metres a side. ``suggested`` are quads (M, 4, 2)
    about the cars that stand where nothing was found, as the mapper would suggest them after several passes.
    """

    finding: Finding
    taken: FloatArray = field(repr=False)
    lot: NDArray[np.bool_] = field(repr=False)
    lot_m: float = LOT_M
    suggested: FloatArray = field(default_factory=lambda: np.zeros((0, 4, 2)), repr=False)


class Eye(Protocol):
    """Looks at pictures."""

    def look(self, image: NDArray[np.uint8], metres_per_pixel: float, *, scale: float = 1.0) -> Result:
        """Return the findings. The picture is shown larger by ``scale`` than ``metres_per_pixel`` says."""
        ...


class NetworkEye:
    """The network, its votes and the rows."""

    def __init__(self, network: StallNetwork, sun: Blob | None = None) -> None:
        """``sun`` is that of `hawk.algo.vision.network.sun_input`; None where it is not known."""
        self._network = network
        self._sun = sun

    def look(self, image: NDArray[np.uint8], metres_per_pixel: float, *, scale: float = 1.0) -> Result:
        """Find stalls and lot."""
        shown = _shown(image, metres_per_pixel, scale)
        maps = self._network.run(shown, self._sun)
        stalls = stalls_of(maps)
        result = _result(stalls, decode.occupancy(maps, stalls), maps.lot, shown.shape, scale)
        return replace(result, suggested=_suggested(maps.car, stalls) / scale)

    def maps(self, image: NDArray[np.uint8], metres_per_pixel: float) -> NetworkMaps:
        """Return the network's maps of a picture."""
        return self._network.run(_shown(image, metres_per_pixel, 1.0), self._sun)


def stalls_of(maps: NetworkMaps) -> Stalls:
    """Return the stalls that the maps show, in cells, their rows completed."""
    return _stalls(complete_rows(finds_of(decode.vote(maps, CELL_M)), partial(ground_at, maps)))


def boxes_of_maps(maps: NetworkMaps) -> tuple[Rectangles, FloatArray]:
    """Return the stalls that the maps show, rows completed, and their scores (N,); metres from the picture's corner."""
    stalls = stalls_of(maps)
    centres = np.column_stack([stalls.column, stalls.row]) * CELL_M + GROUND_M / 2
    return Rectangles(centres, stalls.angle, stalls.width * CELL_M, stalls.length * CELL_M), stalls.score


def _suggested(car: NDArray[np.float32], stalls: Stalls) -> FloatArray:
    """Return quads (M, 4, 2) of (x, y) metres about the cars on no stall and in no aisle."""
    cars = car_boxes(car, Window(0, 0, car.shape[0], car.shape[1], CELL_M))
    places = np.column_stack([cars.east, -cars.north]) - (CELL_M - GROUND_M) / 2  # as in `_result`
    angle = cars.angle - np.pi / 2
    shape = [v * CELL_M for v in (stalls.column, stalls.row, stalls.width, stalls.length)]
    known = (shape[0] + GROUND_M / 2, shape[1] + GROUND_M / 2, stalls.angle, shape[2], shape[3])
    left = ~on_stalls(places, angle, cars.length, known)
    x, y = places[left].T
    return quads.corners(x, y, angle[left], np.full(len(x), WIDTH_M), length_about(cars)[left])


def north_up(image: NDArray[np.uint8], metres_per_pixel: float, *, scale: float = 1.0) -> GroundImage:
    """Return a nadir picture on the ground with north up: its (x, y) is (east, -north), metres."""
    shown = _shown(image, metres_per_pixel, scale)
    to_map = np.array([[0.0, -GROUND_M, 0.0], [GROUND_M, 0.0, 0.0]])
    return GroundImage(shown, to_map, np.ones(shown.shape[:2], np.bool_))


def _shown(image: NDArray[np.uint8], metres_per_pixel: float, scale: float) -> NDArray[np.uint8]:
    factor = metres_per_pixel / GROUND_M * scale
    method = cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(image, None, fx=factor, fy=factor, interpolation=method), np.uint8)


def _result(stalls: Stalls, taken: FloatArray, lot: NDArray[np.float32], size: tuple[int, ...], scale: float) -> Result:
    share = CELL_M / LOT_M
    probability = cv2.resize(lot, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    area = lot_outline(np.asarray(probability > 0.5), stalls.corners() * share, LOT_M) > 0
    # cell (c, r) is picture pixel (2 c, 2 r), whose centre lies half a pixel from the picture's corner
    metres = stalls.corners() * CELL_M + GROUND_M / 2
    metres, is_shown = as_shown(metres, (size[1] * GROUND_M, size[0] * GROUND_M))
    taken = taken[is_shown]
    states = [StallState.FREE if p < 0.5 else StallState.TAKEN for p in taken.tolist()]
    return Result(Finding(metres / scale, state_array(states)), taken, area, LOT_M / scale)


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


def finds_of(stalls: Stalls) -> Finds:
    """Return stalls, given in cells, in metres."""
    centres = np.column_stack([stalls.column, stalls.row]) * CELL_M
    return Finds(centres, stalls.angle, stalls.width * CELL_M, stalls.length * CELL_M, stalls.score)


def ground_at(maps: NetworkMaps, places: FloatArray) -> Ground:
    """Return the maps at places (..., 2), metres."""
    layers = (maps.core, maps.car, maps.lot, np.ones_like(maps.core))
    return Ground(*(decode.sample(values, places / CELL_M) for values in layers))


def _stalls(rows: RowStalls) -> Stalls:
    """Return the stalls as the mapper publishes them."""
    width, length = published_size(rows.width, rows.length)
    score = 1 / (1 + np.exp(-rows.log_odds))
    return Stalls(rows.north / CELL_M, rows.east / CELL_M, rows.angle, width / CELL_M, length / CELL_M, score)


def boxes(table: FloatArray) -> FloatArray:
    """Return quads (N, 4, 2) of (x, y) for rows (N, 5) of north, east, angle, width, length."""
    corners = quads.corners(*(table[:, k] for k in range(5)))
    return np.stack([corners[..., 1], -corners[..., 0]], axis=-1)
