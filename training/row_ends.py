"""Narrow planted islands at the ends of rows, whose bushes hang over the last stall and shade it."""

from __future__ import annotations

from typing import Final

import numpy as np
import shapely

from hawk.worlds.canvas import Points
from hawk.worlds.materials import grey, sample_material
from hawk.worlds.plan import SitePlan, Surface
from training.long_vehicles import stalls_beside

_WIDTH_M: Final = (0.5, 1.5)
_OVER_LINE_M: Final = (-0.15, 0.1)
"""The island's near side, from the outer line of the last stall: below zero it covers the line."""
_GROUNDS: Final = ("grass", "bark", "dirt", "concrete", "gravel")
_BUSHES: Final = 4
_RADIUS_M: Final = (0.4, 1.8)
_HEIGHT_M: Final = (0.7, 5.0)


def plant_row_end(plan: SitePlan, rng: np.random.Generator) -> None:
    """Put an island with bushes beside the last stall of some row, where it covers no other stall."""
    if not plan.stalls:
        return
    first, step = int(rng.integers(len(plan.stalls))), 1 if rng.random() < 0.5 else -1
    last = stalls_beside(plan.stalls, first, step)[-1]
    side = _outer_side(plan.stalls[last].corners, plan.stalls[last - step].corners if last != first else None, rng)
    near, width = rng.uniform(*_OVER_LINE_M), rng.uniform(*_WIDTH_M)
    island = _beside(side, near, near + width)
    others = [stall.corners for k, stall in enumerate(plan.stalls) if k != last]
    if others and shapely.intersects(shapely.polygons(np.array(others)), shapely.Polygon(island)).any():
        return
    kerb = grey(rng, 120, 235) if rng.random() < 0.8 else None
    material = sample_material(rng, str(rng.choice(_GROUNDS)))
    plan.islands.append(Surface(island, material, kerb, round_m=rng.uniform(0.1, width / 2)))
    for _ in range(int(rng.integers(_BUSHES))):
        along = rng.uniform(0.05, 1.0)
        x, y = (island[0] + island[1]) / 2 * (1 - along) + (island[2] + island[3]) / 2 * along
        plan.plant((float(x), float(y)), rng.uniform(*_RADIUS_M), rng.uniform(1.3, 2.4), _HEIGHT_M)


def _outer_side(quad: Points, neighbour: Points | None, rng: np.random.Generator) -> Points:
    """Return the long side of a stall that its neighbour does not touch, from the open to the closed end, and outwards.

    (3, 2): both ends of the side, and the unit vector that points away from the stall.
    """
    across = quad[1] - quad[0]
    away = quad.mean(0) - neighbour.mean(0) if neighbour is not None else across * (1 if rng.random() < 0.5 else -1)
    is_right = bool(away @ across > 0)
    start, end = (quad[1], quad[2]) if is_right else (quad[0], quad[3])
    outwards = across / np.linalg.norm(across) * (1 if is_right else -1)
    return np.stack([start, end, outwards])


def _beside(side: Points, near: float, far: float) -> Points:
    start, end, outwards = side
    return np.stack([start + outwards * near, start + outwards * far, end + outwards * far, end + outwards * near])
