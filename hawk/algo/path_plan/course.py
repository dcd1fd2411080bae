"""The tour that is flown: searched a little with every frame, so that none takes long.

The present tour is only ever improved; a challenger is begun elsewhere, cooled over some frames, and takes over when it
is cheaper by a margin. Over wide ground challengers begin with lanes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from hawk.algo.ground import Floats, Place
from hawk.algo.path_plan.footprint import Footprint, Singles
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.path_plan.tour import Terms, Tour, Wanted

_OVERHANG: Final = 0.1
"""Share of a lane's width by which the ground may be wider than its lanes together."""


def to_and_fro(cells: Singles, footprint: Footprint, start: Place, heading: float) -> Floats:
    """Return waypoints (K, 2) of (north, east): the start, then lanes along ``heading`` (radians) that show all cells.

    A lane is flown over gaps in the ground; it begins and ends where its pictures show the last of its cells. Of both
    orders and both directions the ones with the shortest path are returned. ``cells`` (N, 2) are at least one.
    """
    c, s = math.cos(heading), math.sin(heading)
    to_lanes = np.array([[c, -s], [s, c]])
    turned = cells.astype(np.float64) @ to_lanes  # along, across
    lanes = _lanes(turned, footprint)
    begin = np.array(start) @ to_lanes
    orders = [_joined(lanes[::step], first) for step in (1, -1) for first in (0, 1)]
    tours = [np.vstack([begin, order]) for order in orders]
    shortest = min(tours, key=lambda tour: float(np.hypot(*np.diff(tour, axis=0).T).sum()))
    places: Floats = shortest @ to_lanes.T
    places[0] = start
    return places


def _lanes(turned: Floats, footprint: Footprint) -> Floats:
    """Return the ends (L, 2, 2) of lanes as (along, across), in order across."""
    low, high = float(turned[:, 1].min()), float(turned[:, 1].max())
    count = max(1, math.ceil((high - low) / footprint.width - _OVERHANG))
    pitch = max((high - low) / count, 1e-6)
    number = np.minimum(((turned[:, 1] - low) / pitch).astype(int), count - 1)
    lanes = []
    for lane in range(count):
        along = turned[number == lane, 0]
        if len(along) == 0:
            continue
        first, last = float(along.min()) + footprint.depth / 2, float(along.max()) - footprint.depth / 2
        if first > last:
            first = last = (first + last) / 2
        across = low + (lane + 0.5) * pitch
        lanes.append(((first, across), (last, across)))
    return np.array(lanes)


def _joined(lanes: Floats, first: int) -> Floats:
    """Return the waypoints of lanes (L, 2, 2) flown to and fro, the first one from its end ``first``."""
    flown = lanes.copy()
    flown[1 - first :: 2] = flown[1 - first :: 2, ::-1]
    places = flown.reshape(-1, 2)
    moved = np.any(np.diff(places, axis=0) != 0, axis=1)
    kept: Floats = places[np.concatenate([[True], moved])]
    return kept


_FIRST_SWEEPS: Final = 6
_CHALLENGE_FRAMES: Final = 8
_HOT_M: Final = 6.0
_COLD_M: Final = 0.2
_SWEEPS: Final = 2
_MOST_SHIFTS: Final = 12
_STEPS_M: Final = (6.0, 2.0, 0.7)
_WARM_M: Final = 3.0
"""A challenger that begins with lanes is good by itself, and heated no more than this."""
_LANES_FROM: Final = 16.0  # pictures' areas of wanted ground: it fills many pictures


@dataclass(frozen=True, slots=True)
class Outlook:
    """One frame for the search: the drone's place, the picture's heading (radians), the wanted ground, the terms."""

    place: Place
    yaw: float
    wanted: Wanted
    terms: Terms


class Course:
    """The tour that is flown: followed from frame to frame, bettered a little at each, replaced by a better one."""

    def __init__(self, settings: PathPlanSettings) -> None:
        self._settings = settings
        self._rng = np.random.default_rng(0)
        self._tour: Tour | None = None
        self._challenger: Tour | None = None
        self._has_lanes = False
        self._cooled = 0
        self._frame = 0

    def prepare(self, outlook: Outlook) -> None:
        """Search for the first tour, a part with every frame, while the drone does not follow it yet."""
        self._frame += 1
        if self._tour is None:
            self._tour = self._challenged(outlook)
        else:
            self._go_on(self._tour, outlook)

    def follow(self, outlook: Outlook) -> Floats:
        """Return the waypoints still to be flown (K, 2), none when nothing is worth the path."""
        self._frame += 1
        if self._tour is None:
            self._tour = self._begun(outlook)
            for sweep in range(_FIRST_SWEEPS):
                self._sweep(self._tour, _HOT_M * (_COLD_M / _HOT_M) ** (sweep / _FIRST_SWEEPS))
        self._go_on(self._tour, outlook)
        return self._tour.places[1:]

    def _go_on(self, tour: Tour, outlook: Outlook) -> None:
        """Better the tour from the drone's present place, or let the challenger take over."""
        self._meet(tour, outlook)
        self._sweep(tour, 0.0)
        challenger = self._challenged(outlook)
        if challenger is not None and challenger.cost < tour.cost - self._settings.switch_m:
            self._tour = challenger

    def _challenged(self, outlook: Outlook) -> Tour | None:
        """Cool the challenger by one frame; return it when it is cold, and begin another with the next frame."""
        if self._challenger is None:
            footprint = outlook.terms.footprint
            self._has_lanes = outlook.wanted.total > _LANES_FROM * footprint.width * footprint.depth
            self._challenger, self._cooled = self._laned(outlook) if self._has_lanes else self._begun(outlook), 0
        else:
            self._meet(self._challenger, outlook)
        self._cooled += 1
        share, hot = self._cooled / _CHALLENGE_FRAMES, _WARM_M if self._has_lanes else _HOT_M
        self._sweep(self._challenger, 0.0 if share >= 1 else hot * (_COLD_M / hot) ** share)
        if share < 1:
            return None
        cold, self._challenger = self._challenger, None
        return cold

    def _begun(self, outlook: Outlook) -> Tour:
        return Tour(outlook.terms, outlook.wanted, np.array([outlook.place]), outlook.yaw, self._rng)

    def _laned(self, outlook: Outlook) -> Tour:
        """Begin with lanes in a direction drawn at random."""
        heading = self._rng.uniform(0.0, math.pi)
        places = to_and_fro(outlook.wanted.cells, outlook.terms.footprint, outlook.place, heading)
        is_allowed = outlook.terms.allowed(places)
        is_allowed[0] = True
        return Tour(outlook.terms, outlook.wanted, places[is_allowed], outlook.yaw, self._rng)

    def _meet(self, tour: Tour, outlook: Outlook) -> None:
        """Go on from the drone's present place."""
        left = tour.places[1:]
        while len(left) and math.dist(left[0], outlook.place) <= self._settings.arrival_m:
            left = left[1:]
        tour.meet(outlook.terms, outlook.wanted, np.vstack([outlook.place, left]), outlook.yaw)

    def _sweep(self, tour: Tour, heat: float) -> None:
        """Try to better every waypoint, and the tour as a whole."""
        for number in range(_SWEEPS):
            step = _STEPS_M[(self._frame + number) % len(_STEPS_M)] if heat < 1.0 else _STEPS_M[0]
            tour.sweep(step, heat, _MOST_SHIFTS)
