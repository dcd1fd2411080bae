"""Pictures with labels: stitched places, tiles, and pictures without any stall."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.model import StallState
from hawk.survey.scoring import FloatArray, LabelledPlace

TILE_METRES_PER_PIXEL = 0.0938
FREE_COVER, TAKEN_COVER = 0.12, 0.30
"""A labelled stall is free below this cover by labelled cars, taken above the other."""
LEAST_LABELS = 5
"""Tiles with fewer labelled stalls are left out: their labels are incomplete."""
_CAR, _LOT, _STALL = 0, 1, 3
_PICTURES = (".jpg", ".jpeg", ".png")


@dataclass(frozen=True, slots=True)
class Place:
    """A picture and what is there, metres from its upper left corner (x right, y down)."""

    name: str
    image: NDArray[np.uint8]
    metres_per_pixel: float
    truth: LabelledPlace


def read_lots(folder: Path) -> Iterator[Place]:
    """Yield the places of a folder of PLACE.jpg and PLACE.json."""
    for path in sorted(folder.glob("*.json")):
        told = json.loads(path.read_text())
        states = [StallState(s["state"]) if s["state"] != "unclear" else StallState.UNKNOWN for s in told["stalls"]]
        corners = np.array([s["corners_m"] for s in told["stalls"]], float).reshape(-1, 4, 2)
        lots = tuple(np.array(lot, float) for lot in told["lots_m"])
        truth = LabelledPlace(corners, state_array(states), lots)
        yield Place(path.stem, read_picture(path.with_suffix(".jpg")), told["metres_per_pixel"], truth)


def read_tiles(folder: Path) -> Iterator[Place]:
    """Yield the tiles with at least `LEAST_LABELS` labelled stalls: ``images/*.jpg`` with ``labels/*.txt``."""
    for path in sorted((folder / "images").glob("*.jpg")):
        image = read_picture(path)
        size = np.array([image.shape[1], image.shape[0]])
        shapes = [_shape(line, size) for line in _lines(folder / "labels" / f"{path.stem}.txt")]
        stalls = [_box(points) for kind, points in shapes if kind == _STALL]
        if len(stalls) < LEAST_LABELS:
            continue
        cars = np.zeros(image.shape[:2], np.uint8)
        cv2.fillPoly(cars, [points.astype(np.int32) for kind, points in shapes if kind == _CAR], (1,))
        states = state_array([_state(cars, stall) for stall in stalls])
        lots = tuple(points * TILE_METRES_PER_PIXEL for kind, points in shapes if kind == _LOT)
        truth = LabelledPlace(np.array(stalls, float) * TILE_METRES_PER_PIXEL, states, lots)
        yield Place(path.stem, image, TILE_METRES_PER_PIXEL, truth)


def read_pictures(folder: Path) -> Iterator[tuple[str, NDArray[np.uint8]]]:
    """Yield name and picture of every picture of a folder."""
    for path in sorted(p for p in folder.iterdir() if p.suffix.lower() in _PICTURES):
        yield path.name, read_picture(path)


def read_picture(path: Path) -> NDArray[np.uint8]:
    """Return the picture, BGR. Raises FileNotFoundError."""
    image = cv2.imread(str(path))
    if image is None:
        raise FileNotFoundError(f"{path} cannot be read as a picture")
    return np.asarray(image, np.uint8)


def state_array(values: Sequence[StallState]) -> NDArray[Any]:
    """Return states as `hawk.survey.scoring` takes them."""
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


def _state(cars: NDArray[np.uint8], stall: FloatArray) -> StallState:
    inside = np.zeros(cars.shape, np.uint8)
    cv2.fillPoly(inside, [np.asarray(stall).astype(np.int32)], (1,))
    cover = float(cars[inside > 0].mean()) if inside.any() else 0.5 * (FREE_COVER + TAKEN_COVER)
    if cover < FREE_COVER:
        return StallState.FREE
    return StallState.TAKEN if cover > TAKEN_COVER else StallState.UNKNOWN
