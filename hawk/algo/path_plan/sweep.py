"""What pictures show along a way: the swath, and how far on a straight way something new is shown."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from hawk.algo.path_plan.field import InformationField
from hawk.algo.path_plan.turned import Axes, Place
from hawk.model import CameraModel


@dataclass(frozen=True, slots=True)
class Swath:
    """Ground in the good part of a picture, metres: ``width`` across the heading, ``depth`` along it."""

    width: float
    depth: float

    @classmethod
    def of(cls, camera: CameraModel, height: float, good_share: float) -> Swath:
        """Return the swath of a level camera at a height."""
        return cls(height * camera.width / camera.fx * good_share, height * camera.height / camera.fy * good_share)


def ahead(
    field: InformationField, place: Place, heading: float, swath: Swath, reach_m: float, row_gain: float
) -> tuple[float, float]:
    """Return how far on (metres) a straight way still shows something new, and how much (square metres).

    A row of the field counts from ``row_gain`` square metres on. The way ends where the drone may not be.
    """
    cell = field.window.cell_m
    half, across = swath.depth / 2 / cell, max(1, round(swath.width / cell))
    steps = math.ceil(reach_m / cell)
    axes = Axes(place, heading, cell, 0.0, (across - 1) / 2)
    rows = axes.turned(field, field.gain, (steps + math.ceil(half), across)).sum(1)
    free = Axes(place, heading, cell, 0.0, 0.0).turned(field, field.allowed, (steps, 1), cv2.INTER_NEAREST)[:, 0] > 0
    open_steps = int(np.argmin(free[1:])) if not free[1:].all() else steps - 1
    worth = np.flatnonzero(rows >= row_gain)
    if len(worth) == 0:
        return 0.0, 0.0
    length = min(max(float(worth[-1]) + 1 - half, 0.0), float(open_steps))
    return length * cell, float(rows[: math.ceil(length + half)].sum())
