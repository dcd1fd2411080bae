"""Autonomous exploration: the next place to fly to, until nothing is left to learn.

The secret is the policy: among straight ways over the lot and inside the fence, take the one with the most expected new
lot per metre flown, count leftovers higher than the same area in one piece, and keep what was begun.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.path_plan.fence import FenceGuard
from hawk.algo.path_plan.field import InformationField
from hawk.algo.path_plan.route import way_round
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.sweep import Swath, Way, best_way, end_of, straight_ways
from hawk.model import ExploreStatus, MapPoint, MapPose

_HEADINGS = 32
_LEAST_M = 3.0
_REACH_M = 120.0

Place = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Aim:
    """Where to fly: a place, the heading on the way there, and what for."""

    place: Place
    heading: float
    stall_id: int | None = None
    transit: bool = False


@dataclass(frozen=True, slots=True)
class Exploration:
    """One plan: the aim (None: hold), how far the exploration is."""

    aim: Aim | None
    status: ExploreStatus


class Explorer:
    """Follows one exploration from frame to frame."""

    def __init__(self, settings: PathPlanSettings) -> None:
        self._settings = settings
        self._headings = np.linspace(0, 2 * math.pi, _HEADINGS, endpoint=False)
        self.start()

    def start(self) -> None:
        """Begin anew: nothing is done, no stall was looked at again."""
        self._aim: Aim | None = None
        self._quiet = 0
        self._looked: set[int] = set()

    def plan(
        self,
        field: InformationField,
        pose: MapPose,
        swath: Swath,
        fence: FenceGuard,
        unclear: dict[int, Place],
    ) -> Exploration:
        """Return the next place. ``unclear`` are the stalls whose state is not known, by id."""
        place = (pose.north, pose.east)
        if not (field.lot > 0).any():
            return Exploration(None, ExploreStatus(reason="no lot is known yet"))
        self._drop_reached(place)
        aim = self._to_new_lot(field, place, pose.yaw, swath, fence)
        if aim is None:
            aim = self._to_unclear(field, place, fence, unclear)
        self._aim = aim
        self._quiet = 0 if aim is not None else self._quiet + 1
        done = self._quiet >= self._settings.quiet_plans
        remaining = float(field.gain[_seeable(field, swath)].sum()) / swath.width
        reason = "nothing is left to learn" if done else ""
        status = ExploreStatus(done, field.seen_share, 0.0 if done else round(remaining, 1), reason)
        return Exploration(aim, status)

    def _drop_reached(self, place: Place) -> None:
        aim = self._aim
        if aim is not None and math.dist(aim.place, place) <= self._settings.arrival_m:
            if aim.stall_id is not None:
                self._looked.add(aim.stall_id)
            self._aim = None

    def _to_new_lot(
        self, field: InformationField, place: Place, yaw: float, swath: Swath, fence: FenceGuard
    ) -> Aim | None:
        best = self._best(field, place, yaw, swath, self._headings, _passable(field, place))
        present = self._present(field, place, yaw, swath)
        aim = self._aim
        if aim is not None and present is not None and self._keeps(present, best, aim, place, fence):
            return Aim(aim.place, present.heading)
        if best is not None:
            end = end_of(place, best.heading, best.length)
            if not fence.contains(*place) or fence.contains_way(place, end):
                return Aim(end, best.heading)
        return self._round_about(field, place, swath, fence)

    def _keeps(self, present: Way, best: Way | None, aim: Aim, place: Place, fence: FenceGuard) -> bool:
        better = best is not None and best.score >= present.score * self._settings.switch_factor
        return not better and fence.contains_way(place, aim.place)

    def _present(self, field: InformationField, place: Place, yaw: float, swath: Swath) -> Way | None:
        """Return the way to the present aim as it is worth by now, None when it is worth nothing any more."""
        aim = self._aim
        if aim is None or aim.transit or aim.stall_id is not None:
            return None
        heading = math.atan2(aim.place[1] - place[1], aim.place[0] - place[0]) % (2 * math.pi)
        length = math.dist(aim.place, place)
        lengths, gains, scores, free = straight_ways(
            field, place, yaw, swath, np.array([heading]), length + field.window.cell_m, field.fenced
        )
        last = int(np.argmin(np.abs(lengths - length)))
        if gains[0, last] < self._settings.least_gain_m2 or not free[0, last]:
            return None
        return Way(heading, length, float(gains[0, last]), float(scores[0, last]))

    def _best(
        self,
        field: InformationField,
        place: Place,
        yaw: float,
        swath: Swath,
        headings: NDArray[np.float64],
        mask: NDArray[np.uint8],
    ) -> Way | None:
        ways = straight_ways(field, place, yaw, swath, headings, _REACH_M, mask)
        return best_way(ways, headings, self._settings.least_gain_m2, _LEAST_M)

    def _round_about(self, field: InformationField, place: Place, swath: Swath, fence: FenceGuard) -> Aim | None:
        """Where no straight way shows anything: round the corner, over allowed ground."""
        if self._aim is not None and self._aim.transit and fence.contains_way(place, self._aim.place):
            return self._aim
        corner = way_round(field, place, swath, self._settings.least_gain_m2)
        if corner is None or math.dist(corner, place) <= self._settings.arrival_m:
            return None
        if fence.contains(*place) and not fence.contains_way(place, corner):
            return None
        return Aim(corner, math.atan2(corner[1] - place[1], corner[0] - place[0]), transit=True)

    def _to_unclear(
        self, field: InformationField, place: Place, fence: FenceGuard, unclear: dict[int, Place]
    ) -> Aim | None:
        """Fly once over a stall whose state is unclear: the nearest first."""
        aim = self._aim
        if aim is not None and aim.stall_id in unclear and fence.contains_way(place, aim.place):
            return aim
        if len(self._looked) >= self._settings.second_looks:
            return None
        waiting = [(math.dist(there, place), i) for i, there in unclear.items() if i not in self._looked]
        for _, stall_id in sorted(waiting):
            there = unclear[stall_id]
            if fence.contains_way(place, there) and _is_allowed(field, there):
                heading = math.atan2(there[1] - place[1], there[0] - place[0])
                return Aim(there, heading, stall_id)
        return None


def _is_allowed(field: InformationField, place: Place) -> bool:
    column, row = np.round(field.window.cells_of(np.array(place[0]), np.array(place[1]))).astype(int)
    inside = 0 <= row < field.window.rows and 0 <= column < field.window.columns
    return bool(inside and field.allowed[row, column])


def _passable(field: InformationField, place: Place) -> NDArray[np.uint8]:
    """Where the drone may pass: over the lot, or anywhere inside the fence while it is not there."""
    return field.allowed if _is_allowed(field, place) else field.fenced


def _seeable(field: InformationField, swath: Swath) -> NDArray[np.bool_]:
    """Cells that some allowed place shows: about half a swath from it."""
    size = max(3, round(swath.depth / field.window.cell_m) | 1)
    return np.asarray(cv2.dilate(field.allowed, np.ones((size, size), np.uint8)) > 0)


def to_point(place: Place) -> MapPoint:
    """Return the place as the map has it."""
    return MapPoint(round(place[0], 3), round(place[1], 3))
