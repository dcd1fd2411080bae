"""Flights over textured ground whose poses are known, for tests."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.model.pictures import CameraModel
from hawk.picture.reconstruction.alignment import PosePrior
from hawk.picture.reconstruction.camera_pose import CameraPose
from hawk.picture.reconstruction.features import Features, features

CAMERA = CameraModel(480, 360, 360.0, 360.0, 239.5, 179.5)
_SCALE = 0.1
_SIDE = 1400


@functools.cache
def ground() -> NDArray[np.uint8]:
    """Return ground of 140 m a side, 0.1 m a pixel, with spots of every size; its middle is the origin."""
    rng = np.random.default_rng(7)
    image: Any = np.zeros((_SIDE, _SIDE), np.float32)
    for size in (20, 60, 160, 400):
        noise = rng.normal(0, 1, (size, size)).astype(np.float32)
        image = image + np.asarray(cv2.resize(noise, (_SIDE, _SIDE), interpolation=cv2.INTER_CUBIC), np.float32)
    low, high = np.percentile(image, (1, 99))
    grey = np.clip((image - low) / (high - low) * 255, 0, 255).astype(np.uint8)
    return np.asarray(cv2.merge([grey, grey, grey]), np.uint8)


def picture(posed: CameraPose) -> NDArray[np.uint8]:
    """Return what a camera sees of the ground."""
    columns, rows = np.meshgrid(np.arange(posed.camera.width), np.arange(posed.camera.height))
    places = posed.ground(np.column_stack([columns.ravel(), rows.ravel()]).astype(np.float64))
    at = np.column_stack([places[:, 1] / _SCALE, -places[:, 0] / _SCALE]) + _SIDE / 2
    grid = at.astype(np.float32).reshape(posed.camera.height, posed.camera.width, 2)
    return np.asarray(cv2.remap(ground(), grid[..., 0], grid[..., 1], cv2.INTER_LINEAR), np.uint8)


@functools.cache
def found(flown: Flight) -> list[Features]:
    """Return the strongest features of a flight's pictures."""
    return [features(image).strongest(600) for image in flown.pictures]


@dataclass(frozen=True, eq=False)
class Flight:
    """True poses, and what their files say of them."""

    true: tuple[CameraPose, ...]
    known: tuple[PosePrior, ...]
    pictures: tuple[NDArray[np.uint8], ...] = field(repr=False)


@functools.cache
def flight(
    *, lanes: int = 2, count: int = 3, sigma: float = 1.0, turned: frozenset[int] = frozenset(), seed: int = 1
) -> Flight:
    """Return a flight at 30 m, 8 m a step, 12 m between lanes; the files of ``turned`` ones are off by 180 degrees."""
    rng = np.random.default_rng(seed)
    true: list[CameraPose] = []
    known: list[PosePrior] = []
    for lane in range(lanes):
        for step in range(count):
            north = (step - (count - 1) / 2) * 8.0 * (1 if lane % 2 == 0 else -1)
            east = (lane - (lanes - 1) / 2) * 12.0
            yaw = 0.1 if lane % 2 == 0 else 0.1 - math.pi
            tilt = rng.normal(0, 0.01, 2).tolist()
            posed = CameraPose(CAMERA, north, east, 30.0, (tilt[0], tilt[1], yaw))
            off = rng.normal(0, sigma, 2).tolist()
            said_yaw = yaw + float(rng.normal(0, 0.03)) + (math.pi if len(true) in turned else 0.0)
            said = CameraPose(CAMERA, north + off[0], east + off[1], 30.6, (0.0, 0.0, said_yaw))
            true.append(posed)
            known.append(PosePrior(said, sigma, 0.5, 0.02, 0.1))
    return Flight(tuple(true), tuple(known), tuple(picture(posed) for posed in true))
