"""Goods on stalls: containers and crates in place of cars, and tents over stalls."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np

from hawk.worlds.canvas import Points
from hawk.worlds.cars import outline
from hawk.worlds.materials import Material, grey
from hawk.worlds.plan import Axes, Block, Building, SitePlan, inside
from training.long_vehicles import run_of_stalls

_LENGTH_M: Final = (2.4, 16.0)
"""Length of the run of stalls that goods take."""
_TENT_SHARE: Final = 0.25
_CONTAINER_SHARE: Final = 0.4
"""Share of the other goods that are one container a stall."""
_CRATE_M: Final = (0.8, 1.6)
_TENT_HEIGHT_M: Final = (2.4, 4.0)


def store_goods(plan: SitePlan, rng: np.random.Generator) -> None:
    """Put goods on some stalls side by side in place of the cars there, unless the row is too short.

    A stall with goods on it is taken.
    """
    if not plan.stalls:
        return
    run = run_of_stalls(plan.stalls, int(rng.integers(len(plan.stalls))), rng.uniform(*_LENGTH_M))
    if not run:
        return
    quads = [plan.stalls[k].corners for k in run]
    areas = [quad.astype(np.float32) for quad in quads]
    plan.vehicles = [one for one in plan.vehicles if not any(inside(area, one.x, one.y) for area in areas)]
    for number in run:
        plan.stalls[number] = replace(plan.stalls[number], taken=True)
    if rng.random() < _TENT_SHARE:
        _tents(plan, rng, quads)
    elif rng.random() < _CONTAINER_SHARE:
        _containers(plan, rng, quads)
    else:
        _crates(plan, rng, quads)


def _tents(plan: SitePlan, rng: np.random.Generator, quads: list[Points]) -> None:
    """Put a white roof over each stall; side by side they are one tent."""
    roof = Material("roof", grey(rng, 215, 252, 4), 0.01, 0.01, 0.02)
    height = rng.uniform(*_TENT_HEIGHT_M)
    for quad in quads:
        axes, width, depth = _axes(quad)
        plan.buildings.append(Building(axes, width, depth, height, roof, shelter=True))


def _axes(quad: Points) -> tuple[Axes, float, float]:
    """Return axes from a stall's first corner along its open end, its width and its depth (metres)."""
    across, along = quad[1] - quad[0], quad[3] - quad[0]
    width = float(np.linalg.norm(across))
    u = across / width
    into = along - u * (along @ u)
    depth = float(np.linalg.norm(into))
    v = into / depth
    axes = Axes((float(quad[0][0]), float(quad[0][1])), (float(u[0]), float(u[1])), (float(v[0]), float(v[1])))
    return axes, width, depth


def _containers(plan: SitePlan, rng: np.random.Generator, quads: list[Points]) -> None:
    """Put a container or a skip along each stall."""
    colour, height = grey(rng, 25, 225, 40), rng.uniform(1.0, 2.6)
    length, width = rng.uniform(3.5, 6.1), rng.uniform(1.7, 2.44)
    for quad in quads:
        x, y = quad.mean(0).tolist()
        plan.blocks.append(Block(outline(x, y, _heading(quad), length, width), height, colour))
        if rng.random() < 0.5:  # an open skip: its inside is of another colour
            inner = outline(x, y, _heading(quad), length - 0.3, width - 0.3)
            plan.blocks.append(Block(inner, height, grey(rng, 30, 200, 25)))


def _crates(plan: SitePlan, rng: np.random.Generator, quads: list[Points]) -> None:
    """Put crates in lines along each stall, all of one size, some missing."""
    size, colour, height = rng.uniform(*_CRATE_M, 2), grey(rng, 60, 250, 20), rng.uniform(0.4, 1.8)
    full = rng.uniform(0.5, 1.0)
    for quad in quads:
        across, along = quad[1] - quad[0], quad[3] - quad[0]
        columns = max(1, int(np.linalg.norm(across) / (size[1] + 0.25)))
        rows = max(1, int(np.linalg.norm(along) / (size[0] + 0.25)))
        for column in range(columns):
            for row in range(rows):
                if rng.random() < full:
                    x, y = quad[0] + across * (column + 0.5) / columns + along * (row + 0.5) / rows
                    heading = _heading(quad) + rng.normal(0, 0.02)
                    plan.blocks.append(Block(outline(float(x), float(y), heading, *size.tolist()), height, colour))


def _heading(quad: Points) -> float:
    along = quad[3] - quad[0]
    return math.atan2(along[1], along[0])
