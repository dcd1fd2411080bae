"""Surroundings of a lot: roads, pavements, buildings, yards, grass, water, sports courts, and small things."""

from __future__ import annotations

import itertools
import math

import numpy as np

from hawk.worlds.plan import Axes, Block, Building, SitePlan, Surface, Vehicle
from hawk.worlds.scene.cars import outline, sample_kind
from hawk.worlds.scene.materials import Material, grey, sample_material

REACH_M = 140.0
"""Depth of the surroundings from a lot's edge."""

_SIDES = ("road", "building", "grass", "yard", "dirt", "wild")


def plan_side(plan: SitePlan, rng: np.random.Generator, axes: Axes, span: float, *, kind: str | None = None) -> None:
    """Plan one side of a lot: ``axes.u`` runs along the edge from its middle, v points away from the lot.

    ``span`` is half the length of the edge; ``kind`` one of road, building, grass, yard, dirt, wild, else drawn.
    """
    kind = kind or str(rng.choice(_SIDES, p=[0.32, 0.34, 0.12, 0.10, 0.05, 0.07]))
    v = _border(plan, rng, axes)
    if kind == "road":
        kerb = v
        v += plan_road(plan, rng, axes.moved(0, kerb))
        v += _border(plan, rng, axes.moved(0, v))
        fill_ground(plan, rng, axes, v, ("grass", "concrete", "dirt", "grass", "gravel"))
        if rng.random() < 0.5:
            _houses(plan, rng, axes.moved(0, v + rng.uniform(1, 8)))
        _driveway(plan, rng, axes, span, kerb)
    elif kind == "building":
        fill_ground(plan, rng, axes, v, ("concrete", "grass", "asphalt", "dirt", "pavers"))
        width = span * rng.uniform(0.6, 1.0) * 2
        shift = rng.uniform(-0.2, 0.2) * span
        building = axes.moved(shift - width / 2, v + rng.choice([0.0, rng.uniform(0, 4)]))
        plan.buildings.append(Building(building, width, rng.uniform(10, 45), rng.uniform(3.5, 11)))
    elif kind == "yard":
        fill_ground(plan, rng, axes, v, ("asphalt", "gravel", "concrete", "asphalt"))
        if rng.random() < 0.5:
            plan_containers(plan, rng, axes.moved(rng.uniform(-0.9, 0.3) * span, v + rng.uniform(1, 10)))
        for _ in range(int(rng.integers(0, 9))):
            x, y = axes.at(rng.uniform(-span, span), v + rng.uniform(3, 30))
            heading = axes.angle + float(rng.choice([0, math.pi / 2, rng.uniform(0, 6.28)]))
            plan.vehicles.append(Vehicle(x, y, heading, sample_kind(rng, "yard")))
    elif kind == "wild":
        material = fill_ground(plan, rng, axes, v, ("grass", "water", "rock", "grass"))
        if material.kind != "water":
            scatter_trees(plan, rng, axes.moved(-span, v + 2), 2 * span, 35, int(rng.integers(4, 40)))
    else:
        fill_ground(plan, rng, axes, v, ("grass",) if kind == "grass" else ("dirt", "gravel"))
        if rng.random() < 0.25:
            plan_court(plan, rng, axes.moved(rng.uniform(-span, span / 2), v + rng.uniform(4, 12)))
        scatter_trees(plan, rng, axes.moved(-span, v + 2), 2 * span, 25, int(rng.integers(0, 12)))


def plan_road(plan: SitePlan, rng: np.random.Generator, axes: Axes) -> float:
    """Plan a road along ``axes.u`` with its near kerb at v = 0; return its width (metres)."""
    width = rng.uniform(6.5, 21)
    asphalt = plan.asphalt if rng.random() < 0.2 else sample_material(rng, "asphalt")
    kerb = grey(rng, 130, 225) if rng.random() < 0.7 else None
    plan.add_surface(Surface(axes.rect(-REACH_M, 0, REACH_M, width), asphalt, kerb))
    v = rng.uniform(0.4, 3.2)
    while v < width - 0.3:
        _lane_line(plan, rng, axes.moved(0, v))
        if rng.random() < 0.2:
            _lane_line(plan, rng, axes.moved(0, v + 0.35))
        v += rng.uniform(2.8, 4.0)
    if rng.random() < 0.45:
        _crosswalk(plan, rng, axes.moved(rng.uniform(-25, 25), 0), width)
    for _ in range(int(rng.integers(0, 7))):
        x, y = axes.at(rng.uniform(-45, 45), rng.uniform(1.4, max(1.5, width - 1.4)))
        heading = axes.angle + (math.pi if rng.random() < 0.5 else 0) + rng.normal(0, 0.03)
        plan.vehicles.append(Vehicle(x, y, heading, sample_kind(rng, "road")))
    for _ in range(int(rng.integers(0, 5))):
        u, length = rng.uniform(-50, 50), rng.uniform(2, 25)
        patch = axes.rect(u, rng.uniform(0, width * 0.6), u + length, width * rng.uniform(0.6, 1))
        plan.change(patch, 1 + rng.uniform(-0.2, 0.15), soften=0.04)
    return width


def plan_court(plan: SitePlan, rng: np.random.Generator, axes: Axes) -> None:
    """Plan a sports court with its markings: rectangles and a circle, easily taken for stalls."""
    width, depth = rng.uniform(13, 30), rng.uniform(7, 17)
    plan.add_surface(Surface(axes.rect(-2, -2, width + 2, depth + 2), sample_material(rng, "court")))
    plan.add_surface(Surface(axes.rect(0, 0, width, depth), sample_material(rng, "court")))
    thick, colour = rng.uniform(0.06, 0.14), int(rng.choice([1, 3]))
    corners = [(0, 0), (width, 0), (width, depth), (0, depth), (0, 0)]
    for start, end in itertools.pairwise(corners):
        plan.line(axes.at(*start), axes.at(*end), thick, colour, 0.9)
    for share in (0.22, 0.5, 0.78):
        plan.line(axes.at(width * share, 0), axes.at(width * share, depth), thick, colour, 0.9)
    for share in (0.14, 0.5, 0.86)[: int(rng.integers(1, 4))]:
        plan.line(axes.at(0, depth * share), axes.at(width, depth * share), thick, colour, 0.9)
    ring = [(width / 2 + 1.8 * math.cos(t), depth / 2 + 1.8 * math.sin(t)) for t in np.linspace(0, 2 * math.pi, 17)]
    for start, end in itertools.pairwise(ring):
        plan.line(axes.at(*start), axes.at(*end), thick, colour, 0.9)


def scatter_trees(plan: SitePlan, rng: np.random.Generator, axes: Axes, width: float, depth: float, count: int) -> None:
    """Put trees and bushes anywhere in [0, width] x [0, depth]."""
    for _ in range(count):
        x, y = axes.at(rng.uniform(0, width), rng.uniform(0, depth))
        radius = rng.uniform(0.6, 4.6)
        plan.plant((x, y), radius, rng.uniform(1.6, 2.8), (1, 14))


def _border(plan: SitePlan, rng: np.random.Generator, axes: Axes) -> float:
    """Plan pavements and planted strips from v = 0 on; return their far edge (v, metres)."""
    v = 0.0
    for _ in range(int(rng.integers(0, 3))):
        width = rng.uniform(0.4, 4.0)
        material = sample_material(rng, str(rng.choice(["grass", "concrete", "bark", "grass", "pavers", "rock"])))
        kerb = grey(rng, 140, 228) if rng.random() < 0.5 else None
        plan.add_surface(Surface(axes.rect(-REACH_M, v, REACH_M, v + width), material, kerb))
        if material.kind in ("grass", "bark") and rng.random() < 0.5:
            step = rng.uniform(2.5, 10)
            for u in np.arange(-45, 45, step):
                x, y = axes.at(float(u) + rng.normal(0, 0.5), v + width / 2 + rng.normal(0, 0.3))
                radius = rng.uniform(0.5, 3.4)
                plan.plant((x, y), radius, rng.uniform(1.6, 2.6), (1, 11))
        v += width
    return v


def fill_ground(plan: SitePlan, rng: np.random.Generator, axes: Axes, v: float, kinds: tuple[str, ...]) -> Material:
    """Cover everything from v on with one of the materials; return it."""
    material = sample_material(rng, str(rng.choice(kinds)))
    plan.add_surface(Surface(axes.rect(-REACH_M, v, REACH_M, REACH_M), material))
    return material


def _driveway(plan: SitePlan, rng: np.random.Generator, axes: Axes, span: float, kerb: float) -> None:
    """Join the lot to its road across the border in between."""
    if kerb < 0.3 or rng.random() < 0.2:
        return
    width, middle = rng.uniform(5, 9), rng.uniform(-0.8, 0.8) * span
    plan.add_surface(Surface(axes.rect(middle - width / 2, 0, middle + width / 2, kerb + 0.2), plan.asphalt))
    if rng.random() < 0.5:
        plan.line(axes.at(middle, kerb - 0.4), axes.at(middle + width / 2 - 0.4, kerb - 0.4), 0.4, 3, 0.9)


def _houses(plan: SitePlan, rng: np.random.Generator, axes: Axes) -> None:
    u = rng.uniform(-50, -30)
    while u < 45:
        width = rng.uniform(8, 30)
        if rng.random() < 0.7:
            plan.buildings.append(
                Building(axes.moved(u, rng.uniform(0, 3)), width, rng.uniform(8, 25), rng.uniform(3, 9))
            )
        u += width + rng.uniform(2, 15)


def _lane_line(plan: SitePlan, rng: np.random.Generator, axes: Axes) -> None:
    colour, width, strength = int(rng.choice([0, 1, 3, 3])), rng.uniform(0.1, 0.2), rng.uniform(0.3, 1.0)
    if rng.random() < 0.4:
        plan.line(axes.at(-80, 0), axes.at(80, 0), width, colour, strength)
        return
    period = float(rng.choice([4.5, 6.0, 9.0, 12.0]))
    for u in np.arange(-80 + rng.uniform(0, period), 80, period):
        plan.line(axes.at(float(u), 0), axes.at(float(u) + period * 0.4, 0), width, colour, strength)


def _crosswalk(plan: SitePlan, rng: np.random.Generator, axes: Axes, width: float) -> None:
    bar, length = rng.uniform(0.3, 0.6), rng.uniform(2, 4)
    for v in np.arange(0.3, width, bar * 2):
        plan.line(axes.at(0, float(v)), axes.at(length, float(v)), bar, 3, 0.9)
    plan.line(axes.at(length + 1.5, 0.3), axes.at(length + 1.5, width / 2), 0.4, 3, 0.9)


def plan_clutter(plan: SitePlan, rng: np.random.Generator, axes: Axes, width: float, depth: float) -> None:
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


def plan_containers(plan: SitePlan, rng: np.random.Generator, axes: Axes) -> None:
    """Put freight containers side by side from the origin of ``axes`` on: much like stalls, and none."""
    length, gap = float(rng.choice([6.1, 12.2])), float(rng.choice([0.1, 0.4, 1.2]))
    for k in range(int(rng.integers(2, 11))):
        if rng.random() < 0.85:
            place = axes.moved(k * (2.44 + gap), rng.normal(0, 0.15))
            plan.buildings.append(Building(place, 2.44, length, 2.6 * float(rng.choice([1, 1, 2]))))
