"""Answer to a question about a lot's use: parts of it at some hours of the week.

The hours are those of `hawk.stats.figures`, of all surveys of the period: a cell says the same whatever else is asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from pydantic import Field

from hawk.lots.answers import Count, Share, Shown
from hawk.lots.plan.values import Id
from hawk.lots.values import LotInputError, moment
from hawk.stats.counts import count
from hawk.stats.figures import flown, sums
from hawk.stats.hours import Hours
from hawk.stats.partition import Partition
from hawk.stats.use_query import Asked, DayHour
from hawk.stats.values import (
    LEVEL,
    NO_TIME,
    NOT_YET,
    NOTHING,
    WEEKDAYS,
    Bools,
    Estimate,
    Group,
    LeftOut,
    Local,
    Panel,
    Unit,
    Weekday,
    groups_of,
    whole,
)

UNSEEN_PART: Final = "it saw no stall of what is asked"
_PART: Final = 1
"""Number of the group that is asked: behind the whole lot, by which the movement of all groups is known."""
MOST_NAMED: Final = 30
"""Names of a refusal."""


@dataclass(frozen=True, slots=True)
class Cell:
    """Mean over the dates with a survey in an hour of a weekday; null where nobody flew. `is_asked`: of the question.

    `days`: dates; where a clock shows an hour twice on one, both count in the mean. `accumulation`: the mean number of
    what is taken, which a section without places has alone.
    """

    weekday: Weekday
    hour: DayHour
    is_asked: bool
    days: Count
    occupancy: Estimate
    accumulation: Estimate


@dataclass(frozen=True, slots=True)
class RowUse:
    """Another row, with its stalls of the zones and kinds that are asked, at the same hours."""

    row: str
    stalls: Count
    occupancy: Estimate


@dataclass(frozen=True, slots=True)
class SurveyShare:
    """A survey behind an answer, with the share that was taken at its moment of what is asked."""

    survey: Id
    at: Local
    occupancy: Estimate
    accumulation: Estimate


class AskedUse(Shown):
    """Use of what is `asked`, over the surveyed hours that are asked, which count alike.

    `unit`: what is counted. Of sections `occupancy` is vehicles of their `places`, above 1 where more are parked, and
    null where nobody said how many places there are: `accumulation` is the mean number of vehicles.

    `stalls`: of the newest survey's layout; `days`: dates, `hours`: surveyed hours that are behind `occupancy`, the
    mean share that was taken, and `accumulation`, the mean number of taken stalls. `cells`: every hour of the week, by
    weekday and hour; `fullest` and `emptiest` of those that are asked. `others`: the rows that are not, where rows are.
    `left_out`: surveys of the hours that are asked which are in no figure, and those whose hour is not sure.
    """

    lot: Id
    name: str
    clock: str
    interval: Share
    asked: Asked
    unit: Unit
    stalls: Count
    places: Count | None
    days: Count
    hours: Count
    occupancy: Estimate
    accumulation: Estimate
    fullest: Cell | None
    emptiest: Cell | None
    cells: tuple[Cell, ...] = Field(repr=False)
    others: tuple[RowUse, ...]
    surveys: tuple[SurveyShare, ...] = Field(repr=False)
    left_out: tuple[LeftOut, ...]


def asked_use(panel: Panel, asked: Asked) -> AskedUse:
    """Return the answer to a question. Raises LotInputError for a part that the lot has not."""
    part, others = _groups(panel, asked)
    groups = [*whole(panel), part, *others]
    hours, _ = flown(panel, groups)
    is_hour = is_asked(asked, [day.weekday() for day in hours.day], hours.hour)
    occupancy, number = hours.over(is_hour), hours.known(is_hour)
    cells = _cells(hours, asked)
    flown_cells = [cell for cell in cells if cell.is_asked and cell.days]
    newest = panel.is_there[-1] if len(panel.surveys) else np.ones(len(panel.stalls), np.bool_)
    surveys, unseen = _surveys(panel, part, asked)
    return AskedUse(
        lot=panel.lot, name=panel.name, clock=panel.clock_name, interval=LEVEL, asked=asked,
        unit="stalls", stalls=int((newest & part.members).sum()), places=None,
        days=len({hours.day[k] for k in np.flatnonzero(number[:, _PART]).tolist()}), hours=int(number[:, _PART].sum()),
        occupancy=occupancy[_PART],
        accumulation=hours.load(is_hour)[_PART].times(1 / max(int(number[:, _PART].sum()), 1)),
        fullest=max(flown_cells, key=_share, default=None), emptiest=min(flown_cells, key=_share, default=None),
        cells=cells,
        others=tuple(
            RowUse(group.name, int((newest & group.members).sum()), occupancy[k])
            for k, group in enumerate(others, _PART + 1)
        ),
        surveys=surveys, left_out=(*_left_out(panel, asked), *unseen),
    )  # fmt: skip


def _groups(panel: Panel, asked: Asked) -> tuple[Group, list[Group]]:
    """Return the stalls that are asked, and those of each other row with the same zones and kinds."""
    within = _any_of(panel, "zone", asked.zones) & _any_of(panel, "kind", asked.kinds)
    rows = [Group(each.name, each.members & within) for each in groups_of(panel, "row")] if asked.rows else []
    part = Group("", _any_of(panel, "row", asked.rows) & within)
    if len(panel.stalls) and not part.members.any():
        last = next(field for field in ("kind", "zone", "row") if getattr(asked, f"{field}s"))
        raise LotInputError(last, "leaves no stall of the others that are asked: leave one of them out")
    return part, [each for each in rows if each.name not in asked.rows and each.members.any()]


def _any_of(panel: Panel, by: Partition, names: Sequence[str]) -> Bools:
    """Return the stalls of any of some rows, zones or kinds; all where none is named."""
    members = np.full(len(panel.stalls), not names, np.bool_)
    known = {group.name: group.members for group in groups_of(panel, by)} if names else {}
    for name in names:
        if name not in known:
            there = ", ".join([*known][:MOST_NAMED]) + ", …" * (len(known) > MOST_NAMED)
            raise LotInputError(by, f"the lot has none that is called {name!r}; there is {there or 'no stall'}")
        members |= known[name]
    return members


def is_asked(asked: Asked, weekdays: Sequence[int], hours: Sequence[int]) -> Bools:
    """Return which of some weekdays, 0 for Monday, with their hours are asked."""
    days = {WEEKDAYS.index(day) for day in asked.weekdays}
    return np.array([day in days and hour in asked.hours for day, hour in zip(weekdays, hours, strict=True)], np.bool_)


def _cells(hours: Hours, asked: Asked) -> tuple[Cell, ...]:
    """Return every hour of the week, each with the mean of its flown hours."""
    known = hours.known()[:, _PART]
    number = np.array([day.weekday() * 24 + hour for day, hour in zip(hours.day, hours.hour, strict=True)], np.int64)
    flown_numbers = sorted(set(number[known].tolist()))
    is_it = (number[:, None] == np.array(flown_numbers, np.int64)) & known[:, None]
    weights = is_it / np.maximum(is_it.sum(axis=0), 1)
    stalls = weights * hours.capacity[:, _PART : _PART + 1]
    shares, amounts = sums(hours, weights, group=_PART), sums(hours, stalls, high=stalls.sum(axis=0), group=_PART)
    means = dict(zip(flown_numbers, zip(shares, amounts, strict=True), strict=True))
    dates: dict[int, set[object]] = {}
    for k in np.flatnonzero(known).tolist():
        dates.setdefault(int(number[k]), set()).add(hours.day[k])
    return tuple(
        Cell(
            day, hour, day in asked.weekdays and hour in asked.hours, len(dates.get(24 * n + hour, ())),
            *means.get(24 * n + hour, (NOTHING, NOTHING)),
        )
        for n, day in enumerate(WEEKDAYS)
        for hour in range(24)
    )  # fmt: skip


def _share(cell: Cell) -> float:
    return cell.occupancy.value or 0.0


def _surveys(panel: Panel, part: Group, asked: Asked) -> tuple[tuple[SurveyShare, ...], tuple[LeftOut, ...]]:
    """Return the surveys of the hours that are asked with the share of a part, and those that saw nothing of it."""
    at = panel.local_times
    is_one = is_asked(asked, [each.weekday() for each in at], [each.hour for each in at])
    counted = count(panel, (part,))
    shares, stalls = counted.shares(), counted.capacity[:, 0].tolist()
    chosen = np.flatnonzero(is_one).tolist()
    found = tuple(
        SurveyShare(panel.surveys[k].id, at[k].isoformat(timespec="minutes"), shares[k], shares[k].times(stalls[k]))
        for k in chosen
        if shares[k].surveys
    )
    unseen = tuple(
        LeftOut(panel.surveys[k].id, moment(panel.surveys[k].at), UNSEEN_PART) for k in chosen if not shares[k].surveys
    )
    return found, unseen


def _left_out(panel: Panel, asked: Asked) -> tuple[LeftOut, ...]:
    """Return the surveys without figures whose hour is asked, or not sure."""
    at = [each.ended.astimezone(panel.clock) for each in panel.left_out]
    is_one = is_asked(asked, [each.weekday() for each in at], [each.hour for each in at])
    return tuple(
        each
        for each, is_of in zip(panel.left_out, is_one.tolist(), strict=True)
        if is_of or each.why in (NO_TIME, NOT_YET)
    )
