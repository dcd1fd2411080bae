"""Breaks in rows, as long as some stalls, that are none: driveways between islands, and racks of bicycles."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from hawk.worlds.plan import Block, SitePlan, Surface
from hawk.worlds.scene.canvas import Points
from hawk.worlds.scene.cars import outline
from hawk.worlds.scene.materials import Colour, grey, sample_material
from training.long_vehicles import run_of_stalls

_DRIVEWAY_SHARE: Final = 0.6
"""Share of the breaks that are driveways; the others are racks."""
_ISLANDS_SHARE: Final = 0.7
"""Share of the driveways with an island on both sides."""
_LENGTH_M: Final = (5.0, 12.0)
_ISLANDS: Final = ("grass", "concrete", "dirt", "bark", "gravel", "pavers")
_BESIDE_M: Final = 0.2
"""Ground beside the break that is remade with it, so that no line stays."""
_BICYCLE_M: Final = (1.7, 0.14, 0.9)
"""Length, width of what shows of the frame, height."""
_HANDLEBAR_M: Final = 0.55


def break_row(plan: SitePlan, rng: np.random.Generator) -> None:
    """Put a driveway or a rack of bicycles in the place of some stalls side by side, where a row is long enough."""
    if not plan.stalls:
        return
    run = run_of_stalls(plan.stalls, int(rng.integers(len(plan.stalls))), rng.uniform(*_LENGTH_M))
    if not run:
        return
    quads = [plan.stalls[k].corners for k in run]
    plan.stalls = [stall for k, stall in enumerate(plan.stalls) if k not in run]
    if rng.random() < _DRIVEWAY_SHARE:
        _driveway(plan, rng, quads)
    else:
        _racks(plan, rng, quads)


def _driveway(plan: SitePlan, rng: np.random.Generator, quads: list[Points]) -> None:
    plan.add_surface(Surface(_around(quads, _BESIDE_M), plan.asphalt))
    if len(quads) < 3 or rng.random() >= _ISLANDS_SHARE:
        return
    material, kerb = sample_material(rng, str(rng.choice(_ISLANDS))), grey(rng, 120, 235)
    for quad in (quads[0], quads[-1]):
        middle = quad.mean(0)
        plan.islands.append(Surface(middle + (quad - middle) * 0.92, material, kerb, round_m=rng.uniform(0.2, 1.0)))
        if rng.random() < 0.5:
            x, y = (middle + (quad[0] - middle) * rng.uniform(-0.6, 0.6)).tolist()
            plan.plant((x, y), rng.uniform(0.4, 1.2), rng.uniform(1.2, 2.0), (0.5, 2.5))


def _racks(plan: SitePlan, rng: np.random.Generator, quads: list[Points]) -> None:
    """Park bicycles side by side, in one line or in two, some places empty."""
    ground = plan.asphalt if rng.random() < 0.5 else sample_material(rng, str(rng.choice(("pavers", "concrete"))))
    area = _around(quads, 0.0)
    plan.add_surface(Surface(_around(quads, _BESIDE_M), ground))
    across, along = area[1] - area[0], area[3] - area[0]
    heading, width = math.atan2(along[1], along[0]), float(np.linalg.norm(across))
    apart, full = rng.uniform(0.35, 0.8), rng.uniform(0.3, 1.0)
    for line in ((0.5,), (0.27, 0.73))[int(rng.integers(2))]:
        for share in np.arange(0.5 * apart, width, apart) / width:
            if rng.random() < full:
                x, y = area[0] + across * share + along * (line + rng.normal(0, 0.02))
                _bicycle(plan, rng, (float(x), float(y)), heading + rng.normal(0, 0.06))


def _bicycle(plan: SitePlan, rng: np.random.Generator, place: tuple[float, float], heading: float) -> None:
    length, width, height = _BICYCLE_M
    colour: Colour = grey(rng, 20, 230, 30)
    plan.blocks.append(Block(outline(*place, heading, length, width), height, colour))
    x, y = place[0] + 0.3 * length * math.cos(heading), place[1] + 0.3 * length * math.sin(heading)
    plan.blocks.append(Block(outline(x, y, heading, 0.1, _HANDLEBAR_M), height, colour))


def _around(quads: list[Points], margin: float) -> Points:
    """Return the corners of what stalls side by side cover, each side moved outwards by a margin (metres)."""
    first, last = quads[0], quads[-1]
    if np.linalg.norm(first[1] - last[0]) > np.linalg.norm(first[0] - last[1]):  # the row runs in the other direction
        first, last = last, first
    corners = np.array([first[0], last[1], last[2], first[3]])
    across, along = corners[1] - corners[0], corners[3] - corners[0]
    u, v = (side / max(float(np.linalg.norm(side)), 1e-6) * margin for side in (across, along))
    return corners + np.array([-u - v, u - v, u + v, -u + v])
