"""A day's rounds from lots that are due, their flights and a forecast: pure functions. They propose, and start nothing.

A round starts at the first hour that fits: little wind, no rain, and light enough for the camera until it has landed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Final

import numpy as np

from hawk.comm.protocol.commands import MOST_LOTS
from hawk.daemon.lots.schedule import EARLY, LATE
from hawk.ddc.battery import energy
from hawk.ddc.battery.survey import Battery, SurveyNeed
from hawk.ddc.fence.geometry import ring_to_map
from hawk.ddc.fence.outline import OutlineError, overlap
from hawk.model.day_plan import DayPlan, DayRound, Forecast, StartHour, WeatherHour
from hawk.model.known_lot import AGAIN_M, LotAhead
from hawk.model.poses import GlobalPose
from hawk.model.sentences import say
from hawk.model.sun import sun_position

FORECAST_S: Final = 12 * 3600.0
"""An older forecast is not believed: weather models run every six hours, so it was replaced twice."""
AHEAD_S: Final = 300.0
"""A forecast may be issued so much later than now: clocks differ."""
SWAP_S: Final = 300.0
"""Assumed time on the ground between two batteries."""
LEAST_LUX: Final = 2000.0
"""Light for an exposure of 10 ms at f/2.8 and ISO 100: C N² / (t S), C = 250 (ISO 2720), is 1,960 lx."""
LUX_BY_W_M2: Final = 110.0
"""Daylight's luminous efficacy, lm/W (Littlefair 1985: 105 to 120)."""


@dataclass(frozen=True, slots=True)
class DueLot:
    """A lot whose survey is due at a moment of its clock."""

    lot: LotAhead
    due: datetime


@dataclass(frozen=True, slots=True)
class RoundFlight:
    """Flight over lots: in the order of its tour, with its length, and the batteries that it needs.

    ``place``: latitude and longitude, degrees. ``seconds``: of `flight_seconds`.
    """

    lots: tuple[DueLot, ...]
    place: tuple[float, float]
    distance_m: float = 0.0
    seconds: float = 0.0
    batteries: int = 1
    problem: str = ""

    @property
    def due(self) -> datetime:
        """The moment at which all of the surveys are due."""
        return max(each.due for each in self.lots)


@dataclass(frozen=True, slots=True)
class DayLimits:
    """``now``: Unix seconds. ``batteries``: full ones for the day. ``wind_m_s``: limit of the settings."""

    now: float
    batteries: int
    wind_m_s: float
    forecast: Forecast | None = field(default=None, repr=False)


def day_rounds(due: Sequence[DueLot]) -> tuple[tuple[DueLot, ...], ...]:
    """Return lots that can be one flight: due within half an hour of each other, within `AGAIN_M` of the first one,
    and apart on the ground.
    """
    rounds: list[list[DueLot]] = []
    for each in sorted(due, key=lambda one: (one.due, one.lot.name)):
        mine = next((lots for lots in rounds if _is_one_of(each, lots)), None)
        if mine is None:
            rounds.append([each])
        else:
            mine.append(each)
    return tuple(map(tuple, rounds))


def _is_one_of(each: DueLot, lots: Sequence[DueLot]) -> bool:
    first = lots[0]
    if len(lots) >= MOST_LOTS or each.due - first.due > EARLY or each.lot.id in {one.lot.id for one in lots}:
        return False
    if not each.lot.has_plan or not first.lot.has_plan:
        return False
    try:
        is_apart = overlap([one.lot.outline for one in (*lots, each)]) is None
    except OutlineError:  # too wide together, or damaged: it is flown by itself
        return False
    return is_apart and distance_m(first.lot, each.lot) <= AGAIN_M


def distance_m(one: LotAhead, other: LotAhead) -> float:
    """Return the least distance between corners of two lots, metres."""
    datum = GlobalPose(*one.outline.polygons[0][0], 0.0)
    mine = [place for ring in one.outline.polygons for place in ring_to_map(datum, ring)]
    theirs = [place for ring in other.outline.polygons for place in ring_to_map(datum, ring)]
    return min(math.dist(a, b) for a in mine for b in theirs)


def flight_seconds(need: SurveyNeed, battery: Battery, travel_m: float) -> float:
    """Return the time of a round, with its climbs, flights home and swaps. ``travel_m``: height of travel, metres.

    Each battery after the first flies to the place where the one before turned back: as far as home.
    """
    home = (need.home - need.reserve) / energy.SAFETY_FACTOR / battery.drain
    swaps = need.batteries - 1
    return need.seconds + travel_m / energy.CLIMB_M_S + home + swaps * (SWAP_S + 2 * home)


def day_plan(flights: Sequence[RoundFlight], limits: DayLimits, problems: Sequence[str] = ()) -> DayPlan:
    """Return the day's rounds, one after the other, each at the first hour that fits, while batteries are left.

    ``problems`` are those of the settings.
    """
    of_forecast = "" if not flights else forecast_problem(limits)
    left, free, rounds = limits.batteries, limits.now, list[DayRound]()
    for flight in sorted(flights, key=lambda each: each.due):
        planned = _round(flight, limits, left, free, of_forecast)
        rounds.append(planned)
        if planned.end is not None:
            left, free = left - planned.batteries, planned.end.timestamp() + SWAP_S
    return DayPlan(tuple(rounds), tuple(filter(None, (*problems, of_forecast))))


def forecast_problem(limits: DayLimits) -> str:
    """Return why a forecast is not believed, with the remedy; empty for a good one."""
    if limits.forecast is None:
        return say("There is no forecast: enter one.")
    age = limits.now - limits.forecast.issued
    if age < -AHEAD_S:
        return say("The forecast was issued in the future: look at its time and at the computer's clock.")
    if age > FORECAST_S:
        return say("The forecast is {age:.0f} h old: enter one of the last 12 h.", age=age / 3600)
    return ""


def _round(flight: RoundFlight, limits: DayLimits, left: int, free: float, of_forecast: str) -> DayRound:
    lots, due = tuple((each.lot.id, each.lot.name) for each in flight.lots), flight.due
    problem = flight.problem or of_forecast
    if not problem and flight.batteries > left:
        problem = say("It needs {batteries} batteries; left: {left}.", batteries=flight.batteries, left=left)
    hours, start = list[StartHour](), None
    for at in () if problem else start_times(due, max(free, limits.now)):
        reasons = tuple(hour_reasons(flight, at, limits))
        hours.append(StartHour(at, reasons))
        if not reasons:
            start = at
            break
    if not problem and not hours:
        problem = say("An earlier round takes until it is due no more.")
    end = None if start is None else _after(start, flight.seconds)
    return DayRound(lots, due, start, end, flight.seconds, flight.batteries, flight.distance_m, problem, tuple(hours))


def start_times(due: datetime, free: float) -> Iterator[datetime]:
    """Yield the times at which a round can start: as soon as it may, then each full hour, while it is due.

    ``free``: Unix seconds before which no drone is there for it.
    """
    at, last = max(due, datetime.fromtimestamp(free, due.tzinfo)), _after(due, LATE.total_seconds())
    while at < last:
        yield at
        at = datetime.fromtimestamp(math.floor(at.timestamp() / 3600 + 1) * 3600, due.tzinfo)


def _after(moment: datetime, seconds: float) -> datetime:
    """Return a moment of the same clock, N real seconds later: in between summer time may begin or end."""
    return datetime.fromtimestamp(moment.timestamp() + seconds, moment.tzinfo)


def hour_reasons(flight: RoundFlight, at: datetime, limits: DayLimits) -> Iterator[str]:
    """Yield the reasons against a start at a time: each hour until the landing must fit."""
    begin, end = at.timestamp(), at.timestamp() + flight.seconds
    hours = () if limits.forecast is None else limits.forecast.hours
    during = sorted((hour for hour in hours if hour.begin < end and hour.end > begin), key=lambda hour: hour.begin)
    missing = _gap(during, begin, end)
    if missing is not None:
        yield say("the forecast says nothing of {time}", time=f"{datetime.fromtimestamp(missing, at.tzinfo):%H:%M}")
    windy = max(during, key=lambda hour: hour.gust, default=None)
    if windy is not None and windy.gust > limits.wind_m_s:
        yield say(
            "wind of {wind:.0f} m/s with gusts of {gust:.0f} m/s, limit {limit:g} m/s",
            wind=windy.wind, gust=windy.gust, limit=limits.wind_m_s,
        )  # fmt: skip
    rain = max((hour.rain for hour in during), default=0.0)
    if rain > 0.0:
        yield say("{rain:g} mm of rain", rain=rain)
    cloud = max((hour.cloud for hour in during), default=0.0)
    height = min(_sun_deg(each, flight.place) for each in (*np.arange(begin, end, 3600.0).tolist(), end))
    if light(height, cloud) < LEAST_LUX:
        yield say("too dark: sun at {height:.0f}°, {cloud:.0f} % of cloud", height=height, cloud=100 * cloud)


def _gap(hours: Sequence[WeatherHour], begin: float, end: float) -> float | None:
    """Return the first moment of a time that no hour of a forecast covers, Unix seconds; None where all is."""
    for hour in hours:
        if hour.begin > begin:
            return begin
        begin = max(begin, hour.end)
    return begin if begin < end else None


def light(sun_deg: float, cloud: float) -> float:
    """Return the light on the ground, lx, by the sun's height in degrees and the share of cloud (0..1).

    Kasten and Czeplak, Solar Energy 24 (1980): 910 sin h - 30 W/m² under a clear sky, and 1 - .75 n^3.4 of it under
    cloud.
    """
    clear = 910.0 * math.sin(math.radians(sun_deg)) - 30.0
    return max(0.0, clear) * (1.0 - 0.75 * math.pow(cloud, 3.4)) * LUX_BY_W_M2


def _sun_deg(seconds: float, place: tuple[float, float]) -> float:
    return sun_position(datetime.fromtimestamp(seconds, UTC), *place).elevation
