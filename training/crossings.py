"""Crossings of two roads: queues before stop lines, cars that turn and pass, cars along kerbs, and no stall at all."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from hawk.worlds.generate import empty_plan
from hawk.worlds.plan import Axes, Building, SitePlan, Surface, Vehicle
from hawk.worlds.scene.cars import length_m, sample_kind
from hawk.worlds.scene.materials import Material, grey, sample_material
from hawk.worlds.scene.surroundings import REACH_M, fill_ground, scatter_trees

_LANES: Final = ((1, 1), (1, 2), (2, 2), (2, 1), (3, 2), (2, 3))
"""Lanes towards the crossing and away from it."""
_LANE_M: Final = (2.8, 3.6)
_ARMS: Final = (((1, 0), (0, 1)), ((0, 1), (-1, 0)), ((-1, 0), (0, -1)), ((0, -1), (1, 0)))
_GAP_M: Final = (0.7, 3.2)
"""Between two vehicles that wait."""
_QUEUE: Final = (0, 9)
_TIGHT_SHARE: Final = 0.25
"""Share of the crossings whose lanes are all full: vehicles stand side by side as on stalls."""
_KERB_SHARE: Final = 0.3
"""Share of the arms with cars along the kerb, which no mark gives a stall."""


def plan_crossing_site(rng: np.random.Generator, centre: tuple[float, float]) -> SitePlan:
    """Plan a crossing about ``centre`` (metres) with vehicles that wait, turn and pass."""
    plan = empty_plan(rng, centre, calm=False)
    fill_ground(plan, rng, plan.axes, -REACH_M, ("grass", "pavers", "concrete", "dirt"))
    lanes = [_LANES[int(rng.integers(len(_LANES)))] for _ in range(2)]
    lane = rng.uniform(*_LANE_M)
    half = [max(one) * lane for one in lanes]
    pavement, width = sample_material(rng, "pavers" if rng.random() < 0.5 else "concrete"), rng.uniform(1.5, 5)
    kerb = grey(rng, 130, 225) if rng.random() < 0.7 else None
    for grown, material, edge in ((width, pavement, None), (0.0, plan.asphalt, kerb)):
        plan.add_surface(Surface(plan.axes.rect(-REACH_M, -half[0] - grown, REACH_M, half[0] + grown), material, edge))
        plan.add_surface(Surface(plan.axes.rect(-half[1] - grown, -REACH_M, half[1] + grown, REACH_M), material, edge))
    is_full = rng.random() < _TIGHT_SHARE
    handed = 1 if rng.random() < 0.7 else -1
    for k, (ahead, left) in enumerate(_ARMS):
        axes = plan.axes.facing(ahead, (left[0] * handed, left[1] * handed))
        _arm(plan, rng, axes.moved(half[(k + 1) % 2], 0), lanes[k % 2], lane, is_full=is_full)
    _turning(plan, rng, half)
    _corners(plan, rng, half, width)
    plan.settle()
    return plan


def _arm(
    plan: SitePlan, rng: np.random.Generator, axes: Axes, lanes: tuple[int, int], lane: float, *, is_full: bool
) -> None:
    """Plan one arm: ``axes.u`` leads away from the crossing's edge, lanes towards it lie at v > 0."""
    towards, away = lanes
    stop = rng.uniform(1.0, 7.0)
    if rng.random() < 0.6 and stop > 3.0:
        bar = rng.uniform(0.35, 0.6)
        for v in np.arange(-away * lane + 0.4, towards * lane - 0.3, 2 * bar).tolist():
            plan.line(axes.at(0.6, v), axes.at(stop - 0.8, v), bar, 3, rng.uniform(0.6, 1))
    plan.line(axes.at(stop, 0.2), axes.at(stop, towards * lane - 0.2), rng.uniform(0.25, 0.5), 3, rng.uniform(0.4, 1))
    _lane_lines(plan, rng, axes, lanes, lane, stop)
    for number in range(towards):
        v = (number + 0.5) * lane
        count = int(rng.integers(4, 12)) if is_full else int(rng.integers(*_QUEUE))
        _queue(plan, rng, axes.moved(stop + rng.uniform(0.3, 2.0), v), count)
    for number in range(away):
        u = rng.uniform(0, 25)
        while u < 60 and rng.random() < (0.8 if is_full else 0.5):
            _stand(plan, rng, axes.moved(u, -(number + 0.5) * lane), 0.0)
            u += rng.uniform(6, 25)
    if rng.random() < _KERB_SHARE:
        v, u = towards * lane + 1.0, stop + rng.uniform(8, 20)
        plan.add_surface(Surface(axes.rect(u - 3, towards * lane - 0.1, 60, v + 1.1), plan.asphalt))
        _queue(plan, rng, axes.moved(u, v), int(rng.integers(1, 8)))


def _lane_lines(
    plan: SitePlan, rng: np.random.Generator, axes: Axes, lanes: tuple[int, int], lane: float, stop: float
) -> None:
    """Paint lines between lanes: whole ones near the crossing, broken ones farther away."""
    whole, width, strength = rng.uniform(8, 35), rng.uniform(0.1, 0.18), rng.uniform(0.3, 1)
    for number in range(-lanes[1] + 1, lanes[0]):
        v = number * lane
        plan.line(axes.at(stop, v), axes.at(stop + whole, v), width, 3 if number else int(rng.choice([1, 3])), strength)
        for u in np.arange(stop + whole + 2, 80, 6.0).tolist():
            plan.line(axes.at(u, v), axes.at(u + 3, v), width, 3, strength)


def _queue(plan: SitePlan, rng: np.random.Generator, axes: Axes, count: int) -> None:
    """Put vehicles one behind the other along ``axes.u``, with their fronts at its origin."""
    u = 0.0
    for _ in range(count):
        u += _stand(plan, rng, axes.moved(u, rng.normal(0, 0.15)), math.pi) + rng.uniform(*_GAP_M)


def _stand(plan: SitePlan, rng: np.random.Generator, axes: Axes, turn: float) -> float:
    """Put one vehicle with its front, or its tail, at the origin; return its usual length."""
    kind = sample_kind(rng, "road")
    if rng.random() < 0.03:
        kind = "coach"
    length = length_m(kind)
    x, y = axes.at(length / 2, 0)
    plan.vehicles.append(Vehicle(x, y, axes.angle + turn + rng.normal(0, 0.02), kind))
    return length


def _turning(plan: SitePlan, rng: np.random.Generator, half: list[float]) -> None:
    """Put vehicles on the crossing itself, in any direction."""
    for _ in range(int(rng.integers(0, 4))):
        x, y = plan.axes.at(rng.uniform(-half[1], half[1]), rng.uniform(-half[0], half[0]))
        plan.vehicles.append(Vehicle(x, y, plan.axes.angle + rng.uniform(0, 2 * math.pi), sample_kind(rng, "road")))


def _corners(plan: SitePlan, rng: np.random.Generator, half: list[float], width: float) -> None:
    """Plan what stands at the four corners: houses, trees or nothing."""
    for ahead, left in _ARMS:
        corner = plan.axes.facing(ahead, left).moved(
            half[0 if ahead[0] == 0 else 1] + width, half[1 if ahead[0] == 0 else 0] + width
        )
        if rng.random() < 0.6:
            roof = Material("roof", grey(rng, 45, 200, 10), 0.04, 0.03, 0.04, 0.01)
            sides = rng.uniform((8, 8), (35, 30))
            height = rng.uniform(4, 14)
            plan.buildings.append(
                Building(corner.moved(*rng.uniform(1, 8, 2)), float(sides[0]), float(sides[1]), height, roof)
            )
        scatter_trees(plan, rng, corner, 30, 30, int(rng.integers(0, 12)))
