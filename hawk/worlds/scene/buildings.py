"""Buildings: walls, and flat roofs with what stands on them."""

from __future__ import annotations

import cv2
import numpy as np

from hawk.worlds.plan import Axes, Building
from hawk.worlds.scene.canvas import Bytes, Canvas, Floats, Points, noise
from hawk.worlds.scene.facets import HeightLayer
from hawk.worlds.scene.light import Sun
from hawk.worlds.scene.materials import Colour, grey, sample_material, texture

_SMALL_M = 6.0
ROOF_AXES = Axes((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
"""Axes of a roof on its own canvas: u right, v down, metres."""


def draw_building(rng: np.random.Generator, building: Building, sun: Sun, metres_per_pixel: float) -> list[HeightLayer]:
    """Return the four walls and the roof."""
    roof = _roof_picture(rng, building, sun, metres_per_pixel)
    corners = building.polygon
    top = HeightLayer(np.column_stack([corners, np.full(4, building.height)]), roof, "roof")
    wall = np.array(grey(rng, 70, 225, 10), np.float32)
    walls = [_wall(corners[k], corners[(k + 1) % 4], building.height, wall, sun) for k in range(4)]
    return [*walls, top]


def _roof_picture(rng: np.random.Generator, building: Building, sun: Sun, metres_per_pixel: float) -> Bytes:
    width = max(8, round(building.width / metres_per_pixel))
    depth = max(8, round(building.depth / metres_per_pixel))
    canvas = Canvas(0.0, 0.0, width, depth, metres_per_pixel)
    material = building.roof or sample_material(rng, "roof")
    canvas.image = texture(rng, material, depth, width, metres_per_pixel)
    if rng.random() < 0.55:
        _seams(rng, canvas, building)
    _stains(rng, canvas)
    if building.crowd is not None:
        building.crowd(rng, canvas, building, sun)
    if min(building.width, building.depth) >= _SMALL_M:
        _furnish(rng, canvas, building, sun)
    _parapet(rng, canvas, material.colour)
    picture = np.clip(canvas.image, 0, 255).astype(np.uint8)
    pixels: Bytes = np.dstack([picture, np.full((depth, width), 255, np.uint8)])
    return pixels


def _furnish(rng: np.random.Generator, canvas: Canvas, building: Building, sun: Sun) -> None:
    """Put panels, ventilators and skylights on a roof."""
    if rng.random() < 0.12:
        _panels(rng, canvas, building)
    cast = shadow_on_roof(building, sun)
    for _ in range(int(rng.choice([0, 2, 5, 14, 24]))):
        _unit(rng, canvas, building, cast, sun)


def shadow_on_roof(building: Building, sun: Sun) -> Points:
    """Return the shadow's offset per metre of height, in the roof's own axes."""
    return np.array([np.dot(sun.shadow, building.axes.u), np.dot(sun.shadow, building.axes.v)])


def draw_box(canvas: Canvas, box: Points, shadow: Points, colour: Colour, gain: tuple[float, float, float]) -> None:
    """Draw a box (4, 2) on a roof, and its shadow: ``shadow`` (2,) is its reach in metres, ``gain`` the light in it."""
    hull = cv2.convexHull(np.concatenate([box, box + shadow]).astype(np.float32))[:, 0]
    canvas.gain(canvas.patch(hull.astype(np.float64)), gain)
    canvas.cover(canvas.patch(box), colour)


def _seams(rng: np.random.Generator, canvas: Canvas, building: Building) -> None:
    step = float(rng.choice([rng.uniform(0.4, 1.2), rng.uniform(1.5, 6)]))
    change, width = 1 + rng.uniform(-0.3, 0.15), rng.uniform(0.05, 0.16)
    along = rng.random() < 0.5
    lines = np.zeros((canvas.height, canvas.width), np.uint8)
    for place in np.arange(step / 2, building.depth if along else building.width, step):
        k = int(place / canvas.metres_per_pixel)
        ends = ((0, k), (canvas.width, k)) if along else ((k, 0), (k, canvas.height))
        cv2.line(lines, ends[0], ends[1], 255, max(1, round(width / canvas.metres_per_pixel)))
    canvas.image *= 1 + (lines.astype(np.float32) / 255 * np.float32(change - 1))[..., None]


def _stains(rng: np.random.Generator, canvas: Canvas) -> None:
    field = noise(
        rng, canvas.height, canvas.width, [6 / canvas.metres_per_pixel, 2 / canvas.metres_per_pixel], [1, 0.5]
    )
    level = np.float32(rng.uniform(0, 0.13))
    canvas.image *= (1 - level * np.clip(field, 0, 1.5))[..., None]


def _panels(rng: np.random.Generator, canvas: Canvas, building: Building) -> None:
    """Put rows of solar panels on the roof."""
    width, depth = (1.0, 1.65) if rng.random() < 0.5 else (1.7, 1.0)
    gap, aisle = rng.uniform(0.02, 0.12), rng.uniform(0.3, 2.2)
    colour = (rng.uniform(55, 120), rng.uniform(35, 70), rng.uniform(20, 50))
    u0, v0 = rng.uniform(1, 0.4 * building.width), rng.uniform(1, 0.4 * building.depth)
    u1, v1 = u0 + rng.uniform(4, 25), v0 + rng.uniform(3, 15)
    for v in np.arange(v0, min(v1, building.depth - depth - 0.5), depth + aisle):
        for u in np.arange(u0, min(u1, building.width - width - 0.5), width + gap):
            canvas.cover(canvas.patch(ROOF_AXES.rect(float(u), float(v), float(u) + width, float(v) + depth)), colour)


def _unit(rng: np.random.Generator, canvas: Canvas, building: Building, cast: Points, sun: Sun) -> None:
    """Put a ventilator, a skylight or a box on the roof."""
    u, v = rng.uniform(1, max(1.5, building.width - 3)), rng.uniform(1, max(1.5, building.depth - 3))
    du, dv = rng.uniform(0.5, 3.6, 2)
    box = ROOF_AXES.rect(u, v, u + du, v + dv)
    height = float(rng.choice([0.1, rng.uniform(0.6, 2.0)]))
    draw_box(canvas, box, cast * height, grey(rng, 50, 240, 6), sun.gain)
    inner = canvas.patch(box.mean(0) + (box - box.mean(0)) * rng.uniform(0.4, 0.85))
    if inner is not None and rng.random() < 0.6:
        canvas.cover(inner, grey(rng, 30, 220, 6))


def _parapet(rng: np.random.Generator, canvas: Canvas, colour: tuple[float, float, float]) -> None:
    if rng.random() < 0.3:
        return
    thick = max(1, round(rng.uniform(0.15, 0.5) / canvas.metres_per_pixel))
    level = np.clip(np.array(colour) * rng.uniform(0.6, 1.3), 10, 250)
    corner = (canvas.width - 1, canvas.height - 1)
    cv2.rectangle(canvas.image, (0, 0), corner, tuple(map(float, level)), thick)


def _wall(start: Points, end: Points, height: float, colour: Floats, sun: Sun) -> HeightLayer:
    along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-6)
    outward = np.array([along[1], -along[0]])  # the footprint runs clockwise on the map (x east, y south)
    lit = -float(np.dot(outward, sun.shadow)) / (float(np.hypot(*sun.shadow)) + 1e-6)
    pixels = np.full((1, 1, 4), 255, np.uint8)
    pixels[..., :3] = np.clip(colour * np.float32(0.62 + 0.28 * lit), 0, 255)
    upper = np.array([[*start, height], [*end, height], [*end, 0.0], [*start, 0.0]])
    return HeightLayer(upper - [0, 0, 0.01], pixels, "wall")
