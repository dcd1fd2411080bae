"""The tiles of a picture from straight above: the detector's stalls with their rows completed, the lot, suggestions.

A picture is shown to the network at 0.1 m a pixel. Places are metres from the picture's upper left corner, x to the
right and y down.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import Window
from hawk.algo.mapper.cell_classes import lot_outline
from hawk.algo.mapper.stalls import call_state
from hawk.algo.mapper.suggestions import WIDTH_M, car_boxes, length_about, on_stalls
from hawk.algo.mapper.table import STATES, UNKNOWN, published_size
from hawk.algo.rows.evidence import Ground
from hawk.algo.rows.fit import Finds
from hawk.algo.rows.lot import RowStalls, complete_rows
from hawk.algo.vision import decode, quads
from hawk.algo.vision.decode import Stalls
from hawk.algo.vision.detection import FloatArray, GroundImage
from hawk.algo.vision.detector import ALL_ENDS, Ends, StallDetector
from hawk.algo.vision.network import CELL_PIXELS, Engine, EngineChoice, NetworkMaps, StallNetwork, VehicleMaps
from hawk.algo.vision.network_file import VisionModelError, packaged_weights
from hawk.algo.vision.vehicles import vehicles_of
from hawk.model.lot_map import StallState
from hawk.picture.cars import are_shown
from hawk.picture.values import PictureError, of_model

GROUND_M: Final = 0.10
CELL_M: Final = GROUND_M * CELL_PIXELS
LOT_M: Final = 2 * CELL_M
"""Side of a cell of the found lot, metres."""
_EVERY: Final = 7
"""One pixel of this number gives the usual colour."""
_LEAST_SHOWN: Final = 0.5
"""Of a stall with a smaller share of its area in the picture nothing is said."""
_GREY: Final = 127
"""Colour of missing ground, the middle of the network's input."""
_SURE: Final = 1e-6
_TAKEN_FROM: Final = 0.5
_REACH_M: Final = 9.0
"""Between middles of places of usual size that overlap."""
_TOUCH: Final = 0.1
"""Intersection over union from which a car stands on a place that is suggested already."""
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class TileVehicles:
    """Vehicles of a picture: ``corners`` (V, 4, 2), ``probability`` and ``kind`` (V,), an index of `VEHICLE_KINDS`."""

    corners: FloatArray = field(repr=False)
    probability: FloatArray = field(repr=False)
    kind: NDArray[np.intp] = field(repr=False)

    def __len__(self) -> int:
        return len(self.probability)

    def chosen(self, which: Mask | NDArray[np.intp]) -> TileVehicles:
        """Return some of them."""
        return TileVehicles(self.corners[which], self.probability[which], self.kind[which])


@dataclass(frozen=True, slots=True)
class TileDetections:
    """Findings in a picture, metres from its upper left corner.

    ``stalls`` (N, 4, 2) may reach beyond the picture. ``taken`` and ``score`` (N,): probabilities of being taken and of
    being a stall. ``lot``: mask whose cells are ``lot_m`` metres a side. ``suggested`` (M, 4, 2): stalls that
    `are_shown` takes out, and places about cars on no stall and in no aisle, as the mapper would suggest them after
    several passes. ``vehicles``: None of a network that knows none.
    """

    stalls: FloatArray = field(repr=False)
    taken: FloatArray = field(repr=False)
    score: FloatArray = field(repr=False)
    lot: Mask = field(repr=False)
    suggested: FloatArray = field(repr=False)
    lot_m: float = LOT_M
    vehicles: TileVehicles | None = field(default=None, repr=False)

    @property
    def states(self) -> tuple[StallState, ...]:
        """States of the stalls, unknown where the probability is near a half, as the mapper calls them."""
        return states_of(self.taken)


def program_name(model: str) -> str:
    """Return the program's version with its network, of which ``model`` is the SHA-256."""
    return f"{version('hawk-drone')}, network {model[:8]}"


def states_of(taken: FloatArray) -> tuple[StallState, ...]:
    """Return the states for probabilities (N,) of being taken, by the mapper's limits for the first look."""
    sure = np.clip(taken, _SURE, 1 - _SURE)
    called = call_state(np.log(sure / (1 - sure)), np.full(len(taken), UNKNOWN, np.int64))
    return tuple(STATES[number] for number in called.tolist())


class TileDetector:
    """Detects stalls in pictures from straight above as `hawk.algo.vision.detector` does, and completes their rows."""

    def __init__(self, network: StallNetwork, *, model: str = "") -> None:
        """``model``: SHA-256 of the network's file, which names results."""
        self._detector = StallDetector(network)
        self.model = model

    @classmethod
    def load(cls, model: Path | None = None, engine: EngineChoice = "auto") -> TileDetector:
        """Return a detector with the network at ``model``, that of the package for None; it runs in one thread.

        Raises PictureError for a network that cannot be used.
        """
        try:
            onnx = packaged_weights() if model is None else model.read_bytes()
            network = StallNetwork(onnx, "the network of the package" if model is None else str(model), engine)
        except OSError as error:
            raise PictureError(f"--model: {model} cannot be read: {error.strerror}; name an ONNX file") from error
        except VisionModelError as error:
            raise of_model(error) from error
        return cls(network, model=hashlib.sha256(onnx).hexdigest())

    @property
    def engine(self) -> Engine:
        """The engine that runs the network."""
        return self._detector.engine

    def detect(
        self,
        image: NDArray[np.uint8],
        metres_per_pixel: float | tuple[float, float],
        valid: Mask | None = None,
        ends: Ends = ALL_ENDS,
    ) -> TileDetections:
        """Return what a picture (H, W, 3), BGR, shows.

        Args:
            image: The picture.
            metres_per_pixel: Its scale; along columns and along rows where the two differ.
            valid: Pixels (H, W) that show ground; None: all do. Elsewhere nothing is found.
            ends: Sides at which the picture ends.

        Raises:
            PictureError: The network cannot be run.
        """
        is_whole = valid is None or bool(valid.all())
        own = image if valid is None or is_whole else np.where(valid[..., None], image, np.uint8(_GREY))
        colour = _usual_colour(image if valid is None or is_whole else image[valid][None])
        picture = _on_ground(at_ground_scale(own, metres_per_pixel), None if is_whole else valid)
        try:
            look = self._detector.look(picture, ends=ends, colour=colour)
        except VisionModelError as error:
            raise of_model(error) from error
        return found_in(look.maps, None if is_whole else look.shown, look.stalls)


def _on_ground(image: NDArray[np.uint8], valid: Mask | None) -> GroundImage:
    """Return a picture at `GROUND_M` a pixel in metres from its upper left corner, along its columns and rows.

    ``valid``: pixels at the picture's own scale that show ground; None: all do. A cell of the network's answer shows
    ground where most of it does.
    """
    shown = np.ones(image.shape[:2], np.bool_)
    if valid is not None:
        cells = (-(-image.shape[1] // CELL_PIXELS), -(-image.shape[0] // CELL_PIXELS))
        share = cv2.resize(valid.astype(np.float32), cells, interpolation=cv2.INTER_AREA) > 0.5
        shown = share.repeat(CELL_PIXELS, 0).repeat(CELL_PIXELS, 1)[: image.shape[0], : image.shape[1]]
    middle = GROUND_M / 2
    return GroundImage(image, np.array([[GROUND_M, 0.0, middle], [0.0, GROUND_M, middle]]), shown)


def _usual_colour(image: NDArray[np.uint8]) -> tuple[float, ...]:
    """Return the median of each channel of a picture (H, W, 3)."""
    some = image.reshape(-1, 3)[::_EVERY]
    return tuple(np.median(some, axis=0).tolist())


def at_ground_scale(image: NDArray[np.uint8], metres_per_pixel: float | tuple[float, float]) -> NDArray[np.uint8]:
    """Return a picture at `GROUND_M` a pixel; its scale may differ between columns and rows."""
    both = metres_per_pixel if isinstance(metres_per_pixel, tuple) else (metres_per_pixel, metres_per_pixel)
    fx, fy = (metres / GROUND_M for metres in both)
    if (fx < 1) != (fy < 1):  # one method cannot do both
        return resized(resized(image, fx, 1.0), 1.0, fy)
    return resized(image, fx, fy)


def resized(image: NDArray[np.uint8], fx: float, fy: float) -> NDArray[np.uint8]:
    """Return a picture larger by ``fx`` along its columns' axis and ``fy`` along its rows'; smaller below 1."""
    method = cv2.INTER_AREA if min(fx, fy) < 1 else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(image, None, fx=fx, fy=fy, interpolation=method), np.uint8)


def found_in(maps: NetworkMaps, seen: NDArray[np.float32] | None = None, votes: Stalls | None = None) -> TileDetections:
    """Return what the network's maps show, rows completed.

    ``seen``: 1 for the cells that show ground, None: all do. ``votes``: stalls that the maps vote for, None: not known.
    """
    every, probability, shown = _stalls_with_states(maps, seen, votes)
    lot, car, is_seen = maps.lot, maps.car, np.ones_like(shown)
    if seen is not None:
        is_seen = decode.sample(seen, decode.sample_points(every)).mean(axis=1) >= _LEAST_SHOWN
        lot, car = lot * seen, car * seen
    stalls, taken = every[shown & is_seen], probability[shown & is_seen]
    share = CELL_M / LOT_M
    on_lot = cv2.resize(lot, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    area = lot_outline(np.asarray(on_lot > 0.5), stalls.corners() * share, LOT_M) > 0
    if seen is not None:  # gaps that are closed may lead over missing ground
        area &= cv2.resize(seen, area.shape[::-1], interpolation=cv2.INTER_AREA) > 0.5
    return TileDetections(
        corners_of(stalls),
        taken,
        stalls.score,
        area,
        _suggested(car, stalls, every[~shown & is_seen]),
        vehicles=None if maps.vehicles is None else vehicles_in(maps.vehicles, seen),
    )


def vehicles_in(maps: VehicleMaps, seen: NDArray[np.float32] | None = None) -> TileVehicles:
    """Return the vehicles that maps show, metres from the picture's upper left corner; ``seen`` as in `found_in`."""
    found = vehicles_of(maps, CELL_M, seen)
    return TileVehicles(corners_of(found.boxes), found.probability, found.kind.astype(np.intp))


def corners_of(boxes: Stalls) -> FloatArray:
    """Return the corners (N, 4, 2) of boxes in cells, metres from the picture's upper left corner.

    Cell (c, r) is pixel (2 c, 2 r), whose centre lies half a pixel from that corner.
    """
    return np.asarray(boxes.corners() * CELL_M + GROUND_M / 2)


def stalls_of(maps: NetworkMaps, seen: NDArray[np.float32] | None = None, votes: Stalls | None = None) -> Stalls:
    """Return the stalls that the maps show, in cells, their rows completed; arguments as in `found_in`."""
    stalls, _, shown = _stalls_with_states(maps, seen, votes)
    return stalls[shown]


def _stalls_with_states(
    maps: NetworkMaps, seen: NDArray[np.float32] | None, votes: Stalls | None
) -> tuple[Stalls, FloatArray, Mask]:
    """Return stalls, the probability (N,) that each is taken, and which `are_shown` (N,): those are of `stalls_of`."""
    votes = decode.vote(maps, CELL_M, seen) if votes is None else votes
    ground = partial(ground_at, maps, seen=seen)
    rows = complete_rows(finds_of(votes), ground)
    stalls = _stalls(rows)
    taken = decode.occupancy(maps, stalls)
    return stalls, taken, are_shown(rows, taken < _TAKEN_FROM, ground)


def finds_of(stalls: Stalls) -> Finds:
    """Return stalls, given in cells, in metres."""
    centres = np.column_stack([stalls.column, stalls.row]) * CELL_M
    return Finds(centres, stalls.angle, stalls.width * CELL_M, stalls.length * CELL_M, stalls.score)


def ground_at(maps: NetworkMaps, places: FloatArray, seen: NDArray[np.float32] | None = None) -> Ground:
    """Return the maps at places (..., 2), metres; ``seen`` as in `found_in`."""
    shown = np.ones_like(maps.core) if seen is None else seen
    layers = (maps.core, maps.car, maps.lot, shown)
    return Ground(*(decode.sample(values, places / CELL_M) for values in layers))


def _suggested(car: NDArray[np.float32], stalls: Stalls, others: Stalls) -> FloatArray:
    """Return quads (M, 4, 2) of (x, y) metres: ``others``, and those about cars on none of both and in no aisle."""
    cars = car_boxes(car, Window(0, 0, car.shape[0], car.shape[1], CELL_M))
    places = np.column_stack([cars.east, -cars.north]) - (CELL_M - GROUND_M) / 2  # as in `found_in`
    angle = cars.angle - np.pi / 2
    shape = [v * CELL_M for v in (stalls.column, stalls.row, stalls.width, stalls.length)]
    known = (shape[0] + GROUND_M / 2, shape[1] + GROUND_M / 2, stalls.angle, shape[2], shape[3])
    left = ~on_stalls(places, angle, cars.length, known)
    x, y = places[left].T
    about, given = (
        quads.corners(x, y, angle[left], np.full(len(x), WIDTH_M), length_about(cars)[left]),
        corners_of(others),
    )
    i, j = quads.near_pairs(about.mean(axis=1), given.mean(axis=1), _REACH_M)
    alone = np.ones(len(about), np.bool_)
    alone[i[quads.overlap_more(about[i], given[j], _TOUCH)]] = False
    return np.concatenate([given, about[alone]])


def _stalls(rows: RowStalls) -> Stalls:
    """Return the stalls as the mapper publishes them."""
    width, length = published_size(rows.width, rows.length)
    score = 1 / (1 + np.exp(-rows.log_odds))
    return Stalls(rows.north / CELL_M, rows.east / CELL_M, rows.angle, width / CELL_M, length / CELL_M, score)
