"""Places that look like parking lots: roofscapes, aprons, gardens, terraces, courts, solar fields, canopies."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from hawk.worlds.plan import Axes, Block, Building, SitePlan, Surface, Vehicle
from hawk.worlds.scene.cars import outline, sample_kind
from hawk.worlds.scene.materials import Colour, Material, grey, sample_material
from hawk.worlds.scene.surroundings import fill_ground, plan_court
from training.crowded_roofs import draw_crowd

_Planner = Callable[[SitePlan, np.random.Generator, Axes, float], None]


def plan_premises(plan: SitePlan, rng: np.random.Generator, axes: Axes, span: float) -> None:
    """Plan such a place from the edge of ``axes`` (u along it from its middle, ``span`` m to each side) towards v."""
    kinds: tuple[_Planner, ...] = (
        *(_roofscape, _roofscape, _apron, _garden, _terrace, _courts, _solar_field, _canopies),
    )
    kinds[int(rng.integers(len(kinds)))](plan, rng, axes, span)


def _roofscape(plan: SitePlan, rng: np.random.Generator, axes: Axes, span: float) -> None:
    """Large roofs of several heights, wall to wall or with lanes between them."""
    fill_ground(plan, rng, axes, 0, ("concrete", "asphalt", "grass", "dirt"))
    u, v = -span - rng.uniform(0, 20), rng.uniform(0, 4)
    while u < span:
        width, depth, height = rng.uniform(14, 60), rng.uniform(14, 50), rng.uniform(3.5, 12)
        roof = _pale(rng) if rng.random() < 0.5 else None
        plan.buildings.append(Building(axes.moved(u, v), width, depth, height, roof, crowd=draw_crowd))
        u += width + float(rng.choice([0.0, rng.uniform(1, 9)]))


def _apron(plan: SitePlan, rng: np.random.Generator, axes: Axes, span: float) -> None:
    """Concrete slabs before a hall: docks with lorries side by side, guide lines, pallets."""
    fill_ground(plan, rng, axes, 0, ("concrete", "concrete", "asphalt"))
    start = rng.uniform(14, 26)
    hall = Building(axes.moved(-span, start), 2 * span, rng.uniform(15, 40), rng.uniform(6, 12), crowd=draw_crowd)
    plan.buildings.append(hall)
    pitch, length = rng.uniform(3.4, 5.0), rng.uniform(8, 13)
    is_painted, busy, colour = rng.random() < 0.6, rng.uniform(0, 0.8), int(rng.choice([1, 3]))
    for u in np.arange(-span + 2, span - 2, pitch).tolist():
        if is_painted:
            plan.line(axes.at(u, start - length), axes.at(u, start), 0.12, colour, rng.uniform(0.3, 1))
        if rng.random() < busy:
            x, y = axes.at(u + pitch / 2, start - 4.6)
            kind = "lorry" if rng.random() < 0.8 else sample_kind(rng, "yard")
            plan.vehicles.append(Vehicle(x, y, axes.angle - math.pi / 2, kind))
    for _ in range(int(rng.integers(0, 12))):
        place = axes.at(rng.uniform(-span, span), rng.uniform(1, start - 1))
        _block(plan, place, axes.angle, (rng.uniform(0.8, 2.6), rng.uniform(0.8, 1.4)), 0.8, grey(rng, 30, 210, 20))


def _garden(plan: SitePlan, rng: np.random.Generator, axes: Axes, span: float) -> None:
    """Beds and rows of shrubs with paths between them."""
    fill_ground(plan, rng, axes, 0, ("grass", "grass", "dirt", "gravel"))
    pitch, length, count = rng.uniform(1.3, 4.0), rng.uniform(3, 12), int(rng.integers(3, 14))
    bed, path = (sample_material(rng, str(rng.choice(("bark", "dirt", "grass", "pavers", "gravel")))) for _ in range(2))
    kerb = grey(rng, 120, 230) if rng.random() < 0.4 else None
    first = axes.moved(rng.uniform(-span, span / 2), rng.uniform(1, 8))
    is_planted = rng.random() < 0.5
    for row in range(int(rng.integers(1, 4))):
        corner = first.moved(0, row * (length + rng.uniform(1.2, 3)))
        plan.add_surface(Surface(corner.rect(0, -1, count * pitch, -0.2), path))
        for k in range(count):
            plan.add_surface(
                Surface(corner.rect(k * pitch, 0, (k + rng.uniform(0.4, 0.85)) * pitch, length), bed, kerb)
            )
            for v in np.arange(0.5, length, rng.uniform(0.8, 2.5)).tolist() if is_planted else ():
                x, y = corner.at((k + 0.3) * pitch, v)
                radius = rng.uniform(0.25, 0.8)
                plan.plant((x, y), radius, 2.0, (0.5, 1.6))
    if rng.random() < 0.5:
        plan.buildings.append(Building(axes.moved(rng.uniform(-span, span), 9), 3.5, rng.uniform(3, 6), 2.6))


def _terrace(plan: SitePlan, rng: np.random.Generator, axes: Axes, span: float) -> None:
    """Sunshades, tables or market stands in rows on a paved ground."""
    fill_ground(plan, rng, axes, 0, ("pavers", "concrete", "pavers"))
    size = rng.uniform((1.0, 1.0), (3.2, 3.2)) if rng.random() < 0.6 else np.array([rng.uniform(2, 2.6), 5.0])
    pitch, height = size + rng.uniform(0.3, 3.0, 2), rng.uniform(0.7, 2.6)
    colours = [_bright(rng) for _ in range(int(rng.integers(1, 4)))]
    columns, rows = rng.integers((2, 1), (13, 5)).tolist()
    for i in range(columns):
        for k in range(rows):
            place = axes.at(-span * 0.6 + i * pitch[0], 3 + k * pitch[1])
            colour = colours[int(rng.integers(len(colours)))]
            _block(plan, place, axes.angle + rng.normal(0, 0.03), (float(size[0]), float(size[1])), height, colour)


def _courts(plan: SitePlan, rng: np.random.Generator, axes: Axes, span: float) -> None:
    """Sports courts side by side."""
    fill_ground(plan, rng, axes, 0, ("grass", "asphalt", "concrete"))
    for k in range(int(rng.integers(1, 4))):
        plan_court(plan, rng, axes.moved(-span + 36 * k, rng.uniform(3, 8)))


def _solar_field(plan: SitePlan, rng: np.random.Generator, axes: Axes, span: float) -> None:
    """Rows of solar panels on the ground."""
    fill_ground(plan, rng, axes, 0, ("grass", "gravel", "dirt"))
    depth, gap, piece = rng.uniform(1.5, 5), rng.uniform(1.2, 5), rng.uniform(2, 12)
    colour = (rng.uniform(55, 120), rng.uniform(35, 70), rng.uniform(20, 50))
    for v in np.arange(2, 40, depth + gap).tolist():
        for u in np.arange(-span, span, piece + rng.uniform(0.2, 1)).tolist():
            _block(plan, axes.at(u, v), axes.angle, (piece, depth), 1.2, colour)


def _canopies(plan: SitePlan, rng: np.random.Generator, axes: Axes, span: float) -> None:
    """Long roofs of glass or foil along a hall, with a bar every few steps: bays as wide as stalls, and none."""
    fill_ground(plan, rng, axes, 0, ("pavers", "concrete", "asphalt"))
    plan.buildings.append(Building(axes.moved(-span, 8), 2 * span, rng.uniform(10, 30), rng.uniform(4, 9)))
    pitch, bar = rng.uniform(1.0, 3.2), rng.uniform(0.08, 0.25)
    glass = Material("roof", grey(rng, 120, 225, 8), 0.015, 0.02, 0.05)
    u = -span + rng.uniform(0, 8)
    while u < span - 6:
        length, depth = min(rng.uniform(8, 40), span - u), rng.uniform(2.5, 6)
        plan.add_surface(Surface(axes.rect(u, 7.5 - depth, u + length, 7.5), glass))
        for x in np.arange(u, u + length + 0.1, pitch).tolist():
            plan.line(axes.at(x, 7.5 - depth), axes.at(x, 7.5), bar, int(rng.choice([1, 3])), rng.uniform(0.4, 1))
        u += length + rng.uniform(2, 15)


def _block(
    plan: SitePlan, place: tuple[float, float], angle: float, size: tuple[float, float], height: float, colour: Colour
) -> None:
    plan.blocks.append(Block(outline(place[0], place[1], angle, size[0], size[1]), height, colour))


def _pale(rng: np.random.Generator) -> Material:
    """Draw a pale roof: those with seams are most easily taken for lots."""
    return Material("roof", grey(rng, 165, 250, 5), 0.015, 0.02, 0.03)


def _bright(rng: np.random.Generator) -> Colour:
    if rng.random() < 0.5:
        return grey(rng, 60, 245)
    blue, green, red = rng.uniform(20, 230, 3)
    return float(blue), float(green), float(red)
