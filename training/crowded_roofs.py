"""Crowded roofs: seams, walkways, skylights, units and ducts in rows, easily taken for stalls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hawk.worlds.plan import Building
from hawk.worlds.scene.buildings import ROOF_AXES, draw_box, shadow_on_roof
from hawk.worlds.scene.canvas import Canvas, Points
from hawk.worlds.scene.light import Sun
from hawk.worlds.scene.materials import Colour, grey

_RIM_M = 1.0
_FLAT_M = 0.2
"""Lower things cast no shadow that shows, metres."""


@dataclass(frozen=True, slots=True)
class _Roof:
    """A roof to draw on: canvas, size (metres), shadow per metre of height, and the light left in it (B, G, R)."""

    canvas: Canvas
    width: float
    depth: float
    cast: Points
    gain: tuple[float, float, float]


def draw_crowd(rng: np.random.Generator, canvas: Canvas, building: Building, sun: Sun) -> None:
    """Crowd a roof on its canvas, whose axes are the building's (u right, v down)."""
    roof = _Roof(canvas, building.width, building.depth, shadow_on_roof(building, sun), sun.gain)
    if rng.random() < 0.35:
        _raised_part(rng, roof)
    if rng.random() < 0.75:
        _seam_field(rng, roof)
    if rng.random() < 0.3:
        _stripes(rng, roof)
    for _ in range(int(rng.choice([0, 1, 1, 2]))):
        _field(rng, roof)
    for _ in range(int(rng.choice([0, 0, 2, 5]))):
        _duct(rng, roof)


def _raised_part(rng: np.random.Generator, roof: _Roof) -> None:
    """Raise a part of the roof, in another tone."""
    u, v = rng.uniform(0, 0.7, 2) * (roof.width, roof.depth)
    du, dv = rng.uniform(0.2, 0.7, 2) * (roof.width, roof.depth)
    _box(roof, ROOF_AXES.rect(u, v, min(u + du, roof.width), min(v + dv, roof.depth)), rng.uniform(0.3, 3), _tone(rng))


def _seam_field(rng: np.random.Generator, roof: _Roof) -> None:
    """Seams at the distance of stall lines or closer, darker or lighter than the roof; often cut to lengths."""
    step = rng.uniform(1.4, 4.5)
    length = rng.uniform(4, 12) if rng.random() < 0.5 else 400.0
    change = 1 + rng.choice([rng.uniform(-0.35, -0.05), rng.uniform(0.04, 0.3)])
    width, along = rng.uniform(0.06, 0.2), rng.random() < 0.5
    far, long = (roof.depth, roof.width) if along else (roof.width, roof.depth)
    low, high = sorted(rng.uniform(0, 1, 2)) if rng.random() < 0.4 else (0.0, 1.0)
    for place in np.arange(rng.uniform(0, step), far, step).tolist():
        for start in np.arange(low * long, high * long, length).tolist():
            end = min(start + 0.96 * length, high * long)
            ends = [(start, place), (end, place)] if along else [(place, start), (place, end)]
            roof.canvas.gain(roof.canvas.strip(ROOF_AXES.points(ends), width), float(change))


def _stripes(rng: np.random.Generator, roof: _Roof) -> None:
    """Paint walkways and borders in light or yellow paint."""
    colour = grey(rng, 190, 250) if rng.random() < 0.6 else (60.0, 190.0, 225.0)
    width = rng.uniform(0.08, 0.25)
    for _ in range(int(rng.integers(1, 5))):
        place, across = rng.uniform(0, 1), rng.random() < 0.5
        for offset in (0.0, rng.uniform(0.8, 3.0)):
            ends = [(0.0, place), (1.0, place)] if across else [(place, 0.0), (place, 1.0)]
            points = np.array(ends) * (roof.width, roof.depth) + ((0, offset) if across else (offset, 0))
            roof.canvas.cover(roof.canvas.strip(ROOF_AXES.points(points), width), colour, 0.8)


def _field(rng: np.random.Generator, roof: _Roof) -> None:
    """Put skylights or units in rows, some of the size and at the distance of parked cars."""
    size = rng.uniform((0.6, 0.8), (2.3, 5.0))
    if rng.random() < 0.5:
        size = size[::-1]
    pitch = size + rng.uniform(0.3, 5.0, 2)
    height = float(rng.choice([0.05, 0.3, rng.uniform(0.5, 2.0)]))
    colour, inner, gaps = _tone(rng), _tone(rng), rng.uniform(0, 0.5)
    first, count = rng.uniform(0, 0.6, 2) * (roof.width, roof.depth) + _RIM_M, rng.integers((1, 1), (14, 6))
    for i in range(int(count[0])):
        for k in range(int(count[1])):
            u, v = first + pitch * (i, k)
            if u + size[0] > roof.width - _RIM_M or v + size[1] > roof.depth - _RIM_M or rng.random() < gaps:
                continue
            box = ROOF_AXES.rect(u, v, u + size[0], v + size[1])
            _box(roof, box, height, colour)
            roof.canvas.cover(roof.canvas.patch(box.mean(0) + (box - box.mean(0)) * 0.6), inner, 0.7)


def _duct(rng: np.random.Generator, roof: _Roof) -> None:
    """Draw a long narrow box."""
    u, v = rng.uniform(0.05, 0.8, 2) * (roof.width, roof.depth)
    length, wide = rng.uniform(2, 14), rng.uniform(0.3, 1.0)
    du, dv = (length, wide) if rng.random() < 0.5 else (wide, length)
    _box(
        roof, ROOF_AXES.rect(u, v, min(u + du, roof.width), min(v + dv, roof.depth)), rng.uniform(0.3, 1.0), _tone(rng)
    )


def _box(roof: _Roof, box: Points, height: float, colour: Colour) -> None:
    if height > _FLAT_M:
        draw_box(roof.canvas, box, roof.cast * height, colour, roof.gain)
    else:
        roof.canvas.cover(roof.canvas.patch(box), colour)


def _tone(rng: np.random.Generator) -> Colour:
    return grey(rng, 25, 248, 6)
