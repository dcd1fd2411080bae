"""What finds stalls on a rectified picture: the network, or whatever else fits the protocol."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import cv2
import numpy as np

from hawk.algo.vision import decode
from hawk.algo.vision.network import CELL_PIXELS, StallNetwork
from hawk.algo.vision.seen import GroundImage, StallSeen

_EDGE_CELLS = 2


@dataclass(frozen=True, slots=True)
class Found:
    """Stalls and maps of one rectified picture; see `Seen`."""

    stalls: tuple[StallSeen, ...]
    lot: GroundImage = field(repr=False)
    car: GroundImage = field(repr=False)
    core: GroundImage = field(repr=False)


class Finder(Protocol):
    """Finds stalls."""

    def find(self, picture: GroundImage) -> Found:
        """Return what is seen on a rectified picture (uint8 BGR, 0.1 m a pixel)."""
        ...


class NetworkFinder:
    """Finds stalls by the network and its votes."""

    def __init__(self, network: StallNetwork) -> None:
        self._network = network

    def find(self, picture: GroundImage) -> Found:
        """Return what the network sees. Raises VisionModelError when the network fails."""
        maps = self._network.run(picture.values)
        valid = picture.valid[::CELL_PIXELS, ::CELL_PIXELS]
        edge = np.ones((2 * _EDGE_CELLS + 1,) * 2, np.uint8)
        shown = np.asarray(cv2.erode(valid.astype(np.float32), edge, borderValue=(1,)), np.float32)
        cells = decode.cell_raster(picture, maps.core * shown)
        stalls = decode.vote(maps, cells.metres_per_pixel, shown)
        taken = decode.occupancy(maps, stalls)
        return Found(
            stalls=decode.to_seen(stalls, taken, cells),
            lot=GroundImage(maps.lot, cells.to_map, cells.valid),
            car=GroundImage(maps.car, cells.to_map, cells.valid),
            core=cells,
        )
