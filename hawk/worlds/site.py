"""Whole sites: a lot of one or two sections with its surroundings."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import shapely

from hawk.worlds.canvas import Points
from hawk.worlds.layout import asphalt_details, plan_section
from hawk.worlds.materials import Material, sample_material
from hawk.worlds.plan import Axes, SitePlan, Surface
from hawk.worlds.style import LotStyle, sample_palette, sample_style
from hawk.worlds.surroundings import plan_clutter, plan_side

Rect = tuple[float, float, float, float]
"""u0, v0, u1, v1 of a section in the site's axes, metres."""


@dataclass(frozen=True, slots=True)
class SiteSize:
    """Range of the main section's width and depth in metres, and the probability of a second one."""

    width: tuple[float, float]
    depth: tuple[float, float]
    second: float


def plan_lot_site(rng: np.random.Generator, centre: tuple[float, float], size: SiteSize) -> SitePlan:
    """Plan a usual lot about ``centre`` (metres) with its surroundings, a road and a building among them."""
    plan = empty_plan(rng, centre, calm=True)
    sections, links = plan_sections(rng, size)
    lots = outlines(plan.axes, [*sections, *links])
    sides, kinds = sides_of(plan.axes, sections), ("road", "building", None, None)
    for k in rng.permutation(4):
        plan_side(plan, rng, *sides[k], kind=kinds[k])
    fill_lots(plan, rng, lots, sections, sample_style(rng, calm=True))
    return plan


def fill_lots(
    plan: SitePlan, rng: np.random.Generator, lots: list[Points], sections: list[Rect], style: LotStyle
) -> None:
    """Cover the outlines of the lots with asphalt, and fill their sections with rows and small things."""
    plan.settle()
    for outline in lots:
        plan.add_surface(Surface(outline, plan.asphalt))
    plan.lots.extend(lots)
    for r in sections:
        corner = plan.axes.moved(r[0], r[1])
        width, depth = r[2] - r[0], r[3] - r[1]
        asphalt_details(plan, rng, corner, width, depth)
        plan_clutter(plan, rng, corner, width, depth)
        if rng.random() < 0.25:  # rows across
            plan_section(plan, rng, plan.axes.moved(r[2], r[1]).facing((0, 1), (-1, 0)), depth, width, style)
        else:
            plan_section(plan, rng, corner, width, depth, style)


def empty_plan(rng: np.random.Generator, centre: tuple[float, float], *, calm: bool) -> SitePlan:
    """Return a plan of ground and asphalt only; ``calm`` ones are those of most lots."""
    kind = "asphalt" if calm else str(rng.choice(["asphalt", "concrete", "pavers"], p=[0.88, 0.08, 0.04]))
    asphalt = sample_material(rng, kind)
    asphalt = darkened(asphalt, 165 if calm else 182)  # white paint must show on it
    return SitePlan(
        axes=Axes.turned(centre, rng.uniform(0, 2 * math.pi)),
        ground=sample_material(rng, str(rng.choice(["grass", "dirt", "concrete", "grass"]))),
        asphalt=asphalt,
        palette=sample_palette(rng, float(np.mean(asphalt.colour)), calm=calm),
        wear=rng.uniform(0.1, 0.9) if calm else rng.uniform(0.0, 0.75),
        wet=rng.uniform(0.2, 1.0) if not calm and rng.random() < 0.06 else 0.0,
    )


def darkened(material: Material, brightest: float) -> Material:
    """Return the material no brighter than ``brightest`` (0..255)."""
    scale = min(1.0, brightest / max(material.colour))
    blue, green, red = (channel * scale for channel in material.colour)
    return replace(material, colour=(blue, green, red))


def plan_sections(rng: np.random.Generator, size: SiteSize) -> tuple[list[Rect], list[Rect]]:
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


def outlines(axes: Axes, rects: list[Rect]) -> list[Points]:
    """Return the outlines (N, 2) of rectangles of ``axes``, those that touch as one; metres."""
    boxes = [shapely.box(*r).buffer(0.005, join_style="mitre") for r in rects]
    union = shapely.union_all(boxes).simplify(0.02)
    parts = union.geoms if hasattr(union, "geoms") else [union]
    return [axes.points(np.asarray(part.exterior.coords)[:-1]) for part in parts]


def sides_of(axes: Axes, rects: list[Rect]) -> list[tuple[Axes, float]]:
    """Return the four sides of the box about sections: axes at its middle with v outwards, and half its length."""
    u0, v0, u1, v1 = (f(r[k] for r in rects) for k, f in enumerate((min, min, max, max)))
    middle_u, middle_v = (u0 + u1) / 2, (v0 + v1) / 2
    return [
        (axes.moved(middle_u, v0).facing((1, 0), (0, -1)), (u1 - u0) / 2),
        (axes.moved(middle_u, v1).facing((1, 0), (0, 1)), (u1 - u0) / 2),
        (axes.moved(u0, middle_v).facing((0, 1), (-1, 0)), (v1 - v0) / 2),
        (axes.moved(u1, middle_v).facing((0, 1), (1, 0)), (v1 - v0) / 2),
    ]
