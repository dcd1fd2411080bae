"""Parts of an exploration, each with its own data: turns on the spot, looking around, second looks, places given up."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final, Protocol

import cv2
import numpy as np

from hawk.algo.ground import Floats, Place
from hawk.algo.path_plan.field import InformationField
from hawk.algo.path_plan.footprint import Footprint, Singles
from hawk.algo.path_plan.lot_ground import FenceGuard
from hawk.algo.path_plan.overview import ExploreScene
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.tour import Wanted

_LEAD_RAD: Final = 0.3  # the heading asked for lies this much beyond: a controller slows down towards it
_LEAST_RAD: Final = 0.02
_MOST_RAD: Final = math.pi  # after half a turn the picture has shown everything
_BARRED_CELLS: Final = 2  # distance of waypoints from a place that was given up, at least
_MOST_BEYOND: Final = 6  # places given up from which on nothing is looked for beyond the lot

Waypoints = tuple[Place, ...]


class Turning:
    """One turn on the spot: the picture's long side shows the ground about the drone, for seconds and no path.

    It goes the shorter of both directions until the wanted ground about the drone is shown, and no farther.
    """

    def __init__(self, place: Place, footprint: Footprint, least_m2: float, idle_plans: int) -> None:
        """``least_m2`` is the least worth turning for; after ``idle_plans`` plans without a move the turn is over."""
        self.place = place
        self._footprint = footprint
        self._least = least_m2
        self._most_idle = idle_plans
        self._side = 0.0
        self._last: float | None = None
        self._turned = 0.0
        self._idle = 0

    def heading(self, place: Place, heading: float, wanted: Wanted) -> float | None:
        """Return the picture's heading (radians) to turn to from the present one, None when the turn is over."""
        self._count(heading)
        off = wanted.cells - np.array(place, np.float32)
        near = np.hypot(off[:, 0], off[:, 1]) <= self._footprint.spun
        if self._turned > _MOST_RAD or self._idle > self._most_idle or not near.any():
            return None
        turns = self._footprint.turns_until_shown(off[near], heading)
        left, right = (self._until_little(turn, wanted.weights[near]) for turn in turns)
        if self._side == 0.0:
            self._side = -1.0 if left < right else 1.0
        turn = left if self._side < 0 else right
        return None if turn <= 0 else heading + self._side * (turn + _LEAD_RAD)

    def _count(self, heading: float) -> None:
        moved = 0.0 if self._last is None else abs(math.remainder(heading - self._last, math.tau))
        self._idle = 0 if moved > _LEAST_RAD else self._idle + 1
        self._turned += moved
        self._last = heading

    def _until_little(self, turns: Floats, weights: Singles) -> float:
        """Return the turn in one direction until little enough is left, radians; 0 is none."""
        order = np.argsort(-turns)
        beyond = np.cumsum(weights[order])
        last = int(np.searchsorted(beyond, self._least))  # the farthest of them together are worth less
        return 0.0 if last >= len(order) else float(turns[order[last]])


class Standing(Protocol):
    """A drone at a place: what a turn on the spot depends on."""

    @property
    def place(self) -> Place:
        """(north, east), metres."""
        ...

    @property
    def footprint(self) -> Footprint:
        """Ground that a picture shows."""
        ...

    @property
    def fence(self) -> FenceGuard:
        """The limits of the flight."""
        ...


class Turns:
    """Turns on the spot where the exploration begins, and where its tour ends; one at each place."""

    def __init__(self, settings: PathPlanSettings) -> None:
        self._settings = settings
        self._turning: Turning | None = None
        self._turned_at: list[Place] = []

    def present(self, scene: Standing, route: Waypoints) -> Turning | None:
        """Return the turn that is being made or begins now; ``route`` is that of the last plan."""
        if self._turning is None and self._is_due(scene, route):
            place = route[0] if route else scene.place
            settings = self._settings
            self._turned_at.append(place)
            self._turning = Turning(place, scene.footprint, settings.least_turn_m2, settings.idle_plans)
        return self._turning

    def end(self) -> None:
        """End the present turn."""
        self._turning = None

    def _is_due(self, scene: Standing, route: Waypoints) -> bool:
        place = scene.place
        if scene.footprint.spun <= 0 or not scene.fence.contains(*place):
            return False
        arrival = self._settings.arrival_m
        if any(math.dist(turned_at, place) <= 2 * arrival for turned_at in self._turned_at):
            return False
        if not self._turned_at:
            return True
        return len(route) == 1 and math.dist(route[0], place) <= arrival


class LookAround:
    """Limits of looking around a lot that seems too small to be the whole."""

    def __init__(self, settings: PathPlanSettings) -> None:
        self._settings = settings
        self._flown = 0.0
        self._place: Place = (0.0, 0.0)
        self._left_m2 = 0.0

    def may_begin(self, scene: ExploreScene) -> bool:
        """Return True when the lot is small and some of the path for it is left."""
        return scene.scouting is not None and self._flown <= self._settings.scout_path_m

    def begin(self, place: Place, left_m2: float) -> None:
        """Begin at a place; ``left_m2`` square metres of the known lot are wanted still."""
        self._place, self._left_m2 = place, left_m2

    def is_over(self, scene: ExploreScene, left_m2: float) -> bool:
        """Record one plan; return True when it showed more lot, cost too much path, or the lot is no longer small."""
        self._flown += math.dist(self._place, scene.place)
        self._place = scene.place
        found = left_m2 > self._left_m2 + self._settings.least_gain_m2
        return found or self._flown > self._settings.scout_path_m or scene.scouting is None

    def finish(self) -> None:
        """End it for this exploration: nothing is left to see around the lot."""
        self._flown = math.inf


class SecondLooks:
    """Flights over stalls with unknown state, the nearest first, once each."""

    def __init__(self, settings: PathPlanSettings) -> None:
        self._settings = settings
        self._stall: int | None = None
        self._looked: set[int] = set()

    def route(self, scene: ExploreScene) -> Waypoints:
        """Return the path to the next stall, none when one was just reached or none is left."""
        unclear, place = scene.unclear, scene.place
        if self._stall is not None:
            near = self._settings.stall_look_m
            self._looked |= {i for i, at in unclear.items() if math.dist(at, place) <= near}
            stall_at = unclear.get(self._stall)
            if stall_at is not None and self._stall not in self._looked:
                return (stall_at,)
            self._looked.add(self._stall)
            self._stall = None
            return ()
        if len(self._looked) >= self._settings.second_looks:
            return ()
        for _, stall_id in sorted((math.dist(at, place), i) for i, at in unclear.items() if i not in self._looked):
            at = unclear[stall_id]
            if scene.are_allowed(np.array([at]))[0]:
                self._stall = stall_id
                return (at,)
            self._looked.add(stall_id)
        return ()


class BorderPath:
    """Limit of the path for looks beyond the lot's border: a share of what was flown until lot was found last."""

    def __init__(self, settings: PathPlanSettings) -> None:
        self._settings = settings
        self._place: Place | None = None
        self._flown = 0.0
        self._beyond = 0.0
        self._found_m2 = 0.0
        self._found_at = 0.0

    def is_left(self, scene: ExploreScene, *, is_beyond: bool) -> bool:
        """Record one plan; return True while some of the path is left. Lot that is found gives it back.

        ``is_beyond``: the path since the last plan was for such looks.
        """
        moved = 0.0 if self._place is None else math.dist(self._place, scene.place)
        self._place = scene.place
        self._flown += moved
        self._beyond += moved if is_beyond else 0.0
        settings, lot_m2 = self._settings, scene.overview.lot_m2
        if lot_m2 > self._found_m2 + settings.found_m2:
            self._found_m2, self._found_at, self._beyond = lot_m2, self._flown, 0.0
        longest = settings.beyond_path_m + settings.beyond_path_share * self._found_at
        return self._beyond <= longest


@dataclass(frozen=True, slots=True)
class _Progress:
    """Plans at one place, and metres flown, since the area seen well grew; the place of the last plan."""

    place: Place | None = None
    well_m2: float = 0.0
    plans: int = 0
    path_m: float = 0.0


class GivenUp:
    """Places given up because no path leads to them, or because flying there shows nothing new."""

    def __init__(self, settings: PathPlanSettings) -> None:
        self._settings = settings
        self._places: list[Place] = []
        self._progress = _Progress()

    @property
    def has_any(self) -> bool:
        """True when a place was given up."""
        return bool(self._places)

    def add(self, place: Place) -> None:
        """Give up a place."""
        self._places.append(place)
        self._progress = _Progress()

    def learns_nothing(self, scene: ExploreScene) -> bool:
        """Record one plan; return True when too many plans at one place, or too long a path, showed nothing new."""
        progress, place, well = self._progress, scene.place, scene.overview.well_m2
        moved = 0.0 if progress.place is None else math.dist(progress.place, place)
        if well > progress.well_m2 + 1.0:
            self._progress = _Progress(place, well)
            return False
        plans = progress.plans + 1 if moved < self._settings.arrival_m / 10 else 0
        self._progress = _Progress(place, progress.well_m2, plans, progress.path_m + moved)
        return plans > self._settings.idle_plans or self._progress.path_m > self._settings.idle_path_m

    def without(self, scene: ExploreScene) -> ExploreScene:
        """Take the places out of the fields, with more ground each time, so that it always comes to an end."""
        if not self._places:
            return scene
        depth, rest, scouting = scene.footprint.depth, scene.rest, scene.scouting
        return replace(
            scene.with_field(self._taken_out(scene.field, depth)),
            rest=None if rest is None else replace(rest, field=self._taken_out(rest.field, depth)),
            scouting=None if scouting is None else self._taken_out(scouting, depth),
        )

    def _taken_out(self, field: InformationField, depth: float) -> InformationField:
        gain, lot, allowed = field.gain.copy(), field.lot.copy(), field.allowed.copy()
        beyond = None if field.beyond is None else replace(field.beyond, near=field.beyond.near.copy())
        places = np.array(self._places)
        cells = np.round(field.window.cells_of(places[:, 0], places[:, 1])).astype(np.intp)
        for times, (column, row) in enumerate(cells.tolist(), 1):
            radius = depth / 2 * (1 + times / 8) / field.window.cell_m
            for layer in (gain, lot):
                cv2.circle(layer, (column, row), math.ceil(radius), (0.0,), cv2.FILLED)
            if beyond is not None:
                cv2.circle(beyond.near, (column, row), math.ceil(radius), (0,), cv2.FILLED)
            cv2.circle(allowed, (column, row), _BARRED_CELLS, (0,), cv2.FILLED)
        if beyond is not None and len(self._places) >= _MOST_BEYOND:
            beyond.near[:] = 0
        left = replace(field, gain=gain, allowed=allowed, lot=lot, beyond=beyond)
        given_up = field.unseen_lot - left.unseen_lot
        if beyond is not None and field.beyond is not None:
            given_up = np.maximum(given_up, field.beyond.near.astype(np.float32) - beyond.near)
        return replace(left, given_up=given_up)
