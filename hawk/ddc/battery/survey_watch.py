"""Watch of the battery against the rest of the survey, on the ground and in flight.

It is a part of the senses. What an exploration left and the drain of the flight are journalled, so that the next flight
knows them, also after a battery swap with the power off.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

from hawk.ddc.battery.drain import KEPT_FLIGHTS, DrainMeter, known_drain
from hawk.ddc.battery.energy import ASSUMED_DRAIN, Reserve
from hawk.ddc.battery.survey import Basis, Battery, Manner, SurveyNeed, need_in_flight, need_on_ground
from hawk.ddc.settings import DdcSettings
from hawk.ddc.stopwatch import Stopwatch
from hawk.ddc.survey_memory import SurveyMemory
from hawk.model.limits import HeightParameters
from hawk.model.operation import SurveyLeft
from hawk.model.plans import PathPlan

_LOGGER = logging.getLogger(__name__)

LOOK_S: Final = 0.5
"""Seconds between two estimates."""
SAME_OUTLINE: Final = 0.1
"""Areas of one outline differ by less, as a share: cells, and the fence of another arm place."""
KEEP_S: Final = 2.0
"""The rest of the survey is journalled this often while it explores, seconds."""


@dataclass(frozen=True, slots=True)
class Sighting:
    """The readings of a moment. ``now`` in seconds of the daemon's clock, ``utc`` in Unix seconds."""

    now: float
    utc: float
    armed: bool
    airborne: bool
    exploring: bool
    charge: float | None
    """Percent; None while unknown."""
    reserve: Reserve | None
    """Of this flight; None on the ground."""
    drain: float | None
    """As measured in this flight, percent a second."""
    plan: PathPlan | None
    lot_area: float
    """Of the map, square metres."""
    heights: HeightParameters
    outline_area: float | None
    """Of the outline inside the fence, square metres; None without one."""
    fence_area: Callable[[], float | None]
    """Area of the fence in force or planned, square metres; None while there is none."""


class SurveyWatch:
    """Estimates every half second; `need` is the last estimate."""

    def __init__(self, settings: DdcSettings, memory: SurveyMemory, *, continues_survey: bool) -> None:
        """``continues_survey``: the map of an earlier run was restored."""
        self._settings = settings
        self._memory = memory
        self._continues = continues_survey
        self._left = memory.left
        self._drains = memory.drains
        self._meter = DrainMeter()
        self._short = Stopwatch()
        self._has_failed = False
        self._looked = self._kept = self._explored_until = -math.inf
        self.need: SurveyNeed | None = None
        """None while the charge or the size of the survey is not known."""

    def short_s(self, now: float) -> float | None:
        """Return the seconds for which the charge has been too low for the rest of the survey; None while it is not."""
        return self._short.read(now)

    def fail(self) -> None:
        """Note a fault in `look`: nothing is known. It is logged once."""
        if not self._has_failed:
            _LOGGER.exception("the battery against the survey")
        self._has_failed = True
        self.need = None
        self._short = Stopwatch()

    def begin(self) -> None:
        """Forget what the last survey left: another one begins. The drain of the last flights stays."""
        self._continues, self._left, self.need = False, None, None
        self._short = Stopwatch()
        self._looked = self._kept = self._explored_until = -math.inf

    def look(self, seen: Sighting) -> None:
        """Take the readings of a tick."""
        self._measure(seen)
        self._follow(seen)
        if seen.now - self._looked < LOOK_S:
            return
        self._looked = seen.now
        self.need = self._estimate(seen)
        is_short = self.need is not None and not self.need.is_enough
        self._short.update(is_short and seen.exploring and seen.drain is not None, seen.now)

    def _measure(self, seen: Sighting) -> None:
        flight = self._meter.update(seen.charge, seen.now, seen.utc, airborne=seen.airborne, armed=seen.armed)
        if flight is not None:
            self._drains = (*self._drains, flight)[-KEPT_FLIGHTS:]
            self._memory.keep_drains(self._drains)

    def _follow(self, seen: Sighting) -> None:
        """Note what an exploration leaves, and the time that it took so far."""
        plan = seen.plan
        if not seen.exploring:
            self._explored_until = -math.inf
            return
        flown = 0.0 if self._left is None else self._left.flown_s
        flown += seen.now - self._explored_until if math.isfinite(self._explored_until) else 0.0
        self._explored_until = seen.now
        if plan is None or not _says_what_is_left(plan):
            if self._left is not None:
                self._left = replace(self._left, flown_s=flown)
            return
        done_before = self._left is not None and self._left.done
        explore = plan.explore
        area = seen.lot_area if explore.asked_m2 is None else explore.asked_m2
        self._left = SurveyLeft(explore.seen, area, explore.remaining_m or 0.0, explore.done, flown)
        if seen.now - self._kept >= KEEP_S or explore.done != done_before:
            self._kept = seen.now
            self._memory.keep_left(self._left)

    def _estimate(self, seen: Sighting) -> SurveyNeed | None:
        manner = self._manner(seen)
        rest = self._rest(seen, manner)
        if rest is None or seen.charge is None:
            return None
        basis, area, distance = rest
        battery = self._battery(seen, seen.charge)
        flown = 0.0 if self._left is None else self._left.flown_s
        if seen.airborne:
            if seen.reserve is None:
                return None
            return replace(need_in_flight(basis, area, distance, manner, seen.reserve.needed, battery), flown_s=flown)
        heights = seen.heights.desired, seen.heights.maximum
        return replace(need_on_ground(basis, area, distance, manner, heights, battery), flown_s=flown)

    def _manner(self, seen: Sighting) -> Manner:
        speed, height = self._settings.flight.speed_m_s, seen.heights.desired
        if seen.exploring and seen.plan is not None:
            speed = min(speed, seen.plan.speed or speed)
            height = seen.plan.height or height
        return Manner.of(speed, height, self._settings.view)

    def _rest(self, seen: Sighting, manner: Manner) -> tuple[Basis, float, float] | None:
        """Return source, area and distance of the rest of the survey; None while nothing is known of it."""
        left = self._left
        if left is not None and (seen.exploring or _is_about(left, seen.outline_area)):
            unseen = manner.distance(left.lot_area * (1.0 - left.seen))
            if seen.exploring:
                return "planner", left.lot_area, 0.0 if left.done else left.remaining_m
            return "map", left.lot_area, 0.0 if left.done else max(left.remaining_m, unseen)
        if self._continues and seen.lot_area > 0.0:
            return "map", seen.lot_area, manner.distance(seen.lot_area)
        if seen.outline_area is not None:
            return "outline", seen.outline_area, manner.distance(seen.outline_area)
        area = seen.fence_area()
        return None if area is None else ("fence", area, manner.distance(area))

    def _battery(self, seen: Sighting, charge: float) -> Battery:
        """Return the battery with the drain of this flight, else of the last ones, else the assumed one."""
        known = seen.drain if seen.airborne and seen.drain is not None else known_drain(self._drains, seen.utc)
        drain = ASSUMED_DRAIN if known is None else max(known, ASSUMED_DRAIN / 3)
        return Battery(charge, self._settings.flight.battery_reserve_percent, drain, known is not None)


def _is_about(left: SurveyLeft, outline_area: float | None) -> bool:
    """Return True when an exploration's rest is that of this outline: another outline is another survey."""
    return outline_area is None or abs(left.lot_area - outline_area) <= SAME_OUTLINE * outline_area


def _says_what_is_left(plan: PathPlan) -> bool:
    explore = plan.explore
    if explore.remaining_m is None or not explore.lot_known:
        return False
    return math.isfinite(explore.remaining_m) and math.isfinite(explore.seen)
