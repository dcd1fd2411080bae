"""Lots without white lines: bricks, slabs, gravel or grass grids; stones, corners, blocks or cars part the stalls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from hawk.worlds.generate import SiteSize, darkened, empty_plan, fill_lots, outlines, plan_sections, sides_of
from hawk.worlds.plan import SitePlan
from hawk.worlds.scene.materials import Material, grey, sample_material
from hawk.worlds.scene.surroundings import plan_side
from hawk.worlds.style import LotStyle, Marks, sample_style

_GROUNDS: Final = ("clinker", "clinker", "pavers", "gravel", "grass grid", "asphalt", "dirt")
_BAYS: Final = ("clinker", "pavers", "grass grid", "gravel", "asphalt")
_BAYS_SHARE: Final = 0.5
"""Share of the lots whose stalls have another ground than their aisles."""
MARKS: Final[tuple[Marks, ...]] = ("lines", "dots", "tees", "corners", "blocks")
"""Marks between two stalls of such lots."""
_MARKS_SHARES: Final = (0.45, 0.2, 0.1, 0.12, 0.13)
_UNMARKED_SHARE: Final = 0.3
"""Share of the lots in which nothing parts two stalls."""
_MOSSY_SHARE: Final = 0.3
"""Share of those bays that have the aisles' stones, with moss between them."""
_BRIGHTEST: Final = 182.0
_STONES_DARKER: Final = 0.6
"""Share of the rows of stones that are darker than the ground."""
_CONTRAST: Final = (14.0, 60.0)
"""Levels between such stones and the ground."""


def plan_paved_site(
    rng: np.random.Generator,
    centre: tuple[float, float],
    size: SiteSize,
    change: Callable[[LotStyle], LotStyle] = lambda style: style,
) -> SitePlan:
    """Plan a lot without paint about ``centre`` (metres), with its surroundings; ``change`` changes its style."""
    plan = empty_plan(rng, centre, calm=False)
    style = change(pave(plan, rng))
    sections, links = plan_sections(rng, size)
    lots = outlines(plan.axes, [*sections, *links])
    sides = sides_of(plan.axes, sections)
    for k in rng.permutation(4):
        plan_side(plan, rng, *sides[k])
    fill_lots(plan, rng, lots, sections, style)
    return plan


def pave(plan: SitePlan, rng: np.random.Generator) -> LotStyle:
    """Give a plan ground and stones in place of asphalt and paint; return a style of stalls to go with them."""
    plan.asphalt = darkened(sample_material(rng, str(rng.choice(_GROUNDS))), _BRIGHTEST)
    bays: Material | None = None
    if rng.random() < _BAYS_SHARE:
        bays = darkened(sample_material(rng, str(rng.choice(_BAYS))), _BRIGHTEST)
        if rng.random() < _MOSSY_SHARE:
            bays = _mossy(rng, plan.asphalt)
    stalls = bays or plan.asphalt
    plan.palette[0] = plan.palette[1] = _stones(rng, float(np.mean(stalls.colour)))
    plan.wear = rng.uniform(0.0, 0.4)
    plan.bare = float(rng.choice([0.0, 0.5, 1.0]))
    style = sample_style(rng)
    return replace(
        style,
        width=rng.uniform(2.3, 2.6),
        length=rng.uniform(4.8, 5.4),
        skew=style.skew if rng.random() < 0.3 else 0.0,
        line_width=rng.uniform(0.08, 0.2),
        marks=MARKS[int(rng.choice(len(MARKS), p=_MARKS_SHARES))],
        unpainted=bool(rng.random() < _UNMARKED_SHARE),
        hairpin=False,
        tees=False,
        hatch=0.0,
        accessible=0.1,
        ends=(0.3, 0.7, 0.0),
        bays=bays,
        occupancy=rng.uniform(0.0, 0.95),
    )


def _mossy(rng: np.random.Generator, ground: Material) -> Material:
    """Return the ground as it looks where nobody drives: darker, a little greener."""
    share = np.array([0.92, 1.0, 0.95]) * rng.uniform(0.72, 0.96)
    blue, green, red = (np.array(ground.colour) * share).tolist()
    return replace(ground, colour=(blue, green, red), mottle=ground.mottle * 1.4)


def _stones(rng: np.random.Generator, ground: float) -> tuple[float, float, float]:
    """Return the colour of stones in a ground of that brightness: some levels darker or lighter."""
    apart = rng.uniform(*_CONTRAST) * (-1 if rng.random() < _STONES_DARKER else 1)
    level = float(np.clip(ground + apart, 25, 245))
    return grey(rng, level - 2, level + 2, 6)
