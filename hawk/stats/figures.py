"""Figures of a lot's use over a period: by hour of the day, by day of the week, and by row, zone or kind.

Terms and formulas: docs/statistics.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Annotated, Final

import numpy as np
from pydantic import Field

from hawk.lots.answers import Count, Share, Shown
from hawk.lots.plan.values import Id
from hawk.stats.changes import Steady, steady
from hawk.stats.counts import count
from hawk.stats.flow import Flow, Moves
from hawk.stats.hours import Hours, around, flown_hours
from hawk.stats.partition import Partition
from hawk.stats.turnover import Turnover, longest_gap, turnover
from hawk.stats.values import (
    LEVEL,
    NOTHING,
    WEEKDAYS,
    Estimate,
    Floats,
    Group,
    LeftOut,
    Local,
    Panel,
    Unit,
    Weekday,
    groups_of,
    whole,
)

PRACTICAL: Final = (0.85, 0.90)
"""Occupancies from which a lot counts as full: drivers circle (docs/statistics.md)."""


@dataclass(frozen=True, slots=True)
class Peak:
    """The surveyed hour of highest occupancy. `rivals`: other hours whose interval reaches its own."""

    begin: Local
    occupancy: Estimate
    accumulation: Estimate
    rivals: Count


@dataclass(frozen=True, slots=True)
class Use:
    """Use of a part of the lot, or of all of it, over the surveyed hours of a period.

    `unit`: a section counts vehicles and has no turnover; `capacity`: its places, null where nobody said them.

    `occupancy`: mean share of taken stalls, of hours that count alike; `load_space_hours`: those taken; `accumulation`:
    mean number of taken stalls, the load by the hours; `above`: shares of the surveyed hours at or above an occupancy.
    """

    name: str
    capacity: Count | None
    surveys: Count
    hours: Count
    occupancy: Estimate
    accumulation: Estimate
    load_space_hours: Estimate
    peak: Peak | None
    above: dict[str, Estimate]
    never_taken: Steady
    always_taken: Steady
    turnover: Turnover
    unit: Unit = "stalls"


@dataclass(frozen=True, slots=True)
class Hour:
    """Mean over the days with a survey in an hour of the day. An hour that nobody flew has nothing.

    `days`: dates; where a clock shows an hour twice on one, both count in the mean.
    """

    hour: Annotated[int, Field(ge=0, le=23)]
    days: Count
    occupancy: Estimate
    accumulation: Estimate


@dataclass(frozen=True, slots=True)
class Day:
    """Mean over the surveyed hours of a day of the week: `days` of them, `hours` in all."""

    day: Weekday
    days: Count
    hours: Count
    occupancy: Estimate


@dataclass(frozen=True, slots=True)
class Compared:
    """Two days of the week by the hours that both have: by how much the second is fuller, a share."""

    first: Weekday
    second: Weekday
    hours: Count
    difference: Estimate


class Figures(Shown):
    """Figures of a lot's use in a period. `interval`: share of figures whose interval is to hold the true value.
    `by` says what `parts` are.
    """

    lot: Id
    name: str
    clock: str
    interval: Share
    surveys: Count
    first: Local | None
    last: Local | None
    left_out: tuple[LeftOut, ...]
    whole: Use | None
    by: Partition | None
    parts: tuple[Use, ...] = Field(repr=False)
    hours: tuple[Hour, ...] = Field(repr=False)
    days: tuple[Day, ...] = Field(repr=False)
    compared: tuple[Compared, ...] = Field(repr=False)


def figures(panel: Panel, by: Partition | None = None) -> Figures:
    """Return the figures of a panel."""
    groups = [*whole(panel), *groups_of(panel, by)]
    hours, moves = flown(panel, groups)
    total, *parts = _uses(panel, groups, hours, moves)
    at = panel.local_times
    first, last = (at[end].isoformat(timespec="minutes") if at else None for end in (0, -1))
    return Figures(
        lot=panel.lot, name=panel.name, clock=panel.clock_name, interval=LEVEL, surveys=len(at),
        first=first, last=last, left_out=panel.left_out, whole=total if at else None, by=by, parts=tuple(parts),
        hours=hours_of_day(hours), days=days_of_week(hours), compared=compared(hours),
    )  # fmt: skip


def by_hour(panel: Panel) -> Hours:
    """Return the mean share of a whole lot over every hour with a survey."""
    return flown(panel, whole(panel))[0]


def flown(panel: Panel, groups: Sequence[Group]) -> tuple[Hours, Moves]:
    """Return the surveyed hours and the moves of groups, the first of which is the whole lot."""
    counted, moves = count(panel, groups), Moves.of(panel, groups)
    return flown_hours(panel, counted, Flow.of(moves, counted)), moves


def _uses(panel: Panel, groups: Sequence[Group], hours: Hours, moves: Moves) -> list[Use]:
    mean, load, bounds, still = hours.over(), hours.load(), hours.bounds(), steady(panel, groups)
    above = {f"{limit:.2f}": _above(hours, bounds, limit) for limit in PRACTICAL}
    turnovers = turnover(moves, longest_gap(moves))
    flown = np.isfinite(hours.mean).sum(axis=0).tolist()
    newest = panel.is_there[-1] if len(panel.surveys) else np.zeros(len(panel.stalls), np.bool_)
    return [
        Use(
            group.name, int((newest & group.members).sum()), mean[k].surveys, flown[k], mean[k],
            load[k].times(1 / max(flown[k], 1)), load[k], _peak(hours, bounds, k),
            {limit: each[k] for limit, each in above.items()}, *still[k], turnovers[k],
        )
        for k, group in enumerate(groups)
    ]  # fmt: skip


def _above(hours: Hours, bounds: tuple[Floats, Floats], limit: float) -> list[Estimate]:
    """Return the share of flown hours at or above an occupancy; the ends: hours whose interval is, may be."""
    known = np.isfinite(hours.mean)
    flown = known.sum(axis=0).tolist()
    surveys = np.where(known, hours.surveys, 0.0).sum(axis=0).tolist()
    counts = zip(*((known & (each >= limit)).sum(axis=0).tolist() for each in (hours.mean, *bounds)), strict=True)
    return [
        Estimate(value / whole, least / whole, most / whole, int(count)) if whole else NOTHING
        for (value, least, most), whole, count in zip(counts, flown, surveys, strict=True)
    ]


def _peak(hours: Hours, bounds: tuple[Floats, Floats], group: int) -> Peak | None:
    mean = hours.mean[:, group]
    if not np.isfinite(mean).any():
        return None
    top = int(np.nanargmax(mean))
    low, high = (each[:, group] for each in bounds)
    rivals = int((np.nan_to_num(high, nan=-1.0) >= low[top]).sum()) - 1
    share = Estimate(float(mean[top]), float(low[top]), float(high[top]), int(hours.surveys[top, group]))
    begin = f"{hours.day[top].isoformat()}T{hours.hour[top]:02d}:00"
    return Peak(begin, share, share.times(float(hours.capacity[top, group])), rivals)


def hours_of_day(hours: Hours) -> tuple[Hour, ...]:
    """Return the mean of each of the 24 hours of the day over the days that have it, of the first group."""
    is_it = (np.array(hours.hour, np.int64)[:, None] == np.arange(24)) & np.isfinite(hours.mean[:, :1])
    weights = is_it / np.maximum(is_it.sum(axis=0), 1)
    stalls = weights * hours.capacity[:, :1]
    shares, amounts = sums(hours, weights), sums(hours, stalls, high=stalls.sum(axis=0))
    found = []
    for hour in range(24):
        days = len({hours.day[k] for k in np.flatnonzero(is_it[:, hour]).tolist()})
        found.append(Hour(hour, days, shares[hour], amounts[hour]) if days else Hour(hour, 0, NOTHING, NOTHING))
    return tuple(found)


def days_of_week(hours: Hours) -> tuple[Day, ...]:
    """Return the days of the week that were flown, of the first group."""
    weekday = np.array([day.weekday() for day in hours.day], np.int64)
    numbers = sorted(set(weekday[np.isfinite(hours.mean[:, 0])].tolist()))
    weights = np.zeros((len(weekday), len(numbers)))
    for k, number in enumerate(numbers):
        is_it = (weekday == number) & np.isfinite(hours.mean[:, 0])
        weights[is_it, k] = 1.0 / is_it.sum()
    shares = sums(hours, weights)
    found = []
    for k, number in enumerate(numbers):
        dates = {day for day, weight in zip(hours.day, weights[:, k].tolist(), strict=True) if weight}
        found.append(Day(WEEKDAYS[number], len(dates), int((weights[:, k] > 0).sum()), shares[k]))
    return tuple(found)


def compared(hours: Hours) -> tuple[Compared, ...]:
    """Return each two days of the week by the hours of the day that both have, of the first group.

    Each hour of the day counts once, with the mean over the dates of that day.
    """
    known = np.isfinite(hours.mean[:, 0])
    weekday = np.where(known, np.array([day.weekday() for day in hours.day], np.int64), -1)
    hour = np.array(hours.hour, np.int64)
    of_hours = {day: frozenset(hour[weekday == day].tolist()) for day in sorted(set(weekday[known].tolist()))}
    pairs = [
        (first, second, shared)
        for first, second in combinations(of_hours, 2)
        if (shared := of_hours[first] & of_hours[second])
    ]
    weights = np.zeros((len(hour), len(pairs)))
    for k, (first, second, common) in enumerate(pairs):
        for day, sign in ((first, -1.0), (second, 1.0)):
            for each in sorted(common):
                is_it = (weekday == day) & (hour == each)
                weights[is_it, k] = sign / is_it.sum() / len(common)
    shares = sums(hours, weights, low=-1.0)
    return tuple(
        Compared(WEEKDAYS[first], WEEKDAYS[second], len(common), share)
        for (first, second, common), share in zip(pairs, shares, strict=True)
    )  # fmt: skip


def sums(
    hours: Hours, weights: Floats, low: float = 0.0, high: float | Floats = 1.0, group: int = 0
) -> list[Estimate]:  # fmt: skip
    """Return sums over the hours of a group by weights (K, C), with ends within ``low`` and ``high`` (C,)."""
    values = weights.T @ np.nan_to_num(hours.mean[:, group])
    deviations = np.sqrt(hours.spread(weights[:, :, None], slice(group, group + 1))[:, 0])
    surveys = (weights != 0).T.astype(np.float64) @ hours.surveys[:, group]
    return [
        around(float(value), float(deviation), int(count), low, most)
        for value, deviation, count, most in zip(
            values, deviations, surveys, np.broadcast_to(high, len(values)).tolist(), strict=True
        )
    ]
