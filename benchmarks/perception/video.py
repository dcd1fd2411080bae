"""A video of a camera that stands still straight above a lot: which stalls there are, and how steady their states.

Each frame goes through vision and mapper as in flight, with a pose that never moves.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.perception.eyes import north_up
from hawk.algo.mapper.core import MapCore, MapperSettings
from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.seen import SeenGround
from hawk.model.lot_map import StallState
from hawk.model.poses import MapPose

_HEIGHT_M = 40.0
"""Height given to the mapper, which weighs a frame by the distance moved: none here."""


@dataclass(frozen=True, slots=True)
class Steadiness:
    """A stall: its id, last state, frames in which it counted, and how often it went from free to taken or back."""

    id: int
    state: StallState
    frames: int
    flips: int


def watch(finder: StallDetector, path: Path, metres_per_pixel: float) -> list[Steadiness]:
    """Return every stall that counted in some frame. Raises FileNotFoundError, ValueError for a video of no frames."""
    core = MapCore(MapperSettings(), "video")
    last: dict[int, StallState] = {}
    counted: dict[int, int] = {}
    flips: dict[int, int] = {}
    number = 0
    for number, image in enumerate(_frames(path), 1):
        core.fuse(_seen(finder, image, metres_per_pixel, float(number)))
        core.encode(None)
        for stall in core.index.stalls.values():
            if stall.state is StallState.SUGGESTED:
                continue
            counted[stall.id] = counted.get(stall.id, 0) + 1
            if stall.state is StallState.UNKNOWN:
                continue
            before = last.setdefault(stall.id, stall.state)
            flips[stall.id] = flips.get(stall.id, 0) + (before is not stall.state)
            last[stall.id] = stall.state
    if not number:
        raise ValueError(f"{path} has no frames that can be read; name a video that OpenCV can open")
    return [Steadiness(k, last.get(k, StallState.UNKNOWN), n, flips.get(k, 0)) for k, n in sorted(counted.items())]


def _frames(path: Path) -> Iterator[NDArray[np.uint8]]:
    if not path.exists():
        raise FileNotFoundError(f"{path} does not exist; name a video")
    video = cv2.VideoCapture(str(path))
    try:
        while True:
            good, image = video.read()
            if not good:
                return
            yield np.asarray(image, np.uint8)
    finally:
        video.release()


def _seen(finder: StallDetector, image: NDArray[np.uint8], metres_per_pixel: float, time: float) -> SeenGround:
    ground = north_up(image, metres_per_pixel)
    found = finder.detect(ground)
    middle = ground.map_points(np.array(ground.valid.shape[::-1]) / 2)
    pose = MapPose(float(middle[0]), float(middle[1]), _HEIGHT_M, 0.0, 0.0, 0.0)
    return SeenGround(found.stalls, found.lot, found.car, found.core, found.taken, ground, pose, time)
