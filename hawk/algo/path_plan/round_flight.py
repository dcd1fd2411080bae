"""The flight of a round: one known lot after the other, each as `hawk.algo.path_plan.revisit` flies it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from hawk.algo.ground import Floats, LotMap, Place
from hawk.algo.known_lot import tour_rectangles
from hawk.algo.path_plan.explore import Exploration
from hawk.algo.path_plan.revisit import Revisit, RevisitScene
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.model.known_lot import KnownLot, LotTour
from hawk.model.plans import ExploreStatus, LotLook

_OVER_M: Final = 40.0
"""A drone farther than this from every stall of a lot is on the path there: no picture from there shows one whole."""


class RoundFlight:
    """Follows the flight over the lots of a round from frame to frame."""

    def __init__(self, settings: PathPlanSettings, known: Mapping[str, KnownLot], tours: tuple[LotTour, ...]) -> None:
        """``known`` holds the plan of the lot of each tour, by its id."""
        self.tours = tours
        self._settings = settings
        self._known = known
        self._places: dict[str, Floats] = {tour.lot: tour_rectangles(known[tour.lot]).centres for tour in tours}
        self._number = 0
        self._begun = [Revisit(settings, known[tours[0].lot], tours[0])]
        self._is_between = False

    @property
    def is_between_lots(self) -> bool:
        """True while the drone flies to a lot that it is not over yet."""
        return self._is_between

    def plan(self, scene: RevisitScene, lot_map: LotMap) -> Exploration:
        """Return the next place to fly to; done when every lot is."""
        plan = self._begun[-1].plan(scene, lot_map)
        if plan.status.done and self._number + 1 < len(self.tours):
            self._number += 1
            tour = self.tours[self._number]
            self._begun.append(Revisit(self._settings, self._known[tour.lot], tour))
            plan = self._begun[-1].plan(scene, lot_map)
        path = self._path_m(scene.place, plan)
        self._is_between = path > 0.0
        return replace(plan, status=self._status(plan, path))

    def _path_m(self, place: Place, plan: Exploration) -> float:
        """Return the metres to the lot that is flown to, along the path; 0 over it."""
        places = self._places[self.tours[self._number].lot]
        if not plan.route or plan.status.done or np.hypot(*(places - place).T).min() <= _OVER_M:
            return 0.0
        corner = plan.route[0] if plan.target is None else plan.target
        return math.dist(place, corner) + (math.dist(corner, plan.route[0]) if corner != plan.route[0] else 0.0)

    def _status(self, plan: Exploration, path_m: float) -> ExploreStatus:
        status, last = plan.status, self._number
        looks = [
            LotLook(each.known.id, each.seen, number < last or status.done) for number, each in enumerate(self._begun)
        ]
        ahead = self.tours[last + 1 :]
        looks += [LotLook(tour.lot, 0.0) for tour in ahead]
        count = [len(self._places[tour.lot]) for tour in self.tours]
        seen = sum(look.seen * stalls for look, stalls in zip(looks, count, strict=True)) / max(sum(count), 1)
        left = None if status.remaining_m is None else status.remaining_m + sum(tour.distance_m for tour in ahead)
        return replace(
            status,
            seen=1.0 if all(look.seen >= 1.0 for look in looks) else seen,
            remaining_m=left,
            unreached=any(each.has_given_up for each in self._begun),
            lots=tuple(looks),
            path_m=path_m,
        )
