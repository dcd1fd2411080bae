"""A report read from the store: every figure is that of `hawk.stats`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from datetime import date, datetime
from typing import Final, cast

import numpy as np
from sqlalchemy import Connection, func, select

from hawk.lots import lists
from hawk.lots.answers import Layout
from hawk.lots.plan.queries import in_plan
from hawk.lots.sections.lists import sections_seen
from hawk.lots.storage.schema import LAYOUT, STALL, SURVEY
from hawk.lots.survey.pictures import PictureFolder
from hawk.lots.values import LotInputError
from hawk.report.options import Wanted
from hawk.report.picture import newest_of
from hawk.report.values import (
    NOT_THERE,
    LayoutChange,
    Missing,
    Newest,
    Part,
    Report,
    SectionReport,
    StallRecord,
    Why,
)
from hawk.stats import queries as uses
from hawk.stats.answers import SurveyUse
from hawk.stats.changes import steady
from hawk.stats.hour_use import UNSEEN_PART, asked_use
from hawk.stats.panel import CODES, Period, read_panel
from hawk.stats.period import period_of_lot
from hawk.stats.section_use import read_sections, use_of_sections
from hawk.stats.use_query import Asked
from hawk.stats.values import WEEKDAYS, Estimate, LeftOut, Panel, groups_of, whole

_MOST: Final = 1000
"""Items of a part of a list."""
MOST_STATES: Final = 1000
"""Surveys whose states of stalls are in a report, the newest ones."""
_SECOND: Final = 1.0


def read_report(connection: Connection, pictures: PictureFolder, wanted: Wanted, now: float) -> Report:
    """Return a report; ``now``: Unix seconds. Raises NotFoundError, LotInputError, LotStoreError."""
    period = period_of_lot(connection, wanted.lot, wanted.begin, wanted.end, wanted.time_zone)
    panel = read_panel(connection, wanted.lot, period)
    question = uses.of_parts(connection, wanted.lot, panel, wanted.asked)
    wanted = replace(wanted, asked=replace(question, sections=()))  # stalls and sections are counted apart
    asked = asked_use(panel, wanted.asked)
    listed = uses.uses_of(connection, wanted.lot, period, panel)[::-1]
    used = tuple(each for each in listed if not each.left_out)
    deleted = tuple(_deleted(connection, wanted.lot, panel, period))
    sections = _sections(connection, wanted.lot, period, question)
    use = None if panel.stalls or sections is None else sections.use
    unseen = asked.left_out if use is None else use.left_out
    missing = (*_missing(panel, unseen), *(each for each in deleted if _is_asked(wanted.asked, each.at)))
    layouts, lost = _layouts(connection, wanted.lot, panel, period)
    others = (*(each.at for each in deleted), *(each.ended.astimezone(panel.clock) for each in panel.left_out))
    flown = frozenset(each.date() for each in (*panel.local_times, *others))
    first, last = _days(panel, period, flown, now)
    newest = _newest(connection, pictures, panel, used, has_ground=wanted.has_ground)
    total, rows = Part(panel.name, asked.stalls, asked.occupancy), _rows(panel, wanted.asked)
    if not (wanted.asked.zones or wanted.asked.kinds):
        of_lot, *of_rows = _always(panel)
        rows = tuple(replace(row, always=each) for row, each in zip(rows, of_rows, strict=True))
        total = total if wanted.asked.rows else replace(total, always=of_lot)
    return Report(
        lot=wanted.lot, name=panel.name, clock=panel.clock_name, made=panel.local(now), first=first, last=last,
        unreadable=lost + len(panel.surveys) + len(panel.left_out) - len(listed), asked=asked, newest=newest,
        whole=total, rows=rows, zones=_parts(panel, wanted.asked, "zone"),
        kinds=_parts(panel, wanted.asked, "kind"), surveys=used, flown=flown,
        missing=tuple(sorted(missing, key=lambda each: each.at)), layouts=layouts,
        sections=sections,
        stalls=_stalls(connection, wanted.lot, panel, period), states_at=panel.local_times[-MOST_STATES:],
    )  # fmt: skip


def _sections(connection: Connection, lot: str, period: Period, asked: Asked) -> SectionReport | None:
    """Return the sections with the counts of the newest survey that saw one. Raises LotInputError."""
    panel = read_sections(connection, lot, period)
    use = use_of_sections(panel, asked) if asked.sections else None
    if not panel.surveys:
        return None
    seen = sections_seen(connection, lot, panel.surveys[-1].id).sections
    shown = tuple(each for each in seen if not asked.sections or each.name in asked.sections)
    return SectionReport(panel.local_times[-1], shown, use)


def _days(
    panel: Panel, period: Period, flown: Iterable[date], now: float
) -> tuple[date | None, date | None]:  # fmt: skip
    """Return the first and last day of a period: of its ends where it has them, up to now, else of its surveys."""
    days = sorted(flown)
    first = panel.local(period.begin).date() if period.begin is not None else days[0] if days else None
    last = days[-1] if days else None
    if period.end is not None:
        last = panel.local(min(period.end - _SECOND, max(now, period.begin or now))).date()
    today = panel.local(now).date()
    if first is None or last is None:
        return (None, None) if first == last else (first or last, last or max(first or today, today))
    return first, last


def _rows(panel: Panel, asked: Asked) -> tuple[Part, ...]:
    """Return every row with stalls of what is asked. One question gives them all: a row, and its others."""
    found: dict[str, Part] = {}
    groups = groups_of(panel, "row")
    for group in groups:
        try:
            use = asked_use(panel, replace(asked, rows=(group.name,)))
        except LotInputError:  # no stall of it has the zone and the kind
            continue
        found = {each.row: Part(each.row, each.stalls, each.occupancy) for each in use.others}
        found[group.name] = Part(group.name, use.stalls, use.occupancy)
        break
    return tuple(
        replace(found[group.name], is_asked=group.name in asked.rows) for group in groups if group.name in found
    )


def _always(panel: Panel) -> tuple[Estimate, ...]:
    """Return the numbers of stalls that every survey found taken: of the lot, then of each row."""
    return tuple(always for _, always in steady(panel, [*whole(panel), *groups_of(panel, "row")]))


def _parts(panel: Panel, asked: Asked, by: str) -> tuple[Part, ...]:
    """Return each zone, or each kind, of what is asked; nothing where it has one alone."""
    groups = groups_of(panel, "zone" if by == "zone" else "kind")
    named = asked.zones if by == "zone" else asked.kinds
    found = []
    for group in groups if len(groups) > 1 else ():
        if named and group.name not in named:
            continue
        one = replace(asked, zones=(group.name,)) if by == "zone" else replace(asked, kinds=(group.name,))
        try:
            use = asked_use(panel, one)
        except LotInputError:
            continue
        found.append(Part(group.name, use.stalls, use.occupancy, is_asked=group.name in named))
    return tuple(found) if len(found) > 1 else ()


def _missing(panel: Panel, left_out: Sequence[LeftOut]) -> Iterable[Missing]:
    for each in left_out:
        code: Why = "unseen" if each.why == UNSEEN_PART else _WHYS[each.why]
        yield Missing(each.ended.astimezone(panel.clock), code)


_WHYS: Final[Mapping[str, Why]] = {why: cast("Why", code) for why, code in CODES.items()}


def _deleted(connection: Connection, lot: str, panel: Panel, period: Period) -> Iterable[Missing]:
    """Yield the surveys of the period that a person deleted."""
    changes = lists.changes(connection, lists.Asked(_MOST), lot).items
    ids = [survey for each in changes if each.kind == "delete" and each.undone is None for survey in each.surveys]
    asked = select(SURVEY.c.ended).where(SURVEY.c.id.in_(ids), SURVEY.c.placed == "deleted")
    for ended in connection.execute(asked.where(*period.holds(SURVEY.c.ended))).scalars():
        yield Missing(panel.local(ended), "deleted")


def _is_asked(asked: Asked, at: datetime) -> bool:
    return WEEKDAYS[at.weekday()] in asked.weekdays and at.hour in asked.hours


def _layouts(
    connection: Connection, lot: str, panel: Panel, period: Period
) -> tuple[tuple[LayoutChange, ...], int]:  # fmt: skip
    """Return the versions of the layout that began in the period, and how many others cannot be read."""
    found: list[Layout] = lists.layouts(connection, lot, lists.Asked(_MOST)).items
    count = connection.execute(select(func.count()).select_from(LAYOUT).where(LAYOUT.c.lot == lot)).scalar_one()
    shown = []
    for each in found:
        if period.has(np.array([each.valid_from.timestamp()])).all():
            of_it = select(func.count()).select_from(STALL).where(in_plan(STALL.c, lot, each.version))
            stalls = connection.execute(of_it).scalar_one()
            shown.append(LayoutChange(each.valid_from.astimezone(panel.clock), each.why, stalls))
    return tuple(shown), max(min(count, _MOST) - len(found), 0)


def _newest(
    connection: Connection, pictures: PictureFolder, panel: Panel, used: Sequence[SurveyUse], *, has_ground: bool
) -> Newest | None:  # fmt: skip
    by_id = {each.id: each for each in used}
    for survey, at in zip(panel.surveys[::-1], panel.local_times[::-1], strict=True):
        if survey.id in by_id:
            return newest_of(connection, pictures, by_id[survey.id], at, has_ground=has_ground)
    return None


def _stalls(connection: Connection, lot: str, panel: Panel, period: Period) -> tuple[StallRecord, ...]:
    use = uses.stalls_use(connection, lot, period)
    part = slice(max(len(panel.surveys) - MOST_STATES, 0), None)
    states = np.where(panel.is_there[part], panel.state[part].astype(np.int64), NOT_THERE).T.tolist()
    return tuple(
        StallRecord(
            stall.id, stall.label, stall.row, stall.kind, stall.zones, use.surveys[k], use.share[k], use.low[k],
            use.high[k], tuple(states[k]),
        )
        for k, stall in enumerate(panel.stalls)
    )  # fmt: skip
