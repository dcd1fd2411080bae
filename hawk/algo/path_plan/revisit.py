"""The flight over a known lot: every stall once more, then what is new at the lot's rim.

It begins with the tour that was planned before the start (`known_tour`), and flies it by coordinates until the plan's
place on the map is certain; then the tour moves with the plan. With every frame the rest of the tour is bettered over
the stalls that were not looked at yet: what wind or drift left out comes back as a short leg.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from hawk.algo.ground import COARSE_M, Bools, Floats, KnownMap, LotMap, Place, Window
from hawk.algo.known_lot import tour_rectangles
from hawk.algo.path_plan.explore import Exploration
from hawk.algo.path_plan.footprint import Footprint, Singles
from hawk.algo.path_plan.known_tour import MARGIN_M, MOST_SEARCHED, boxes_of, corner_inside, corners_of, grown
from hawk.algo.path_plan.lot_ground import FenceGuard
from hawk.algo.path_plan.phases import Turning, Turns
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.tour import Terms, Tour, Wanted, as_place
from hawk.algo.rows.fit import Rectangles
from hawk.model.known_lot import KnownLot, LotTour
from hawk.model.lot_map import Stall, StallState
from hawk.model.plans import ExploreStatus

_SEEN: Final = 0.5
"""Share of a cell in a picture from which it counts as looked at."""
_INSIDE_M: Final = 0.8
"""Half a cell: so far within its corners a stall is asked for in the map's cells."""
_STALL_M2: Final = 12.5
_LOST_M: Final = 60.0
"""Cost of a stall that the rest of the tour leaves out, metres of path: more than any detour within a lot."""
_RIM_M: Final = 4.0
"""The same for a place at the rim while stalls of the plan are left: it is looked at on the path, or last."""
_MOST_SHIFTS: Final = 8
_SWEEPS: Final = ((200, 1), (80, 2), (0, 4))
"""Sweeps of a frame, from that number of stalls on that are left."""
_TRIES: Final = 6
"""Frames in which no waypoint, or no path to the first one, is found after which what is left is given up."""
_DROPS: Final = 12
"""Tries to leave out waypoints where a flight goes on: ground of the flight before need not be flown over."""
_STEPS_M: Final = (6.0, 2.0, 0.7)
_BRAKES_M_S2: Final = 2.5
EDGE_M: Final = 1.3
"""Edge of a picture in which no stall counts as shown: of 0.6 m the mapper takes nothing, and stalls of a plan that
vision has found lie up to 0.6 m off."""
_KEPT: Final = 300
"""Pictures that are remembered until the plan has its place: a minute."""
_NEW_M: Final = 2.2
_NEW_UNPLACED_M: Final = 8.0
"""A find farther from every stall of the plan is new: where its place is certain, and before."""
_NEXT: Final = (1.0, 2.0)
"""Stalls, on either side of a new one, that are looked at as well: its row may go on."""
_NEW_WORTH_M: Final = 15.0
"""Path that each new stall is worth once all others are looked at: one alone may be a false find."""
_RIM_PATH_M: Final = 120.0
"""Longest flight at the rim since the last new stall was found."""
_RIM_LOOK: Final = 10
"""Frames between two looks for new stalls."""


@dataclass(frozen=True, slots=True)
class RevisitScene:
    """Inputs of one plan of the flight: the drone's ``place``, the picture's ``heading`` (radians), ``speed``
    over ground (m/s); the ``footprint`` is that of whole pictures. ``picture`` (4, 2) are the corners of the ground
    that this frame shows, None while it is not mapped.
    """

    place: Place
    heading: float
    speed: float
    footprint: Footprint
    fence: FenceGuard
    picture: Floats | None = None


class Revisit:
    """Follows the flight over one known lot from frame to frame."""

    def __init__(self, settings: PathPlanSettings, known: KnownLot, tour: LotTour) -> None:
        self._settings = settings
        self.asked = tour
        self.known = known
        self._boxes = boxes_of(tour_rectangles(known))
        self._looked: Bools = np.zeros(len(self._boxes), np.bool_)
        self._given_up: Bools = np.zeros(len(self._boxes), np.bool_)
        self._count = len(self._boxes)
        """Stalls of the plan, then the places of its sections; the boxes after them are at the rim."""
        self._is_placed = False
        self._pictures: deque[Floats] = deque(maxlen=_KEPT)
        """Ground of the pictures so far, until the plan has its place."""
        self._seen_before: Bools = self._looked.copy()
        """Stalls that an earlier flight has shown."""
        self._tour: Tour | None = None
        self._places: Floats = np.array([(p.north, p.east) for p in tour.points[1:]]).reshape(-1, 2)
        self._turns = Turns(replace(settings, least_turn_m2=_STALL_M2 - 1.0))
        self._rng = np.random.default_rng(0)
        self._frame = self._quiet = self._idle = self._empty = self._barred = 0
        self._last: Place | None = None
        self._rim_flown = 0.0
        self._new: set[int] = set()
        """Stalls of the map that are not in the plan."""
        self._stop: Place = (0.0, 0.0)

    def plan(self, scene: RevisitScene, lot_map: LotMap) -> Exploration:
        """Return the next place to fly to."""
        self._frame += 1
        self._place_plan(lot_map)
        before = int(self._looked.sum())
        self._look(scene, lot_map)
        self._look_at_rim(scene, lot_map)
        self._count_idle(scene, learned=int(self._looked.sum()) > before)
        left = np.flatnonzero(~self._looked & ~self._given_up)
        turning = self._turns.present(_shrunk(scene), self._route)
        if turning is not None:
            turned = self._turn(scene, turning, left)
            if turned is not None:
                return turned
        if len(left) == 0:
            return self._over(scene)
        self._better(scene, left)
        return self._leg(scene, left)

    @property
    def seen(self) -> float:
        """Share (0..1) of the stalls of the plan that were looked at."""
        return float(self._looked[: self._count].mean()) if self._count else 1.0

    @property
    def has_given_up(self) -> bool:
        """True when a stall of the plan was given up."""
        return bool(self._given_up[: self._count].any())

    @property
    def _route(self) -> tuple[Place, ...]:
        return tuple(as_place(place) for place in self._places)

    # -- what was looked at -------------------------------------------------------------------------------------------

    def _place_plan(self, lot_map: LotMap) -> None:
        """Move stalls and tour to where the plan lies on the map, once that is certain."""
        if self._is_placed or not isinstance(lot_map, KnownMap):
            return
        values = lot_map.plan_places(self.known.id)
        stalls = len(self.known.stalls)
        if values is None or not stalls or len(values) != stalls:
            return
        self._is_placed = True
        before, after = self._boxes[:stalls, :2].astype(np.float64), values[:, :2]
        turn = math.remainder(float(np.median((values[:, 2] - _angles(self.known)) % math.pi)), math.pi)
        c, s = math.cos(turn), math.sin(turn)
        turned = np.array([[c, -s], [s, c]])
        self._boxes[:stalls] = boxes_of(Rectangles(values[:, :2], *values[:, 2:].T))
        sections = self._boxes[stalls : self._count]
        sections[:, :2] = (sections[:, :2] - before.mean(0)) @ turned.T + after.mean(0)
        sections[:, 2:] = (sections[:, 2:].reshape(-1, 2) @ turned.T).reshape(-1, 4)
        if len(self._places):
            self._places = (self._places - before.mean(0)) @ turned.T + after.mean(0)
        self._looked[:] = False
        self._looked[: self._count] = self._seen_before[: self._count]
        for picture in self._pictures:
            self._take(picture)
        self._pictures.clear()
        self._given_up[:] = False
        self._tour = None

    def _look(self, scene: RevisitScene, lot_map: LotMap) -> None:
        """Note the stalls that this picture shows whole, and those of an earlier flight when this one begins."""
        if self._frame == 1:
            for part in np.array_split(np.arange(len(self._boxes)), max(1, len(self._boxes) // 500)):
                self._looked[part] = _seen_on(lot_map, self._boxes[part])
            self._seen_before = self._looked.copy()
        if scene.picture is not None:
            self._take(scene.picture)
            if not self._is_placed:
                self._pictures.append(scene.picture)

    def _take(self, picture: Floats) -> None:
        """Note the stalls that a picture shows whole."""
        index = np.flatnonzero(~self._looked)
        self._looked[index] = _shows_whole(picture, self._boxes[index])

    def _look_at_rim(self, scene: RevisitScene, lot_map: LotMap) -> None:
        """Add the ground beside new stalls to the ground to look at: their rows may go on."""
        if self._frame % _RIM_LOOK or self._rim_flown > _RIM_PATH_M or not isinstance(lot_map, KnownMap):
            return
        reach = math.hypot(scene.footprint.width, scene.footprint.depth) / 2
        finds = [stall for stall in lot_map.stalls_near(*scene.place, reach) if stall.seen > 0]
        new = self._beside_plan(finds)
        if new:
            boxes = np.concatenate([_next_to(stall) for stall in new])
            boxes = boxes[self._apart(boxes[:, :2], self._boxes, _NEW_M)]
            self._boxes = np.concatenate([self._boxes, boxes])
            self._looked = np.concatenate([self._looked, _seen_on(lot_map, boxes)])
            self._given_up = np.concatenate([self._given_up, np.zeros(len(boxes), np.bool_)])
            self._rim_flown = 0.0

    def _beside_plan(self, finds: Sequence[Stall]) -> list[Stall]:
        """Return the finds that are no stall of the plan, each once."""
        finds = [stall for stall in finds if stall.id not in self._new and stall.state is not StallState.SUGGESTED]
        places = np.array([(stall.north, stall.east) for stall in finds], np.float32).reshape(-1, 2)
        least_m = _NEW_M if self._is_placed else _NEW_UNPLACED_M
        is_new = self._apart(places, self._boxes[: self._count], least_m)
        new = [stall for stall, yes in zip(finds, is_new, strict=True) if yes]
        self._new |= {stall.id for stall in new}
        return new

    def _apart(self, places: Singles, boxes: Singles, least_m: float) -> Bools:
        """Return True for those of places (M, 2) that are no box's; none is another one's, either."""
        away = np.hypot(*(places[:, None] - boxes[None, :, :2]).transpose(2, 0, 1))
        apart: Bools = np.asarray((away > least_m).all(1))
        twin = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)) <= 1.0
        return np.asarray(apart & ~np.triu(twin, 1).any(0), np.bool_)

    def _count_idle(self, scene: RevisitScene, *, learned: bool) -> None:
        """Give up what lies about a place where nothing is learnt any more; end the flight at the rim in time."""
        moved = 0.0 if self._last is None else math.dist(self._last, scene.place)
        self._last = scene.place
        rim_only = bool(self._looked[: self._count].all())
        self._rim_flown += moved if rim_only else 0.0
        self._idle = 0 if learned or moved > self._settings.arrival_m / 10 else self._idle + 1
        if self._idle > self._settings.idle_plans:
            self._give_up(scene, scene.place)
        if self._rim_flown > _RIM_PATH_M:
            self._given_up[self._count :] = True

    def _give_up(self, scene: RevisitScene, place: Place) -> None:
        """Give up the stalls that a picture from a place would show."""
        away = np.hypot(*(self._boxes[:, :2] - np.array(place, np.float32)).T)
        open_ = ~self._looked & ~self._given_up
        reach = max(scene.footprint.depth / 2, float(away[open_].min(initial=math.inf)) + 1.0)
        self._given_up |= open_ & (away <= reach)
        self._idle = 0

    # -- the tour -----------------------------------------------------------------------------------------------------

    def _turn(self, scene: RevisitScene, turning: Turning, left: np.ndarray) -> Exploration | None:
        """Turn on the spot while that shows stalls; None when it does not."""
        weights = np.full(len(left), _STALL_M2, np.float32)
        heading = turning.heading(scene.place, scene.heading, Wanted(self._boxes[left, :2], weights, 0.0))
        if heading is None:
            self._turns.end()
            return None
        self._quiet = 0
        route = (turning.place, *self._route[0 if self._frame < 2 else 1 :])
        return Exploration(route[0], route, self._status(scene, done=False), heading)

    def _better(self, scene: RevisitScene, left: np.ndarray) -> None:
        """Go on from the drone's place with the rest of the tour, over what is left."""
        while len(self._places) and math.dist(self._places[0], scene.place) <= self._settings.arrival_m:
            self._places = self._places[1:]
        if len(left) > MOST_SEARCHED and len(self._places):
            return  # flown as planned
        left = left[:MOST_SEARCHED]
        boxes = grown(self._boxes[left], MARGIN_M)
        has_plan = bool((left < self._count).any())
        rim_m = _RIM_M if has_plan else min(_NEW_WORTH_M * len(self._new), _RIM_PATH_M)
        worth = np.where(left >= self._count, rim_m, _LOST_M).astype(np.float32)
        wanted = Wanted(boxes, worth * scene.footprint.width, 0.0)
        heading = (math.cos(scene.heading), math.sin(scene.heading)) if scene.speed > 1.0 else (0.0, 0.0)
        terms = Terms(scene.footprint, 1.0, turn_m=0.5, leg_m=0.2, keep_m=3.0, before=heading,
                      allowed=lambda places: self._allowed(places, scene.fence))  # fmt: skip
        places = np.vstack([scene.place, self._places])
        if self._tour is None:
            self._tour = Tour(terms, wanted, places, scene.heading, self._rng)
            for _ in range(_DROPS if self._looked.any() else 0):
                self._tour.drop(0.0)
        else:
            self._tour.meet(terms, wanted, places, scene.heading)
        sweeps = next(count for least, count in _SWEEPS if len(boxes) >= least)
        for number in range(sweeps):
            self._tour.sweep(_STEPS_M[(self._frame + number) % len(_STEPS_M)], 0.0, _MOST_SHIFTS)
        self._places = self._tour.places[1:]

    def _allowed(self, places: Floats, fence: FenceGuard) -> Bools:
        """Return True for places inside the fence and near the lot."""
        low, high = self._boxes[:, :2].min(0), self._boxes[:, :2].max(0)
        near = self._settings.scout_near_lot_m
        return np.asarray(fence.contain(places) & ((places >= low - near) & (places <= high + near)).all(1))

    def _leg(self, scene: RevisitScene, left: np.ndarray) -> Exploration:
        """Fly to the first waypoint, or give up what it would show; hold while there is none."""
        self._empty = 0 if len(self._places) else self._empty + 1
        if self._empty > _TRIES:
            self._given_up[left] = True  # no allowed place shows it
            return self._over(scene)
        if self._empty:
            return Exploration(None, (), self._status(scene, done=False))
        target = corner_inside(scene.fence, scene.place, as_place(self._places[0]))
        self._barred = 0 if target is not None else self._barred + 1
        if target is None:
            if self._barred > _TRIES:
                self._give_up(scene, as_place(self._places[0]))
                self._places = self._places[1:]
            return Exploration(None, (), self._status(scene, done=False))
        self._quiet = 0
        return Exploration(target, self._route, self._status(scene, done=False))

    def _over(self, scene: RevisitScene) -> Exploration:
        """Come to a stop; done after some plans in a row with nothing left."""
        self._places = np.zeros((0, 2))
        if self._quiet == 0:
            ahead = scene.speed**2 / (2 * _BRAKES_M_S2)
            stop = scene.place[0] + ahead * math.cos(scene.heading), scene.place[1] + ahead * math.sin(scene.heading)
            self._stop = stop if scene.fence.contains_line(scene.place, stop) else scene.place
        self._quiet += 1
        status = self._status(scene, done=self._quiet >= self._settings.quiet_plans)
        return Exploration(self._stop, (self._stop,), status, scene.heading)

    def _status(self, scene: RevisitScene, *, done: bool) -> ExploreStatus:
        left = round(sum(math.dist(a, b) for a, b in pairwise((scene.place, *self._route))), 1)
        reason = "nothing is left to look at" if done else ""
        return ExploreStatus(done, self.seen, left, reason, unreached=self.has_given_up)


def _seen_on(lot_map: LotMap, boxes: Singles) -> Bools:
    """Return True for the boxes (N, 6) whose ground pictures have shown, by the map's cells."""
    inner = grown(boxes, -_INSIDE_M)
    points = np.concatenate([corners_of(inner), inner[:, None, :2].astype(np.float64)], axis=1)
    asked = points.reshape(-1, 2)
    window = Window.around(asked, COARSE_M, COARSE_M)
    shown = window.values_at(lot_map.coarse(window).seen, asked).reshape(-1, points.shape[1])
    return np.asarray((shown >= _SEEN).all(1))


def _shows_whole(picture: Floats, boxes: Singles) -> Bools:
    """Return True for the boxes (N, 6) that lie within a picture on the ground (4, 2), without its edge."""
    corners = corners_of(boxes)
    middle, inside = picture.mean(0), np.ones(len(boxes), np.bool_)
    for one, other in zip(picture, np.roll(picture, -1, axis=0), strict=True):
        side = (other - one) / max(float(np.hypot(*(other - one))), 1e-6)
        normal = np.array([-side[1], side[0]])
        normal *= math.copysign(1.0, float((middle - one) @ normal))
        inside &= ((corners - one) @ normal >= EDGE_M).all(1)
    return inside


def _shrunk(scene: RevisitScene) -> RevisitScene:
    """Return the scene with the ground in which the middles of stalls lie whose corners a picture shows."""
    half, foot = 2.9, scene.footprint
    return replace(
        scene,
        footprint=replace(
            foot, width=foot.width - 2 * half, depth=foot.depth - 2 * half, spun=max(foot.spun - half, 0.0)
        ),
    )


def _angles(known: KnownLot) -> Floats:
    return np.array([stall.angle for stall in known.stalls])


def _next_to(stall: Stall) -> Singles:
    """Return the boxes (M, 6) of a new stall and of those that may be next to it in its row."""
    along = np.array([math.cos(stall.angle), math.sin(stall.angle)])
    aside = np.array([-along[1], along[0]]) * stall.width
    steps = [number * aside for one in _NEXT for number in (-one, one)]
    middles = np.array([(stall.north, stall.east)]) + np.array([np.zeros(2), *steps])
    half = np.array([*(along * stall.length / 2), *(aside / 2)])
    return np.hstack([middles, np.tile(half, (len(middles), 1))]).astype(np.float32)
