"""Autonomous exploration: the next place to fly to, until nothing is left to learn.

The secret is the policy: keep a tour over all that is expected (`course`), fly to its first way point, better it with
every frame. What is large comes first; what a first pass left out is flown to at the end. Then the drone looks around a
lot that seems too small, and once more at stalls whose state is unclear.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.path_plan.course import Course, Outlook
from hawk.algo.path_plan.fence import FenceGuard
from hawk.algo.path_plan.field import InformationField, Place
from hawk.algo.path_plan.route import way_round
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.sweep import Swath
from hawk.algo.path_plan.tour import Footprint, Terms, as_place
from hawk.algo.path_plan.wanted import are_allowed, wanted_of
from hawk.model import ExploreStatus, MapPoint, MapPose

_BARRED_CELLS = 2  # no way point lies so near to one that was given up

Route = tuple[Place, ...]


@dataclass(frozen=True, slots=True)
class Exploration:
    """One plan: where to fly (None: hold), the way points from there on, and how far the exploration is."""

    target: Place | None
    route: Route
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
        self._course = self._new_course()
        self._thorough = False
        self._quiet = 0
        self._stall: int | None = None
        self._looked: set[int] = set()
        self._barred: list[Place] = []
        self._progress = _Progress(self._settings)
        self._place: Place | None = None
        self._is_scouting = False
        self._scouted = 0.0
        self._left = 0.0

    def plan(self, around: Surroundings) -> Exploration:
        """Return where to fly next."""
        if not (around.field.lot > 0).any():
            return Exploration(None, (), ExploreStatus(reason="no lot is known yet"))
        around = self._looking(self._without_barred(around))
        was_scouting = self._is_scouting
        route = self._tour(around) or self._last_looks(around)
        target = self._target(around, route[0]) if route else None
        is_barred = bool(route) and (target is None or self._progress.is_none(around))
        if is_barred:
            self._bar(route[0])
            target, route = None, ()
        is_busy = target is not None or is_barred or self._is_scouting or was_scouting
        self._quiet = 0 if is_busy else self._quiet + 1
        done = self._quiet >= self._settings.quiet_plans
        status = ExploreStatus(
            done,
            around.field.seen_share,
            round(_length((around.place, *route)), 1),
            "nothing is left to learn" if done else "",
        )
        return Exploration(target, route, status)

    def _new_course(self) -> Course:
        return Course(self._settings.arrival_m, self._settings.switch_m)

    def _tour(self, around: Surroundings) -> Route:
        """Return the way points of the tour, none when nothing is worth a way any more."""
        for _ in range(2):
            places = self._course.follow(self._outlook(around))
            if len(places) or self._thorough:
                return tuple(as_place(place) for place in places)
            self._thorough = True
        return ()

    def _outlook(self, around: Surroundings) -> Outlook:
        settings, field = self._settings, around.field
        share = settings.last_spare if self._thorough else settings.first_spare
        spare = share * float(field.lot.sum()) * field.window.cell_m**2
        terms = Terms(
            Footprint(around.swath.width, around.swath.depth),
            settings.last_short_by if self._thorough else settings.short_by,
            settings.turn_m,
            settings.leg_m,
            settings.keep_m,
            allowed=lambda places: are_allowed(field, places),
        )
        wanted = wanted_of(field, around.swath, settings.least_gain_m2, spare, settings.border)
        return Outlook(around.place, around.pose.yaw, wanted, terms)

    def _last_looks(self, around: Surroundings) -> Route:
        """After the tour: look around a small lot, then at stalls whose state is unclear."""
        if self._is_scouting:
            self._is_scouting, self._scouted = False, math.inf
            self._course = self._new_course()
        elif around.scouting is not None and self._scouted <= self._settings.scout_way_m:
            self._is_scouting = True
            self._left = self._outlook(around).wanted.total
            self._course = self._new_course()
            return ()
        return self._unclear(around)

    def _looking(self, around: Surroundings) -> Surroundings:
        """While looking around, return what lies around as the field; end it when it showed more lot, or costs too
        much."""
        last, self._place = self._place, around.place
        if not self._is_scouting:
            return around
        self._scouted += 0.0 if last is None else math.dist(last, around.place)
        found = self._outlook(around).wanted.total > self._left + self._settings.least_gain_m2
        if found or self._scouted > self._settings.scout_way_m or around.scouting is None:
            self._is_scouting = False
            self._course = self._new_course()
            return around
        return replace(around, field=around.scouting)

    def _without_barred(self, around: Surroundings) -> Surroundings:
        """Take out of the fields what no way leads to: more each time, so that it always comes to an end."""
        if not self._barred:
            return around
        scouting = None if around.scouting is None else self._without(around.scouting, around.swath)
        return replace(around, field=self._without(around.field, around.swath), scouting=scouting)

    def _without(self, field: InformationField, swath: Swath) -> InformationField:
        gain, lot, allowed = field.gain.copy(), field.lot.copy(), field.allowed.copy()
        for times, (column, row) in enumerate(_cells(field, np.array(self._barred)).tolist(), 1):
            radius = swath.depth / 2 * (1 + times / 8) / field.window.cell_m
            for layer in (gain, lot):
                cv2.circle(layer, (column, row), math.ceil(radius), (0.0,), cv2.FILLED)
            cv2.circle(allowed, (column, row), _BARRED_CELLS, (0,), cv2.FILLED)
        return replace(field, gain=gain, allowed=allowed, lot=lot)

    def _bar(self, place: Place) -> None:
        self._barred.append(place)
        self._course = self._new_course()
        self._progress = _Progress(self._settings)

    def _unclear(self, around: Surroundings) -> Route:
        """Fly once over a stall whose state is unclear, the nearest first."""
        if self._stall is not None:
            at = around.unclear.get(self._stall)
            if at is None or math.dist(at, around.place) <= self._settings.arrival_m:
                self._looked.add(self._stall)
                self._stall = None
                return ()
            return (at,)
        if len(self._looked) >= self._settings.second_looks:
            return ()
        waiting = [(math.dist(at, around.place), i) for i, at in around.unclear.items() if i not in self._looked]
        for _, stall_id in sorted(waiting):
            at = around.unclear[stall_id]
            if are_allowed(around.field, np.array([at]))[0]:
                self._stall = stall_id
                return (at,)
            self._looked.add(stall_id)
        return ()

    def _target(self, around: Surroundings, end: Place) -> Place | None:
        """Return the way point, or the corner to fly to first, None when there is no way."""
        field, fence = around.field, around.fence
        if not fence.contains(*around.place):
            return end
        is_allowed = are_allowed(field, np.array([around.place]))[0]
        is_clear = not is_allowed or _is_clear(field, around.place, end)
        if is_clear and fence.contains_way(around.place, end):
            return end
        corner = way_round(field, around.place, end)
        if corner is None or math.dist(corner, around.place) <= self._settings.arrival_m / 2:
            return None
        return corner if fence.contains_way(around.place, corner) else None


class _Progress:
    """Tells an exploration that flies on and learns nothing: what it flies to cannot be seen."""

    def __init__(self, settings: PathPlanSettings) -> None:
        self._settings = settings
        self._well = 0.0
        self._plans = 0
        self._way = 0.0
        self._place: Place | None = None

    def is_none(self, around: Surroundings) -> bool:
        """Take one plan; whether too many plans at one place, or too long a way, showed nothing new."""
        moved = 0.0 if self._place is None else math.dist(self._place, around.place)
        well = float(around.field.well.sum()) * around.field.window.cell_m**2
        if well > self._well + 1.0:
            self._well, self._plans, self._way, self._place = well, 0, 0.0, around.place
            return False
        self._way += moved
        self._plans = self._plans + 1 if moved < self._settings.arrival_m / 10 else 0
        self._place = around.place
        return self._plans > self._settings.idle_plans or self._way > self._settings.idle_way_m


def _length(places: tuple[Place, ...]) -> float:
    return sum(math.dist(a, b) for a, b in pairwise(places))


def _cells(field: InformationField, places: NDArray[np.float64]) -> NDArray[np.intp]:
    return np.round(field.window.cells_of(places[..., 0], places[..., 1])).astype(np.intp)


def _is_clear(field: InformationField, start: Place, end: Place) -> bool:
    steps = max(2, math.ceil(math.dist(start, end) / field.window.cell_m * 2))
    columns, rows = _cells(field, np.linspace(start, end, steps)).T
    inside = (rows >= 0) & (rows < field.window.rows) & (columns >= 0) & (columns < field.window.columns)
    return bool(inside.all() and field.passable[rows, columns].all())


def to_point(place: Place) -> MapPoint:
    """Return the place as the map has it."""
    return MapPoint(round(float(place[0]), 3), round(float(place[1]), 3))
