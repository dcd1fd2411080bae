"""Vehicles of one picture: where they stand, how large they are and of what kind, by the network's own channels.

A vehicle is an object beside the stalls. It is found by its core, so that cars bumper to bumper stay apart; its box is
the body on the ground, without its shadow.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from hawk.algo.vision.decode import Stalls, VoteRules, sample, sample_points, vote
from hawk.algo.vision.detection import FloatArray, GroundImage, Vehicle
from hawk.algo.vision.network import VEHICLE_CELLS, VEHICLE_KINDS, MapArray, VehicleMaps

VEHICLE_RULES: Final = VoteRules(
    width_m=(1.2, 3.4),
    length_m=(2.2, 20.0),
    beyond=10,
    core_limit=0.2,
    peak_limit=0.15,
    sigma=1.0,
    reach=3.0,
    core_of=(0.0, 1.0),
    is_size_voted=True,
    least_voters=3,
    apart=3,
)
"""From a small car to a lorry with a trailer, of which seven tenths may lie beyond the picture."""
PROBABILITY_WEIGHTS: Final = np.array([1.75, 0.95])
"""Constant and weight of the log-odds of a score, by ``python -m training.vehicles`` over regions left out."""
_LEAST, _MOST = 1e-3, 1 - 1e-3


@dataclass(frozen=True, slots=True)
class Vehicles:
    """Vehicles of one look as arrays of length N: ``boxes`` in cells, ``probability`` and ``kind``, an index of
    `VEHICLE_KINDS`.
    """

    boxes: Stalls
    probability: FloatArray
    kind: FloatArray

    def __len__(self) -> int:
        return len(self.boxes)

    def on_ground(self, ground: GroundImage) -> tuple[Vehicle, ...]:
        """Return the vehicles, given in cells of the raster ``ground``, in metres of the map."""
        if not len(self):
            return ()
        boxes, side = self.boxes, ground.metres_per_pixel
        visible = sample(ground.valid, sample_points(boxes)).mean(axis=1)
        table = np.column_stack([
            ground.map_points(np.stack([boxes.column, boxes.row], -1)),
            ground.map_angle(boxes.angle),
            boxes.width * side,
            boxes.length * side,
            self.probability,
            visible,
        ])  # fmt: skip
        kinds = (VEHICLE_KINDS[int(kind)] for kind in self.kind)
        return tuple(Vehicle(kind, *row) for row, kind in zip(table.tolist(), kinds, strict=True))


def vehicles_of(maps: VehicleMaps, cell_m: float, shown: MapArray | None = None) -> Vehicles:
    """Return the vehicles that the maps show; ``cell_m`` and ``shown`` as of `hawk.algo.vision.decode.vote`, in cells
    of `hawk.algo.vision.network.NetworkMaps`.
    """
    step = VEHICLE_CELLS
    boxes = vote(maps, step * cell_m, None if shown is None else shown[::step, ::step], VEHICLE_RULES)
    if not len(boxes):
        return Vehicles(boxes, np.zeros(0), np.zeros(0))
    said = sample(maps.kinds, sample_points(boxes)).mean(axis=-1)
    column, row = (step * each + (step - 1) / 2 for each in (boxes.column, boxes.row))
    boxes = replace(boxes, column=column, row=row, width=step * boxes.width, length=step * boxes.length)
    return Vehicles(boxes, probability_of(boxes.score), said.argmax(axis=0).astype(np.float64))


def probability_of(score: FloatArray) -> FloatArray:
    """Return the probability (N,) that finds of these scores are vehicles, by a logistic regression."""
    return np.asarray(1 / (1 + np.exp(-(PROBABILITY_WEIGHTS[0] + PROBABILITY_WEIGHTS[1] * log_odds_of(score)))))


def log_odds_of(score: FloatArray) -> FloatArray:
    """Return the log-odds (N,) of scores (0..1), kept from what is certain."""
    kept = np.clip(score, _LEAST, _MOST)
    return np.asarray(np.log(kept / (1 - kept)))
