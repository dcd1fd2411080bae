"""Autonomous exploration: the next place to fly to, until nothing is left to learn.

A tour over all expected lot is kept (`tour.Course`) and bettered with every frame; the drone flies to its first
waypoint. The phases follow one another as in `ExplorePhase`; within each the drone may turn on the spot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum, auto
from itertools import pairwise
from typing import Final

from hawk.algo.ground import Grid, Place
from hawk.algo.path_plan.course import Course, Outlook
from hawk.algo.path_plan.field import InformationField, left_out, share_of, with_beyond
from hawk.algo.path_plan.overview import ExploreScene, GroundPart
from hawk.algo.path_plan.phases import BorderPath, GivenUp, LookAround, SecondLooks, Turns, Waypoints
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.tour import Terms, as_place
from hawk.model.plans import ExploreStatus

_NO_LOT: Final = "no lot is known yet"
_NOTHING_SEEN: Final = "nothing of the outline can be seen from inside the fence"
_FENCE_SAYS: Final = 2
"""Power of the share of the fence's ground that is lot: a fence drawn close about it says that the rest is lot too."""
_STANDS_M_S: Final = 1.0  # slower, the drone has to speed up for whatever leg comes next


class ExplorePhase(Enum):
    """Phases of an exploration; a tour that has waypoints again leads back to the second pass."""

    FIRST_PASS = auto()
    """A tour over all large areas."""
    SECOND_PASS = auto()
    """A tour over the ground that the first pass left out, and to ends of lanes."""
    BORDER = auto()
    """A tour over ground beyond the border, where the lot may go on; lot that it finds has a second pass first."""
    LOOK_AROUND = auto()
    """A tour around a lot that is too small to be the whole."""
    SECOND_LOOKS = auto()
    """Stalls with unknown state; done when none is left."""


@dataclass(frozen=True, slots=True)
class Exploration:
    """One plan: the target (None: hold), the waypoints from there on, and the progress of the exploration.

    ``heading`` is the picture's, radians; None: along the path.
    """

    target: Place | None
    route: Waypoints
    status: ExploreStatus
    heading: float | None = None


class Explorer:
    """Follows one exploration from frame to frame."""

    def __init__(self, settings: PathPlanSettings) -> None:
        self._settings = settings
        self._phase = ExplorePhase.FIRST_PASS
        self._course = Course(settings)
        self._route: Waypoints = ()
        self._turns = Turns(settings)
        self._look_around = LookAround(settings)
        self._second_looks = SecondLooks(settings)
        self._given_up = GivenUp(settings)
        self._border_path = BorderPath(settings)
        self._is_border_open = True
        self._left_m2 = math.inf
        """Least wanted lot since the looks beyond the border began."""
        self._quiet = 0
        """Plans in a row without anything to learn."""

    @property
    def looks_beyond(self) -> bool:
        """True from when the known lot was seen: from then on ground beyond its border is flown to."""
        return self._phase not in (ExplorePhase.FIRST_PASS, ExplorePhase.SECOND_PASS)

    def plan(self, scene: ExploreScene) -> Exploration:
        """Return the next place to fly to."""
        is_left = self._border_path.is_left(scene, is_beyond=self._phase is ExplorePhase.BORDER)
        if is_left != self._is_border_open:
            self._is_border_open = is_left
            scene.overview.forget()  # far ground was made with other borders
        scene = self._learned(self._given_up.without(scene))
        if scene.overview.lot_m2 <= 0:
            return self._without_lot(scene)
        scene = self._looking_around(scene)
        turn = self._turn(scene)
        if turn is not None:
            return turn
        begun_in = self._phase
        self._route = self._tour(scene) or self._last_looks(scene)
        return self._leg(scene, is_looking=ExplorePhase.LOOK_AROUND in (begun_in, self._phase))

    def _without_lot(self, scene: ExploreScene) -> Exploration:
        """Hold: a lot may come in sight. An outline without anything to see is done."""
        if not scene.is_outlined:
            return Exploration(None, (), ExploreStatus(reason=_NO_LOT, lot_known=scene.lot_known))
        self._quiet = self._quiet + 1 if scene.overview.is_complete else 0
        return Exploration(None, (), ExploreStatus(self._quiet >= self._settings.quiet_plans, reason=_NOTHING_SEEN))

    def _leg(self, scene: ExploreScene, *, is_looking: bool) -> Exploration:
        """Fly to the first waypoint, or give it up; without any count the plans until the exploration is done."""
        route, target = self._route, None
        if route:
            target = scene.target_towards(route[0], self._settings.arrival_m / 2)
        is_given_up = bool(route) and (target is None or self._given_up.learns_nothing(scene))
        if is_given_up:
            self._given_up.add(route[0])
            self._course = Course(self._settings)
            target, route = None, ()
        is_busy = target is not None or is_given_up or is_looking or not scene.overview.is_complete
        self._quiet = 0 if is_busy else self._quiet + 1
        done = self._quiet >= self._settings.quiet_plans
        return Exploration(target, route, _status(scene, route, done=done, unreached=self._given_up.has_any))

    def _turn(self, scene: ExploreScene) -> Exploration | None:
        """Turn on the spot while that shows wanted ground, None when it does not."""
        turning = self._turns.present(scene, self._route)
        if turning is None:
            return None
        outlook = self._outlook(scene)
        heading = turning.heading(scene.place, scene.heading, outlook.wanted)
        if heading is None:
            self._turns.end()
            return None
        self._quiet = 0
        if not self._route:
            self._course.prepare(outlook)
        route = (turning.place, *self._route[1:])
        return Exploration(route[0], route, _status(scene, route, done=False), heading)

    def _tour(self, scene: ExploreScene) -> Waypoints:
        """Return the waypoints of the tour, none when nothing is worth a path any more."""
        if self._phase in (ExplorePhase.BORDER, ExplorePhase.SECOND_LOOKS) and self._has_found(scene):
            self._want_other_ground(ExplorePhase.SECOND_PASS, scene)
            scene = self._learned(scene)
        places = self._course.follow(self._outlook(scene))
        if len(places) == 0 and self._phase is ExplorePhase.FIRST_PASS:
            self._want_other_ground(ExplorePhase.SECOND_PASS, scene)
            places = self._course.follow(self._outlook(self._learned(scene)))
        if len(places) == 0 and self._phase is ExplorePhase.SECOND_PASS:
            self._left_m2 = math.inf
            self._want_other_ground(ExplorePhase.BORDER, scene)
        if len(places) and self._phase is ExplorePhase.SECOND_LOOKS:
            self._phase = ExplorePhase.BORDER
        return tuple(as_place(place) for place in places)

    def _has_found(self, scene: ExploreScene) -> bool:
        """Return True when the last looks showed more lot: it is seen first."""
        if not scene.overview.is_complete:
            return False
        wanted_m2 = scene.overview.wanted_lot_m2
        self._left_m2 = min(self._left_m2, wanted_m2)
        return wanted_m2 > self._left_m2 + self._settings.found_m2

    def _want_other_ground(self, phase: ExplorePhase, scene: ExploreScene) -> None:
        self._phase = phase
        scene.overview.forget()

    def _last_looks(self, scene: ExploreScene) -> Waypoints:
        """After the tour: look around a small lot, then at stalls with unknown state."""
        if self._phase is ExplorePhase.BORDER and not scene.overview.is_complete:
            return ()  # what lies beyond the border is found first
        if self._phase is ExplorePhase.LOOK_AROUND:
            self._look_around.finish()
            self._begin_tour(ExplorePhase.SECOND_LOOKS)
        elif self._look_around.may_begin(scene):
            self._look_around.begin(scene.place, self._outlook(scene).wanted.total)
            self._begin_tour(ExplorePhase.LOOK_AROUND)
            return ()
        self._phase = ExplorePhase.SECOND_LOOKS
        return self._second_looks.route(scene)

    def _looking_around(self, scene: ExploreScene) -> ExploreScene:
        """While looking around, return the ground around as the field, until that is over."""
        if self._phase is not ExplorePhase.LOOK_AROUND:
            return scene
        is_over = self._look_around.is_over(scene, self._outlook(scene).wanted.total)
        if is_over or scene.scouting is None:
            self._begin_tour(ExplorePhase.SECOND_PASS)
            return scene
        return scene.with_field(scene.scouting, self._share(scene, scene.scouting))

    def _begin_tour(self, phase: ExplorePhase) -> None:
        self._phase = phase
        self._course = Course(self._settings)

    def _learned(self, scene: ExploreScene) -> ExploreScene:
        """Find the wanted ground, for the scene and its overview."""
        share = self._share(scene, scene.field)
        self._take(scene, scene.near, share)
        if scene.rest is not None:
            self._take(scene, scene.rest, self._share(scene, scene.rest.field))
        return replace(scene, share=share)

    def _take(self, scene: ExploreScene, part: GroundPart, share: Grid) -> None:
        """Give a part to the overview; what is left out is of interest after the first pass."""
        is_late = self._phase is not ExplorePhase.FIRST_PASS
        scene.overview.take(part, share, left_out(part.field, scene.footprint) if is_late else None)

    def _share(self, scene: ExploreScene, field: InformationField) -> Grid:
        settings = self._settings
        if self._phase is ExplorePhase.FIRST_PASS:
            return share_of(field, scene.footprint, settings.least_gain_m2, settings.border)
        ends = settings.open_end_m2 + self._spare(scene) if settings.open_end_m2 > 0 else 0.0
        share = share_of(field, scene.footprint, settings.last_least_gain_m2, settings.border, ends)
        if not (self.looks_beyond and self._is_border_open):
            return share
        worth = settings.beyond_worth * scene.overview.found_share**_FENCE_SAYS
        return with_beyond(share, field, scene.footprint, settings.beyond_least_m2, worth)

    def _spare(self, scene: ExploreScene) -> float:
        """Return the area that the tour may leave out, square metres."""
        settings = self._settings
        share = settings.first_spare if self._phase is ExplorePhase.FIRST_PASS else settings.last_spare
        return min(share * scene.overview.lot_m2, settings.most_spare_m2)

    def _outlook(self, scene: ExploreScene) -> Outlook:
        settings, heading = self._settings, scene.heading
        terms = Terms(
            scene.footprint,
            settings.short_by if self._phase is ExplorePhase.FIRST_PASS else settings.last_short_by,
            settings.turn_m,
            settings.leg_m,
            settings.keep_m,
            before=(math.cos(heading), math.sin(heading)) if scene.speed > _STANDS_M_S else (0.0, 0.0),
            allowed=scene.are_allowed,
        )
        assert scene.share is not None  # noqa: S101 - set by _learned
        spare = min(self._spare(scene), scene.overview.wanted_lot_m2)
        wanted = scene.overview.wanted(scene.near, scene.share, spare)
        return Outlook(scene.place, heading, wanted, terms)


def _status(scene: ExploreScene, route: Waypoints, *, done: bool, unreached: bool = False) -> ExploreStatus:
    left = round(sum(math.dist(a, b) for a, b in pairwise((scene.place, *route))), 1)
    if not scene.lot_known:
        return ExploreStatus(done, 0.0, left, _NO_LOT, lot_known=False)
    reason = "nothing is left to learn" if done else ""
    unseen = scene.overview.left_out if done and not scene.is_outlined else None
    return ExploreStatus(done, scene.overview.seen_share, left, reason, unreached=unreached, left_out=unseen)
