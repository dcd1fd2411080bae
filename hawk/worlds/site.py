"""Whole sites: a lot of one or two sections, or none, with what lies around."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import shapely

from hawk.worlds.canvas import Points
from hawk.worlds.clutter import plan_clutter
from hawk.worlds.layout import asphalt_details, plan_section
from hawk.worlds.materials import Material, grey, sample_material
from hawk.worlds.plan import Axes, Plan, Surface
from hawk.worlds.premises import plan_premises
from hawk.worlds.style import sample_palette, sample_style
from hawk.worlds.surroundings import REACH_M, plan_side, plan_wild

Rect = tuple[float, float, float, float]
"""u0, v0, u1, v1 of a section in the site's axes, metres."""
ROOF_PARKING_SHARE = 0.06
"""How often a lot to train on lies on a roof."""


@dataclass(frozen=True, slots=True)
class SiteSize:
    """Range of the main section's width and depth in metres, and how often there is a second one (0..1)."""

    width: tuple[float, float]
    depth: tuple[float, float]
    second: float


def plan_lot_site(rng: np.random.Generator, centre: tuple[float, float], size: SiteSize, *, calm: bool = False) -> Plan:
    """Plan a lot about ``centre`` (metres) with its surroundings."""
    plan = _empty_plan(rng, centre, calm=calm)
    sections, links = _sections(rng, size)
    whole = sections if calm else [_widened(rng, r) for r in sections]
    lots = _outlines(plan.axes, [*whole, *links])
    u0, v0, u1, v1 = (f(r[k] for r in whole) for k, f in enumerate((min, min, max, max)))
    _surround(plan, rng, (u0, v0, u1, v1), calm=calm)
    if not calm and rng.random() < ROOF_PARKING_SHARE:
        _raise_deck(plan, rng, lots)
    plan.settle()
    for outline in lots:
        plan.lay(Surface(outline, plan.asphalt))
    plan.lots.extend(lots)
    style = sample_style(rng, calm=calm)
    for r in sections:
        corner = plan.axes.moved(r[0], r[1])
        width, depth = r[2] - r[0], r[3] - r[1]
        asphalt_details(plan, rng, corner, width, depth)
        plan_clutter(plan, rng, corner, width, depth)
        if rng.random() < 0.25:  # rows across
            plan_section(plan, rng, plan.axes.moved(r[2], r[1]).facing((0, 1), (-1, 0)), depth, width, style)
        else:
            plan_section(plan, rng, corner, width, depth, style)
    if not calm and rng.random() < 0.2:
        turned = Axes.turned(plan.axes.at(*rng.normal(0, 15, 2)), rng.uniform(0, 2 * math.pi))
        plan.shades.append(turned.rect(0, -200, 200, 200))
    return plan


def plan_plain_site(rng: np.random.Generator, centre: tuple[float, float]) -> Plan:
    """Plan one or two pairs of rows on one even ground about ``centre`` (metres), with next to nothing around them.

    A lot is a lot without roads, kerbs and trees around it; nothing but the rows themselves tells it here.
    """
    plan = _empty_plan(rng, centre, calm=False)
    plan.asphalt = _even(rng, plan.asphalt)
    plan.palette = sample_palette(rng, float(np.mean(plan.asphalt.colour)))
    plan.wear = rng.uniform(0, 0.5)
    far = Axes.turned(centre, 0.0).rect(-REACH_M, -REACH_M, REACH_M, REACH_M)
    plan.lay(Surface(far, plan.asphalt))
    style = replace(sample_style(rng), side_rows=0.0, medians=0.0, break_share=0.0)
    depth = style.aisle * rng.uniform(1.0, 2.2) + style.depth * int(rng.choice([1, 2, 2, 4]))
    width, edge = rng.uniform(14, 60), rng.uniform(1, 7)
    corner = plan.axes.moved(-width / 2, -depth / 2)
    plan.lots.append(corner.rect(-edge, -edge, width + edge, depth + edge))
    if rng.random() < 0.4:
        asphalt_details(plan, rng, corner, width, depth)
    plan_section(plan, rng, corner, width, depth, style)
    return plan


def plan_bare_site(rng: np.random.Generator, centre: tuple[float, float]) -> Plan:
    """Plan a place about ``centre`` (metres) where nobody parks."""
    plan = _empty_plan(rng, centre, calm=False)
    plan_wild(plan, rng, plan.axes)
    if rng.random() < 0.5:
        plan_premises(plan, rng, plan.axes.moved(0, rng.uniform(-25, 0)), rng.uniform(20, 40))
    plan.settle()
    return plan


def _empty_plan(rng: np.random.Generator, centre: tuple[float, float], *, calm: bool) -> Plan:
    kind = "asphalt" if calm else str(rng.choice(["asphalt", "concrete", "pavers"], p=[0.88, 0.08, 0.04]))
    asphalt = sample_material(rng, kind)
    asphalt = _darkened(asphalt, 165 if calm else 182)  # white paint must show on it
    return Plan(
        axes=Axes.turned(centre, rng.uniform(0, 2 * math.pi)),
        ground=sample_material(rng, str(rng.choice(["grass", "dirt", "concrete", "grass"]))),
        asphalt=asphalt,
        palette=sample_palette(rng, float(np.mean(asphalt.colour)), calm=calm),
        wear=rng.uniform(0.1, 0.9) if calm else rng.uniform(0.0, 0.75),
        wet=rng.uniform(0.2, 1.0) if not calm and rng.random() < 0.06 else 0.0,
    )


def _even(rng: np.random.Generator, material: Material) -> Material:
    """Return a material of the same grain or less, in any tone of grey."""
    share = float(rng.choice([0.0, rng.uniform(0, 1)]))
    grain, mottle, blotch = (share * value for value in (material.grain, material.mottle, material.blotch))
    return replace(material, colour=grey(rng, 35, 175), grain=grain, mottle=mottle, blotch=blotch, joints=0.0)


def _raise_deck(plan: Plan, rng: np.random.Generator, lots: list[Points]) -> None:
    """Put a lot on a roof: a parapet around it, and what lies below in its shade."""
    plan.asphalt = _darkened(sample_material(rng, "concrete" if rng.random() < 0.7 else "roof"), 182)
    plan.palette = sample_palette(rng, float(np.mean(plan.asphalt.colour)))
    wall = grey(rng, 90, 240)
    shade, reach = rng.uniform(0.35, 0.8), rng.uniform(-9, 9, 2)
    for outline in lots:
        plan.change(outline + reach, shade, soften=0.2)
        area = np.asarray(shapely.Polygon(outline).buffer(0.4, join_style="mitre").exterior.coords)[:-1]
        plan.lay(Surface(area, Material("concrete", wall, 0.02, 0.02, 0.02)))


def _darkened(material: Material, brightest: float) -> Material:
    scale = min(1.0, brightest / max(material.colour))
    blue, green, red = (channel * scale for channel in material.colour)
    return Material(
        material.kind,
        (blue, green, red),
        material.grain,
        material.mottle,
        material.blotch,
        material.hue,
        material.joints,
    )


def _sections(rng: np.random.Generator, size: SiteSize) -> tuple[list[Rect], list[Rect]]:
    """Return the sections with stalls, and the links (aisles) between those that do not touch."""
    width, depth = rng.uniform(*size.width), rng.uniform(*size.depth)
    main = (-width / 2, -depth / 2, width / 2, depth / 2)
    if rng.random() >= size.second:
        return [main], []
    second_width, second_depth = width * rng.uniform(0.35, 0.6), depth * rng.uniform(0.4, 0.8)
    gap = 0.0 if rng.random() < 0.6 else rng.uniform(2.5, 7)
    low = -depth / 2 if rng.random() < 0.5 else depth / 2 - second_depth
    shift = second_width / 2
    main = (main[0] - shift, main[1], main[2] - shift, main[3])
    second = (main[2] + gap, low, main[2] + gap + second_width, low + second_depth)
    middle = low + second_depth * rng.uniform(0.3, 0.7)
    links = [(main[2] - 0.5, middle - 3.5, second[0] + 0.5, middle + 3.5)] if gap else []
    return [main, second], links


def _widened(rng: np.random.Generator, rect: Rect) -> Rect:
    """Return a section with lanes and spare ground around its rows, on some sides."""
    a, b, c, d = (float(rng.choice([0.0, 0.0, 0.0, rng.uniform(1.5, 9)])) for _ in range(4))
    return rect[0] - a, rect[1] - b, rect[2] + c, rect[3] + d


def _outlines(axes: Axes, rects: list[Rect]) -> list[Points]:
    boxes = [shapely.box(*r).buffer(0.005, join_style="mitre") for r in rects]
    union = shapely.union_all(boxes).simplify(0.02)
    parts = union.geoms if hasattr(union, "geoms") else [union]
    return [axes.points(np.asarray(part.exterior.coords)[:-1]) for part in parts]


def _surround(plan: Plan, rng: np.random.Generator, bounds: Rect, *, calm: bool) -> None:
    u0, v0, u1, v1 = bounds
    middle_u, middle_v = (u0 + u1) / 2, (v0 + v1) / 2
    sides = [
        (plan.axes.moved(middle_u, v0).facing((1, 0), (0, -1)), (u1 - u0) / 2),
        (plan.axes.moved(middle_u, v1).facing((1, 0), (0, 1)), (u1 - u0) / 2),
        (plan.axes.moved(u0, middle_v).facing((0, 1), (-1, 0)), (v1 - v0) / 2),
        (plan.axes.moved(u1, middle_v).facing((0, 1), (1, 0)), (v1 - v0) / 2),
    ]
    kinds: list[str | None] = [None] * 4
    if calm:  # every simulated lot has a road and a building
        kinds[0], kinds[1] = "road", "building"
    for k in rng.permutation(4):
        axes, span = sides[k]
        if not calm and rng.random() < 0.2:
            plan_premises(plan, rng, axes.moved(0, rng.uniform(0, 4)), max(span, 15.0))
        else:
            plan_side(plan, rng, axes, span, kind=kinds[k])
