"""Use of a lot's sections over a period: vehicles that were counted, of the places that a section has.

A figure of an hour is the mean of the looks in it, as at the moments of the surveys. Vehicles that one survey misses,
another one may miss as well, behind the same tree: ends of intervals are means of the ends, no narrower for more looks.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from datetime import date, datetime, timedelta, tzinfo
from typing import Final

import numpy as np
from sqlalchemy import Connection, select

from hawk.lots.plan.queries import sections_of
from hawk.lots.storage.schema import LOT, SECTION_LOOK, SURVEY
from hawk.lots.survey.order import has_been, is_sure
from hawk.lots.values import LotInputError, NotFoundError, moment
from hawk.stats.changes import Steady
from hawk.stats.figures import PRACTICAL, Peak, Use
from hawk.stats.hour_use import MOST_NAMED, AskedUse, Cell, SurveyShare, is_asked
from hawk.stats.panel import Period
from hawk.stats.turnover import NO_TURNOVER
from hawk.stats.use_query import Asked
from hawk.stats.values import (
    LEVEL,
    NO_TIME,
    NOT_YET,
    NOTHING,
    WEEKDAYS,
    Bools,
    Estimate,
    Floats,
    LeftOut,
    PanelRow,
    Unit,
)

UNSEEN_SECTION: Final = "it did not see all of the sections that are asked"
_NONE_STEADY: Final = Steady(None, None, None, 0, ())


@dataclass(frozen=True, slots=True)
class Places:
    """A section by its id and name; ``capacity``: its places, None where nobody says them."""

    id: str
    name: str
    capacity: int | None


@dataclass(frozen=True, slots=True)
class SectionPanel:
    """Looks of S surveys, by their time, at N sections of a lot's plan.

    ``counts`` (S, N, 3): vehicles parked, and the ends of their interval; NaN where a survey did not look.
    """

    lot: str
    name: str
    clock: tzinfo
    clock_name: str
    sections: tuple[Places, ...]
    surveys: tuple[PanelRow, ...] = field(repr=False)
    left_out: tuple[LeftOut, ...]
    counts: Floats = field(repr=False)

    @property
    def local_times(self) -> tuple[datetime, ...]:
        """Moments of the surveys on the lot's clock."""
        return tuple(datetime.fromtimestamp(each.at, self.clock) for each in self.surveys)

    def shares_by_hour(self) -> Iterator[tuple[str, dict[tuple[date, int], float]]]:
        """Yield each section that has places, by its id, with its share by day and hour: the mean where a clock shows
        an hour twice.
        """
        for section in self.sections:
            if section.capacity is None:
                continue
            hours = _hours(self, self.part([section.name]))
            found: dict[tuple[date, int], list[float]] = defaultdict(list)
            for day, hour, count in zip(hours.day, hours.hour, hours.counts[:, 0].tolist(), strict=True):
                found[day, hour].append(count / section.capacity)
            yield section.id, {key: round(sum(shares) / len(shares), 4) for key, shares in found.items()}

    def part(self, names: Sequence[str]) -> _Part:
        """Return some sections counted together; surveys that did not see all of them have no count.

        Raises LotInputError for a section that the plan has not.
        """
        known = {each.name: number for number, each in enumerate(self.sections)}
        for name in names:
            if name not in known:
                there = ", ".join([*known][:MOST_NAMED]) + ", …" * (len(known) > MOST_NAMED)
                raise LotInputError("section", f"the lot has none that is called {name!r}; there is {there or 'none'}")
        chosen = [known[name] for name in names]
        places = [self.sections[number].capacity for number in chosen]
        capacity = None if None in places else sum(each or 0 for each in places)
        return _Part(capacity, self.counts[:, chosen].sum(axis=1))


@dataclass(frozen=True, slots=True)
class _Part:
    """Sections that are counted together: their places, and counts (S, 3), NaN where a survey did not see all."""

    capacity: int | None
    counts: Floats = field(repr=False)

    @property
    def unit(self) -> Unit:
        return "vehicles" if self.capacity is None else "places"

    @property
    def is_seen(self) -> Bools:
        return np.isfinite(self.counts[:, 0])


@dataclass(frozen=True, slots=True)
class _Hours:
    """The K hours in which a part was seen: ``counts`` (K, 3), means of the looks; ``surveys``: how many looked."""

    day: tuple[date, ...]
    hour: tuple[int, ...]
    surveys: tuple[int, ...]
    counts: Floats = field(repr=False)

    def mean(self, chosen: Bools) -> Estimate:
        """Return the mean number of vehicles over some hours (K,), which count alike."""
        if not chosen.any():
            return NOTHING
        looked = sum(number for number, is_one in zip(self.surveys, chosen.tolist(), strict=True) if is_one)
        return _estimate(self.counts[chosen].mean(axis=0), looked)


def read_sections(connection: Connection, lot: str, period: Period) -> SectionPanel:
    """Return the looks at the sections of a lot's plan in a period, by the mean time of a survey's looks.

    A survey whose time is not sure is left out. Raises NotFoundError.
    """
    name = connection.execute(select(LOT.c.name).where(LOT.c.id == lot, LOT.c.merged_into.is_(None))).scalar()
    if name is None:
        raise NotFoundError("lot: there is no lot with this id; reload the list")
    sections = [each for each in sections_of(connection, lot) if each.outline]
    numbers = {each.id: number for number, each in enumerate(sections)}
    looks = (SECTION_LOOK.c[column] for column in ("section", "looked_at", "parked", "least", "most"))
    asked = select(SURVEY.c.id, SURVEY.c.ended, is_sure(), has_been(), *looks)
    asked = asked.join(SECTION_LOOK, SECTION_LOOK.c.survey == SURVEY.c.seq).where(SURVEY.c.lot == lot)
    of_survey = defaultdict(list)
    for survey, ended, time_is_sure, was, section, *look in connection.execute(asked):
        if section in numbers:
            of_survey[survey, ended, time_is_sure, was].append((numbers[section], *look))
    used, left_out = [], []
    for (survey, ended, time_is_sure, was), found in of_survey.items():
        at = float(np.mean([look[1] for look in found]))
        if not period.has(np.array([at]))[0]:
            continue
        if not time_is_sure:
            left_out.append(LeftOut(survey, moment(ended), NO_TIME if was else NOT_YET))
            continue
        counts = np.full((len(sections), 3), np.nan)
        for number, _, *count in found:
            counts[number] = count
        used.append((at, survey, counts))
    used.sort(key=lambda each: each[:2])
    places = tuple(Places(each.id, each.name, each.capacity) for each in sections)
    return SectionPanel(
        lot, str(name), period.clock, period.clock_name, places,
        tuple(PanelRow(survey, at) for at, survey, _ in used), tuple(left_out),
        np.array([counts for *_, counts in used], np.float64).reshape(len(used), len(sections), 3),
    )  # fmt: skip


def use_of_sections(panel: SectionPanel, asked: Asked) -> AskedUse:
    """Return the answer to a question about sections. Raises LotInputError for a section that the plan has not."""
    part = panel.part(asked.sections)
    hours = _hours(panel, part)
    is_it = is_asked(asked, [day.weekday() for day in hours.day], hours.hour)
    number = hours.mean(is_it)
    cells = _cells(hours, part, asked)
    seen = [cell for cell in cells if cell.is_asked and cell.days]
    surveys, unseen = _surveys(panel, part, asked)
    return AskedUse(
        lot=panel.lot, name=panel.name, clock=panel.clock_name, interval=LEVEL, asked=asked, unit=part.unit,
        stalls=0, places=part.capacity, days=len({hours.day[k] for k in np.flatnonzero(is_it).tolist()}),
        hours=int(is_it.sum()), occupancy=_share(number, part), accumulation=number,
        fullest=max(seen, key=_number, default=None), emptiest=min(seen, key=_number, default=None), cells=cells,
        others=(), surveys=surveys, left_out=(*panel.left_out, *unseen),
    )  # fmt: skip


def section_uses(panel: SectionPanel) -> tuple[Use, ...]:
    """Return the use of each section that a survey of the period saw."""
    parts = [(each.name, panel.part([each.name])) for each in panel.sections]
    return tuple(_use(name, part, _hours(panel, part)) for name, part in parts if part.is_seen.any())


def _use(name: str, part: _Part, hours: _Hours) -> Use:
    number = hours.mean(np.ones(len(hours.hour), np.bool_))
    top = int(np.argmax(hours.counts[:, 0]))
    peak = _estimate(hours.counts[top], hours.surveys[top])
    rivals = int((hours.counts[:, 2] >= hours.counts[top, 1]).sum()) - 1
    begin = f"{hours.day[top].isoformat()}T{hours.hour[top]:02d}:00"
    return Use(
        name, part.capacity, number.surveys, len(hours.hour), _share(number, part), number,
        number.times(len(hours.hour)), Peak(begin, _share(peak, part), peak, rivals),
        {f"{limit:.2f}": _above(hours, part, limit) for limit in PRACTICAL}, _NONE_STEADY, _NONE_STEADY, NO_TURNOVER,
        part.unit,
    )  # fmt: skip


def _above(hours: _Hours, part: _Part, limit: float) -> Estimate:
    if part.capacity is None:
        return NOTHING
    return _estimate((hours.counts >= limit * part.capacity).mean(axis=0), sum(hours.surveys))


def _hours(panel: SectionPanel, part: _Part) -> _Hours:
    """Return the hours in which a part was seen, by their time; one that a clock shows twice on a day is two."""
    found: dict[tuple[date, int, timedelta | None], list[int]] = {}
    for number, at in enumerate(panel.local_times):
        if part.is_seen[number]:
            found.setdefault((at.date(), at.hour, at.utcoffset()), []).append(number)
    counts = [part.counts[numbers].mean(axis=0) for numbers in found.values()]
    return _Hours(
        tuple(day for day, *_ in found), tuple(hour for _, hour, _ in found), tuple(map(len, found.values())),
        np.array(counts, np.float64).reshape(-1, 3),
    )  # fmt: skip


def _cells(hours: _Hours, part: _Part, asked: Asked) -> tuple[Cell, ...]:
    """Return every hour of the week, each with the mean of its hours."""
    number = np.array([day.weekday() * 24 + hour for day, hour in zip(hours.day, hours.hour, strict=True)], np.int64)
    found = []
    for cell in range(24 * len(WEEKDAYS)):
        chosen = number == cell
        weekday, hour, mean = WEEKDAYS[cell // 24], cell % 24, hours.mean(chosen)
        days = len({hours.day[k] for k in np.flatnonzero(chosen).tolist()})
        is_one = weekday in asked.weekdays and hour in asked.hours
        found.append(Cell(weekday, hour, is_one, days, _share(mean, part), mean))
    return tuple(found)


def _surveys(
    panel: SectionPanel, part: _Part, asked: Asked
) -> tuple[tuple[SurveyShare, ...], tuple[LeftOut, ...]]:  # fmt: skip
    """Return the surveys of the hours that are asked, and those that did not see all of the part."""
    at = panel.local_times
    chosen = np.flatnonzero(is_asked(asked, [each.weekday() for each in at], [each.hour for each in at])).tolist()
    found, unseen = [], []
    for k in chosen:
        survey = panel.surveys[k]
        if not part.is_seen[k]:
            unseen.append(LeftOut(survey.id, moment(survey.at), UNSEEN_SECTION))
            continue
        number = _estimate(part.counts[k], 1)
        found.append(SurveyShare(survey.id, at[k].isoformat(timespec="minutes"), _share(number, part), number))
    return tuple(found), tuple(unseen)


def _estimate(values: Floats, surveys: int) -> Estimate:
    value, low, high = values.tolist()
    return Estimate(value, low, high, surveys)


def _share(number: Estimate, part: _Part) -> Estimate:
    return NOTHING if part.capacity is None else number.times(1 / part.capacity)


def _number(cell: Cell) -> float:
    return cell.accumulation.value or 0.0
