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
from hawk.algo.path_plan.field import Grid, InformationField, Place
from hawk.algo.path_plan.footprint import Bools, Floats, Footprint
from hawk.algo.path_plan.overview import Overview, Part
from hawk.algo.path_plan.route import way_round
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.tour import Terms, as_place
from hawk.algo.path_plan.turning import Turning
from hawk.algo.path_plan.wanted import are_allowed, share_of
from hawk.model import ExploreStatus, MapPoint

_NO_LOT = "no lot is known yet"
_STANDS_M_S = 1.0  # slower, the drone has to speed up for whatever leg comes next
_BARRED_CELLS = 2  # no way point lies so near to one that was given up

Route = tuple[Place, ...]


@dataclass(frozen=True, slots=True)
class Exploration:
    """One plan: where to fly (None: hold), the way points from there on, and how far the exploration is.

    ``heading`` is the picture's, radians; None: along the way.
    """

    target: Place | None
    route: Route
    status: ExploreStatus
    heading: float | None = None


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What one plan is made from.

    ``near`` is the ground about the drone, ``rest`` another part of which the ``overview`` does not know yet.
    ``place`` is the drone's, ``heading`` the picture's (radians), ``speed`` over ground, m/s; ``unclear`` are the
    stalls whose state is not known, by id; ``scouting`` is the field for looking around, None when the lot is large
    enough to be the whole; ``share`` (0..1) is what is wanted of the near field's cells, once that is found out;
    ``lot_known`` is False while what looks like a lot stands in for one.
    """

    near: Part
    rest: Part | None
    overview: Overview
    place: Place
    heading: float
    speed: float
    footprint: Footprint
    fence: FenceGuard
    unclear: dict[int, Place]
    scouting: InformationField | None = None
    share: Grid | None = None
    lot_known: bool = True

    @property
    def field(self) -> InformationField:
        """What is to be learned about the drone."""
        return self.near.field

    def with_field(self, field: InformationField, share: Grid | None = None) -> Surroundings:
        """Return the same with another field about the drone."""
        return replace(self, near=replace(self.near, field=field), share=share)

    def are_allowed(self, places: Floats) -> Bools:
        """Return for places (T, 2) of (north, east) whether the drone may be there."""
        window = self.field.window
        cells = window.cells_of(places[:, 0], places[:, 1])
        is_near = ((cells >= 0) & (cells <= (window.columns - 1, window.rows - 1))).all(1)
        return np.where(is_near, are_allowed(self.field, places), self.overview.are_allowed(places))


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
        self._turning: Turning | None = None
        self._route: Route = ()
        self._turned_at: list[Place] = []

    def plan(self, around: Surroundings) -> Exploration:
        """Return where to fly next."""
        around = self._taken(self._without_barred(around))
        if around.overview.lot_m2 <= 0:
            return Exploration(None, (), ExploreStatus(reason=_NO_LOT, lot_known=around.lot_known))
        around = self._looking(around)
        turn = self._turn(around)
        if turn is not None:
            return turn
        was_scouting = self._is_scouting
        route = self._tour(around) or self._last_looks(around)
        self._route = route
        target = self._target(around, route[0]) if route else None
        is_barred = bool(route) and (target is None or self._progress.is_none(around))
        if is_barred:
            self._bar(route[0])
            target, route = None, ()
        is_whole = around.overview.is_complete
        is_busy = target is not None or is_barred or self._is_scouting or was_scouting or not is_whole
        self._quiet = 0 if is_busy else self._quiet + 1
        done = self._quiet >= self._settings.quiet_plans
        return Exploration(target, route, _status(around, route, done=done))

    def _turn(self, around: Surroundings) -> Exploration | None:
        """Where the exploration begins, and where its tour ends, turn on the spot while that shows what is wanted."""
        if self._turning is None and self._is_to_turn(around):
            place = self._route[0] if self._route else around.place
            self._turned_at.append(place)
            self._turning = Turning(place, around.footprint, self._settings.least_turn_m2, self._settings.idle_plans)
        if self._turning is None:
            return None
        outlook = self._outlook(around)
        heading = self._turning.heading(around.place, around.heading, outlook.wanted)
        if heading is None:
            self._turning = None
            return None
        self._quiet = 0
        if not self._route:
            self._course.prepare(outlook)
        route = (self._turning.place, *self._route[1:])
        return Exploration(route[0], route, _status(around, route, done=False), heading)

    def _is_to_turn(self, around: Surroundings) -> bool:
        if around.footprint.spun <= 0 or not around.fence.contains(*around.place):
            return False
        arrival = self._settings.arrival_m
        if any(math.dist(place, around.place) <= 2 * arrival for place in self._turned_at):
            return False  # once a place
        if not self._turned_at:
            return True
        return len(self._route) == 1 and math.dist(self._route[0], around.place) <= arrival

    def _new_course(self) -> Course:
        return Course(self._settings)

    def _tour(self, around: Surroundings) -> Route:
        """Return the way points of the tour, none when nothing is worth a way any more."""
        for _ in range(2):
            places = self._course.follow(self._outlook(around))
            if len(places) or self._thorough:
                return tuple(as_place(place) for place in places)
            self._thorough = True
            around.overview.forget()
            around = self._taken(around)
        return ()

    def _taken(self, around: Surroundings) -> Surroundings:
        """Find out what is wanted, and tell the overview."""
        share = self._share(around, around.field)
        around.overview.take(around.near, share)
        if around.rest is not None:
            around.overview.take(around.rest, self._share(around, around.rest.field))
        return replace(around, share=share)

    def _share(self, around: Surroundings, field: InformationField) -> Grid:
        settings = self._settings
        ends = settings.open_end_m2 + self._spare(around) if self._thorough else 0.0
        return share_of(field, around.footprint, settings.least_gain_m2, settings.border, ends)

    def _outlook(self, around: Surroundings) -> Outlook:
        settings = self._settings
        terms = Terms(
            around.footprint,
            settings.last_short_by if self._thorough else settings.short_by,
            settings.turn_m,
            settings.leg_m,
            settings.keep_m,
            before=(math.cos(around.heading), math.sin(around.heading)) if around.speed > _STANDS_M_S else (0.0, 0.0),
            allowed=around.are_allowed,
        )
        assert around.share is not None  # noqa: S101 - found out before
        wanted = around.overview.wanted(around.near, around.share, self._spare(around))
        return Outlook(around.place, around.heading, wanted, terms)

    def _spare(self, around: Surroundings) -> float:
        """Return the square metres that the tour may leave out."""
        share = self._settings.last_spare if self._thorough else self._settings.first_spare
        return min(share * around.overview.lot_m2, self._settings.most_spare_m2)

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
        return around.with_field(around.scouting, self._share(around, around.scouting))

    def _without_barred(self, around: Surroundings) -> Surroundings:
        """Take out of the fields what no way leads to: more each time, so that it always comes to an end."""
        if not self._barred:
            return around
        scouting = None if around.scouting is None else self._without(around.scouting, around.footprint)
        rest = around.rest
        if rest is not None:
            rest = replace(rest, field=self._without(rest.field, around.footprint))
        around = around.with_field(self._without(around.field, around.footprint))
        return replace(around, rest=rest, scouting=scouting)

    def _without(self, field: InformationField, footprint: Footprint) -> InformationField:
        gain, lot, allowed = field.gain.copy(), field.lot.copy(), field.allowed.copy()
        for times, (column, row) in enumerate(_cells(field, np.array(self._barred)).tolist(), 1):
            radius = footprint.depth / 2 * (1 + times / 8) / field.window.cell_m
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
            near = self._settings.stall_look_m
            self._looked |= {i for i, at in around.unclear.items() if math.dist(at, around.place) <= near}
            at = around.unclear.get(self._stall)
            if at is not None and self._stall not in self._looked:
                return (at,)
            self._looked.add(self._stall)
            self._stall = None
            return ()
        if len(self._looked) >= self._settings.second_looks:
            return ()
        waiting = [(math.dist(at, around.place), i) for i, at in around.unclear.items() if i not in self._looked]
        for _, stall_id in sorted(waiting):
            at = around.unclear[stall_id]
            if around.are_allowed(np.array([at]))[0]:
                self._stall = stall_id
                return (at,)
            self._looked.add(stall_id)
        return ()

    def _target(self, around: Surroundings, end: Place) -> Place | None:
        """Return the way point, or the corner to fly to first, None when there is no way."""
        field, fence = around.field, around.fence
        if not fence.contains(*around.place):
            return end
        is_allowed = around.are_allowed(np.array([around.place]))[0]
        is_clear = not is_allowed or _is_clear(field, around.place, end)
        if is_clear and fence.contains_way(around.place, end):
            return end
        corner = self._corner(around, end)
        if corner is None or math.dist(corner, around.place) <= self._settings.arrival_m / 2:
            return None
        return corner if fence.contains_way(around.place, corner) else None

    def _corner(self, around: Surroundings, end: Place) -> Place | None:
        is_near = around.field.window.holds(end)
        corner = way_round(around.field, around.place, end) if is_near else None
        return corner or around.overview.way_round(around.place, end)


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
        well = around.overview.well_m2
        if well > self._well + 1.0:
            self._well, self._plans, self._way, self._place = well, 0, 0.0, around.place
            return False
        self._way += moved
        self._plans = self._plans + 1 if moved < self._settings.arrival_m / 10 else 0
        self._place = around.place
        return self._plans > self._settings.idle_plans or self._way > self._settings.idle_way_m


def _status(around: Surroundings, route: Route, *, done: bool) -> ExploreStatus:
    left = round(_length((around.place, *route)), 1)
    if not around.lot_known:
        return ExploreStatus(done, 0.0, left, _NO_LOT, lot_known=False)
    return ExploreStatus(done, around.overview.seen_share, left, "nothing is left to learn" if done else "")


def _length(places: tuple[Place, ...]) -> float:
    return sum(math.dist(a, b) for a, b in pairwise(places))


def _cells(field: InformationField, places: NDArray[np.float64]) -> NDArray[np.intp]:
    return np.round(field.window.cells_of(places[..., 0], places[..., 1])).astype(np.intp)


def _is_clear(field: InformationField, start: Place, end: Place) -> bool:
    """Whether the straight way is free; what lies beyond the field will be looked at from nearer."""
    steps = max(2, math.ceil(math.dist(start, end) / field.window.cell_m * 2))
    columns, rows = _cells(field, np.linspace(start, end, steps)).T
    inside = (rows >= 0) & (rows < field.window.rows) & (columns >= 0) & (columns < field.window.columns)
    return bool(field.passable[rows[inside], columns[inside]].all())


def to_point(place: Place) -> MapPoint:
    """Return the place as the map has it."""
    return MapPoint(round(float(place[0]), 3), round(float(place[1]), 3))
