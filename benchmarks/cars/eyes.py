"""Eyes for vehicles: the network's own vehicles, and boxes about its car channel as the reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from benchmarks.cars.scenes import CarScene
from hawk.algo.ground import Window
from hawk.algo.mapper.suggestions import car_boxes
from hawk.algo.vision import quads
from hawk.algo.vision.detection import FloatArray
from hawk.algo.vision.network import NetworkMaps, StallNetwork
from hawk.algo.vision.vehicles import Vehicles, vehicles_of
from hawk.picture.orthophoto.tile_detector import CELL_M, GROUND_M, corners_of, resized

LEAST_PROBABILITY: Final = 0.5


@dataclass(frozen=True, slots=True)
class SeenVehicles:
    """Vehicles found in a picture: ``corners`` (N, 4, 2), metres from its upper left corner, and ``probability``."""

    corners: FloatArray
    probability: FloatArray


class CarEye(Protocol):
    """Finds vehicles."""

    def find(self, scene: CarScene) -> SeenVehicles:
        """Return the vehicles of a picture."""
        ...


def maps_of(network: StallNetwork, scene: CarScene) -> NetworkMaps:
    """Return what the network says of a picture, shown at 0.1 m a pixel."""
    factor = scene.metres_per_pixel / GROUND_M
    return network.run(resized(scene.image, factor, factor))


def vehicles_in(network: StallNetwork, scene: CarScene) -> Vehicles:
    """Return the network's vehicles in a picture, in cells. Raises ValueError for a network that knows none."""
    maps = maps_of(network, scene).vehicles
    if maps is None:
        raise ValueError("--model: the network says nothing of vehicles; name one that does")
    return vehicles_of(maps, CELL_M)


class VehicleEye:
    """The vehicles of the network."""

    def __init__(self, network: StallNetwork) -> None:
        self._network = network

    def find(self, scene: CarScene) -> SeenVehicles:
        """Return the vehicles of a picture. Raises ValueError for a network that knows none."""
        found = vehicles_in(self._network, scene)
        return SeenVehicles(corners_of(found.boxes), found.probability)


class ChannelEye:
    """Boxes about the connected parts of the car channel, as suggested stalls are made of them."""

    def __init__(self, network: StallNetwork) -> None:
        self._network = network

    def find(self, scene: CarScene) -> SeenVehicles:
        """Return the boxes of whole cars."""
        car = maps_of(self._network, scene).car
        boxes = car_boxes(car.astype(np.float64), Window(0, 0, car.shape[0], car.shape[1], CELL_M))
        corners = quads.corners(boxes.north, boxes.east, boxes.angle, boxes.width, boxes.length)
        places = np.stack([corners[..., 1], -corners[..., 0]], axis=-1)
        return SeenVehicles(places, np.ones(len(boxes)))
