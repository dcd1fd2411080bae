"""Battery for a survey: its distance and time by the area of the lot, the charge for them and for the flight home.

Before take-off the lot is an earlier survey's, or unknown: then it is at most as large as the fence. In flight the
planner's own distance counts. Percent are those of the battery, lengths metres, areas square metres.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, Literal

from hawk.ddc.battery import energy
from hawk.ddc.settings import DdcSettings, SurveyMemory
from hawk.ddc.stopwatch import Stopwatch
from hawk.model.operation import SurveyLeft
from hawk.model.plans import HeightParameters, PathPlan
from hawk.model.sentences import say

Basis = Literal["planner", "map", "outline", "fence"]
"""Source of an estimate: the planner's distance in flight, an earlier survey's map, the area of outline or fence."""

GOOD_SHARE: Final = 0.85
"""Middle share of the picture that counts as seen, the planner's `PathPlanSettings.good_share`."""
DISTANCE_BY_SWEEP: Final = 1.10
"""Distance of the planner over area by width of the swath.

Measured by ``python -m benchmarks.exploration``, distance to the planner's own end over lots 1-28: 1.00 over lots of
0.3 ha, 1.23 of 1 ha, 1.09 of 3 ha (means). The estimate is 0.74 to 1.25 of nine flights of ten."""
BEGIN_S: Final = 20.0
"""Seconds of a survey beside its distance: the turn on the spot at the start, the last plans at the end.

8 s in those flights, 22 to 26 s in three surveys of the whole daemon (hawk-sim at 35 m, seeds 2, 4 and 7)."""
LOST_S: Final = 2.7
"""Seconds lost at corners on a distance as long as the swath is wide, at 4 m/s (the model's flights)."""
LOST_AT_M_S: Final = 4.0


@dataclass(frozen=True, slots=True)
class Sweep:
    """Survey flight: ``speed`` of travel (m/s), ``width`` (m) of the ground that a picture shows well."""

    speed: float
    width: float

    @classmethod
    def of(cls, speed: float, height: float, view: float) -> Sweep:
        """Return it for a height; ``view`` is the width of the whole picture at a height of one metre."""
        return cls(speed, GOOD_SHARE * view * height)

    def distance(self, area: float) -> float:
        """Return the metres that the planner flies to see a lot whole, second looks included."""
        return DISTANCE_BY_SWEEP * max(0.0, area) / self.width

    def seconds(self, distance: float, *, begins: bool = True) -> float:
        """Return the seconds that a survey takes over a distance, metres; 0 for none.

        A corner costs the time to brake and to speed up again, which grows with the speed. ``begins`` False leaves out
        what a survey takes beside its distance: it is flown already.
        """
        if distance <= 0.0:
            return 0.0
        corners = LOST_S * self.speed / LOST_AT_M_S * distance / self.width
        return distance / self.speed + corners + (BEGIN_S if begins else 0.0)


@dataclass(frozen=True, slots=True)
class Battery:
    """Charge, reserve that stays at the landing (percent), and drain (percent a second), measured or assumed."""

    charge: float
    reserve: float
    drain: float
    is_measured: bool


@dataclass(frozen=True, slots=True)
class SurveyNeed:
    """The battery against the rest of the survey."""

    basis: Basis
    area: float
    """Of the lot (map), of outline or fence (by their names), or of the lot found so far (planner)."""
    seconds: float
    """Time of the rest of the survey, without take-off and the flight home."""
    percent: float
    """Charge for it, with the climb where the drone is on the ground."""
    home: float
    """Charge for the flight home, the reserve included."""
    charge: float
    is_measured: bool = True
    """False when the drain is assumed: no flight has measured it yet."""
    flown_s: float = 0.0
    """Seconds that this survey explored so far, in all of its flights."""
    reserve: float = 0.0
    """Charge that stays at the landing, a part of ``home``."""

    @property
    def left(self) -> float:
        """Charge that is left after the survey and the flight home; negative when it does not suffice."""
        return self.charge - self.home - self.percent

    @property
    def is_enough(self) -> bool:
        """True when the rest of the survey can be flown."""
        return self.left >= 0.0

    @property
    def batteries(self) -> int:
        """Batteries for the rest of the survey, the present one included; each other one is full, and flies to the lot
        and home.
        """
        full = 100.0 - self.home - (self.home - self.reserve) / energy.SAFETY_FACTOR
        return 1 if self.is_enough else 1 + math.ceil(-self.left / max(full, 1.0))

    @property
    def share(self) -> float:
        """Share (0..1) of the rest of the survey that the battery allows."""
        if self.is_enough or self.percent <= 0.0:
            return 1.0
        return min(1.0, max(0.0, (self.charge - self.home) / self.percent))

    @property
    def whole_share(self) -> float:
        """Share (0..1) of the whole survey that is seen when the battery is needed for the flight home, by time."""
        whole = self.flown_s + self.seconds
        return 1.0 if whole <= 0.0 else (self.flown_s + self.share * self.seconds) / whole


def need_on_ground(
    basis: Basis, area: float, distance: float, sweep: Sweep, heights: tuple[float, float], battery: Battery
) -> SurveyNeed:
    """Return the need before take-off.

    Args:
        basis: Source of ``area`` and ``distance``.
        area: Of lot or fence.
        distance: Of the rest of the survey; 0 when nothing is left.
        sweep: How it is flown.
        heights: Height to explore from, and height of the return.
        battery: The charge and the drain.
    """
    travel, top = heights
    seconds = sweep.seconds(distance)
    climb = travel / energy.CLIMB_M_S if seconds > 0.0 else 0.0
    back = energy.seconds_home(_middle_distance(area), travel, top, sweep.speed)
    return SurveyNeed(
        basis=basis,
        area=area,
        seconds=seconds,
        percent=(climb + seconds) * battery.drain,
        home=battery.reserve + energy.SAFETY_FACTOR * back * battery.drain,
        charge=battery.charge,
        is_measured=battery.is_measured,
        reserve=battery.reserve,
    )


def need_in_flight(
    basis: Basis, area: float, distance: float, sweep: Sweep, home: float, battery: Battery
) -> SurveyNeed:
    """Return the need in flight; ``home`` is the charge that the flight home needs now, the reserve included."""
    seconds = sweep.seconds(distance, begins=basis != "planner")
    return SurveyNeed(
        basis,
        area,
        seconds,
        seconds * battery.drain,
        home,
        battery.charge,
        battery.is_measured,
        reserve=battery.reserve,
    )


def _middle_distance(area: float) -> float:
    """Return the distance from home at which a survey ends: half the diagonal of a square lot."""
    return float(0.71 * max(0.0, area) ** 0.5)


def check_words(need: SurveyNeed) -> str:
    """Return the line of the check before Arm."""
    figures = say("home {home:.0f} %, charge {charge:.0f} %", home=need.home, charge=need.charge)
    if need.seconds <= 0.0:
        return say("nothing is left of the survey; {figures}", figures=figures)
    part = say("survey {percent:.0f} %, {figures}", percent=need.percent, figures=figures)
    if not need.is_measured:
        part = say("{part}; drain assumed, no flight has measured it", part=part)
    if need.basis == "fence":
        lot = say("a lot as large as the fence ({size})", size=hectares(need.area))
        if need.is_enough:
            return say("enough, even for {lot}: {part}", lot=lot, part=part)
        return say("enough for about {tens} % of {lot}: {part}", tens=tens(need.share), lot=lot, part=part)
    if need.basis == "outline":
        whole = say("the outline ({size})", size=hectares(need.area))
        if need.is_enough:
            return say("enough for {whole}: {part}", whole=whole, part=part)
        return say(
            "enough for about {tens} % of {whole}: continue after a battery swap; {part}",
            tens=tens(need.share),
            whole=whole,
            part=part,
        )
    if need.is_enough:
        return say("enough for the rest of the survey: {part}", part=part)
    return say(
        "enough for about {tens} % of the rest: continue after a battery swap; {part}",
        tens=tens(need.share),
        part=part,
    )


def hectares(area: float) -> str:
    """Return an area in hectares."""
    return say("{hectares:.1f} ha", hectares=area / 1e4)


def tens(share: float) -> str:
    """Return a share in percent, to the tens below: an estimate is no better than that."""
    return f"{math.floor(share * 10 + 1e-9) * 10}"


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
    reserve: energy.Reserve | None
    """Of this flight; None on the ground."""
    drain: float | None
    """As measured in this flight, percent a second."""
    plan: PathPlan | None
    lot_area: float
    """Of the map, square metres."""
    heights: HeightParameters
    outline_area: float | None
    """Of the outline inside the fence, square metres; None without one."""
    tour_m: float | None
    """Length of the planned flight over lots that are surveyed again; None without one."""
    fence_area: Callable[[], float | None]
    """Area of the fence in force or planned, square metres; None while there is none."""


class SurveyReading:
    """Estimates every half second; `need` is the last estimate."""

    def __init__(self, settings: DdcSettings, memory: SurveyMemory, *, continues_survey: bool) -> None:
        """``continues_survey``: the map of an earlier run was restored."""
        self._settings = settings
        self._memory = memory
        self._continues = continues_survey
        self._left = memory.left
        self._drains = memory.drains
        self._meter = energy.DrainMeter()
        self._short = Stopwatch()
        self._has_failed = False
        self._looked = self._kept = self._explored_until = -math.inf
        self.need: SurveyNeed | None = None
        """None while the charge or the size of the survey is not known."""

    def short_s(self, now: float) -> float | None:
        """Return the seconds for which the charge has been too low for the rest of the survey; None while it is not."""
        return self._short.read(now)

    def fail(self) -> None:
        """Note a fault in `update`: nothing is known. It is logged once."""
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

    def update(self, seen: Sighting) -> None:
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
            self._drains = (*self._drains, flight)[-energy.KEPT_FLIGHTS :]
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
        sweep = self._sweep(seen)
        rest = self._rest(seen, sweep)
        if rest is None or seen.charge is None:
            return None
        basis, area, distance = rest
        battery = self._battery(seen, seen.charge)
        flown = 0.0 if self._left is None else self._left.flown_s
        if seen.airborne:
            if seen.reserve is None:
                return None
            return replace(need_in_flight(basis, area, distance, sweep, seen.reserve.needed, battery), flown_s=flown)
        heights = seen.heights.desired, seen.heights.maximum
        return replace(need_on_ground(basis, area, distance, sweep, heights, battery), flown_s=flown)

    def _sweep(self, seen: Sighting) -> Sweep:
        speed, height = self._settings.flight.speed_m_s, seen.heights.desired
        if seen.exploring and seen.plan is not None:
            speed = min(speed, seen.plan.speed or speed)
            height = seen.plan.height or height
        return Sweep.of(speed, height, self._settings.view)

    def _rest(self, seen: Sighting, sweep: Sweep) -> tuple[Basis, float, float] | None:
        """Return source, area and distance of the rest of the survey; None while nothing is known of it."""
        left = self._left
        if left is not None and (seen.exploring or _is_about(left, seen.outline_area)):
            unseen = sweep.distance(left.lot_area * (1.0 - left.seen))
            if seen.exploring:
                return "planner", left.lot_area, 0.0 if left.done else left.remaining_m
            return "map", left.lot_area, 0.0 if left.done else max(left.remaining_m, unseen)
        if self._continues and seen.lot_area > 0.0:
            return "map", seen.lot_area, sweep.distance(seen.lot_area)
        if seen.outline_area is not None:
            distance = sweep.distance(seen.outline_area) if seen.tour_m is None else seen.tour_m
            return "outline", seen.outline_area, distance
        area = seen.fence_area()
        return None if area is None else ("fence", area, sweep.distance(area))

    def full_battery(self, utc: float) -> Battery:
        """Return a full battery with the drain of the last flights; ``utc`` is now, Unix seconds."""
        return self._with_drain(100.0, energy.known_drain(self._drains, utc))

    def _battery(self, seen: Sighting, charge: float) -> Battery:
        """Return the battery with the drain of this flight, else of the last ones, else the assumed one."""
        known = seen.drain if seen.airborne and seen.drain is not None else energy.known_drain(self._drains, seen.utc)
        return self._with_drain(charge, known)

    def _with_drain(self, charge: float, known: float | None) -> Battery:
        drain = energy.ASSUMED_DRAIN if known is None else max(known, energy.ASSUMED_DRAIN / 3)
        return Battery(charge, self._settings.flight.battery_reserve_percent, drain, known is not None)


def _is_about(left: SurveyLeft, outline_area: float | None) -> bool:
    """Return True when an exploration's rest is that of this outline: another outline is another survey."""
    return outline_area is None or abs(left.lot_area - outline_area) <= SAME_OUTLINE * outline_area


def _says_what_is_left(plan: PathPlan) -> bool:
    explore = plan.explore
    if explore.remaining_m is None or not explore.lot_known:
        return False
    return math.isfinite(explore.remaining_m) and math.isfinite(explore.seen)
