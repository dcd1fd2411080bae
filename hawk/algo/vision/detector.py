"""The detector of stalls: a picture that lies on the ground goes in, what it shows comes out, in metres on the ground.

A flight, photographs, films and the tiles of an orthophoto use it alike. What several looks show is put together
elsewhere: those of frames by the mapper (`hawk.algo.mapper`), those of a picture's tiles by
`hawk.picture.orthophoto.tile_merger`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.decode import Stalls, cell_raster, occupancy, to_seen, vote
from hawk.algo.vision.detection import Found, GroundImage, Vehicle
from hawk.algo.vision.network import CELL_PIXELS, Blob, Engine, NetworkMaps, StallNetwork, VehicleMaps, sun_input
from hawk.algo.vision.vehicles import vehicles_of

BEYOND_CELLS: Final = 16
"""Cells beyond a picture's end that the network is shown in the usual colour of its ground, 3.2 m: at an end it takes
what it was filled up with, or nothing, for more of the lot (docs/results/perception.md).
"""
_EDGE_CELLS: Final = 2
"""Cells of the network's answer about missing ground that it judges by what is not there."""
Ends = tuple[bool, bool, bool, bool]
"""Sides (left, upper, right, lower) at which a picture ends; at the others ground was cut off."""
NO_ENDS: Final[Ends] = (False, False, False, False)
ALL_ENDS: Final[Ends] = (True, True, True, True)


@dataclass(frozen=True, slots=True)
class Look:
    """One look at a picture: the network's ``maps``, and the ``stalls`` that they vote for, in cells.

    ``cells``: ``maps.core`` on the ground, 0 where the picture shows none; ``shown`` (rows, columns): 1 for the cells
    that show ground, 0 elsewhere.
    """

    maps: NetworkMaps = field(repr=False)
    shown: NDArray[np.float32] = field(repr=False)
    cells: GroundImage = field(repr=False)
    stalls: Stalls

    def detections(self) -> Found:
        """Return stalls and probabilities in metres on the ground."""
        taken, maps, cells = occupancy(self.maps, self.stalls), self.maps, self.cells
        lot, car, taken_map = (
            GroundImage(values, cells.to_map, cells.valid) for values in (maps.lot, maps.car, maps.taken)
        )
        stalls = to_seen(self.stalls, taken, cells)
        vehicles = () if maps.vehicles is None else self._vehicles(maps.vehicles)
        return Found(stalls, lot=lot, car=car, core=cells, taken=taken_map, vehicles=vehicles)

    def _vehicles(self, maps: VehicleMaps) -> tuple[Vehicle, ...]:
        return vehicles_of(maps, self.cells.metres_per_pixel, self.shown).on_ground(self.cells)


class StallDetector:
    """Detects stalls by the network and its votes."""

    def __init__(self, network: StallNetwork) -> None:
        self._network = network

    @property
    def engine(self) -> Engine:
        """The engine that runs the network."""
        return self._network.engine

    def detect(self, picture: GroundImage, shadow: tuple[float, float] | None = None) -> Found:
        """Return what a picture shows. Raises VisionModelError when the network fails.

        ``shadow`` of one metre of height, metres (north, east); None where the sun is down or not known.
        """
        return self.look(picture, shadow).detections()

    def look(
        self,
        picture: GroundImage,
        shadow: tuple[float, float] | None = None,
        ends: Ends = NO_ENDS,
        colour: tuple[float, ...] = (),
    ) -> Look:
        """Return a look at a picture. Raises VisionModelError when the network fails.

        Args:
            picture: uint8 BGR at 0.1 m a pixel.
            shadow: As of `detect`.
            ends: Sides at which the picture ends: the network is shown ``colour`` beyond them.
            colour: The usual one of the picture's ground.
        """
        sun = None if shadow is None else sun_input(picture.in_pixels(shadow))
        maps = self._run(picture.values, sun, ends, colour)
        edge = np.ones((2 * _EDGE_CELLS + 1,) * 2, np.uint8)
        valid = picture.valid[::CELL_PIXELS, ::CELL_PIXELS].astype(np.float32)
        shown = np.asarray(cv2.erode(valid, edge, borderValue=(1,)), np.float32)
        cells = cell_raster(picture, maps.core * shown)
        return Look(maps, shown, cells, vote(maps, cells.metres_per_pixel, shown))

    def _run(self, image: NDArray[np.uint8], sun: Blob | None, ends: Ends, colour: tuple[float, ...]) -> NetworkMaps:
        """Return the maps of a picture: nothing of what was shown beyond its ends is in them."""
        if not any(ends):
            return self._network.run(image, sun)
        left, top, right, bottom = (BEYOND_CELLS * CELL_PIXELS * is_end for is_end in ends)
        around = cv2.copyMakeBorder(image, top, bottom, left, right, cv2.BORDER_CONSTANT, value=colour)
        maps = self._network.run(np.asarray(around, np.uint8), sun)
        rows, columns = (-(-side // CELL_PIXELS) for side in image.shape[:2])
        first = top // CELL_PIXELS, left // CELL_PIXELS
        return maps.part(slice(first[0], first[0] + rows), slice(first[1], first[1] + columns))


@contextmanager
def one_thread() -> Iterator[None]:
    """Let OpenCV use one thread, and as many as before afterwards: its results are the same on every computer then."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)
