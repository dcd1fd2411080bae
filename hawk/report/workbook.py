"""A report as a workbook (Office Open XML): the figures of the document as numbers, and every stall.

`sheets` makes the sheets, which are text then; `hawk.report.workbook_file` writes them, which takes long for a large
lot and can be done by a process of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from datetime import date, datetime
from typing import Final

from pydantic_core import to_json

from hawk.lots.answers import ListedSection
from hawk.report.document import labels_of, lots_notes, method_of, source_of, why_of
from hawk.report.lots_report import LotsReport
from hawk.report.options import Language
from hawk.report.queries import MOST_STATES
from hawk.report.values import NOT_THERE, Report
from hawk.report.words import Words
from hawk.report.workbook_file import Kind
from hawk.stats.hour_use import SurveyShare
from hawk.stats.values import FREE, TAKEN, UNSEEN, Estimate

_SECONDS_A_DAY: Final = 86_400
_EPOCH: Final = datetime(1899, 12, 30)  # noqa: DTZ001 - a workbook's times are those of a wall
_STATES: Final = {FREE: "free", TAKEN: "taken", UNSEEN: "unseen", NOT_THERE: "none"}
_WIDE, _NARROW, _ID = 34, 13, 38
_LONGEST_NAME: Final = 31
Cell = tuple[Kind, str | float] | str | float | None
"""A cell: a kind with its value, a text, or a number of its column's kind; None: empty."""


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a sheet: its head, the kind of its numbers, and its width in letters."""

    head: str
    kind: Kind = "text"
    width: float = _NARROW


@dataclass(frozen=True, slots=True)
class Sheet:
    """A sheet of a workbook."""

    name: str
    columns: tuple[Column, ...]
    rows: list[list[Cell]] = field(repr=False)


def sheets(report: Report, language: Language) -> bytes:
    """Return the sheets of a report as JSON, for `hawk.report.workbook_file.written`."""
    return _book(report.name, lot_sheets(report, language), Words(language))


def lots_sheets(report: LotsReport, parts: Sequence[Sequence[bytes]], language: Language) -> bytes:
    """Return the sheets of a report over several lots as JSON: that of all lots, then those of `lot_sheets` of each."""
    words = Words(language)
    first = to_json(_lots(report, words))
    return _book(words("lots", count=len(report.lines)), [first, *(sheet for part in parts for sheet in part)], words)


def lot_sheets(report: Report, language: Language, number: int | None = None) -> list[bytes]:
    """Return the sheets of a lot as JSON; their names begin with its ``number`` among several lots."""
    words = Words(language)
    made = (_summary(report, words), _rows(report, words), _hours(report, words), _surveys(report, words),
            *_sections(report, words), _stalls(report, words), _method(report, words))  # fmt: skip
    return [
        to_json(each if number is None else replace(each, name=f"{number} {each.name}"[:_LONGEST_NAME]))
        for each in made
    ]


def _book(name: str, made: Sequence[bytes], words: Words) -> bytes:
    head = to_json({"title": f"{name}, {words('kind-of-document')}", "author": words("author", program="hawk-drone")})
    return head[:-1] + b',"sheets":[' + b",".join(made) + b"]}"


# -- sheets ------------------------------------------------------------------------------------------------------------


def _lots(report: LotsReport, words: Words) -> Sheet:
    """Return the first page as a sheet: a line a lot, the totals, and what a reader must know of them."""
    heads = ("free-estimated", "low", "high", "vehicles", "low", "high")
    columns = (
        Column(words("number"), "count"), Column(words("lot"), width=_WIDE), Column(words("stalls"), "count"),
        *(Column(words(name), "number") for name in heads), Column(words("section-places"), "count"),
        Column(words("newest-survey"), "moment", 18), Column(words("age-days"), "number"),
        Column(words("drone"), width=20), Column(words("due"), "moment", 18), Column(words("id"), width=_ID),
    )  # fmt: skip
    rows: list[list[Cell]] = [
        [
            number, each.name, each.stalls, *_ranged(each.free), *_ranged(each.vehicles), each.places,
            words("no-survey") if each.at is None else _of_moment(each.at),
            None if each.at is None else (report.made - each.at).total_seconds() / _SECONDS_A_DAY,
            each.drone, None if each.due is None else _of_moment(each.due), each.lot,
        ]
        for number, each in enumerate(report.lines, 1)
    ]  # fmt: skip
    totals: list[list[Cell]] = [
        [None, words(f"total-{name}"), report.stalls, *_ranged(free), *_ranged(vehicles), report.places]
        for name, free, vehicles in (
            ("alike", report.free.alike, report.vehicles.alike), ("apart", report.free.apart, report.vehicles.apart),
        )
    ]  # fmt: skip
    notes: list[list[Cell]] = [[None, note] for note in lots_notes(report, words)]
    return Sheet(words("lots-head"), columns, [*rows, *totals, *notes])


def _summary(report: Report, words: Words) -> Sheet:
    columns = (
        Column(words("what"), width=_WIDE), Column(words("value"), width=_WIDE), Column(words("low")),
        Column(words("high")), Column(words("count-surveys"), "count"), Column(words("unit"), width=_WIDE),
    )  # fmt: skip
    share, stalls, asked = words("unit-share"), words("unit-stalls"), report.asked
    rows: list[list[Cell]] = [
        [words("lot"), report.name],
        [words("clock"), report.clock],
        [words("first-day"), _of_day(report.first)],
        [words("last-day"), _of_day(report.last)],
        [words("made-at"), _of_moment(report.made)],
        [words("question"), words.question(asked.asked)],
        [words("stalls"), ("count", asked.stalls)],
        [words("days-head"), ("count", asked.days)],
        [words("hours-surveyed"), ("count", asked.hours)],
        [words("mean-share"), *_typed(asked.occupancy, "share"), share],
        [words("mean-stalls"), *_typed(asked.accumulation, "number"), stalls],
        *_ends(report, words, share),
    ]
    return Sheet(words("summary"), columns, rows)


def _ends(report: Report, words: Words, unit: str) -> Iterable[list[Cell]]:
    for name, survey in (("fullest-survey", report.fullest), ("emptiest-survey", report.emptiest)):
        if survey is not None:
            yield [words(name), *_typed(survey.occupancy, "share"), unit, _moment_of(survey)]


def _rows(report: Report, words: Words) -> Sheet:
    columns = (
        Column(words("name"), width=_WIDE), Column(words("stall-kind")), Column(words("is-asked")),
        Column(words("stalls"), "count"), *_estimate(words, "share"), Column(words("always"), "number"),
        Column(words("low"), "number"), Column(words("high"), "number"),
    )  # fmt: skip
    whole = replace(report.whole, is_asked=True)
    kinds = (("asked-part", "", (whole,)), ("row", "row", report.rows), ("zone", "zone", report.zones),
             ("stall-kind", "kind", report.kinds))  # fmt: skip
    rows: list[list[Cell]] = [
        [
            words.name(by, part.name) if by else words.part(report.asked.asked), words(name),
            words("yes") if part.is_asked else None, part.stalls, *_ranged(part.occupancy), part.occupancy.surveys,
            *(_ranged(part.always) if part.always is not None else ()),
        ]
        for name, by, parts in kinds
        for part in parts
    ]  # fmt: skip
    return Sheet(words("rows"), columns, rows)


def _hours(report: Report, words: Words) -> Sheet:
    columns = (
        Column(words("weekday")), Column(words("hour"), "count"), Column(words("is-asked")),
        Column(words("days-head"), "count"), *_estimate(words, "share"),
    )  # fmt: skip
    rows: list[list[Cell]] = [
        [
            words.weekday(cell.weekday), cell.hour, words("yes") if cell.is_asked else None, cell.days,
            *_ranged(cell.occupancy), cell.occupancy.surveys,
        ]
        for cell in report.asked.cells
    ]  # fmt: skip
    return Sheet(words("heat-map"), columns, rows)


def _surveys(report: Report, words: Words) -> Sheet:
    columns = (
        Column(words("survey"), "moment", 18), Column(words("began"), "moment", 18),
        Column(words("ended"), "moment", 18), Column(words("is-asked")), *_estimate(words, "share")[:3],
        *(Column(words(name), "count") for name in ("free-stalls", "taken-stalls", "unclear-stalls")),
        Column(words("left-out"), width=_WIDE), Column("", width=_WIDE), Column(words("id"), width=_ID),
    )  # fmt: skip
    asked = {each.survey: each for each in report.asked.surveys}
    rows: list[list[Cell]] = []
    for use in report.surveys:
        share = asked[use.id].occupancy if use.id in asked else use.occupancy
        rows.append(
            [
                *(_of_moment(each.astimezone(report.made.tzinfo)) for each in (use.at, use.began, use.ended)),
                words("yes") if use.id in asked else None,
                *(_ranged(share) if use.id in asked or report.is_whole else (None, None, None)),
                use.free, use.taken, use.unknown, None, source_of(use, words), use.id,
            ]
        )  # fmt: skip
    missing: list[list[Cell]] = [
        [_of_moment(each.at), *[None] * 9, words(f"why-{each.why}")] for each in report.missing
    ]
    return Sheet(words("surveys"), columns, [*rows, *missing])


def _sections(report: Report, words: Words) -> Iterable[Sheet]:
    """Yield what was counted in sections, and their hours where they are asked."""
    found = report.sections
    if found is None:
        return
    heads = ("vehicles", "low", "high", "section-places")
    columns = (
        Column(words("section"), width=_WIDE), *(Column(words(name), "count") for name in heads),
        Column(words("section-given")), Column(words("section-occupancy"), "share"),
        Column(words("section-room"), "count"), Column(words("section-hidden"), "share"),
        Column(words("section-note"), width=_WIDE), Column(words("survey"), "moment", 18),
        Column(words("id"), width=_ID),
    )  # fmt: skip
    yield Sheet(words("sections"), columns, [_section(each, found.at, words) for each in found.sections])
    if found.use is None:
        return
    columns = (
        Column(words("weekday")), Column(words("hour"), "count"), Column(words("is-asked")),
        Column(words("days-head"), "count"), Column(words("section-occupancy"), "share"), Column(words("low"), "share"),
        Column(words("high"), "share"), Column(words("vehicles"), "number"), Column(words("low"), "number"),
        Column(words("high"), "number"), Column(words("count-surveys"), "count"),
    )  # fmt: skip
    rows: list[list[Cell]] = [
        [
            words.weekday(cell.weekday), cell.hour, words("yes") if cell.is_asked else None, cell.days,
            *_ranged(cell.occupancy), *_ranged(cell.accumulation), cell.accumulation.surveys,
        ]
        for cell in found.use.cells
    ]  # fmt: skip
    yield Sheet(f"{words('sections')}, {words('heat-map').lower()}"[:_LONGEST_NAME], columns, rows)


def _section(section: ListedSection, at: datetime, words: Words) -> list[Cell]:
    look, given = section.look, words("yes") if section.is_capacity_given else None
    if look is None:
        return [section.name, None, None, None, section.capacity, given, None, None, None, section.note]
    hidden = min(look.hidden_share + 1 - look.seen_share, 1.0)
    return [
        section.name, look.parked, look.least, look.most, section.capacity, given, look.occupancy, look.room, hidden,
        section.note, _of_moment(at), section.id,
    ]  # fmt: skip


def _stalls(report: Report, words: Words) -> Sheet:
    columns = (
        Column(words("label")), Column(words("id"), width=_ID), Column(words("row")), Column(words("stall-kind")),
        Column(words("zone"), width=20), Column(words("share-taken"), "share"), Column(words("low"), "share"),
        Column(words("high"), "share"), Column(words("surveys-seen"), "count"),
        *(Column(words.moment(at, with_year=True), width=_NARROW) for at in report.states_at),
    )  # fmt: skip
    states = {state: words("state", state=name) or None for state, name in _STATES.items()}
    rows: list[list[Cell]] = [
        [
            stall.label, stall.id, words.name("row", stall.row), words("kind", kind=stall.kind or "normal"),
            words.listed(stall.zones) if stall.zones else None, stall.share, stall.low, stall.high, stall.surveys,
            *(states[each] for each in stall.states),
        ]
        for stall in report.stalls
    ]  # fmt: skip
    return Sheet(words("unit-stalls").capitalize(), columns, rows)


def _method(report: Report, words: Words) -> Sheet:
    lines = [*method_of(report, words), words("ranges-hold"), words("between")]
    if report.newest is not None:
        lines.insert(0, labels_of(report.newest, words))
    if report.unreadable:
        lines.append(words("unreadable", count=report.unreadable))
    if len(report.surveys) > MOST_STATES:
        lines.append(words("states-cut", shown=MOST_STATES, count=len(report.surveys)))
    changes: list[list[Cell]] = [
        [why_of(each.why, words), _of_moment(each.at), ("count", each.stalls)] for each in report.layouts
    ]
    columns = (Column(words("method"), width=110), Column(words("since"), width=18), Column(words("stalls")))
    said: list[list[Cell]] = [[line] for line in lines if line]
    return Sheet(words("method"), columns, [*said, *changes])


# -- cells -------------------------------------------------------------------------------------------------------------


def _estimate(words: Words, kind: Kind) -> tuple[Column, ...]:
    """Return the columns of a figure: the figure, the ends of its interval, and its surveys."""
    shown = (words("share-taken"), words("low"), words("high"))
    return (*(Column(name, kind) for name in shown), Column(words("count-surveys"), "count"))


def _ranged(found: Estimate) -> tuple[Cell, Cell, Cell]:
    return found.value, found.low, found.high


def _typed(found: Estimate, kind: Kind) -> list[Cell]:
    """Return a figure with the ends of its interval and its surveys, in columns of other kinds."""
    ends: list[Cell] = [None if each is None else (kind, each) for each in (found.value, found.low, found.high)]
    return [*ends, found.surveys]


def _moment_of(survey: SurveyShare) -> Cell:
    return _of_moment(datetime.fromisoformat(survey.at))


def _of_moment(at: datetime) -> Cell:
    """Return a moment as a workbook has it: days of a wall's clock, which has no time zone."""
    return "moment", (at.replace(tzinfo=None) - _EPOCH).total_seconds() / _SECONDS_A_DAY


def _of_day(day: date | None) -> Cell:
    return None if day is None else ("day", float((day - _EPOCH.date()).days))
