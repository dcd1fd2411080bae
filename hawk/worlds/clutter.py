"""Small things that lie or stand about: manholes, people, bins, shopping-cart bays, containers, puddles."""

from __future__ import annotations

import math

import numpy as np

from hawk.worlds.canvas import Canvas, noise
from hawk.worlds.cars import outline
from hawk.worlds.materials import grey
from hawk.worlds.plan import Axes, Block, Building, Plan


def plan_clutter(plan: Plan, rng: np.random.Generator, axes: Axes, width: float, depth: float) -> None:
    """Scatter small things over the rectangle [0, width] x [0, depth] of a lot."""
    area = width * depth / 1500
    for _ in range(rng.poisson(1.5 * area)):  # manholes and drains
        x, y = axes.at(rng.uniform(0, width), rng.uniform(0, depth))
        angles = np.linspace(0, 2 * math.pi, 10)[:-1]
        ring = np.array([x, y]) + rng.uniform(0.28, 0.4) * np.stack([np.cos(angles), np.sin(angles)], 1)
        plan.change(ring, float(rng.choice([0.6, 0.75, 1.25])), soften=0.02)
    for _ in range(rng.poisson(0.8 * area)):  # people
        x, y = axes.at(rng.uniform(0, width), rng.uniform(0, depth))
        body = outline(x, y, rng.uniform(0, 6.28), 0.3, 0.55)
        plan.blocks.append(Block(body, 1.6, grey(rng, 20, 220, 25)))
    for _ in range(rng.poisson(0.25 * area)):  # bins, boxes, pallets
        x, y = axes.at(rng.uniform(0, width), rng.uniform(0, depth))
        size = rng.uniform(0.6, 2.2, 2)
        body = outline(x, y, axes.angle + rng.normal(0, 0.2), float(size[0]), float(size[1]))
        plan.blocks.append(Block(body, rng.uniform(0.4, 1.3), grey(rng, 25, 200, 30)))


def plan_containers(plan: Plan, rng: np.random.Generator, axes: Axes) -> None:
    """Put freight containers side by side from the origin of ``axes`` on: much like stalls, and none."""
    length, gap = float(rng.choice([6.1, 12.2])), float(rng.choice([0.1, 0.4, 1.2]))
    for k in range(int(rng.integers(2, 11))):
        if rng.random() < 0.85:
            place = axes.moved(k * (2.44 + gap), rng.normal(0, 0.15))
            plan.buildings.append(Building(place, 2.44, length, 2.6 * float(rng.choice([1, 1, 2]))))


def draw_puddles(canvas: Canvas, wet: float, rng: np.random.Generator) -> None:
    """Make the ground wet (0..1): darker, with puddles that mirror the sky."""
    if wet <= 0:
        return
    per_metre = 1 / canvas.metres_per_pixel
    field = noise(rng, canvas.height, canvas.width, [9 * per_metre, 2.5 * per_metre], [0.7, 0.35])
    damp = np.clip(0.6 + field, 0, 1)[..., None]
    canvas.image *= 1 - np.float32(0.4 * wet) * damp
    puddle = np.clip((field - (1.15 - 0.3 * wet)) * 6, 0, 1)[..., None] * np.float32(0.75)
    sky = np.array(grey(rng, 90, 215, 4), np.float32)
    canvas.image += (sky - canvas.image) * puddle
