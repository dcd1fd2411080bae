"""Runs of stalls side by side on a plan, and what is removed with them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely

from hawk.worlds.plan import PlannedStall, SitePlan
from hawk.worlds.scene.canvas import Points

_SAME_M: Final = 0.02


@dataclass(frozen=True, slots=True)
class Run:
    """Stalls side by side, in order: each begins at the long side where the one before ends."""

    stalls: tuple[PlannedStall, ...]

    def __len__(self) -> int:
        """Return the number of stalls."""
        return len(self.stalls)

    @property
    def corners(self) -> Points:
        """Corners (4, 2) of the whole, metres, in the order of a stall's."""
        first, last = self.stalls[0].corners, self.stalls[-1].corners
        return np.array([first[0], last[1], last[2], first[3]])

    @property
    def width(self) -> float:
        """Width of a stall across its long sides, metres."""
        along = self.corners[3] - self.corners[0]
        span = self.corners[1] - self.corners[0]
        return float(abs(span[0] * along[1] - span[1] * along[0]) / np.linalg.norm(along)) / len(self.stalls)

    def part(self, start: int, stop: int) -> Run:
        """Return the run of some of its stalls."""
        return Run(self.stalls[start:stop])


def runs_of(plan: SitePlan, least: int) -> list[Run]:
    """Return the longest runs of open stalls across the aisle, each of ``least`` stalls or more."""
    found: list[list[PlannedStall]] = []
    for stall in plan.stalls:
        if stall.closed or stall.kind == "parallel":
            continue
        beside = next((run for run in found if _follows(stall, run[-1])), None)
        if beside is None:
            found.append([stall])
        else:
            beside.append(stall)
    return [Run(tuple(run)) for run in found if len(run) >= least]


def _follows(stall: PlannedStall, before: PlannedStall) -> bool:
    sides = stall.corners[[0, 3]] - before.corners[[1, 2]]
    return bool(np.abs(sides).max() < _SAME_M)


def remove(plan: SitePlan, run: Run) -> None:
    """Remove the stalls of a run with the vehicles and low things on them."""
    gone = {stall.number for stall in run.stalls}
    plan.stalls = [stall for stall in plan.stalls if stall.number not in gone]
    clear(plan, run.corners)


def clear(plan: SitePlan, corners: Points) -> None:
    """Remove vehicles and low things from an area (N, 2), metres."""
    area = shapely.Polygon(corners)
    shapely.prepare(area)
    plan.vehicles = [one for one in plan.vehicles if not shapely.contains_xy(area, one.x, one.y)]
    plan.blocks = [one for one in plan.blocks if not shapely.contains_xy(area, *one.polygon.mean(0))]


def remove_paint(plan: SitePlan, corners: Points, grown_m: float) -> list[Points]:
    """Remove the strokes whose middle lies in an area (N, 2), grown by some metres; return their outlines (4, 2)."""
    area = shapely.Polygon(corners).buffer(grown_m, join_style="mitre")
    if not plan.strokes:
        return []
    middles = np.array([stroke.polygon.mean(0) for stroke in plan.strokes])
    inside = shapely.contains_xy(area, middles[:, 0], middles[:, 1])
    gone = [stroke.polygon for stroke, is_in in zip(plan.strokes, inside, strict=True) if is_in]
    plan.strokes = [stroke for stroke, is_in in zip(plan.strokes, inside, strict=True) if not is_in]
    return gone
