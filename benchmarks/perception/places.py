"""Pictures with labels: stitched places, tiles, and pictures without any stall."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.model.lot_map import StallState
from hawk.survey.accuracy import FloatArray, LabelledPlace

TILE_METRES_PER_PIXEL = 0.0938
FREE_COVER, TAKEN_COVER = 0.12, 0.30
"""A labelled stall is free below this cover by labelled cars, taken above the other."""
LEAST_LABELS = 5
"""Tiles with fewer labelled stalls are left out: their labels are incomplete."""
_CAR, _LOT, _STALL = 0, 1, 3
_BLANK, _BLANK_LEVELS = 41, 2
_BLACK, _WHITE = 30, 225
_PICTURES = (".jpg", ".jpeg", ".png")


@dataclass(frozen=True, slots=True)
class Place:
    """A picture and what is there, metres from its upper left corner (x right, y down).

    ``ground``: the kind of ground, empty where the labels do not say it. ``missing`` (H, W): pixels without a picture.
    """

    name: str
    image: NDArray[np.uint8]
    metres_per_pixel: float
    truth: LabelledPlace
    ground: str = ""
    missing: NDArray[np.bool_] | None = None


def read_lots(folder: Path) -> Iterator[Place]:
    """Yield the places of a folder of PLACE.jpg and PLACE.json."""
    for path in sorted(folder.glob("*.json")):
        labels = json.loads(path.read_text())
        states = [StallState(s["state"]) if s["state"] != "unclear" else StallState.UNKNOWN for s in labels["stalls"]]
        corners = np.array([s["corners_m"] for s in labels["stalls"]], float).reshape(-1, 4, 2)
        lots = tuple(np.array(lot, float) for lot in labels["lots_m"])
        truth = LabelledPlace(corners, state_array(states), lots)
        image, scale = read_picture(path.with_suffix(".jpg")), labels["metres_per_pixel"]
        yield Place(path.stem, image, scale, truth, str(labels.get("ground", "")), missing_ground(image))


def read_tiles(folder: Path) -> Iterator[Place]:
    """Yield the tiles with at least `LEAST_LABELS` labelled stalls: ``images/*.jpg`` with ``labels/*.txt``.

    The states of a tile whose labels name no car are unknown: its cars were not labelled.
    """
    for path in sorted((folder / "images").glob("*.jpg")):
        image = read_picture(path)
        shapes = read_shapes(folder / "labels" / f"{path.stem}.txt", image)
        stalls = [_box(points) for kind, points in shapes if kind == _STALL]
        if len(stalls) < LEAST_LABELS:
            continue
        states = state_array(_states(image.shape[:2], [points for kind, points in shapes if kind == _CAR], stalls))
        lots = tuple(points * TILE_METRES_PER_PIXEL for kind, points in shapes if kind == _LOT)
        truth = LabelledPlace(np.array(stalls, float) * TILE_METRES_PER_PIXEL, states, lots)
        yield Place(path.stem, image, TILE_METRES_PER_PIXEL, truth)


def read_shapes(path: Path, image: NDArray[np.uint8]) -> list[tuple[int, FloatArray]]:
    """Return class and polygon (N, 2), in pixels, of each line of a file of labels; nothing without the file."""
    size = np.array([image.shape[1], image.shape[0]])
    return [_shape(line, size) for line in _lines(path)]


def read_pictures(folder: Path) -> Iterator[tuple[str, NDArray[np.uint8]]]:
    """Yield name and picture of every picture of a folder."""
    for path in sorted(p for p in folder.iterdir() if p.suffix.lower() in _PICTURES):
        yield path.name, read_picture(path)


def coarser(place: Place, metres: float) -> Place:
    """Return a place with pixels of this many metres, as a coarser camera takes it; itself where its own are as coarse.

    Blur, haze and the JPEG of a real coarse picture come on top.
    """
    if place.metres_per_pixel >= metres:
        return place
    image, missing = averaged(place.image, place.missing, place.metres_per_pixel / metres)
    return replace(place, image=image, metres_per_pixel=metres, missing=missing)


def averaged(
    image: NDArray[np.uint8], missing: NDArray[np.bool_] | None, factor: float
) -> tuple[NDArray[np.uint8], NDArray[np.bool_] | None]:
    """Return a picture smaller by a factor, averaged, and its pixels without a picture."""
    small = np.asarray(cv2.resize(image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA), np.uint8)
    if missing is None:
        return small, None
    shown = cv2.resize(missing.astype(np.uint8), small.shape[1::-1], interpolation=cv2.INTER_NEAREST)
    return small, np.asarray(shown > 0)


def read_picture(path: Path) -> NDArray[np.uint8]:
    """Return the picture, BGR. Raises FileNotFoundError."""
    image = cv2.imread(str(path))
    if image is None:
        raise FileNotFoundError(f"{path} cannot be read as a picture")
    return np.asarray(image, np.uint8)


def missing_ground(image: NDArray[np.uint8]) -> NDArray[np.bool_] | None:
    """Return the pixels (H, W) of one grey over more than `_BLANK` pixels a side, where parts of a place are missing.

    None where all is shown. Within 5 x 5 pixels the grey differs by up to `_BLANK_LEVELS` levels, as JPEG leaves it;
    black and white are no such grey, because deep shadows and bright roofs are as even.
    """
    low, high = (method(image, np.ones((5, 5), np.uint8)) for method in (cv2.erode, cv2.dilate))
    least, most = low.min(axis=2), high.max(axis=2)
    flat = ((most - least <= _BLANK_LEVELS) & (least > _BLACK) & (most < _WHITE)).astype(np.uint8)
    flat = cv2.morphologyEx(flat, cv2.MORPH_OPEN, np.ones((_BLANK, _BLANK), np.uint8))
    flat = cv2.dilate(flat, np.ones((5, 5), np.uint8))
    return np.asarray(flat > 0) if flat.any() else None


def state_array(values: Sequence[StallState]) -> NDArray[Any]:
    """Return states as `hawk.survey.accuracy` takes them."""
    return np.array([str(value) for value in values], dtype=object)


def _lines(path: Path) -> list[list[float]]:
    if not path.exists():
        return []
    rows = [[float(v) for v in line.split()] for line in path.read_text().splitlines()]
    return [row for row in rows if len(row) >= 5]


def _shape(line: list[float], size: NDArray[np.int_]) -> tuple[int, FloatArray]:
    kind, values = int(line[0]), np.array(line[1:])
    if len(values) == 4:
        centre, half = values[:2], values[2:] / 2
        points = centre + half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    else:
        points = values[: len(values) // 2 * 2].reshape(-1, 2)
    return kind, np.asarray(points * size)


def _box(points: FloatArray) -> FloatArray:
    return np.asarray(cv2.boxPoints(cv2.minAreaRect(points.astype(np.float32))), np.float64)


def _states(shape: tuple[int, int], cars: list[FloatArray], stalls: list[FloatArray]) -> list[StallState]:
    if not cars:
        return [StallState.UNKNOWN] * len(stalls)
    covered = np.zeros(shape, np.uint8)
    cv2.fillPoly(covered, [points.astype(np.int32) for points in cars], (1,))
    return [_state(covered, stall) for stall in stalls]


def _state(cars: NDArray[np.uint8], stall: FloatArray) -> StallState:
    inside = np.zeros(cars.shape, np.uint8)
    cv2.fillPoly(inside, [np.asarray(stall).astype(np.int32)], (1,))
    cover = float(cars[inside > 0].mean()) if inside.any() else 0.5 * (FREE_COVER + TAKEN_COVER)
    if cover < FREE_COVER:
        return StallState.FREE
    return StallState.TAKEN if cover > TAKEN_COVER else StallState.UNKNOWN
