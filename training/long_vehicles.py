"""Long vehicles in a lot: coaches and trailers across several stalls, motorhomes that reach into the aisle."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np
import shapely

from hawk.worlds.plan import PlannedStall, SitePlan, Vehicle, inside
from hawk.worlds.scene.cars import footprint_m, length_m

ACROSS_SHARE: Final = 0.6
"""Share of the long vehicles that stand across the stalls, along the row."""
_KINDS: Final = ("motorhome", "lorry", "coach", "trailer")
_KINDS_SHARES: Final = (0.35, 0.3, 0.15, 0.2)
_MARGIN_M: Final = 0.4
_TAKES_SHARE: Final = 0.3
"""A vehicle that covers more of a stall than this takes it."""
_BESIDE: Final = 1.15
"""Stalls of one row are at most this number of their widths apart."""


def park_long_vehicle(plan: SitePlan, rng: np.random.Generator) -> None:
    """Put a long vehicle somewhere in the rows of a plan, in place of the cars there, unless it finds no room."""
    if not plan.stalls:
        return
    kind = _KINDS[int(rng.choice(len(_KINDS), p=_KINDS_SHARES))]
    first = int(rng.integers(len(plan.stalls)))
    stall = plan.stalls[first]
    if rng.random() >= ACROSS_SHARE:
        length = length_m(kind)
        head, tail = stall.corners[2:].mean(0), stall.corners[:2].mean(0)
        along = (tail - head) / max(float(np.linalg.norm(tail - head)), 1e-6)
        x, y = (head + along * (length / 2 + _MARGIN_M)).tolist()
        _occupy(plan, [first], Vehicle(x, y, math.atan2(-along[1], -along[0]), kind))
        return
    run = run_of_stalls(plan.stalls, first, length_m(kind))
    if not run:
        return
    middle = np.mean([plan.stalls[k].corners.mean(0) for k in run], axis=0)
    across = plan.stalls[first].corners[1] - plan.stalls[first].corners[0]
    heading = math.atan2(across[1], across[0]) + rng.normal(0, 0.05) + (math.pi if rng.random() < 0.5 else 0.0)
    _occupy(plan, run, Vehicle(float(middle[0]), float(middle[1]), heading, kind))


def _occupy(plan: SitePlan, run: list[int], vehicle: Vehicle) -> None:
    """Park it in the stalls of a run; stalls that it covers besides, across the aisle too, are taken by it as well."""
    body = shapely.Polygon(footprint_m(vehicle))
    areas = shapely.polygons(np.array([stall.corners for stall in plan.stalls]))
    covered = shapely.area(shapely.intersection(areas, body)) > _TAKES_SHARE * shapely.area(areas)
    for number in sorted({*run, *np.flatnonzero(covered).tolist()}):
        area = plan.stalls[number].corners.astype(np.float32)
        plan.vehicles = [one for one in plan.vehicles if not inside(area, one.x, one.y)]
        plan.stalls[number] = replace(plan.stalls[number], taken=True)
    plan.vehicles.append(vehicle)


def run_of_stalls(stalls: list[PlannedStall], first: int, length: float) -> list[int]:
    """Return the numbers of stalls side by side from ``first`` on that cover a length (m); none if they are fewer."""
    run = [first]
    width = float(np.linalg.norm(stalls[first].corners[1] - stalls[first].corners[0]))
    while len(run) * width < length and run[-1] + 1 < len(stalls):
        apart = stalls[run[-1] + 1].corners.mean(0) - stalls[run[-1]].corners.mean(0)
        if np.linalg.norm(apart) > _BESIDE * width:
            return []
        run.append(run[-1] + 1)
    return run if len(run) * width >= length else []
