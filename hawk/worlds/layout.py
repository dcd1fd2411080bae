"""Layout of a lot: rows, aisles, medians and sections."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hawk.worlds.plan import Axes, Post, SitePlan, Surface, Vehicle
from hawk.worlds.rows import PARALLEL_DEPTH_M, plan_parallel_row, plan_row
from hawk.worlds.scene.canvas import Points
from hawk.worlds.scene.cars import sample_kind
from hawk.worlds.style import LotStyle


def plan_section(
    plan: SitePlan, rng: np.random.Generator, axes: Axes, width: float, depth: float, style: LotStyle
) -> int:
    """Fill the rectangle [0, width] x [0, depth] of ``axes`` (metres) with rows and aisles; return the stall count."""
    low, high, stalls = _ends(plan, rng, axes, width, depth, style)
    if high - low < 2 * style.pitch:
        return stalls
    rows = _arrange(rng, depth, style)
    v = 0.0
    if rows.first:
        stalls += plan_row(plan, rng, axes.moved(low, style.depth).facing((1, 0), (0, -1)), high - low, style)
        v = style.depth
    for k in range(rows.doubles + 1):
        _aisle(plan, rng, axes.moved(low, v + rows.aisle / 2), high - low, style)
        v += rows.aisle
        if k < rows.doubles:
            stalls += _double_row(plan, rng, axes.moved(low, v), high - low, rows.median, style)
            v += 2 * style.depth + rows.median
    if rows.last:
        stalls += plan_row(plan, rng, axes.moved(low, depth - style.depth), high - low, style)
    return stalls


@dataclass(frozen=True, slots=True)
class _Arrangement:
    first: bool
    last: bool
    doubles: int
    aisle: float
    median: float


def _arrange(rng: np.random.Generator, depth: float, style: LotStyle) -> _Arrangement:
    """Choose the rows of a section; spare depth widens its aisles."""
    median = rng.uniform(0.6, 3.0) if rng.random() < style.medians else 0.0
    double = 2 * style.depth + median
    options = []
    for singles in (0, 1, 2):
        spare = depth - singles * style.depth - style.aisle
        if spare < 0:
            continue
        doubles = int(spare / (double + style.aisle))
        if singles + doubles:
            options.append((spare - doubles * (double + style.aisle), singles, doubles))
    if not options:
        return _Arrangement(first=True, last=False, doubles=0, aisle=max(3.0, depth - style.depth), median=0.0)
    # mostly the arrangement that wastes least
    spare, singles, doubles = min(options) if rng.random() < 0.7 else options[int(rng.integers(len(options)))]
    aisle = style.aisle + min(spare / (doubles + 1), 0.5 * style.aisle)
    first = singles == 2 or (singles == 1 and bool(rng.random() < 0.5))
    return _Arrangement(first, singles == 2 or (singles == 1 and not first), doubles, aisle, median)


def asphalt_details(plan: SitePlan, rng: np.random.Generator, axes: Axes, width: float, depth: float) -> None:
    """Scatter patches, cracks, tar seams and tyre marks over the rectangle [0, width] x [0, depth]."""
    area = width * depth / 1500
    for _ in range(rng.poisson(2.5 * area)):
        u, v = rng.uniform(0, width), rng.uniform(0, depth)
        du, dv = rng.uniform(0.5, 9, 2)
        corners = axes.rect(u, v, min(u + du, width), min(v + dv, depth))
        plan.change(corners, 1 + rng.uniform(-0.24, 0.16), soften=0.04)
    for _ in range(rng.poisson(5 * area)):
        _crack(plan, rng, axes, width, depth)
    for _ in range(rng.poisson(1.2 * area)):
        start = np.array([rng.uniform(0, width), rng.uniform(0, depth)])
        bend = rng.uniform(0, 2 * math.pi) + np.linspace(0, rng.normal(0, 1.2), 14)
        steps = np.stack([np.cos(bend), np.sin(bend)], 1) * rng.uniform(0.6, 1.4)
        track = axes.points(_kept(start + np.cumsum(steps, 0), width, depth))
        plan.change(track, 1 - rng.uniform(0.04, 0.2), soften=0.05, width=rng.uniform(0.15, 0.3))


def _ends(
    plan: SitePlan, rng: np.random.Generator, axes: Axes, width: float, depth: float, style: LotStyle
) -> tuple[float, float, int]:
    """Close both ends of the rows by a cross aisle, a row of its own, or nothing.

    Returns:
        Low and high end of the rest along u (metres), and the count of stalls at the ends.
    """
    low, high, stalls = 0.0, width, 0
    for far in (False, True):
        free = rng.random()
        if free < style.side_rows and width > 45 and depth > 24:
            reach = style.depth + style.aisle
            away = style.depth if not far else width - style.depth
            side = axes.moved(away, style.depth * 0.2).facing((0, 1), (1 if far else -1, 0))
            stalls += plan_row(plan, rng, side, depth - style.depth * 0.4, style, mirrored=far)
        elif free < 0.9 and width > 28:
            reach = rng.uniform(0.7, 1.1) * style.aisle
        else:
            reach = 0.0
            if rng.random() < 0.5 and width > 40:
                edge = axes.moved(width - PARALLEL_DEPTH_M if far else PARALLEL_DEPTH_M, 4).facing(
                    (0, 1), (1 if far else -1, 0)
                )
                stalls += plan_parallel_row(plan, rng, edge, depth - 8, style)
                reach = PARALLEL_DEPTH_M + style.aisle
        low, high = (low, high - reach) if far else (low + reach, high)
    return low, high, stalls


def _double_row(
    plan: SitePlan, rng: np.random.Generator, axes: Axes, length: float, median: float, style: LotStyle
) -> int:
    stalls = plan_row(plan, rng, axes, length, style)
    back = axes.moved(0, 2 * style.depth + median).facing((1, 0), (0, -1))
    stalls += plan_row(plan, rng, back, length, style, mirrored=rng.random() < 0.5)
    if median > 0.15:
        middle = style.depth + median / 2
        strip = axes.rect(0, style.depth + 0.05, length, style.depth + median - 0.05)
        plan.islands.append(Surface(strip, style.island, style.kerb, round_m=min(0.8, median / 3)))
        _plant(plan, rng, axes.moved(0, middle), length, median, style)
    elif rng.random() < 0.5:
        for u in np.arange(rng.uniform(4, 12), length, rng.uniform(16, 30)):
            _post(plan, rng, axes.moved(float(u), style.depth))
    return stalls


def _plant(plan: SitePlan, rng: np.random.Generator, axes: Axes, length: float, median: float, style: LotStyle) -> None:
    if rng.random() > 0.25 + style.trees:
        return
    step = rng.uniform(3.5, 12)
    for u in np.arange(rng.uniform(0, step), length, step):
        x, y = axes.at(float(u) + rng.normal(0, 0.4), rng.normal(0, 0.1) * median)
        radius = rng.uniform(*style.crown)
        plan.plant((x, y), radius, rng.uniform(1.6, 2.6), (2, 9))
        if rng.random() < 0.15:
            _post(plan, rng, axes.moved(float(u) + step / 2, 0))


def _post(plan: SitePlan, rng: np.random.Generator, axes: Axes) -> None:
    x, y = axes.origin
    plan.posts.append(Post(x, y, rng.uniform(5, 9), axes.angle + math.pi / 2 * float(rng.integers(4))))


def _aisle(plan: SitePlan, rng: np.random.Generator, axes: Axes, length: float, style: LotStyle) -> None:
    """Put arrows, stop bars and moving cars in an aisle along ``axes.u``."""
    if rng.random() < 0.45:
        for u in np.arange(rng.uniform(3, 15), length - 4, rng.uniform(14, 30)):
            _arrow(plan, rng, axes.moved(float(u), rng.choice([-1, 1]) * style.aisle * 0.22))
    if rng.random() < 0.25:
        for u in (2.0, length - 2.0):
            plan.line(axes.at(u, 0.3), axes.at(u, style.aisle * 0.42), 0.4, 0, rng.uniform(0.5, 1.0))
    if rng.random() < 0.12:  # a crosswalk over the aisle
        u = rng.uniform(0.2, 0.8) * length
        for v in np.arange(-style.aisle / 2 + 0.3, style.aisle / 2, 0.9):
            plan.line(axes.at(u, float(v)), axes.at(u + 3, float(v)), 0.45, 1, 0.9)
    for _ in range(rng.poisson(max(0.0, 0.35 * length / 30))):
        x, y = axes.at(rng.uniform(2, max(3, length - 2)), rng.uniform(-0.22, 0.22) * style.aisle)
        turn = rng.normal(0, 0.12) if rng.random() < 0.8 else rng.uniform(-0.9, 0.9)
        heading = axes.angle + turn + (math.pi if rng.random() < 0.5 else 0)
        plan.vehicles.append(Vehicle(x, y, heading, sample_kind(rng, "aisle")))


def _arrow(plan: SitePlan, rng: np.random.Generator, axes: Axes) -> None:
    sense = 1.0 if rng.random() < 0.5 else -1.0
    size, strength = rng.uniform(0.9, 1.5), rng.uniform(0.5, 1.0)
    plan.line(axes.at(-size * sense, 0), axes.at(size * 0.5 * sense, 0), 0.16, 3, strength)
    for side in (-1, 1):
        plan.line(axes.at(size * sense, 0), axes.at(size * 0.35 * sense, 0.4 * side), 0.2, 3, strength)


def _crack(plan: SitePlan, rng: np.random.Generator, axes: Axes, width: float, depth: float) -> None:
    count = int(rng.integers(5, 30))
    wander = float(rng.choice([0.4, 0.08]))
    heading = rng.choice([0, math.pi / 2, rng.uniform(0, 6.3)]) + np.cumsum(rng.normal(0, wander, count))
    start = np.array([rng.uniform(0, width), rng.uniform(0, depth)])
    track = start + np.cumsum(np.stack([np.cos(heading), np.sin(heading)], 1) * rng.uniform(0.4, 1.3), 0)
    points = axes.points(_kept(track, width, depth))
    plan.change(points, 1 - rng.uniform(0.06, 0.4), width=float(rng.uniform(0.03, 0.1)))


def _kept(track: Points, width: float, depth: float) -> Points:
    """Cut a track off where it leaves [0, width] x [0, depth]."""
    outside = ((track < 0) | (track > (width, depth))).any(1)
    end = int(np.argmax(outside)) if outside.any() else len(track)
    return track[: max(2, end)]
