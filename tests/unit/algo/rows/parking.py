"""Drawn rows of stalls: where they are, what was found of them, and what the ground shows."""

from __future__ import annotations

import math

import numpy as np

from hawk.algo.rows.evidence import Ground, GroundAt
from hawk.algo.rows.fit import Finds
from hawk.algo.vision.detection import FloatArray
from hawk.algo.vision.network import CORE_SHARE

WIDTH, LENGTH = 2.6, 5.2


def row_at(
    count: int, direction: float = 0.3, lean: float = math.pi / 2, origin: tuple[float, float] = (10, -20)
) -> FloatArray:
    """Centres (N, 2) of a row that runs along ``direction``; its stalls are turned by ``lean`` from it."""
    step = np.array([math.cos(direction), math.sin(direction)]) * WIDTH / math.sin(lean)
    return np.array(origin) + np.arange(count)[:, None] * step


def finds_at(centres: FloatArray, angle: float | FloatArray, score: float | FloatArray = 0.9) -> Finds:
    ones = np.ones(len(centres))
    return Finds(centres, ones * angle % math.pi, ones * WIDTH, ones * LENGTH, ones * score)


def joined(*parts: Finds) -> Finds:
    names = ("centres", "angle", "width", "length", "score")
    return Finds(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def ground_of(
    stalls: FloatArray,
    angle: float | FloatArray,
    cars: FloatArray | None = None,
    core: float | FloatArray = 0.95,
    reach_m: float = 8,
) -> GroundAt:
    """Ground that shows the stalls with these centres (N, 2), each with its ``core``, cars on some of them, and lot
    within a reach.
    """
    angles, shown = np.ones(len(stalls)) * angle, np.ones(len(stalls)) * core
    taken = np.zeros((0, 2)) if cars is None else cars

    def within(
        places: FloatArray, centres: FloatArray, turned: FloatArray, share: float, value: FloatArray
    ) -> FloatArray:
        offset = places[..., None, :] - centres
        along = np.abs(offset[..., 0] * np.cos(turned) + offset[..., 1] * np.sin(turned))
        across = np.abs(offset[..., 1] * np.cos(turned) - offset[..., 0] * np.sin(turned))
        inside = (along <= LENGTH * share / 2) & (across <= WIDTH * share / 2)
        return np.asarray((inside * value).max(axis=-1, initial=0.0))

    def at(places: FloatArray) -> Ground:
        near = np.hypot(*np.moveaxis(places[..., None, :] - stalls, -1, 0)).min(axis=-1) < reach_m
        car = within(places, taken, np.ones(len(taken)) * np.mean(angles), 0.7, np.ones(len(taken)))
        return Ground(within(places, stalls, angles, CORE_SHARE, shown), car, near * 0.95, np.ones(places.shape[:-1]))

    return at
