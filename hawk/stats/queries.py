"""Statistics of a lot in a store: one call each for the command line, the API and other tools."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from sqlalchemy import ColumnElement, Connection, func, select, tuple_

from hawk.lots.plan.queries import sections_of
from hawk.lots.sections.lists import sections_seen
from hawk.lots.storage.rows import is_among, readable
from hawk.lots.storage.schema import LOOKS, SURVEY
from hawk.lots.survey.counts import COUNTS, counts_of, found_by, is_by_layout
from hawk.lots.survey.order import newest_first
from hawk.lots.survey.source import SOURCE_COLUMNS, source_json
from hawk.lots.values import LotInputError, moment
from hawk.stats.answers import NextSurvey, StallsUse, SurveysUse, SurveyUse
from hawk.stats.changes import Changed, SectionChange, SectionCounts, changes_between
from hawk.stats.counts import Counted, count
from hawk.stats.figures import Figures, figures
from hawk.stats.hour_use import AskedUse, asked_use
from hawk.stats.panel import CODES, Period, read_panel
from hawk.stats.partition import Partition
from hawk.stats.period import period_of_lot
from hawk.stats.section_use import read_sections, section_uses, use_of_sections
from hawk.stats.use_query import Asked
from hawk.stats.values import DEVIATIONS, LEVEL, NOTHING, TAKEN, UNSEEN, Floats, Panel, whole

_SHOWN: Final = ("id", "layout", "placed", *COUNTS, "blurred", "simulated", "program", "accuracy")
_READ: Final = (*_SHOWN, *SOURCE_COLUMNS, "seq", "lot", "began", "ended")


def statistics(connection: Connection, lot: str, period: Period, by: Partition | None = None) -> Figures:
    """Return the figures of a lot in a period, by a partition of it.

    Raises NotFoundError, LotStoreError.
    """
    found = figures(read_panel(connection, lot, period), by)
    if by != "section":
        return found
    return found.model_copy(update={"parts": section_uses(read_sections(connection, lot, period))})


def ask(connection: Connection, lot: str, period: Period, asked: Asked) -> AskedUse:
    """Return the answer to a question about a lot in a period.

    Raises LotInputError for a part that the lot has not; NotFoundError, LotStoreError.
    """
    panel = read_panel(connection, lot, period)
    asked = of_parts(connection, lot, panel, asked)
    if asked.sections:
        return use_of_sections(read_sections(connection, lot, period), asked)
    return asked_use(panel, asked)


def of_parts(connection: Connection, lot: str, panel: Panel, asked: Asked) -> Asked:
    """Return a question with the parts that it means: the whole of a lot without stalls is all of its sections."""
    if panel.stalls or asked.rows or asked.zones or asked.kinds or asked.sections:
        return asked
    return replace(asked, sections=tuple(each.name for each in sections_of(connection, lot) if each.outline))


def changes(connection: Connection, lot: str, before: str, after: str) -> Changed:
    """Return what changed from one survey of a lot to another one, by their ids.

    Raises LotInputError for a survey that the lot has not, or whose place or time is not sure; NotFoundError.
    """
    panel = read_panel(connection, lot, period_of_lot(connection, lot), (before, after))
    numbers = {survey.id: number for number, survey in enumerate(panel.surveys)}
    reasons = {each.survey: each.why for each in panel.left_out}
    for field, survey in (("before", before), ("after", after)):
        if survey not in numbers:
            words = reasons.get(survey, "is no survey of this lot: name another one")
            raise LotInputError(field, words)
    found = changes_between(panel, numbers[before], numbers[after])
    return found.model_copy(update={"sections": tuple(_section_changes(connection, lot, before, after))})


def _section_changes(connection: Connection, lot: str, before: str, after: str) -> Iterator[SectionChange]:
    """Yield the sections that one of two surveys of a lot looked at."""
    first, then = (sections_seen(connection, lot, each).sections for each in (before, after))
    for one, other in zip(first, then, strict=True):
        was, now = one.look, other.look
        if was is None and now is None:
            continue
        earlier, later = (
            None if look is None else SectionCounts(look.parked, look.least, look.most) for look in (was, now)
        )
        is_changed = None if was is None or now is None else was.most < now.least or now.most < was.least
        yield SectionChange(one.id, one.name, one.capacity, earlier, later, is_changed)


def surveys_use(
    connection: Connection, lot: str, period: Period, survey: str | None = None, newest: int | None = None
) -> SurveysUse:  # fmt: skip
    """Return the surveys of a lot that the figures of a period use or leave out, the newest first.

    Args:
        connection: A reading connection.
        lot: Its id.
        period: The period.
        survey: This survey alone.
        newest: The most surveys, the newest of the period.

    Returns:
        Of each survey ``occupancy``, the share of taken stalls with its interval, by the looks, and ``left_out``, why
        no figure uses it, "" for the others.

    Raises:
        NotFoundError: There is no such lot.
        LotStoreError: The store cannot be read.
    """
    chosen = _chosen(connection, lot, period, survey, newest)
    panel = read_panel(connection, lot, period, chosen)
    rows = _rows(connection, panel, period, SURVEY.c.lot == lot if chosen is None else SURVEY.c.id.in_(chosen))
    is_first, is_last = (chosen is None and end is None for end in (period.begin, period.end))
    return SurveysUse(
        lot=lot, name=panel.name, clock=panel.clock_name, interval=LEVEL, surveys=_uses(connection, panel, rows),
        before=None if is_first else _beside(connection, lot, period, rows, is_earlier=True),
        after=None if is_last else _beside(connection, lot, period, rows, is_earlier=False),
    )  # fmt: skip


def uses_of(connection: Connection, lot: str, period: Period, panel: Panel) -> list[SurveyUse]:
    """Return all surveys of a panel as `surveys_use` does, without those beside the period."""
    return _uses(connection, panel, _rows(connection, panel, period, SURVEY.c.lot == lot))


def _rows(
    connection: Connection, panel: Panel, period: Period, is_asked: ColumnElement[bool]
) -> list[dict[str, Any]]:  # fmt: skip
    """Return the rows of a panel's surveys, those that are left out too, the newest first."""
    known = {each.id for each in panel.surveys} | {each.survey for each in panel.left_out}
    asked = select(*(SURVEY.c[name] for name in _READ)).where(is_asked, *period.may_have()).order_by(*newest_first())
    rows = (dict(zip(_READ, row, strict=True)) for row in connection.execute(asked))
    return [row for row in rows if row["id"] in known]


def _uses(connection: Connection, panel: Panel, rows: Sequence[dict[str, Any]]) -> list[SurveyUse]:
    counted = count(panel, whole(panel))
    shares = dict(zip((survey.id for survey in panel.surveys), counted.shares(), strict=True))
    reasons = {each.survey: each.why for each in panel.left_out}
    at = {each.id: moment(each.at) for each in panel.surveys} | {each.survey: each.ended for each in panel.left_out}
    counts = _counts(connection, panel, counted, rows)

    def use(row: dict[str, Any]) -> SurveyUse:
        return SurveyUse(
            **{name: row[name] for name in _SHOWN} | counts[row["id"]] | source_json(row),
            found=found_by(row), at=at[row["id"]], began=moment(row["began"]), ended=moment(row["ended"]),
            occupancy=shares.get(row["id"], NOTHING),
            left_out=reasons.get(row["id"], ""), left_out_code=CODES.get(reasons.get(row["id"], ""), ""),
        )  # fmt: skip

    return readable(use, rows)


def _counts(
    connection: Connection, panel: Panel, counted: Counted, rows: Sequence[dict[str, Any]]
) -> dict[str, dict[str, Any]]:  # fmt: skip
    """Return what `counts_of` does of surveys, by id. A panel's own are not read again: its looks say it."""
    seen, taken, stalls = (each[:, 0].astype(int) for each in (counted.seen, counted.taken, counted.capacity))
    numbers = np.column_stack((seen - taken, taken, stalls - seen)).tolist()
    found = {each.id: dict(zip(COUNTS, line, strict=True)) for each, line in zip(panel.surveys, numbers, strict=True)}
    others = [row for row in rows if row["id"] not in found or not is_by_layout(row)]
    return found | {row["id"]: each for row, each in zip(others, counts_of(connection, others), strict=True)}


_MOMENT: Final = func.coalesce(
    select(LOOKS.c.at).where(LOOKS.c.survey == SURVEY.c.seq).scalar_subquery(), SURVEY.c.ended
)
"""When a survey counts: the mean time of its looks, the end of one without."""


def _chosen(
    connection: Connection, lot: str, period: Period, survey: str | None, newest: int | None
) -> tuple[str, ...] | None:  # fmt: skip
    """Return the ids of the surveys that are asked for; None: all of the period."""
    if survey is not None:
        return (survey,)
    if newest is None:
        return None
    asked = select(SURVEY.c.id).where(SURVEY.c.lot == lot, *period.holds(_MOMENT)).order_by(*newest_first())
    return tuple(str(each) for each in connection.execute(asked.limit(newest)).scalars())


def _beside(
    connection: Connection, lot: str, period: Period, rows: Sequence[dict[str, Any]], *, is_earlier: bool
) -> NextSurvey | None:  # fmt: skip
    """Return the survey next to those in ``rows``, or to the period where there are none; of one moment by number."""
    place = (_MOMENT, SURVEY.c.seq)
    order = [each.desc() if is_earlier else each for each in place]
    is_beside: ColumnElement[bool]
    if rows:
        shown = select(*place).where(is_among(SURVEY.c.seq, [row["seq"] for row in rows]))
        ends = [each if is_earlier else each.desc() for each in place]
        end = tuple_(*connection.execute(shown.order_by(*ends).limit(1)).one())
        here = tuple_(*place)
        is_beside = here < end if is_earlier else here > end
    elif (at := period.begin if is_earlier else period.end) is None:
        return None
    else:
        is_beside = at > _MOMENT if is_earlier else at <= _MOMENT
    asked = select(SURVEY.c.id, _MOMENT.label("at")).where(SURVEY.c.lot == lot, is_beside).order_by(*order).limit(1)
    row = connection.execute(asked).first()
    return None if row is None else NextSurvey(id=row.id, at=moment(row.at))


def stalls_use(connection: Connection, lot: str, period: Period) -> StallsUse:
    """Return of each stall the share of a period's surveys in which it was taken, in columns.

    ``surveys``: those that saw its state; ``share``, ``low``, ``high``: None without any. The shares are those of the
    surveys' moments. Raises NotFoundError, LotStoreError.
    """
    panel = read_panel(connection, lot, period)
    is_seen = panel.is_there & (panel.state != UNSEEN)
    looks = is_seen.sum(axis=0).astype(np.float64)
    taken = (is_seen & (panel.state == TAKEN)).sum(axis=0).astype(np.float64)
    wrong = np.where(is_seen, panel.taken_probability * (1 - panel.taken_probability), np.float32(0)).sum(
        axis=0, dtype=np.float64
    )
    low, high = share_bounds(taken, looks, wrong)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = taken / looks
    return StallsUse(
        lot=lot, interval=LEVEL, surveys_in_period=len(panel.surveys),
        ids=[stall.id for stall in panel.stalls], labels=[stall.label for stall in panel.stalls],
        surveys=looks.astype(int).tolist(), share=_listed(share), low=_listed(low), high=_listed(high),
    )  # fmt: skip


def share_bounds(taken: Floats, looks: Floats, wrong: Floats) -> tuple[Floats, Floats]:
    """Return the ends of the interval of shares ``taken / looks``; NaN without looks.

    Wilson's interval (1927) of a share among independent moments, widened by the variance ``wrong`` of the number of
    taken ones by wrong states.
    """
    z = DEVIATIONS
    with np.errstate(divide="ignore", invalid="ignore"):
        share = taken / looks
        middle = (share + z**2 / (2 * looks)) / (1 + z**2 / looks)
        half = z * np.sqrt(share * (1 - share) / looks + z**2 / (4 * looks**2)) / (1 + z**2 / looks)
        off = np.hypot(half, z * np.sqrt(wrong) / looks)
    return np.clip(np.minimum(middle - off, share), 0.0, 1.0), np.clip(np.maximum(middle + off, share), 0.0, 1.0)


def _listed(values: Floats) -> list[float | None]:
    return [round(value, 4) if value == value else None for value in values.tolist()]
