"""Decks: the top of a parking garage, of concrete or of panels in other tones, with parapets, ramps and lamps."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
import shapely

from hawk.worlds.generate import SiteSize, darkened, empty_plan, fill_lots, outlines, plan_sections, sides_of
from hawk.worlds.plan import Axes, Block, Post, SitePlan
from hawk.worlds.scene.canvas import Points
from hawk.worlds.scene.materials import Material, grey, sample_material
from hawk.worlds.scene.surroundings import plan_side
from hawk.worlds.style import LotStyle, sample_palette, sample_style
from training.sites import wall_in

_PANEL_M: Final = ((2.2, 9.0), (4.0, 16.0))
"""Sides of the panels."""
_PANELS_SHARE: Final = 0.6
_STALL_PANELS_SHARE: Final = 0.35
"""Share of the decks with a panel on each stall, darker than the aisle: no car, though as large and as dark as one."""
_BRIGHT: Final = (165.0, 225.0)
_PARAPET_M: Final = 0.35


def plan_deck_site(rng: np.random.Generator, centre: tuple[float, float], size: SiteSize) -> SitePlan:
    """Plan a deck about ``centre`` (metres), higher than what lies around it."""
    plan = empty_plan(rng, centre, calm=False)
    sections, links = plan_sections(rng, size)
    lots = outlines(plan.axes, [*sections, *links])
    sides = sides_of(plan.axes, sections)
    for k in rng.permutation(4):
        plan_side(plan, rng, *sides[k])
    _surface(plan, rng, lots)
    style = replace(
        sample_style(rng), trees=0.0, medians=0.0, break_share=0.0, ends=(0.8, 0.05, 0.15), worn=0.1, drop=0.02
    )
    plan.wear = rng.uniform(0, 0.3)
    if rng.random() < _STALL_PANELS_SHARE:
        style = replace(style, bays=_tone(rng, plan.asphalt, 0.35, 0.85))
    fill_lots(plan, rng, lots, sections, style)
    _things(plan, rng, lots, style)
    return plan


def _surface(plan: SitePlan, rng: np.random.Generator, lots: list[Points]) -> None:
    """Plan the deck: bright or dark concrete with a parapet, and the shade that it throws below."""
    ground = sample_material(rng, "concrete" if rng.random() < 0.75 else "roof")
    if rng.random() < 0.4:
        ground = replace(ground, colour=grey(rng, *_BRIGHT))
    plan.asphalt = darkened(ground, _BRIGHT[1])
    plan.palette = sample_palette(rng, float(np.mean(plan.asphalt.colour)))
    wall_in(plan, rng, lots)


def _things(plan: SitePlan, rng: np.random.Generator, lots: list[Points], style: LotStyle) -> None:
    """Tone panels, and put parapets and lamps on the deck."""
    for outline in lots:
        area = shapely.Polygon(outline)
        if rng.random() < _PANELS_SHARE:
            _panels(plan, rng, area, style)
        if rng.random() < 0.8:
            _parapet(plan, rng, outline)
        u0, v0, u1, v1 = area.bounds
        for _ in range(int(rng.integers(0, 8))):
            x, y = rng.uniform((u0, v0), (u1, v1)).tolist()
            if area.contains(shapely.Point(x, y)):
                plan.posts.append(Post(x, y, rng.uniform(4, 7), rng.uniform(0, 6.28)))


def _panels(plan: SitePlan, rng: np.random.Generator, area: shapely.Polygon, style: LotStyle) -> None:
    """Make slabs of the deck lighter or darker than others: by rows, or anywhere."""
    along, across = (float(rng.uniform(*sides)) for sides in _PANEL_M)
    if rng.random() < 0.5:
        along, across = style.pitch * int(rng.integers(1, 4)), style.depth
    spread, busy = rng.uniform(0.05, 0.3), rng.uniform(0.1, 0.9)
    span = max(area.bounds[2] - area.bounds[0], area.bounds[3] - area.bounds[1]) * 0.75
    middle = area.centroid
    axes = Axes((middle.x, middle.y), plan.axes.u, plan.axes.v)
    for u in np.arange(-span, span, along).tolist():
        for v in np.arange(-span, span, across).tolist():
            if rng.random() < busy:
                panel = shapely.intersection(shapely.Polygon(axes.rect(u, v, u + along, v + across)), area)
                if panel.geom_type == "Polygon" and panel.area > 1:
                    corners = np.asarray(panel.exterior.coords)[:-1]
                    plan.change(corners, float(np.exp(rng.normal(0, spread))), soften=0.02)


def _parapet(plan: SitePlan, rng: np.random.Generator, outline: Points) -> None:
    """Put a wall along the deck's edge, which throws shade onto the stalls beside it."""
    height, colour = rng.uniform(0.8, 1.6), grey(rng, 90, 240)
    for start, end in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        strip = shapely.LineString([start, end]).buffer(_PARAPET_M / 2, cap_style="flat")
        plan.blocks.append(Block(np.asarray(strip.exterior.coords)[:-1], height, colour))


def _tone(rng: np.random.Generator, material: Material, low: float, high: float) -> Material:
    blue, green, red = (np.array(material.colour) * rng.uniform(low, high)).tolist()
    return replace(material, colour=(blue, green, red), joints=0.0)
