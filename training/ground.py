"""Real ground to train on: windows of pictures of regions, with labelled stalls or without any label.

A folder holds ``REGION.jpg`` and, where the stalls are labelled, ``REGION.json`` (metres_per_pixel, stalls with
corners_m in metres from the picture's upper left corner, state). What the labels do not say (lots, cars, the states of
stalls; without a file the stalls too) is what a network agrees on with itself (`training.agreement`). Vehicles are
those that a person labelled (`benchmarks.cars.labels`), unknown elsewhere. Nothing of the pictures is kept.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.cars.labels import HAND_LABELS, LabelError, read_truth
from benchmarks.perception.places import missing_ground
from hawk.algo.vision.network import StallNetwork
from training.agreement import Agreed, agreed, labels_of, states
from training.targets import UNKNOWN, TrainingScene, VehicleLabels

METRES_PER_PIXEL = 0.1
WINDOW_PIXELS = 496
"""Side of a window: a crop of 320 pixels at the smallest scale of `training.augment`."""
_NEAR_STALLS = 0.8
"""Share of the windows about a stall; the others lie anywhere."""
_JITTER_PIXELS = 110.0
_EDGE_PIXELS = 8
"""Stalls whose labels end this near to the picture's edge are cut: they are not judged."""


class GroundError(ValueError):
    """A picture or its labels cannot be used; the text names the file and the remedy."""


@dataclass(frozen=True, slots=True)
class Region:
    """One picture with its labels."""

    name: str
    scene: TrainingScene = field(repr=False)

    def window(self, rng: np.random.Generator) -> TrainingScene:
        """Return a random window, most of them about a stall."""
        height, width = self.scene.image.shape[:2]
        if len(self.scene.quads) and rng.random() < _NEAR_STALLS:
            about = self.scene.quads[int(rng.integers(len(self.scene.quads)))].mean(0) + rng.normal(
                0, _JITTER_PIXELS, 2
            )
        else:
            about = rng.uniform((0, 0), (width, height))
        left, top = (
            int(np.clip(at - WINDOW_PIXELS / 2, 0, max(size - WINDOW_PIXELS, 0)))
            for at, size in zip(about, (width, height), strict=True)
        )
        return cut(self.scene, left, top, WINDOW_PIXELS)


class Ground:
    """Regions from which windows are drawn, each by the root of its number of stalls."""

    def __init__(self, regions: Sequence[Region]) -> None:
        """Raises GroundError without a region."""
        if not regions:
            raise GroundError("--ground: no picture is left; name a folder of REGION.jpg, or leave out fewer")
        self.regions = tuple(regions)
        weight = np.sqrt([len(region.scene.quads) + 1.0 for region in regions])
        self._share = weight / weight.sum()

    def window(self, rng: np.random.Generator) -> TrainingScene:
        """Return a random window of a random region."""
        return self.regions[int(rng.choice(len(self.regions), p=self._share))].window(rng)


def read_ground(folder: Path, network: StallNetwork, left_out: Sequence[str] = (), seed: int = 0) -> Ground:
    """Read the regions of a folder, but for those whose names fit a pattern of ``left_out``.

    Raises GroundError for a file that cannot be used, and where no region is left.
    """
    names = sorted(path.stem for path in folder.glob("*.jpg"))
    kept = [name for name in names if not any(fnmatchcase(name, pattern) for pattern in left_out)]
    return Ground([read_region(folder / f"{name}.jpg", network, np.random.default_rng((seed, 3))) for name in kept])


def read_region(path: Path, network: StallNetwork, rng: np.random.Generator) -> Region:
    """Read one picture, at 0.1 m, and its labels where it has any. Raises GroundError."""
    image = cv2.imread(str(path))
    if image is None:
        raise GroundError(f"{path} cannot be read as a picture")
    labels = _read_labels(path.with_suffix(".json"))
    scale = METRES_PER_PIXEL if labels is None else float(labels["metres_per_pixel"])
    size = [round(side * scale / METRES_PER_PIXEL) for side in image.shape[1::-1]]
    shown = image if abs(scale / METRES_PER_PIXEL - 1) < 1e-3 else cv2.resize(image, size, None, 0, 0, cv2.INTER_AREA)
    picture = np.asarray(shown[: (shown.shape[0] - 1) | 1, : (shown.shape[1] - 1) | 1], np.uint8)
    found = agreed(picture, network, rng)
    missing = missing_ground(picture)
    scene = _labelled(picture, found, labels) if labels is not None else _unlabelled(picture, found)
    scene = replace(scene, vehicles=_vehicles(HAND_LABELS / f"{path.stem}.json"))
    return Region(path.stem, scene if missing is None else _without(scene, missing))


def cut(scene: TrainingScene, left: int, top: int, side: int) -> TrainingScene:
    """Return a window of a scene, with the stalls that touch it."""
    part = slice(top, top + side), slice(left, left + side)
    quads = scene.quads - np.array([left, top], np.float32)
    touches = (quads.max(1) > 0).all(1) & (quads.min(1) < side).all(1)
    return TrainingScene(
        scene.image[part],
        scene.labels[part],
        quads[touches],
        scene.taken[touches],
        scene.judged[touches],
        None if scene.unclear is None else scene.unclear[touches],
        None if scene.seen is None else scene.seen[part],
        vehicles=None if scene.vehicles is None else _cut_vehicles(scene.vehicles, left, top, side),
    )


def _cut_vehicles(vehicles: VehicleLabels, left: int, top: int, side: int) -> VehicleLabels:
    quads = vehicles.quads - np.array([left, top], np.float32)
    touches = (quads.max(1) > 0).all(1) & (quads.min(1) < side).all(1)
    return VehicleLabels(quads[touches], vehicles.kind[touches], vehicles.judged[touches])


def _vehicles(path: Path) -> VehicleLabels | None:
    """Return the vehicles that a person labelled in a region, None without a file. Raises GroundError."""
    try:
        truth = read_truth(path)
    except LabelError as error:
        raise GroundError(str(error)) from error
    if truth is None:
        return None
    quads = truth.corners / METRES_PER_PIXEL - 0.5
    return VehicleLabels(quads.astype(np.float32), truth.kind, truth.is_counted)


def _read_labels(path: Path) -> dict[str, Any] | None:
    """Return a file of labels, None where there is none. Raises GroundError."""
    if not path.exists():
        return None
    try:
        labels = json.loads(path.read_text())
        if not float(labels["metres_per_pixel"]) > 0:
            raise ValueError("metres_per_pixel must be above 0")
        corners = np.array([stall["corners_m"] for stall in labels["stalls"]], float).reshape(-1, 4, 2)
        return {**labels, "corners_m": corners}
    except (KeyError, TypeError, ValueError) as error:
        raise GroundError(f"{path}: not labels of a region ({error}); see the head of training/ground.py") from error


def _labelled(picture: NDArray[np.uint8], found: Agreed, labels: dict[str, Any]) -> TrainingScene:
    size = picture.shape[:2]
    quads = labels["corners_m"] / METRES_PER_PIXEL - 0.5  # metres from the corner of the first pixel
    low, high = quads.min(1), quads.max(1)
    judged = ((low > _EDGE_PIXELS) & (high < np.array(size[::-1]) - _EDGE_PIXELS)).all(1)
    taken, unclear = states(found, quads)
    said = np.array([stall.get("state", "unclear") for stall in labels["stalls"]], object)
    known = (said == "free") | (said == "taken")
    return TrainingScene(
        picture,
        _layers(found, size),
        quads.astype(np.float32),
        np.where(known, said == "taken", taken).astype(np.bool_),
        judged,
        unclear & ~known,
    )


def _unlabelled(picture: NDArray[np.uint8], found: Agreed) -> TrainingScene:
    """Return a scene whose stalls are those that the views agree on; where they differ nothing is judged."""
    kept = found.is_stall | found.is_doubtful
    quads = found.quads[kept]
    taken, unclear = states(found, quads)
    sure = found.is_stall[kept]
    seen = (labels_of(found.core, picture.shape[:2]) != UNKNOWN).astype(np.uint8)
    for quad in quads[sure]:  # the rim of a sure stall is between core and none
        cv2.fillConvexPoly(seen, np.round(quad * 16).astype(np.int32), 1, shift=4)
    layers = _layers(found, picture.shape[:2])
    return TrainingScene(picture, layers, quads.astype(np.float32), taken, sure, unclear, seen)


def _layers(found: Agreed, size: tuple[int, ...]) -> NDArray[np.uint8]:
    """Return the labels (H, W, 4) of lot and cars; nothing is known of shade and cover."""
    lot, car = (labels_of(mean, (size[0], size[1])) for mean in (found.lot, found.car))
    unknown = np.full_like(lot, UNKNOWN)
    return np.stack([lot, car, unknown, unknown], axis=-1)


def _without(scene: TrainingScene, missing: NDArray[np.bool_]) -> TrainingScene:
    """Return the scene without the ground that its picture lacks."""
    seen = ~missing if scene.seen is None else ~missing & (scene.seen > 0)
    labels = scene.labels.copy()
    labels[missing] = UNKNOWN
    middle = np.clip(np.rint(scene.quads).astype(int), 0, np.array(missing.shape[::-1]) - 1)
    cut_off = missing[middle[..., 1], middle[..., 0]].any(1)
    return replace(scene, labels=labels, judged=scene.judged & ~cut_off, seen=seen.astype(np.uint8))
