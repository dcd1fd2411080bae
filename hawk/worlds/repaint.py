"""Changes of a lot's layout over the years: a row at another pitch, an island, bays added, a row closed by fences.

Each change follows from seed and number alone, and acts on what the changes before it left. Stalls that it leaves alone
keep their ids; no id is used again.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np
import shapely

from hawk.worlds.bays import Place, Room
from hawk.worlds.parked_cars import car_on, number_stalls
from hawk.worlds.plan import Block, PlannedStall, SitePlan, Surface
from hawk.worlds.runs import clear, remove, remove_paint, runs_of
from hawk.worlds.scene.canvas import Points
from hawk.worlds.scene.materials import grey, sample_material

_STREAM: Final = 41
"""Distinguishes the random numbers of changes from others of the same seed."""
_WIDTHS: Final = (2.3, 3.2)
"""Width of a repainted stall, metres."""
_LEAST_CHANGE: Final = 0.06
"""Least change of a row's pitch, as a share."""
_FENCE_M: Final = 0.12
_OLD_LINE: Final = 0.93
"""Brightness of the asphalt on which a line was."""

Change = Callable[[SitePlan, np.random.Generator, tuple[float, float]], bool]
"""Changes a plan, whose picture has a size in metres; returns False where the plan has no place for the change."""


def repaint(plan: SitePlan, seed: int, number: int, size_m: tuple[float, float]) -> str:
    """Make change ``number`` (from 1) of a plan with numbered stalls; return its name.

    The kinds come in turn, in the seed's order. One that has no place gives its turn to the next; "none" where no kind
    has one.
    """
    turns = np.random.default_rng((seed, _STREAM)).permutation(len(CHANGES))
    names: list[str] = [list(CHANGES)[k] for k in turns.tolist()]
    rng = np.random.default_rng((seed, _STREAM, number))
    for k in range(len(names)):
        name = names[(number - 1 + k) % len(names)]
        if CHANGES[name](plan, rng, size_m):
            number_stalls(plan)
            return name
    return "none"


def change_pitch(plan: SitePlan, rng: np.random.Generator, size_m: tuple[float, float]) -> bool:
    """Paint a row again, with one stall or two more or less on its length."""
    del size_m
    options = [
        (run, len(run) + more)
        for run in runs_of(plan, 5)
        for more in (-2, -1, 1, 2)
        if _WIDTHS[0] <= run.width * len(run) / (len(run) + more) <= _WIDTHS[1]
        and abs(more) / (len(run) + more) >= _LEAST_CHANGE
    ]
    if not options:
        return False
    run, count = options[int(rng.integers(len(options)))]
    share = sum(stall.taken for stall in run.stalls) / len(run)
    kind = next((stall.kind for stall in run.stalls if stall.kind != "accessible"), "perpendicular")
    remove(plan, run)
    _black_out(plan, remove_paint(plan, run.corners, 0.3))
    front, back, back_end = run.corners[0], run.corners[3], run.corners[2]
    step = (run.corners[1] - front) / count
    assert np.allclose(back_end - back, run.corners[1] - front, atol=0.05)  # noqa: S101
    _paint_row(plan, rng, [np.array([front + step * k, back + step * k]) for k in range(count + 1)])
    for k in range(count):
        corners = np.array([front + step * k, front + step * (k + 1), back + step * (k + 1), back + step * k])
        _add_stall(plan, rng, corners, kind, share)
    return True


def build_island(plan: SitePlan, rng: np.random.Generator, size_m: tuple[float, float]) -> bool:
    """Turn two or three stalls in a row into an island."""
    del size_m
    runs = runs_of(plan, 5)
    if not runs:
        return False
    run = runs[int(rng.integers(len(runs)))]
    count = int(rng.integers(2, 4))
    start = int(rng.integers(1, len(run) - count))
    part = run.part(start, start + count)
    remove(plan, part)
    remove_paint(plan, _shrunk(part.corners, 0.95), 0.0)
    like = plan.islands[int(rng.integers(len(plan.islands)))] if plan.islands else None
    material = sample_material(rng, "grass") if like is None else like.material
    kerb = grey(rng, 140, 228) if like is None else like.kerb
    plan.islands.append(Surface(_shrunk(part.corners, 0.92), material, kerb, round_m=0.6))
    for _ in range(int(rng.integers(1, 3))):
        x, y = part.corners[0] + (part.corners[2] - part.corners[0]) * rng.uniform(0.3, 0.7)
        plan.plant((x, y), rng.uniform(0.7, 1.5), rng.uniform(1.5, 2.5), (0.8, 4))
    return True


def add_bays(plan: SitePlan, rng: np.random.Generator, size_m: tuple[float, float]) -> bool:
    """Add a row of bays along an edge of a lot, which grows where they lie outside."""
    places = Room(plan, size_m).places()
    if not places:
        return False
    place = places[int(rng.integers(len(places)))]
    clear(plan, place.outline)
    if place.bay.outside:
        plan.add_surface(Surface(place.outline, plan.asphalt))
        plan.lots = _grown(plan.lots, place)
    share = sum(stall.taken for stall in plan.stalls) / max(1, len(plan.stalls))
    steps = [k * place.bay.pitch for k in range(place.count + 1)]
    _paint_row(plan, rng, [place.axes.points([(u, 0.0), (u, place.bay.depth)]) for u in steps])
    for k in range(place.count):
        _add_stall(plan, rng, place.corners(k), place.bay.kind, share)
    return True


def close_row(plan: SitePlan, rng: np.random.Generator, size_m: tuple[float, float]) -> bool:
    """Close a row by fences: its stalls stay, and nobody can park on them."""
    del size_m
    runs = runs_of(plan, 4)
    if not runs:
        return False
    run = runs[int(rng.integers(len(runs)))]
    clear(plan, run.corners)
    closed = {stall.number for stall in run.stalls}
    plan.stalls = [replace(s, closed=True, taken=False) if s.number in closed else s for s in plan.stalls]
    colour = (40.0, 110.0, 215.0) if rng.random() < 0.5 else grey(rng, 120, 220)
    corners = _shrunk(run.corners, 0.97)
    height = rng.uniform(1.0, 2.0)
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        plan.blocks.append(Block(_wall(start, end), height, colour))
    return True


CHANGES: Final[dict[str, Change]] = {
    "pitch": change_pitch,
    "island": build_island,
    "bays": add_bays,
    "fences": close_row,
}


def _add_stall(plan: SitePlan, rng: np.random.Generator, corners: Points, kind: str, share: float) -> None:
    """Add a stall, with a car on it by the share that is taken."""
    stall = PlannedStall(corners, kind, taken=bool(rng.random() < share), worn=False, paint=1.0)
    plan.stalls.append(stall)
    if stall.taken:
        plan.vehicles.append(car_on(stall, rng))


def _paint_row(plan: SitePlan, rng: np.random.Generator, lines: list[Points]) -> None:
    """Paint lines (2, 2) from the open to the closed end, all alike and fresh."""
    width = rng.uniform(0.1, 0.16)
    for start, end in lines:
        plan.line((float(start[0]), float(start[1])), (float(end[0]), float(end[1])), width, 0, 0.95)


def _black_out(plan: SitePlan, strokes: list[Points]) -> None:
    """Leave a trace on the asphalt where lines were."""
    for stroke in strokes:
        if np.linalg.norm(stroke[1] - stroke[0]) > 1.5:
            plan.change(stroke, _OLD_LINE, soften=0.03)


def _grown(lots: list[Points], place: Place) -> list[Points]:
    """Return the outlines of the lots, the one beside new bays grown by them."""
    bays = shapely.Polygon(place.outline).buffer(0.02, join_style="mitre")
    grown = []
    for lot in lots:
        area = shapely.Polygon(lot)
        if area.intersects(bays):
            area = shapely.union(area.buffer(0), bays).simplify(0.03)
        grown.append(np.asarray(area.exterior.coords)[:-1] if area.geom_type == "Polygon" else lot)
    return grown


def _shrunk(corners: Points, share: float) -> Points:
    centre = corners.mean(0)
    return np.asarray(centre + (corners - centre) * share)


def _wall(start: Points, end: Points) -> Points:
    """Return the outline (4, 2) of a fence between two places."""
    length = math.dist(start, end)
    aside = np.array([-(end[1] - start[1]), end[0] - start[0]]) / max(length, 1e-9) * _FENCE_M / 2
    return np.array([start + aside, end + aside, end - aside, start - aside])
