"""Pictures with labelled vehicles: Dutch regions, tiles of lots, and frames over crossings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.cars.labels import HAND_LABELS, VehicleTruth, read_truth, truth_of
from benchmarks.perception.boxes import Boxes
from benchmarks.perception.places import TILE_METRES_PER_PIXEL, averaged, missing_ground, read_picture, read_shapes
from hawk.algo.vision.detection import FloatArray
from hawk.worlds.plan import SitePlan
from training.crossings import plan_crossing_site
from training.scenes import draw_scene

CROSSING_METRES_PER_PIXEL: Final = 0.058
"""Of the frames over a crossing: a car of 4.5 m is some 78 pixels long there."""
_DRAWN_PIXELS: Final = 704
_CAR: Final = 0
_EDGE_M: Final = 0.3
_LEAST_M: Final = 1.2
"""A label with a shorter side is what an edge left of a car."""


@dataclass(frozen=True, slots=True)
class CarScene:
    """A picture with its vehicles; ``missing`` (H, W): pixels without a picture, None where all is shown."""

    name: str
    image: NDArray[np.uint8] = field(repr=False)
    metres_per_pixel: float
    truth: VehicleTruth = field(repr=False)
    missing: NDArray[np.bool_] | None = field(default=None, repr=False)

    @property
    def size(self) -> FloatArray:
        """Width and height, metres."""
        return np.array(self.image.shape[1::-1]) * self.metres_per_pixel

    def is_missing(self, places: FloatArray) -> NDArray[np.bool_]:
        """Return True (N,) for the places (N, 2), metres, that the picture does not show."""
        out = ((places < 0) | (places >= self.size)).any(axis=1)
        if self.missing is not None and len(places):
            cells = np.clip((places / self.metres_per_pixel).astype(int), 0, np.array(self.missing.shape[::-1]) - 1)
            out |= self.missing[cells[:, 1], cells[:, 0]]
        return np.asarray(out)


def read_regions(folder: Path, labels: Path = HAND_LABELS) -> Iterator[CarScene]:
    """Yield the regions of a folder of ``REGION.jpg`` whose vehicles are labelled by hand. Raises LabelError."""
    for path in sorted(folder.glob("*.jpg")):
        truth = read_truth(labels / f"{path.stem}.json")
        if truth is not None:
            image = read_picture(path)
            yield CarScene(path.stem, image, 0.1, truth, missing_ground(image))


def read_car_tiles(folder: Path) -> Iterator[CarScene]:
    """Yield the tiles (``images/*.jpg``, ``labels/*.txt``) whose labels name a car."""
    for path in sorted((folder / "images").glob("*.jpg")):
        if scene := _labelled_by_shapes(path, folder / "labels" / f"{path.stem}.txt", TILE_METRES_PER_PIXEL):
            yield scene


def read_crossings(folder: Path) -> Iterator[CarScene]:
    """Yield the frames (``*.jpg`` with ``*.txt`` beside them) over crossings: boxes along the picture's sides."""
    for path in sorted(folder.glob("*.jpg")):
        if scene := _labelled_by_shapes(path, path.with_suffix(".txt"), CROSSING_METRES_PER_PIXEL):
            yield scene


def draw_crossing(seed: int) -> CarScene:
    """Return a drawn crossing without a stall, and without labels."""

    def plan_site(rng: np.random.Generator) -> SitePlan:
        return plan_crossing_site(rng, (0.0, 0.0))

    drawn = draw_scene(np.random.default_rng((seed, _DRAWN_PIXELS)), _DRAWN_PIXELS, plan_site=plan_site)
    return CarScene(f"crossing {seed}", drawn.image, drawn.metres_per_pixel, truth_of([]))


def at_metres(scene: CarScene, metres: float) -> CarScene | None:
    """Return a scene with pixels of this many metres, averaged; None where its own are as coarse."""
    if scene.metres_per_pixel >= metres:
        return None
    image, missing = averaged(scene.image, scene.missing, scene.metres_per_pixel / metres)
    return replace(scene, image=image, metres_per_pixel=metres, missing=missing)


def shifted(scene: CarScene, columns: int, rows: int) -> CarScene:
    """Return a scene without its first columns and rows of pixels; the labels stay where the ground is."""
    off = np.array([columns, rows]) * scene.metres_per_pixel
    return replace(
        scene,
        image=np.ascontiguousarray(scene.image[rows:, columns:]),
        truth=replace(scene.truth, corners=scene.truth.corners - off),
        missing=None if scene.missing is None else scene.missing[rows:, columns:],
    )


def _labelled_by_shapes(path: Path, labels: Path, metres_per_pixel: float) -> CarScene | None:
    image = read_picture(path)
    cars = [points for kind, points in read_shapes(labels, image) if kind == _CAR and len(points) > 2]
    if not cars:
        return None
    quads = [cv2.boxPoints(cv2.minAreaRect(points.astype(np.float32))) for points in cars]
    corners = np.asarray(quads, np.float64) * metres_per_pixel
    size = np.array(image.shape[1::-1]) * metres_per_pixel
    is_cut = ((corners < _EDGE_M) | (corners > size - _EDGE_M)).any(axis=(1, 2)) | (Boxes.of(corners).width < _LEAST_M)
    count, none = len(corners), np.zeros(len(corners), np.bool_)
    truth = VehicleTruth(corners, np.zeros(count, np.intp), ("open",) * count, none, none, ~is_cut)
    return CarScene(path.stem, image, metres_per_pixel, truth)
