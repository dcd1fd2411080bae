"""Streets of houses: bays along the kerb and pockets of a few stalls, between hedges and trees."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from hawk.worlds.generate import empty_plan
from hawk.worlds.plan import Axes, Building, SitePlan, Surface
from hawk.worlds.rows import PARALLEL_DEPTH_M, plan_parallel_row, plan_row
from hawk.worlds.scene.materials import Material, grey, sample_material
from hawk.worlds.scene.surroundings import REACH_M, fill_ground, scatter_trees
from hawk.worlds.style import LotStyle
from training.house_roofs import draw_house_roofs, draw_shed_roof
from training.paved import pave

_SPAN_M: Final = 75.0
"""Half the length of the street."""
_ROAD_M: Final = (4.6, 7.0)
_POCKET_STALLS: Final = (2, 11)
_GAP_M: Final = (1.0, 14.0)
"""Along the kerb between two pockets."""
_KINDS: Final = ("parallel", "square", "none")
_PAVEMENT_M: Final = (1.2, 2.6)
_GARDEN_M: Final = (2.0, 7.0)
_HOUSE_WIDTH_M: Final = (22.0, 60.0)


def plan_street_site(rng: np.random.Generator, centre: tuple[float, float]) -> SitePlan:
    """Plan a street along ``axes.u`` through ``centre`` (metres) with stalls and houses on both sides."""
    plan = empty_plan(rng, centre, calm=False)
    style = replace(pave(plan, rng), trees=0.0, back_line=0.0, front_line=0.0, ends=(1.0, 0.0, 0.0), break_share=0.0)
    fill_ground(plan, rng, plan.axes, -REACH_M, ("grass", "grass", "dirt"))
    half = rng.uniform(*_ROAD_M) / 2
    road = sample_material(rng, "asphalt") if rng.random() < 0.4 else plan.asphalt
    reaches = [_side(plan, rng, axes, half, style) for axes in _both_sides(plan.axes)]
    plan.add_surface(Surface(plan.axes.rect(-_SPAN_M, -half, _SPAN_M, half), road))
    for axes, v in zip(_both_sides(plan.axes), reaches, strict=True):
        _houses(plan, rng, axes.moved(0, v))
    plan.settle()
    return plan


def _both_sides(axes: Axes) -> tuple[Axes, Axes]:
    return axes, axes.facing((-1, 0), (0, -1))


def _side(plan: SitePlan, rng: np.random.Generator, axes: Axes, kerb: float, style: LotStyle) -> float:
    """Plan one side from the kerb on: stalls, then the pavement; return where the gardens begin, metres."""
    kind = _KINDS[int(rng.choice(len(_KINDS), p=(0.4, 0.45, 0.15)))]
    depth = {"parallel": PARALLEL_DEPTH_M, "square": style.depth, "none": 0.0}[kind]
    strip = sample_material(rng, str(rng.choice(("grass", "bark", "dirt", "grass"))))
    plan.add_surface(Surface(axes.rect(-_SPAN_M, kerb - 0.1, _SPAN_M, kerb + depth), strip))
    width = rng.uniform(*_PAVEMENT_M)
    pavement = sample_material(rng, "pavers" if rng.random() < 0.6 else "concrete")
    plan.add_surface(Surface(axes.rect(-_SPAN_M, kerb + depth, _SPAN_M, kerb + depth + width), pavement))
    u = -_SPAN_M + rng.uniform(0, 12)
    while depth and u < _SPAN_M - 8:
        u += _pocket(plan, rng, axes.moved(u, kerb), kind, style)
        gap = rng.uniform(*_GAP_M)
        _green(plan, rng, axes.moved(u, kerb), gap, depth)
        u += gap
    return kerb + depth + width


def _pocket(plan: SitePlan, rng: np.random.Generator, axes: Axes, kind: str, style: LotStyle) -> float:
    """Plan some stalls side by side from the origin on; return their length along the kerb, metres."""
    ground = style.bays or plan.asphalt
    count = int(rng.integers(*_POCKET_STALLS))
    fill = replace(style, occupancy=float(np.clip(style.occupancy + rng.normal(0, 0.25), 0, 1)))
    if kind == "parallel":
        length, depth, plan_stalls = (1 + count // 3) * 7.2, PARALLEL_DEPTH_M, plan_parallel_row
    else:
        length, depth, plan_stalls = count * style.pitch + abs(style.shift) + 0.05, style.depth, plan_row
    plan.add_surface(Surface(axes.rect(0, -0.2, length, depth), ground))
    if plan_stalls(plan, rng, axes, length, fill):
        plan.lots.append(axes.rect(0, 0, length, depth))
    return length


def _green(plan: SitePlan, rng: np.random.Generator, axes: Axes, gap: float, depth: float) -> None:
    """Plant what stands between two pockets: a tree, a hedge, or nothing."""
    share = rng.random()
    if share < 0.45:
        place = axes.at(gap / 2, depth / 2 + rng.normal(0, 0.4))
        plan.plant(place, rng.uniform(1.5, 4.5), rng.uniform(1.6, 2.6), (3, 11))
    elif share < 0.8:
        for u in np.arange(0.4, gap, 0.9).tolist():
            for v in np.arange(0.5, depth, 0.9).tolist():
                place = axes.at(u + rng.normal(0, 0.1), v)
                plan.plant(place, rng.uniform(0.4, 0.8), 1.8, (0.6, 1.4))


def _houses(plan: SitePlan, rng: np.random.Generator, axes: Axes) -> None:
    """Plan front gardens, terraced houses with dark roofs, and gardens behind them."""
    front, u = rng.uniform(*_GARDEN_M), -_SPAN_M
    depth, height = rng.uniform(8, 11), rng.uniform(5, 9.5)
    roof = Material("roof", grey(rng, 45, 125, 12), 0.04, 0.03, 0.04, 0.01)
    scatter_trees(plan, rng, axes.moved(-_SPAN_M, 0), 2 * _SPAN_M, front, int(rng.integers(8, 50)))
    while u < _SPAN_M:
        width = rng.uniform(*_HOUSE_WIDTH_M)
        plan.buildings.append(Building(axes.moved(u, front), width, depth, height, roof, draw_house_roofs))
        for _ in range(int(rng.integers(0, 5))):  # sheds and extensions
            shed = axes.moved(u + rng.uniform(0, width), front + depth + rng.uniform(0, 12))
            wide, deep, high = rng.uniform((2, 2, 2.2), (5, 4, 3.0)).tolist()
            plan.buildings.append(Building(shed, wide, deep, high, crowd=draw_shed_roof))
        scatter_trees(plan, rng, axes.moved(u, front + depth + 1), width, 14, int(rng.integers(4, 30)))
        u += width + rng.uniform(1.5, 12)
