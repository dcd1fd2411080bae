"""Autonomous exploration: the next place to fly to, until nothing is left to learn.

The secret is the policy: plan the whole way over what is expected, fly its first line for as long as it shows something
new, and plan again. What was begun is kept unless another plan is much cheaper.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.path_plan.fence import FenceGuard
from hawk.algo.path_plan.field import InformationField
from hawk.algo.path_plan.lines import LinePlan, best_plan
from hawk.algo.path_plan.route import way_round
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.sweep import Swath, ahead
from hawk.algo.path_plan.turned import Place
from hawk.model import ExploreStatus, MapPoint, MapPose

_HEADINGS = tuple(i * math.pi / 16 for i in range(16))
_REACH_M = 150.0
_ROW_GAIN_M2 = 2.0  # new ground in a row of the swath for which a line goes on


class Purpose(Enum):
    """What a leg is for."""

    APPROACH = "approach"
    SWEEP = "sweep"
    STALL = "stall"


@dataclass(frozen=True, slots=True)
class Leg:
    """One straight way: where to, the heading of the picture, what for, and the way on for display."""

    purpose: Purpose
    end: Place
    heading: float
    onwards: tuple[Place, ...] = ()
    stall_id: int | None = None


@dataclass(frozen=True, slots=True)
class Exploration:
    """One plan: where to fly (None: hold), with the way on, and how far the exploration is."""

    leg: Leg | None
    target: Place | None
    status: ExploreStatus


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What one plan is made from.

    ``unclear`` are the stalls whose state is not known, by id; ``scouting`` is the field for looking around, None when
    the lot is large enough to be the whole.
    """

    field: InformationField
    pose: MapPose
    swath: Swath
    fence: FenceGuard
    unclear: dict[int, Place]
    scouting: InformationField | None = None

    @property
    def place(self) -> Place:
        """Where the drone is."""
        return self.pose.north, self.pose.east


class Explorer:
    """Follows one exploration from frame to frame."""

    def __init__(self, settings: PathPlanSettings) -> None:
        self._settings = settings
        self.start()

    def start(self) -> None:
        """Begin anew: nothing is done, no stall was looked at again."""
        self._leg: Leg | None = None
        self._quiet = 0
        self._age = 0
        self._looked: set[int] = set()
        self._barred: list[Place] = []
        self._place: Place | None = None
        self._is_scouting = False
        self._scouted = 0.0

    def plan(self, around: Surroundings) -> Exploration:
        """Return where to fly next."""
        if not (around.field.lot > 0).any():
            return Exploration(None, None, ExploreStatus(reason="no lot is known yet"))
        around = self._without_barred(self._looking(around))
        target = self._aim(around, self._kept(around)) or self._aim(around, self._fresh(around))
        barred = target is None and self._leg is not None
        if self._leg is not None and barred:
            self._barred.append(self._leg.end)
            self._leg = None
        is_busy = target is not None or barred or self._is_scouting
        self._quiet = 0 if is_busy else self._quiet + 1
        done = self._quiet >= self._settings.quiet_plans
        left = 0.0 if self._leg is None else _length((around.place, self._leg.end, *self._leg.onwards))
        reason = "nothing is left to learn" if done else ""
        status = ExploreStatus(done, around.field.seen_share, round(left, 1), reason)
        return Exploration(self._leg, target, status)

    def _looking(self, around: Surroundings) -> Surroundings:
        """Change between exploring and looking around, and return what the plan is made from."""
        last, self._place = self._place, around.place
        if not self._is_scouting:
            return around
        self._scouted += 0.0 if last is None else math.dist(last, around.place)
        self._age += 1
        is_review = self._age % self._settings.review_plans == 0
        is_over = around.scouting is None or self._scouted > self._settings.scout_way_m
        if is_over or (is_review and self._cheapest(around) is not None):
            self._is_scouting, self._leg = False, None
            return around
        return replace(around, field=around.scouting or around.field)

    def _aim(self, around: Surroundings, leg: Leg | None) -> Place | None:
        """Take up a leg and return where to fly for it, None when there is no way."""
        self._leg = leg
        return None if leg is None else self._target(around, leg.end)

    def _without_barred(self, around: Surroundings) -> Surroundings:
        """Take out of the field what no way leads to: more each time, so that it always comes to an end."""
        if not self._barred:
            return around
        field = around.field
        gain = field.gain.copy()
        for times, (column, row) in enumerate(_cells(field, np.array(self._barred)).tolist(), 1):
            radius = around.swath.depth / 2 * (1 + times / 8) / field.window.cell_m
            cv2.circle(gain, (column, row), math.ceil(radius), (0.0,), cv2.FILLED)
        return replace(around, field=replace(field, gain=gain))

    def _kept(self, around: Surroundings) -> Leg | None:
        """Return the present leg as it is by now, None when it is flown or not worth it any more."""
        leg = self._leg
        if leg is None:
            return None
        reached = math.dist(leg.end, around.place) <= self._settings.arrival_m
        if leg.purpose is Purpose.SWEEP:
            return self._swept_on(around, leg)
        if reached and leg.stall_id is not None:
            self._looked.add(leg.stall_id)
        if reached or (leg.stall_id is not None and leg.stall_id not in around.unclear):
            return None
        self._age += 1
        if leg.purpose is Purpose.APPROACH and self._age % self._settings.review_plans == 0:
            return self._reviewed(around, leg)
        return leg

    def _swept_on(self, around: Surroundings, leg: Leg) -> Leg | None:
        """Go on along the line for as long as it shows something new."""
        length, gain = ahead(around.field, around.place, leg.heading, around.swath, _REACH_M, _ROW_GAIN_M2)
        if gain < self._settings.least_gain_m2 or length < self._settings.arrival_m:
            return None
        c, s = math.cos(leg.heading), math.sin(leg.heading)
        return replace(leg, end=(around.place[0] + length * c, around.place[1] + length * s))

    def _reviewed(self, around: Surroundings, leg: Leg) -> Leg | None:
        """Keep approaching unless another plan is much cheaper, or nothing is left."""
        plan = self._cheapest(around)
        if plan is None:
            return None
        cost = _length((around.place, leg.end, *leg.onwards)) + 1.0
        return leg if plan.cost > cost * self._settings.switch_share else self._begun(around, plan)

    def _fresh(self, around: Surroundings) -> Leg | None:
        plan = self._cheapest(around)
        if plan is not None:
            return self._begun(around, plan)
        if self._is_scouting:
            self._is_scouting, self._scouted = False, math.inf
        elif around.scouting is not None and self._scouted <= self._settings.scout_way_m:
            self._is_scouting = True
            return None
        return self._unclear(around)

    def _cheapest(self, around: Surroundings) -> LinePlan | None:
        pose = around.pose
        return best_plan(around.field, around.place, pose.yaw, around.swath, _HEADINGS, self._settings.least_gain_m2)

    def _begun(self, around: Surroundings, plan: LinePlan) -> Leg | None:
        first = plan.lines[0]
        self._age = 0
        onwards = tuple(place for line in plan.lines[1:] for place in (line.start, line.end))
        if math.dist(first.start, around.place) > self._settings.arrival_m:
            return Leg(Purpose.APPROACH, first.start, _bearing(around.place, first.start), (first.end, *onwards))
        if math.dist(first.start, first.end) <= self._settings.arrival_m:
            return None
        leg = Leg(Purpose.SWEEP, first.end, _bearing(first.start, first.end), onwards)
        return leg if self._swept_on(around, leg) is not None else None

    def _unclear(self, around: Surroundings) -> Leg | None:
        """Fly once over a stall whose state is unclear, the nearest first."""
        if len(self._looked) >= self._settings.second_looks:
            return None
        waiting = [(math.dist(at, around.place), i) for i, at in around.unclear.items() if i not in self._looked]
        for _, stall_id in sorted(waiting):
            at = around.unclear[stall_id]
            if _is_allowed(around.field, at):
                return Leg(Purpose.STALL, at, _bearing(around.place, at), stall_id=stall_id)
            self._looked.add(stall_id)
        return None

    def _target(self, around: Surroundings, end: Place) -> Place | None:
        """Return the end of the leg, or the corner to fly to first, None when there is no way."""
        field, fence = around.field, around.fence
        if not fence.contains(*around.place):
            return end
        is_clear = not _is_allowed(field, around.place) or _is_clear(field, around.place, end)
        if is_clear and fence.contains_way(around.place, end):
            return end
        corner = way_round(field, around.place, end)
        if corner is None or math.dist(corner, around.place) <= self._settings.arrival_m / 2:
            return None
        return corner if fence.contains_way(around.place, corner) else None


def _bearing(start: Place, end: Place) -> float:
    return math.atan2(end[1] - start[1], end[0] - start[0])


def _length(places: tuple[Place, ...]) -> float:
    return sum(math.dist(a, b) for a, b in pairwise(places))


def _cells(field: InformationField, places: NDArray[np.float64]) -> NDArray[np.intp]:
    return np.round(field.window.cells_of(places[..., 0], places[..., 1])).astype(np.intp)


def _is_allowed(field: InformationField, place: Place) -> bool:
    column, row = _cells(field, np.array(place))
    inside = 0 <= row < field.window.rows and 0 <= column < field.window.columns
    return bool(inside and field.allowed[row, column])


def _is_clear(field: InformationField, start: Place, end: Place) -> bool:
    steps = max(2, math.ceil(math.dist(start, end) / field.window.cell_m * 2))
    columns, rows = _cells(field, np.linspace(start, end, steps)).T
    inside = (rows >= 0) & (rows < field.window.rows) & (columns >= 0) & (columns < field.window.columns)
    return bool(inside.all() and field.passable[rows, columns].all())


def to_point(place: Place) -> MapPoint:
    """Return the place as the map has it."""
    return MapPoint(round(float(place[0]), 3), round(float(place[1]), 3))
