"""Labels on which a network agrees with itself over a picture that is turned, mirrored, scaled and lit otherwise.

Where the views of one picture agree, the answer is a label to train on (noisy student: Xie et al. 2020,
arXiv 1911.04252); where they differ, nothing is known. So pictures without labels serve too.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision import decode
from hawk.algo.vision.detection import FloatArray
from hawk.algo.vision.network import CELL_PIXELS, NetworkMaps, StallNetwork
from hawk.survey.accuracy import match
from training.augment import light
from training.targets import CELL_M, UNKNOWN, shape_of

SCALES: Final = (0.9, 1.1)
"""Scales of the views that are neither turned nor mirrored."""
_TURNS = 4
_SURE: Final = 0.75
"""Mean probability from which a label is 1, one minus it the one below which it is 0; share of the views that show a
stall from which it is one, and below one minus it none.
"""

Map = NDArray[np.float32]
View = tuple[Map, FloatArray]
"""Layers (4, H/2, W/2) of lot, core, car and taken, and stalls (N, 4, 2) in pixels."""


@dataclass(frozen=True, slots=True)
class Agreed:
    """Means over all views, (H/2, W/2), of lot, core, car and taken, and the stalls that any view shows: ``quads``
    (N, 4, 2) in pixels, and ``share`` (N,), the share of the views that show each.
    """

    lot: Map = field(repr=False)
    core: Map = field(repr=False)
    car: Map = field(repr=False)
    taken: Map = field(repr=False)
    quads: FloatArray = field(repr=False)
    share: FloatArray = field(repr=False)

    @property
    def is_stall(self) -> NDArray[np.bool_]:
        """True (N,) for the stalls on which the views agree."""
        return np.asarray(self.share >= _SURE)

    @property
    def is_doubtful(self) -> NDArray[np.bool_]:
        """True (N,) for those that some views show and some do not."""
        return (self.share < _SURE) & (self.share > 1 - _SURE)


def agreed(picture: NDArray[np.uint8], network: StallNetwork, rng: np.random.Generator) -> Agreed:
    """Look at a picture, BGR (H, W, 3) at 0.1 m, both sides odd so that turned cells meet, in ten views."""
    views = [*_turned(picture, network, rng), *_scaled(picture, network, rng)]
    lot, core, car, taken = np.asarray(np.mean([layers for layers, _ in views], axis=0), np.float32)
    quads, share = _in_common([quads for _, quads in views])
    return Agreed(lot, core, car, taken, quads, share)


def labels_of(mean: Map, size: tuple[int, int]) -> NDArray[np.uint8]:
    """Return the labels (H, W), 0, 1 or `UNKNOWN`, that a mean probability gives; ``size`` is (H, W)."""
    said = np.where(mean >= _SURE, 1, np.where(mean <= 1 - _SURE, 0, UNKNOWN)).astype(np.uint8)
    return np.repeat(np.repeat(said, CELL_PIXELS, 0), CELL_PIXELS, 1)[: size[0], : size[1]]


def states(found: Agreed, quads: FloatArray) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which stalls (N, 4, 2; pixels) are taken, and of which that is unclear, both (N,)."""
    if not len(quads):
        return np.zeros(0, np.bool_), np.zeros(0, np.bool_)
    centre, angle, width, length = shape_of(quads / CELL_PIXELS)
    stalls = decode.Stalls(centre[:, 0], centre[:, 1], angle, width, length, np.ones(len(quads)))
    none = np.zeros_like(found.core)
    maps = NetworkMaps(found.lot, found.core, found.car, none, none, none, none, none, none, found.taken, none, none)
    taken = decode.occupancy(maps, stalls)
    return taken >= 0.5, (taken > 1 - _SURE) & (taken < _SURE)


def _look(picture: NDArray[np.uint8], network: StallNetwork) -> View:
    """Return the layers and the stalls of one view, on its own cells and pixels."""
    maps = network.run(np.ascontiguousarray(picture))
    return np.stack([maps.lot, maps.core, maps.car, maps.taken]), decode.vote(maps, CELL_M).corners() * CELL_PIXELS


def _lit(picture: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    return light(picture.astype(np.float32), rng).astype(np.uint8)


def _turned(picture: NDArray[np.uint8], network: StallNetwork, rng: np.random.Generator) -> list[View]:
    """Return what the eight turned and mirrored views show, on the cells and pixels of the picture."""
    height, width = picture.shape[:2]
    views = []
    for turns in range(_TURNS):
        for mirrored in (False, True):
            turned = np.rot90(picture[:, ::-1] if mirrored else picture, turns)
            layers, quads = _look(_lit(turned, rng), network)
            layers, quads = np.rot90(layers, -turns, (1, 2)), _back(quads, turns, (height, width))
            if mirrored:
                layers, quads = layers[..., ::-1], quads * (-1, 1) + (width - 1, 0)
            views.append((layers, quads))
    return views


def _back(quads: FloatArray, turns: int, size: tuple[int, int]) -> FloatArray:
    """Return pixels (..., 2) of (column, row) of a picture of a size (H, W) from those of its ``turns`` times turned
    view (`numpy.rot90`: a quarter turn anticlockwise).
    """
    height, width = size
    x, y = quads[..., 0], quads[..., 1]
    back = ((x, y), (width - 1 - y, x), (width - 1 - x, height - 1 - y), (y, height - 1 - x))[turns]
    return np.stack(back, axis=-1)


def _scaled(picture: NDArray[np.uint8], network: StallNetwork, rng: np.random.Generator) -> list[View]:
    """Return what the picture shows at other scales, on its own cells and pixels."""
    height, width = picture.shape[:2]
    cells = (-(-width // CELL_PIXELS), -(-height // CELL_PIXELS))
    views = []
    for scale in SCALES:
        shown = cv2.resize(
            _lit(picture, rng), (round(width * scale), round(height * scale)), None, 0, 0, cv2.INTER_AREA
        )
        layers, quads = _look(np.asarray(shown, np.uint8), network)
        resized = [cv2.resize(layer, cells, interpolation=cv2.INTER_LINEAR) for layer in layers]
        views.append((np.stack(resized).astype(np.float32), quads / scale))
    return views


def _in_common(views: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return the stalls (N, 4, 2) of all views, each once, as the first that shows it has it, and the share (N,) of the
    views that show it.
    """
    quads, count = np.zeros((0, 4, 2)), np.zeros(0)
    for found in views:
        pairs = match(found, quads)
        count[pairs.true] += 1
        fresh = np.delete(np.arange(len(found)), pairs.found)
        quads, count = np.concatenate([quads, found[fresh]]), np.concatenate([count, np.ones(len(fresh))])
    return quads, count / len(views)
