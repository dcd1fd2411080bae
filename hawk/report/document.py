"""A report as one HTML document: a browser shows and prints it, and `hawk.report.pdf` makes a PDF of it."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import lru_cache
from importlib.metadata import version
from typing import Any, Final

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

from hawk.lots.answers import ListedSection
from hawk.lots.change_detection.takeover import TAKEN_OVER
from hawk.lots.ingest import FIRST_FLIGHT
from hawk.lots.plan.edits import CORRECTED
from hawk.report.canvas import curve, lot_drawing
from hawk.report.lots_report import LotsReport
from hawk.report.options import Form, Paper
from hawk.report.values import Newest, Report
from hawk.report.words import NONE, Words
from hawk.stats.answers import SurveyUse
from hawk.stats.hour_use import Cell
from hawk.stats.values import WEEKDAYS, Estimate

FONTS: Final = '"DejaVu Sans", Inter, "Liberation Sans", Arial, sans-serif'
MOST_ROWS: Final = 200
"""Rows, zones, changes and surveys that a list shows."""
_BESIDE: Final = 8
"""Rows up to which their table stands beside the curve."""
_MOST_POINTS: Final = 60
"""Surveys up to which the curve leaves room beside it."""
_BESIDE_PX: Final = 348.0
_SHADES: Final = 10


@dataclass(frozen=True, slots=True)
class _Sheet:
    """Size of a paper, its width within the margins, and the height of the picture, pixels of 1/96 inch."""

    size: str
    width: float
    picture: float


_SHEETS: Final[dict[Paper, _Sheet]] = {
    "a4": _Sheet("210mm 297mm", 680.0, 352.0), "letter": _Sheet("8.5in 11in", 702.0, 320.0),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Figure:
    """One of the figures in short."""

    figure: str
    words: str
    range: str


@dataclass(frozen=True, slots=True)
class _Shaded:
    """A cell of the heat map with the names of its looks."""

    use: Cell
    look: str


@dataclass(frozen=True, slots=True)
class _Row:
    """A line of the list of surveys."""

    at: datetime
    occupancy: Estimate
    use: SurveyUse
    source: str


def document(report: Report, form: Form) -> str:
    """Return a report as HTML, which asks for nothing else: its style and its picture are in it."""
    return _html(Words(form.language), form.paper, [lot_part(report, form)], report, report.name)


def lots_document(report: LotsReport, parts: Sequence[Markup], form: Form) -> str:
    """Return a report over several lots as HTML: its first page, then `lot_part` of each line.

    Without parts it is the first page alone, as `hawk.report.pdf.printed_parts` takes it: a link leads to itself.
    """
    words = Words(form.language)
    name = words("lots", count=len(report.lines))
    return _html(words, form.paper, [_first_page(report, words, is_alone=not parts), *parts], report, name)


def lot_part(report: Report, form: Form) -> Markup:
    """Return what a document says of a lot, as HTML."""
    words = Words(form.language)
    template = _environment().get_template("lot.html")
    return Markup(template.render(_values(report, words, _SHEETS[form.paper]), w=words))  # noqa: S704 - escaped in it


def _html(words: Words, paper: Paper, parts: Sequence[Markup], report: Report | LotsReport, name: str) -> str:
    period = period_of(report, words)
    css = Markup(_style(words, paper, ", ".join(filter(None, (name, period)))))  # noqa: S704 - escaped as CSS
    return _environment().get_template("report.html").render(
        parts=parts, css=css, language=words.language, made=report.made, name=name,
        title=", ".join(filter(None, (words("kind-of-document"), period))),
        author=words("author", program=f"hawk-drone {version('hawk-drone')}"),
    )  # fmt: skip


def _first_page(report: LotsReport, words: Words, *, is_alone: bool) -> Markup:
    template = _environment().get_template("lots.html")
    made = words.moment(report.made, with_year=True)
    return Markup(  # noqa: S704 - the template escapes
        template.render(
            report=report, w=words, period=period_of(report, words), free=report.free, vehicles=report.vehicles,
            has_sections=any(each.vehicles.value is not None for each in report.lines), none_there=NONE,
            made=made if report.clock else f"{made} UTC", notes=lots_notes(report, words), is_alone=is_alone,
        )
    )  # fmt: skip


def lots_notes(report: LotsReport, words: Words) -> list[str]:
    """Return what a reader must know of the total of several lots, a paragraph each."""
    totals = (("lots-apart", report.free), ("lots-apart-vehicles", report.vehicles))
    apart = [words(name, range=words.amounts(total.apart)) for name, total in totals if total.apart != total.alike]
    notes = [words("ranges-hold"), *([words("lots-together")] if apart else []), *apart]
    if report.free.alike.value is not None:
        notes.append(words("lots-unseen"))
    if report.moments is not None:
        first, last = (words.moment(each, with_year=True) for each in report.moments)
        if first != last:
            notes.append(words("lots-moments", first=first, last=last))
    if report.uncounted:
        notes.append(words("lots-uncounted", count=report.uncounted))
    return notes


def content_policy(html: str) -> str:
    """Return the Content-Security-Policy of a document: no script, its own style and pictures alone."""
    style = html.partition("<style>")[2].partition("</style>")[0]
    digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
    return (
        f"default-src 'none'; style-src 'sha256-{digest}'; img-src data:; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'self'"
    )


def period_of(report: Report | LotsReport, words: Words) -> str:
    """Return the days of a report; empty without any."""
    return "" if report.first is None or report.last is None else words.period(report.first, report.last)


def labels_of(newest: Newest, words: Words) -> str:
    """Return whether labels are as painted, or our guess; empty without stalls."""
    if newest.named == newest.stalls:
        return words("labels-painted") if newest.stalls else ""
    if not newest.named:
        return words("labels-guessed")
    return words("labels-both", named=newest.named, stalls=newest.stalls)


def method_of(report: Report, words: Words) -> list[str]:
    """Return method and limits, a paragraph each."""
    names = ("method-look", "method-range", "method-mean", "method-between", "method-always", "method-labels")
    others = sum(each.kind == "picture" for each in report.surveys)
    pictures = [words("method-pictures", count=others)] if others else []
    return [*map(words, names), *pictures, words("method-private")]


def why_of(why: str, words: Words) -> str:
    """Return why a layout changed: our own words in the report's language, a person's as they are."""
    return words(_WHYS[why]) if why in _WHYS else why


_WHYS: Final = {FIRST_FLIGHT: "layout-first", CORRECTED: "layout-corrected", TAKEN_OVER: "layout-taken"}


def source_of(use: SurveyUse, words: Words) -> str:
    """Return what a reader must know of where a survey is from; empty for a flight."""
    found = ["by-pictures"] if use.kind == "picture" else []
    return ", ".join(words(each) for each in (*found, *(["by-simulator"] if use.simulated else [])))


def _values(report: Report, words: Words, sheet: _Sheet) -> dict[str, Any]:
    asked, newest = report.asked, report.newest
    is_beside = 0 < len(report.rows) <= _BESIDE and len(asked.surveys) <= _MOST_POINTS
    surveys = _surveys(report, words)
    days = report.asked.days
    return {
        "report": report, "asked": asked, "newest": newest, "days": days, "zone": report.clock,
        "period": period_of(report, words), "simulated": sum(each.simulated for each in report.surveys),
        "labels": "" if newest is None else labels_of(newest, words),
        "picture": _picture(newest, words, sheet), "short": _short(report, words), "is_beside": is_beside,
        "curve": curve(report, words, _BESIDE_PX if is_beside else sheet.width),
        "hatched": bool(report.empty), "always": any(part.always for part in report.rows), "most_rows": MOST_ROWS,
        "weekdays": WEEKDAYS, "heat": _heat(report.asked.cells, is_always=report.is_always), "surveys": surveys,
        "section_cells": lambda each: section_cells(each, words), "section_heat": _section_heat(report),
        "sourced": any(row.source for row in surveys), "why": lambda why: why_of(why, words),
        "method": method_of(report, words),
    }  # fmt: skip


def _picture(newest: Newest | None, words: Words, sheet: _Sheet) -> Markup:
    if newest is None or newest.picture is None:
        return Markup("")
    return lot_drawing(newest.picture, words, sheet.width, sheet.picture)


def _short(report: Report, words: Words) -> list[_Figure]:
    """Return the figures in short: none without a survey."""
    fullest, emptiest, asked = report.fullest, report.emptiest, report.asked
    if fullest is None or emptiest is None:
        return []
    mean = words("mean", hours=asked.hours)
    found = [_Figure(words.share(asked.occupancy), mean, words.shares(asked.occupancy))]
    ends = [("fullest", fullest), ("emptiest", emptiest)] if len(asked.surveys) > 1 else [("only", fullest)]
    for name, survey in ends:
        at = words.moment(datetime.fromisoformat(survey.at))
        found.append(_Figure(words.share(survey.occupancy), words(name, at=at), words.shares(survey.occupancy)))
    rows = [part for part in report.rows if part.occupancy.value is not None]
    if len(rows) > 1 and not asked.asked.rows:
        row = max(rows, key=lambda part: part.occupancy.value or 0.0)
        name, share = words.name("row", row.name), words.share(row.occupancy)
        ranged = words.shares(row.occupancy)
        return [*found, _Figure(words("fullest-row-name", row=name), words("fullest-row", share=share), ranged)]
    stalls = words("stalls-taken", stalls=asked.stalls)
    return [*found, _Figure(words.amount(asked.accumulation), stalls, words.amounts(asked.accumulation))]


def section_cells(section: ListedSection, words: Words) -> list[str]:
    """Return what the newest survey counted in a section: vehicles, their range, places, share, room, hidden share."""
    look, capacity = section.look, words.places(section.capacity)
    if look is None:
        return [NONE, NONE, capacity, NONE, NONE, NONE]
    share = NONE if look.occupancy is None else words.share(Estimate(look.occupancy, None, None, 1))
    hidden = words.share(Estimate(min(look.hidden_share + 1 - look.seen_share, 1.0), None, None, 1))
    between = words("range", low=words.count(look.least), high=words.count(look.most))
    room = NONE if look.room is None else words.count(look.room)
    return [words.count(look.parked), between, capacity, share, room, hidden]


def _section_heat(report: Report) -> list[list[_Shaded]]:
    """Return the cells of the sections that are asked: by their share, else by the largest number."""
    use = None if report.sections is None else report.sections.use
    if use is None:
        return []
    most = max((cell.accumulation.value or 0.0 for cell in use.cells), default=0.0) or 1.0
    return _heat(use.cells, is_always=all(cell.is_asked for cell in use.cells), most=None if use.places else most)


def _heat(cells: Sequence[Cell], *, is_always: bool, most: float | None = None) -> list[list[_Shaded]]:
    """Return the cells of each hour, by weekday; ``most``: number that is the darkest, where shares are not known."""
    found: list[list[_Shaded]] = [[] for _ in range(24)]
    for cell in cells:
        number = cell.accumulation.value
        share = cell.occupancy.value if most is None else None if number is None else number / most
        look = "none" if share is None else f"s{min(int(share * _SHADES), _SHADES - 1)}"
        found[cell.hour].append(_Shaded(cell, f"{look} in" if cell.is_asked and not is_always else look))
    return found


def _surveys(report: Report, words: Words) -> list[_Row]:
    """Return the newest surveys behind the answer, the oldest of these first."""
    uses = {use.id: use for use in report.surveys}
    return [
        _Row(datetime.fromisoformat(each.at), each.occupancy, uses[each.survey], source_of(uses[each.survey], words))
        for each in report.asked.surveys[-MOST_ROWS:]
        if each.survey in uses
    ]


# -- style -------------------------------------------------------------------------------------------------------------


def _style(words: Words, paper: Paper, foot: str) -> str:
    sheet = _SHEETS[paper]
    return _environment().get_template("report.css").render(
        size=sheet.size, width=sheet.width, foot=_css_text(foot), page=_css_text(words("page")),
        of=_css_text(words("page-of")), fonts=FONTS, shades=list(_shades()),
    )  # fmt: skip


def _css_text(text: str) -> str:
    """Return a text as a string of CSS that says the same within HTML: all but letters and digits is escaped."""
    return '"' + "".join(each if each.isascii() and each.isalnum() else f"\\{ord(each):x} " for each in text) + '"'


def _shades() -> Iterable[tuple[str, str]]:
    """Yield colour and ink of each tenth of a share, from light to dark."""
    light, dark = (255, 244, 234), (176, 66, 0)
    for step in range(_SHADES):
        part = step / (_SHADES - 1)
        colour: Sequence[int] = [round(a + (b - a) * part) for a, b in zip(light, dark, strict=True)]
        yield "#" + "".join(f"{each:02x}" for each in colour), "#15202b" if part < 0.6 else "#ffffff"


@lru_cache
def _environment() -> Environment:
    """Return the templates; every value is escaped, and one that is missing is an error."""
    loader = PackageLoader("hawk.report", "templates")
    return Environment(
        loader=loader, autoescape=select_autoescape(["html"]), undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
