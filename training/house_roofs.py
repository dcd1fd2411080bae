"""Roofs of houses: ridge, solar panels, dormers, windows and chimneys, and the pale rims of sheds."""

from __future__ import annotations

from typing import Final

import numpy as np

from hawk.worlds.plan import Building
from hawk.worlds.scene.buildings import ROOF_AXES, draw_box, shadow_on_roof
from hawk.worlds.scene.canvas import Canvas, Points
from hawk.worlds.scene.cars import outline
from hawk.worlds.scene.light import Sun
from hawk.worlds.scene.materials import grey

_HOUSE_M: Final = (4.8, 7.0)
"""Width of one house in its terrace."""
_PANEL_M: Final = (1.0, 1.65)
_SLOPE_LIGHT: Final = 0.35
"""Change of a slope's brightness for each metre of shadow that the sun casts over it from a metre of height."""
_SOLAR_SHARE: Final = 0.35
_DORMER_SHARE: Final = 0.4


def draw_house_roofs(rng: np.random.Generator, canvas: Canvas, building: Building, sun: Sun) -> None:
    """Draw a terrace's two slopes (the ridge along u) and what its houses have on them."""
    cast = shadow_on_roof(building, sun)
    ridge = building.depth * rng.uniform(0.4, 0.6)
    for (v0, v1), facing in (((0.0, ridge), 1.0), ((ridge, building.depth), -1.0)):
        light = 1 + _SLOPE_LIGHT * float(np.clip(facing * cast[1], -1.2, 0.8))
        canvas.gain(canvas.patch(ROOF_AXES.rect(0, v0, building.width, v1)), light)
    tone = grey(rng, 60, 190, 6)
    canvas.cover(canvas.strip(ROOF_AXES.points([(0, ridge), (building.width, ridge)]), 0.25), tone, 0.7)
    wide = rng.uniform(*_HOUSE_M)
    for u in np.arange(0, building.width - 0.6 * wide, wide).tolist():
        canvas.gain(canvas.strip(ROOF_AXES.points([(u, 0), (u, building.depth)]), 0.12), float(rng.uniform(0.75, 1.3)))
        for v0, v1 in ((0.4, ridge - 0.3), (ridge + 0.3, building.depth - 0.4)):
            slope = (u + 0.3, v0, min(u + wide, building.width) - 0.3, v1)
            if rng.random() < _SOLAR_SHARE:
                _solar(rng, canvas, slope)
            elif rng.random() < _DORMER_SHARE:
                _dormer(rng, canvas, slope, cast, sun)
            elif rng.random() < 0.4:
                _window(rng, canvas, slope)
        if rng.random() < 0.6:
            place = (u + rng.uniform(0.2, wide - 0.2), ridge + rng.normal(0, 0.5))
            draw_box(canvas, outline(*place, 0.0, 0.7, 0.9), 1.2 * cast, grey(rng, 50, 170, 15), sun.gain)


def draw_shed_roof(rng: np.random.Generator, canvas: Canvas, building: Building, sun: Sun) -> None:
    """Draw a flat roof of felt with a rim, often a pale one, as sheds and extensions have."""
    del sun
    whole = ROOF_AXES.rect(0, 0, building.width, building.depth)
    canvas.cover(canvas.patch(whole), grey(rng, 190, 250, 5) if rng.random() < 0.6 else grey(rng, 40, 190, 8))
    rim = rng.uniform(0.1, 0.3)
    inner = ROOF_AXES.rect(rim, rim, building.width - rim, building.depth - rim)
    canvas.cover(canvas.patch(inner), grey(rng, 30, 150, 8))


def _solar(rng: np.random.Generator, canvas: Canvas, slope: tuple[float, float, float, float]) -> None:
    """Cover a part of a slope (u0, v0, u1, v1; metres) with panels in rows, their frames showing or not."""
    u0, v0, u1, v1 = slope
    wide, deep = _PANEL_M if rng.random() < 0.6 else _PANEL_M[::-1]
    deep *= rng.uniform(0.75, 1.0)  # a slope looks shorter from above
    gap = rng.uniform(0.02, 0.09)
    columns, rows = int((u1 - u0) / (wide + gap)), int((v1 - v0) / (deep + gap))
    if min(columns, rows) < 1:
        return
    columns, rows = int(rng.integers(1, columns + 1)), int(rng.integers(1, rows + 1))
    u0 += rng.uniform(0, u1 - u0 - columns * (wide + gap))
    v0 += rng.uniform(0, v1 - v0 - rows * (deep + gap))
    if rng.random() < 0.6:
        back = ROOF_AXES.rect(u0 - gap, v0 - gap, u0 + columns * (wide + gap), v0 + rows * (deep + gap))
        canvas.cover(canvas.patch(back), grey(rng, 120, 225, 5))
    colour = (rng.uniform(45, 120), rng.uniform(30, 70), rng.uniform(18, 55))
    left_out = rng.choice([0.0, 0.0, 0.12])
    for i in range(columns):
        for k in range(rows):
            if rng.random() >= left_out:
                u, v = u0 + i * (wide + gap), v0 + k * (deep + gap)
                canvas.cover(canvas.patch(ROOF_AXES.rect(u, v, u + wide, v + deep)), colour)


def _dormer(
    rng: np.random.Generator,
    canvas: Canvas,
    slope: tuple[float, float, float, float],
    cast: Points,
    sun: Sun,
) -> None:
    """Put a dormer on a slope: a flat roof with a pale rim, and its shadow."""
    u0, v0, u1, v1 = slope
    wide, deep = min(rng.uniform(1.8, 5.0), u1 - u0), min(rng.uniform(1.6, 3.2), v1 - v0)
    u, v = u0 + rng.uniform(0, u1 - u0 - wide + 0.01), v0 + rng.uniform(0, v1 - v0 - deep + 0.01)
    box = ROOF_AXES.rect(u, v, u + wide, v + deep)
    draw_box(canvas, box, rng.uniform(0.7, 1.6) * cast, grey(rng, 150, 250, 5), sun.gain)
    rim = rng.uniform(0.08, 0.3)
    canvas.cover(canvas.patch(ROOF_AXES.rect(u + rim, v + rim, u + wide - rim, v + deep - rim)), grey(rng, 35, 190, 8))


def _window(rng: np.random.Generator, canvas: Canvas, slope: tuple[float, float, float, float]) -> None:
    u, v = rng.uniform(slope[:2], slope[2:]).tolist()
    canvas.cover(canvas.patch(outline(u, v, 0.0, 0.8, 1.1)), grey(rng, 40, 230, 15))
