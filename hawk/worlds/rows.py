"""One row of stalls: its lines, stalls, cars, hatched bays and islands."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np

from hawk.worlds.plan import Axes, Block, Building, PlannedStall, SitePlan, Surface, Vehicle
from hawk.worlds.scene.canvas import Points
from hawk.worlds.scene.cars import sample_kind
from hawk.worlds.scene.materials import sample_material
from hawk.worlds.style import LotStyle

PARALLEL_DEPTH_M = 2.4
"""Room that kerbside stalls need, metres."""
_DOTS_APART_M = (0.3, 0.7)
_ISLAND = 1
"""The ending of a row that an island closes (`LotStyle.ends`)."""
WORN_BELOW = 0.6
"""A stall whose better long line keeps less than this share of its paint is worn."""


@dataclass(frozen=True, slots=True)
class _Slot:
    axes: Axes
    u: float
    pitch: float
    depth: float
    shift: float

    def at(self, across: float, along: float) -> tuple[float, float]:
        """Return the point at shares (0..1) across the stall and from its open to its closed end."""
        return self.axes.at(self.u + self.pitch * across + self.shift * along, self.depth * along)

    @property
    def corners(self) -> Points:
        return np.array([self.at(0, 0), self.at(1, 0), self.at(1, 1), self.at(0, 1)])


def plan_row(
    plan: SitePlan, rng: np.random.Generator, axes: Axes, length: float, style: LotStyle, *, mirrored: bool = False
) -> int:
    """Plan a row along ``axes.u`` with its open (aisle) side at v = 0; return its stall count.

    ``mirrored`` leans angled stalls to the other side.
    """
    shift = -style.shift if mirrored else style.shift
    ending = int(rng.choice(3, p=style.ends))
    cap = style.pitch * rng.uniform(0.5, 1.25) if ending else 0.0
    count = int((length - 2 * cap - abs(shift)) / style.pitch)
    if count < 1:
        return 0
    first = cap + max(0.0, -shift)
    slots = [_Slot(axes, first + k * style.pitch, style.pitch, style.depth, shift) for k in range(count)]
    if style.bays is not None:
        outline = np.array([slots[0].at(0, 0), slots[-1].at(1, 0), slots[-1].at(1, 1), slots[0].at(0, 1)])
        plan.add_surface(Surface(outline, style.bays))
    paint = _line_strengths(rng, count + 1, style)
    if ending == _ISLAND and style.bare_ends:
        paint[[0, -1]] *= rng.random(2) >= style.bare_ends
    for slot, strength in zip([*slots, replace(slots[-1], u=slots[-1].u + style.pitch)], paint, strict=True):
        _divider(plan, rng, slot, style, float(strength))
    if style.unpainted:
        return _fill(plan, rng, slots, paint, style)
    if style.front_line and rng.random() < style.front_line:
        plan.line(slots[0].at(0, 0), slots[-1].at(1, 0), style.line_width, 0, 1.0)
    if rng.random() < style.back_line:
        plan.line(slots[0].at(0, 1), slots[-1].at(1, 1), style.line_width, 0, rng.uniform(0.6, 1.0))
    found = _fill(plan, rng, slots, paint, style)
    if ending:
        _cap(plan, rng, slots[0], -cap, ending, style)
        _cap(plan, rng, slots[-1], cap, ending, style)
    return found


def plan_parallel_row(plan: SitePlan, rng: np.random.Generator, axes: Axes, length: float, style: LotStyle) -> int:
    """Plan kerbside stalls along ``axes.u`` (open side at v = 0); return their count."""
    pitch, depth = rng.uniform(6.0, 7.2), rng.uniform(2.1, PARALLEL_DEPTH_M)
    count = int(length / pitch)
    paint = 0.0 if style.unpainted else 1.0
    if style.bays is not None and count:
        plan.add_surface(Surface(axes.rect(0, 0, count * pitch, depth), style.bays))
    for k in range(count + 1):
        plan.line(axes.at(k * pitch, 0), axes.at(k * pitch, depth), style.line_width, 0, paint)
    if count and paint and rng.random() < 0.6:
        plan.line(axes.at(0, 0), axes.at(count * pitch, 0), style.line_width, 0, 0.9)
    for k in range(count):
        slot = _Slot(axes, k * pitch, pitch, depth, 0.0)
        taken = bool(rng.random() < style.occupancy)
        if taken:
            x, y = slot.at(rng.uniform(0.44, 0.56), rng.uniform(0.42, 0.58))
            plan.vehicles.append(Vehicle(x, y, axes.angle + rng.normal(0, 0.03), sample_kind(rng, "stall")))
        corners = np.roll(slot.corners, 1, axis=0)
        plan.stalls.append(PlannedStall(corners, "parallel", taken, worn=False, paint=paint))
    return count


def hatch(
    plan: SitePlan, rng: np.random.Generator, corners: Points, width: float, colour: int, *, strength: float = 1.0
) -> None:
    """Paint a bay with slanted lines: ``corners`` is a parallelogram."""
    origin, across, along = corners[0], corners[1] - corners[0], corners[3] - corners[0]
    span = float(np.linalg.norm(along))
    step = rng.uniform(0.45, 1.1)
    slant = min(0.9, float(np.linalg.norm(across)) / max(span, 0.1)) * (1 if rng.random() < 0.5 else -1)
    for share in np.arange(-abs(slant), 1 + abs(slant), step / max(span, 0.1)):
        ends = _clipped(float(share), slant)
        if ends is not None:
            (a0, b0), (a1, b1) = ends
            start, end = origin + across * a0 + along * b0, origin + across * a1 + along * b1
            plan.line(_pair(start), _pair(end), width, colour, strength)
    if rng.random() < 0.6:
        for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            plan.line(_pair(start), _pair(end), width, colour, strength)


def _line_strengths(rng: np.random.Generator, count: int, style: LotStyle) -> Points:
    """Give each line the share of its paint that is left: worn lines come in stretches."""
    if style.unpainted:
        return np.zeros(count)
    strengths = rng.uniform(0.85, 1.0, count)
    k = 0
    while k < count:
        run = int(rng.integers(2, 7))
        if rng.random() < style.worn:
            strengths[k : k + run] = rng.uniform(0.16, 0.55) * rng.uniform(0.85, 1.1, len(strengths[k : k + run]))
        k += run
    strengths[rng.random(count) < style.drop / 2] = 0.0
    return strengths


def _divider(plan: SitePlan, rng: np.random.Generator, slot: _Slot, style: LotStyle, strength: float) -> None:
    if style.marks != "lines":
        _mark(plan, rng, slot, style, strength)
        return
    start, end = 0.0, rng.uniform(0.96, 1.0)
    if rng.random() < style.drop:
        start, end = (rng.uniform(0.2, 0.6), end) if rng.random() < 0.5 else (start, rng.uniform(0.4, 0.8))
    if style.hairpin:
        half = 0.2 / slot.pitch
        for side in (-half, half):
            plan.line(slot.at(side, start), slot.at(side, end), style.line_width, 0, strength)
        plan.line(slot.at(-half, start), slot.at(half, start), style.line_width, 0, strength)
        return
    plan.line(slot.at(0, start), slot.at(0, end), style.line_width, 0, strength)
    if style.tees:
        reach = 0.4 / slot.pitch
        plan.line(slot.at(-reach, 0), slot.at(reach, 0), style.line_width, 0, strength)


def _mark(plan: SitePlan, rng: np.random.Generator, slot: _Slot, style: LotStyle, strength: float) -> None:
    """Part two stalls by something shorter than a line."""
    piece = rng.uniform(0.08, 0.14)
    if style.marks == "dots":
        step, half = rng.uniform(*_DOTS_APART_M) / slot.depth, style.line_width / 2 / slot.depth
        for share in np.arange(half, 1, step).tolist():
            plan.line(slot.at(0, share - half), slot.at(0, share + half), style.line_width, 0, strength)
        return
    if style.marks == "blocks":
        plan.line(slot.at(0, 1 - piece), slot.at(0, 1), style.line_width * 1.5, 0, strength)
        return
    for share, towards in ((0.0, piece), (1.0, 1 - piece)):
        plan.line(slot.at(0, share), slot.at(0, towards), style.line_width, 0, strength)
        if style.marks == "tees":
            reach = 0.35 / slot.pitch
            plan.line(slot.at(-reach, share), slot.at(reach, share), style.line_width, 0, strength)


def _fill(plan: SitePlan, rng: np.random.Generator, slots: list[_Slot], paint: Points, style: LotStyle) -> int:
    """Make each slot a stall, an island, a hatched bay or a shelter; return the stall count."""
    occupancy = float(np.clip(style.occupancy + rng.normal(0, 0.12), 0, 1))
    accessible = int(rng.integers(1, 5)) if rng.random() < style.accessible else 0
    found = 0
    for k, slot in enumerate(slots):
        inner = 0 < k < len(slots) - 1
        if inner and rng.random() < style.break_share:
            _island(plan, rng, slot.corners, style)
        elif rng.random() < style.hatch and not style.unpainted:
            hatch(plan, rng, slot.corners, style.line_width * rng.uniform(1, 1.6), 1, strength=rng.uniform(0.6, 1))
        elif style.shelters and not style.skew and rng.random() < style.shelters:
            _shelter(plan, rng, slot)
        else:
            kind = "accessible" if k < accessible else ("angled" if style.skew else "perpendicular")
            left = float(max(paint[k], paint[k + 1]))
            _stall(plan, rng, slot, style, kind, left, worn=float(min(paint[k], paint[k + 1])) < WORN_BELOW)
            _park(plan, rng, slot, style, occupancy * (0.4 if kind == "accessible" else 1.0))
            found += 1
    return found


def _stall(
    plan: SitePlan, rng: np.random.Generator, slot: _Slot, style: LotStyle, kind: str, paint: float, *, worn: bool
) -> None:
    plan.stalls.append(PlannedStall(slot.corners, kind, taken=False, worn=worn, paint=paint))
    if kind == "accessible" and not style.unpainted:
        _accessible_sign(plan, rng, slot)
    if style.wheel_stops:
        along = rng.uniform(0.84, 0.91)
        half = 0.12 / slot.depth
        corners = [slot.at(0.18, along), slot.at(0.82, along), slot.at(0.82, along + half), slot.at(0.18, along + half)]
        level = rng.uniform(150, 215)
        plan.blocks.append(Block(np.array(corners), 0.15, (level, level, level)))
    if rng.random() < 0.45:
        _stain(plan, rng, slot)
    if rng.random() < style.trees * 0.25:
        x, y = slot.at(rng.uniform(-0.1, 1.1), 1.0)
        radius = rng.uniform(*style.crown)
        plan.plant((x, y), radius, rng.uniform(1.6, 2.6), (2.5, 9))


def _park(plan: SitePlan, rng: np.random.Generator, slot: _Slot, style: LotStyle, probability: float) -> None:
    if rng.random() >= probability:
        return
    stall = plan.stalls[-1]
    plan.stalls[-1] = replace(stall, taken=True)
    x, y = slot.at(0.5 + rng.normal(0, 0.035) * style.tidy, rng.uniform(0.44, 0.57))
    tail, head = np.array(slot.at(0.5, 0)), np.array(slot.at(0.5, 1))
    heading = math.atan2(*(head - tail)[::-1]) + rng.normal(0, 0.03) * style.tidy
    if rng.random() < 0.3:
        heading += math.pi
    kind = sample_kind(rng, "stall")
    if kind == "motorcycle" and rng.random() < 0.5:
        x, y = slot.at(rng.uniform(0.3, 0.7), rng.uniform(0.25, 0.8))
    plan.vehicles.append(Vehicle(x, y, heading, kind))


def _stain(plan: SitePlan, rng: np.random.Generator, slot: _Slot) -> None:
    centre = np.array(slot.at(0.5 + rng.normal(0, 0.08), rng.uniform(0.25, 0.8)))
    angles = np.linspace(0, 2 * math.pi, 9)[:-1]
    radii = rng.uniform(0.2, 0.9) * rng.uniform(0.6, 1.2, 8)
    outline = centre + np.stack([np.cos(angles), np.sin(angles)], 1) * radii[:, None]
    plan.change(outline, 1 - rng.uniform(0.03, 0.28), soften=0.2)


def _accessible_sign(plan: SitePlan, rng: np.random.Generator, slot: _Slot) -> None:
    half = rng.uniform(0.45, 0.75)
    middle = rng.uniform(0.25, 0.5)
    across, along = half / slot.pitch, half / slot.depth
    if rng.random() < 0.7:
        square = [
            slot.at(0.5 + a, middle + b)
            for a, b in ((-across, -along), (across, -along), (across, along), (-across, along))
        ]
        plan.paint(np.array(square), 2, rng.uniform(0.6, 1.0))
    ring = [
        slot.at(0.5 + 0.6 * across * math.cos(t), middle + 0.6 * along * math.sin(t)) for t in np.linspace(0, 5.2, 12)
    ]
    for start, end in itertools.pairwise(ring):
        plan.line(start, end, 0.12, 3, 0.9)
    plan.line(slot.at(0.5, middle - 0.9 * along), slot.at(0.5, middle + 0.2 * along), 0.14, 3, 0.9)


def _cap(plan: SitePlan, rng: np.random.Generator, slot: _Slot, reach: float, ending: int, style: LotStyle) -> None:
    """Close a row with an island (1) or hatching (2); a negative reach is before the first slot."""
    share = reach / slot.pitch
    low, high = (share, 0.0) if reach < 0 else (1.0, 1.0 + share)
    corners = np.array([slot.at(low, 0), slot.at(high, 0), slot.at(high, 1), slot.at(low, 1)])
    if ending == _ISLAND:
        _island(plan, rng, corners, style)
    else:
        hatch(plan, rng, corners, style.line_width * rng.uniform(1, 1.6), 1, strength=rng.uniform(0.6, 1))


def _shelter(plan: SitePlan, rng: np.random.Generator, slot: _Slot) -> None:
    """Put a small roof for shopping carts where a stall would be."""
    margin = rng.uniform(0.05, 0.2)
    axes = slot.axes.moved(slot.u + margin * slot.pitch, rng.uniform(0.02, 0.1) * slot.depth)
    width, depth = slot.pitch * (1 - 2 * margin), slot.depth * rng.uniform(0.75, 0.95)
    roof = sample_material(rng, "court" if rng.random() < 0.6 else "roof")
    plan.buildings.append(Building(axes, width, depth, rng.uniform(1.8, 2.8), roof, shelter=True))


def _island(plan: SitePlan, rng: np.random.Generator, corners: Points, style: LotStyle) -> None:
    centre = corners.mean(0)
    shrunk = centre + (corners - centre) * 0.9
    plan.islands.append(Surface(shrunk, style.island, style.kerb, round_m=rng.uniform(0.3, 1.0)))
    for _ in range(int(rng.choice([0, 1, 1, 2]))):
        x, y = centre + (corners[0] - centre) * rng.uniform(-0.6, 0.6)
        radius = rng.uniform(*style.crown) if rng.random() < 0.6 else rng.uniform(0.4, 0.9)
        plan.plant((x, y), radius, rng.uniform(1.5, 2.5), (0.8, 9))


def _clipped(offset: float, slant: float) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Clip the slanted line from (0, offset) to (1, offset + slant) to the unit square; None when it misses it."""
    ends = []
    for across, along in ((0.0, offset), (1.0, offset + slant)):
        clamped = min(1.0, max(0.0, along))
        if clamped != along:
            across += (clamped - along) / slant
        ends.append((across, clamped))
    inside = all(-1e-9 <= across <= 1 + 1e-9 for across, _ in ends)
    return (ends[0], ends[1]) if inside and ends[0] != ends[1] else None


def _pair(point: Points) -> tuple[float, float]:
    return float(point[0]), float(point[1])
