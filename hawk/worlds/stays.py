"""Stays of cars on the stalls of a lot, over days: each with its stall, its begin and its end.

The stays of a stall on one day follow from seed, stall and date alone, so that every question about them gets the same
answer. A day of the lot begins at `DAY_BEGINS_H` o'clock. On it cars come one after the other: a free stall is taken
with the rate that keeps the share of taken stalls on the day's curve. A car that stays overnight comes in the
evening and leaves in the morning.

Curves, shares and lengths are ours: the shape that a shop's lot has, and a mean stay of an hour and a half.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import date, datetime, time, timedelta, tzinfo
from typing import Final

import numpy as np
from numpy.typing import NDArray

DAY_BEGINS_H: Final = 4
MEAN_STAY_S: Final = 1.5 * 3600.0
STAY_SIGMA: Final = 0.8
"""Standard deviation of the logarithm of a stay's length: half of the stays are shorter than 65 minutes."""
LONGEST_STAY_S: Final = 10 * 3600.0
SHORTEST_STAY_S: Final = 120.0
SHORTEST_GAP_S: Final = 60.0
"""Between a car that leaves and the next one."""
LONG_SHARE: Final = 0.12
"""Share of the weekday mornings' cars that stay for the day."""
LONG_BEGINS_H: Final = (6.0, 10.0)
LONG_MEAN_S, LONG_SIGMA_S = 8.5 * 3600.0, 0.8 * 3600.0
NIGHT_SHARE: Final = 0.03
"""Share of the stalls with a car overnight."""
NEAR_M: Final = 60.0
"""Beyond this distance from the building no stall is less liked than another, metres."""
ACCESSIBLE_SHARE: Final = 0.4
"""Demand for an accessible stall as a share of that for another."""

_SLOT_S: Final = 300.0
_SLOTS: Final = int(24 * 3600 / _SLOT_S)
_WEEKDAY: Final = (
    (0, .02), (6, .03), (7, .12), (8, .35), (9, .52), (10, .62), (11, .7), (12, .76), (13, .72), (14, .64), (15, .62),
    (16, .66), (17, .7), (18, .6), (19, .44), (20, .3), (21, .16), (22, .06), (24, .02),
)  # fmt: skip
_SATURDAY: Final = (
    (0, .02), (7, .04), (8, .15), (9, .35), (10, .6), (11, .78), (12, .86), (13, .88), (14, .86), (15, .8), (16, .72),
    (17, .6), (18, .45), (19, .3), (20, .18), (22, .06), (24, .02),
)  # fmt: skip
_SUNDAY: Final = ((0, .02), (8, .04), (10, .15), (12, .32), (14, .36), (16, .3), (18, .18), (20, .08), (22, .03), (24, .02))  # fmt: skip  # noqa: E501
_ZONE_LOGIT: Final = 1.4
"""Logit of the demand beside the building over that far from it."""
_STREAM: Final = 21
"""Distinguishes the random numbers of stays from others of the same seed."""


@dataclass(frozen=True, slots=True)
class Stay:
    """A car on a stall, by its id, from ``begin`` on, until before ``end``."""

    stall: int
    begin: datetime
    end: datetime

    def covers(self, moment: datetime) -> bool:
        """Return True while the car stands there."""
        return self.begin <= moment < self.end


@dataclass(frozen=True, slots=True)
class Demand:
    """Demand for one stall: ``nearness`` to the building (0: far, 1: beside it), and whether it is accessible."""

    nearness: float
    accessible: bool = False


class LotStays:
    """The stays of a lot, drawn from its seed; ``stalls`` has the demand for each stall by its id.

    ``clock`` is the lot's own. Moments that are asked for are aware, of any clock.
    """

    def __init__(self, seed: int, stalls: Mapping[int, Demand], clock: tzinfo) -> None:
        self._seed = seed
        self._clock = clock
        self._stalls = dict(stalls)
        self._busy = float(np.random.default_rng((seed, _STREAM)).uniform(0.85, 1.1))

    def at(self, moment: datetime) -> dict[int, Stay]:
        """Return the stays that cover a moment, by stall."""
        return {stay.stall: stay for stay in self.between(moment, moment) if stay.covers(moment)}

    def between(self, begin: datetime, end: datetime) -> list[Stay]:
        """Return every stay with a part in [begin, end], whole, by stall and time."""
        begin, end = begin.astimezone(self._clock), end.astimezone(self._clock)
        first, last = _day_of(begin) - timedelta(days=1), _day_of(end)
        days = [first + timedelta(days=k) for k in range((last - first).days + 1)]
        return [
            stay
            for stall in sorted(self._stalls)
            for day in days
            for stay in self._of_day(stall, day)
            if stay.begin <= end and stay.end > begin
        ]

    def share(self, stall: int, moment: datetime) -> float:
        """Return the share of the time (0..1) that the demand asks of a stall at a moment."""
        day = _day_of(moment.astimezone(self._clock))
        seconds = (moment - self._begin_of(day)).total_seconds()
        return float(self._shares(self._stalls[stall], day)[min(int(seconds / _SLOT_S), _SLOTS - 1)])

    def _begin_of(self, day: date) -> datetime:
        return datetime.combine(day, time(DAY_BEGINS_H), self._clock)

    def _of_day(self, stall: int, day: date) -> Iterator[Stay]:
        """Yield the stays that begin on a day of the lot, in whole seconds."""
        begins = self._begin_of(day)
        low, high = self._night(stall, day - timedelta(days=1))[1] - 86400.0, self._night(stall, day)[0]
        for begin, end in self._by_day(stall, day, low, high):
            yield Stay(stall, begins + timedelta(seconds=begin), begins + timedelta(seconds=end))
        arrives, leaves = self._night(stall, day)
        if leaves > 86400.0:
            yield Stay(stall, begins + timedelta(seconds=arrives), begins + timedelta(seconds=leaves))

    def _night(self, stall: int, day: date) -> tuple[int, int]:
        """Return arrival and departure of the night's car, seconds from the day's begin; without one the day's end."""
        rng = np.random.default_rng((self._seed, _STREAM, 1, stall, day.toordinal()))
        is_there = rng.random() < NIGHT_SHARE
        arrives, leaves = rng.uniform(17.5, 23.0), rng.uniform(30.0, 33.5)
        if not is_there:
            return 86400, 86400
        return round((arrives - DAY_BEGINS_H) * 3600), round((leaves - DAY_BEGINS_H) * 3600)

    def _by_day(self, stall: int, day: date, low: float, high: float) -> Iterator[tuple[int, int]]:
        """Yield begin and end of the stays within [low, high], seconds from the day's begin."""
        rng = np.random.default_rng((self._seed, _STREAM, 2, stall, day.toordinal()))
        shares = self._shares(self._stalls[stall], day)
        rates = _rates(shares, _is_work(day))
        chances, offsets = rng.random(_SLOTS), rng.random(_SLOTS)
        lengths = rng.lognormal(math.log(MEAN_STAY_S) - STAY_SIGMA**2 / 2, STAY_SIGMA, _SLOTS)
        long, long_lengths = rng.random(_SLOTS), rng.normal(LONG_MEAN_S, LONG_SIGMA_S, _SLOTS)
        free = low
        for k in np.flatnonzero(chances < 1 - np.exp(-rates * _SLOT_S)).tolist():
            begin = int((k + offsets[k]) * _SLOT_S)
            if begin < free + SHORTEST_GAP_S:
                continue
            is_long = _is_work(day) and _is_morning(k) and long[k] < LONG_SHARE
            length = float(long_lengths[k]) if is_long else float(np.clip(lengths[k], SHORTEST_STAY_S, LONGEST_STAY_S))
            end = int(min(begin + length, high - SHORTEST_GAP_S))
            if end - begin >= SHORTEST_STAY_S:
                free = end
                yield begin, end

    def _shares(self, demand: Demand, day: date) -> NDArray[np.float64]:
        """Return the shares of time (0..1) that the demand asks of a stall in each slot of a day."""
        usual = np.interp(_HOURS % 24, *_curve_of(day)) * self._busy
        usual = np.clip(usual * (ACCESSIBLE_SHARE if demand.accessible else 1.0), 0.005, 0.95)
        logit = np.log(usual / (1 - usual)) + _ZONE_LOGIT * (demand.nearness - 0.5)
        return np.asarray(1 / (1 + np.exp(-logit)), np.float64)


_HOURS: Final = DAY_BEGINS_H + (np.arange(_SLOTS) + 0.5) * _SLOT_S / 3600.0


def _curve_of(day: date) -> tuple[Sequence[float], Sequence[float]]:
    curve = (_WEEKDAY, _SATURDAY, _SUNDAY)[max(0, day.weekday() - 4)]
    hours, shares = zip(*curve, strict=True)
    return hours, shares


def _is_work(day: date) -> bool:
    return day.weekday() < 5


def _is_morning(slot: int) -> bool:
    return LONG_BEGINS_H[0] <= float(_HOURS[slot]) < LONG_BEGINS_H[1]


def _rates(shares: NDArray[np.float64], is_work: bool) -> NDArray[np.float64]:
    """Return the rates (1/s) by which free stalls are taken, so that the shares of taken ones follow a curve.

    The share p of taken stalls changes by rate (1 - p) - p / mean stay, where the stays' lengths are exponential.
    """
    morning = np.array([_is_morning(slot) and is_work for slot in range(_SLOTS)])
    mean = np.where(morning, (1 - LONG_SHARE) * MEAN_STAY_S + LONG_SHARE * LONG_MEAN_S, MEAN_STAY_S)
    return np.asarray(np.clip((np.gradient(shares, _SLOT_S) + shares / mean) / (1 - shares), 0, None), np.float64)


def _day_of(moment: datetime) -> date:
    return (moment - timedelta(hours=DAY_BEGINS_H)).date()
