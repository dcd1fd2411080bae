"""Sites to train on: lots of every kind, rows on even ground, and places where nobody parks."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import shapely

from hawk.worlds.generate import Rect, SiteSize, darkened, empty_plan, fill_lots, outlines, plan_sections, sides_of
from hawk.worlds.layout import asphalt_details, plan_section
from hawk.worlds.plan import Axes, SitePlan, Surface
from hawk.worlds.scene.canvas import Points
from hawk.worlds.scene.materials import Material, grey, sample_material
from hawk.worlds.scene.surroundings import REACH_M, fill_ground, plan_court, plan_side, scatter_trees
from hawk.worlds.style import sample_palette, sample_style
from training.premises import plan_premises

ROOF_PARKING_SHARE = 0.06
"""Share of the lots that are on a roof."""


def plan_any_lot_site(rng: np.random.Generator, centre: tuple[float, float], size: SiteSize) -> SitePlan:
    """Plan a lot of any kind about ``centre`` (metres) with its surroundings."""
    plan = empty_plan(rng, centre, calm=False)
    sections, links = plan_sections(rng, size)
    whole = [_widened(rng, r) for r in sections]
    lots = outlines(plan.axes, [*whole, *links])
    sides = sides_of(plan.axes, whole)
    for k in rng.permutation(4):
        axes, span = sides[k]
        if rng.random() < 0.2:
            plan_premises(plan, rng, axes.moved(0, rng.uniform(0, 4)), max(span, 15.0))
        else:
            plan_side(plan, rng, axes, span)
    if rng.random() < ROOF_PARKING_SHARE:
        _raise_deck(plan, rng, lots)
    fill_lots(plan, rng, lots, sections, sample_style(rng))
    if rng.random() < 0.2:
        turned = Axes.turned(plan.axes.at(*rng.normal(0, 15, 2)), rng.uniform(0, 2 * math.pi))
        plan.shades.append(turned.rect(0, -200, 200, 200))
    return plan


def plan_plain_site(rng: np.random.Generator, centre: tuple[float, float]) -> SitePlan:
    """Plan one or two pairs of rows on one even ground about ``centre`` (metres), with next to nothing around them.

    A lot is a lot without roads, kerbs and trees around it; only its rows show it here.
    """
    plan = empty_plan(rng, centre, calm=False)
    plan.asphalt = _even(rng, plan.asphalt)
    plan.palette = sample_palette(rng, float(np.mean(plan.asphalt.colour)))
    plan.wear = rng.uniform(0, 0.5)
    far = Axes.turned(centre, 0.0).rect(-REACH_M, -REACH_M, REACH_M, REACH_M)
    plan.add_surface(Surface(far, plan.asphalt))
    style = replace(sample_style(rng), side_rows=0.0, medians=0.0, break_share=0.0)
    depth = style.aisle * rng.uniform(1.0, 2.2) + style.depth * int(rng.choice([1, 2, 2, 4]))
    width, edge = rng.uniform(14, 60), rng.uniform(1, 7)
    corner = plan.axes.moved(-width / 2, -depth / 2)
    plan.lots.append(corner.rect(-edge, -edge, width + edge, depth + edge))
    if rng.random() < 0.4:
        asphalt_details(plan, rng, corner, width, depth)
    plan_section(plan, rng, corner, width, depth, style)
    return plan


def plan_bare_site(rng: np.random.Generator, centre: tuple[float, float]) -> SitePlan:
    """Plan a place about ``centre`` (metres) where nobody parks."""
    plan = empty_plan(rng, centre, calm=False)
    plan_wild(plan, rng, plan.axes)
    if rng.random() < 0.5:
        plan_premises(plan, rng, plan.axes.moved(0, rng.uniform(-25, 0)), rng.uniform(20, 40))
    plan.settle()
    return plan


def plan_wild(plan: SitePlan, rng: np.random.Generator, axes: Axes) -> None:
    """Plan a place without any lot about the origin of ``axes``."""
    fill_ground(
        plan, rng, axes, -REACH_M, ("grass", "dirt", "asphalt", "gravel", "concrete", "water", "roof", "pavers")
    )
    for _ in range(int(rng.integers(1, 4))):
        turned = axes.facing(*(((1, 0), (0, 1)), ((0, 1), (-1, 0)), ((-1, 0), (0, -1)))[int(rng.integers(3))])
        plan_side(plan, rng, turned.moved(0, rng.uniform(-18, 15)), rng.uniform(10, 40))
    if rng.random() < 0.3:
        plan_court(plan, rng, axes.moved(rng.uniform(-20, 5), rng.uniform(-15, 5)))
    scatter_trees(plan, rng, axes.moved(-30, -30), 60, 60, int(rng.integers(0, 16)))


def _even(rng: np.random.Generator, material: Material) -> Material:
    """Return a material of the same grain or less, in any tone of grey."""
    share = float(rng.choice([0.0, rng.uniform(0, 1)]))
    grain, mottle, blotch = (share * value for value in (material.grain, material.mottle, material.blotch))
    return replace(material, colour=grey(rng, 35, 175), grain=grain, mottle=mottle, blotch=blotch, joints=0.0)


def _raise_deck(plan: SitePlan, rng: np.random.Generator, lots: list[Points]) -> None:
    """Put a lot on a roof: a parapet around it, and its shade on the ground below."""
    plan.asphalt = darkened(sample_material(rng, "concrete" if rng.random() < 0.7 else "roof"), 182)
    plan.palette = sample_palette(rng, float(np.mean(plan.asphalt.colour)))
    wall_in(plan, rng, lots)


def wall_in(plan: SitePlan, rng: np.random.Generator, lots: list[Points]) -> None:
    """Put a parapet around lots on a roof, and the shade that they throw on the ground below."""
    wall = grey(rng, 90, 240)
    shade, reach = rng.uniform(0.35, 0.8), rng.uniform(-9, 9, 2)
    for outline in lots:
        plan.change(outline + reach, shade, soften=0.2)
        area = np.asarray(shapely.Polygon(outline).buffer(0.4, join_style="mitre").exterior.coords)[:-1]
        plan.add_surface(Surface(area, Material("concrete", wall, 0.02, 0.02, 0.02)))


def _widened(rng: np.random.Generator, rect: Rect) -> Rect:
    """Return a section with lanes and spare ground around its rows, on some sides."""
    a, b, c, d = (float(rng.choice([0.0, 0.0, 0.0, rng.uniform(1.5, 9)])) for _ in range(4))
    return rect[0] - a, rect[1] - b, rect[2] + c, rect[3] + d
