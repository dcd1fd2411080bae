"""Figures as a table of text, and as rows of CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from hawk.results.stall_files import table_text
from hawk.stats.figures import Figures, Use
from hawk.stats.hour_use import AskedUse, Cell
from hawk.stats.turnover import Bracket
from hawk.stats.use_query import Asked
from hawk.stats.values import WEEKDAYS, Estimate, LeftOut, Weekday

NONE: Final = "–"
"""Text of what nobody flew, and of an end that is open."""


def figures_csv(found: Figures) -> str:
    """Return a table as CSV: a line an hour of the day, or a line a part; without parts one of the whole lot.

    The columns are the fields of `Hour` and `Use`: an estimate has two more columns, for its ends. Each line ends with
    lot, clock, period and what was left out, so that it stands by itself.
    """
    shown = found.model_dump(mode="json", exclude={"days", "compared"})
    uses = shown["parts"] or ([] if shown["whole"] is None else [shown["whole"]])
    about = {
        "lot": found.name, "lot_id": found.lot, "clock": found.clock, "interval": found.interval, "first": found.first,
        "last": found.last, "surveys_in_period": found.surveys, "surveys_left_out": len(found.left_out),
    }  # fmt: skip
    return _csv(shown["hours"] if found.by == "hour" else uses, about)


def asked_csv(found: AskedUse) -> str:
    """Return the cells that are asked as CSV, a line a weekday and hour, as `figures_csv`."""
    about = {"lot": found.name, "lot_id": found.lot, "clock": found.clock, "interval": found.interval}
    about |= {"surveys_asked": found.occupancy.surveys, "surveys_left_out": len(found.left_out)}
    asked = {name: ", ".join(map(str, getattr(found.asked, name))) for name in ("rows", "zones", "kinds", "sections")}
    asked["unit"] = found.unit
    cells = [each for each in found.model_dump(mode="json")["cells"] if each.pop("is_asked")]
    return _csv(cells, about | asked)


def _csv(shown: Iterable[Mapping[str, Any]], about: Mapping[str, object]) -> str:
    lines = [{**dict(_cells(each)), **about} for each in shown]
    names = dict.fromkeys(name for line in lines for name in line) or about
    out = io.StringIO()
    writer = csv.DictWriter(out, list(names), lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: _cell(cell) for name, cell in line.items()} for line in lines)
    return out.getvalue()


def _cells(shown: Mapping[str, Any], prefix: str = "") -> Iterable[tuple[str, object]]:
    """Return the cells of an object, each with the name of its column; lists, and an object that is null, have none."""
    for name, value in shown.items():
        if isinstance(value, Mapping):
            yield from _cells(value, f"{prefix}{name}_")
        elif not isinstance(value, list) and (value is not None or prefix):
            yield f"{prefix}{name}".removesuffix("_value"), value


def _cell(cell: object) -> object:
    return table_text(cell) if isinstance(cell, str) else "" if cell is None else cell


def figures_text(found: Figures) -> str:
    """Return the figures as text for a terminal; intervals stand behind each figure."""
    lines = [f"{found.name}: {_counted(found.surveys, 'survey')}, times by {found.clock}", *_left_out(found.left_out)]
    if found.by == "section":
        return "\n".join([*lines, *_section_lines(found)])
    if found.whole is None or found.first is None or found.last is None:
        return "\n".join([*lines, "No survey of this period can be used: choose another one by --from and --to"])
    first, last = (each[:16].replace("T", " ") for each in (found.first, found.last))
    lines[0] += f", {first} to {last}; {found.interval:.0%} intervals"
    lines += _use_lines(found.whole)
    if found.by == "hour":
        hours = [
            (f"{each.hour:02d}", each.occupancy.surveys, share(each.occupancy), amount(each.accumulation))
            for each in found.hours
        ]
        lines += ["", *_table(("hour", "surveys", "occupancy", "accumulation"), hours)]
    elif found.by:
        rows = [
            (use.name, use.capacity, use.surveys, share(use.occupancy), amount(use.load_space_hours),
             _peak(use), bracket(use.turnover.arrivals))
            for use in found.parts
        ]  # fmt: skip
        names = (found.by, "stalls", "surveys", "occupancy", "space-hours", "peak", "arrivals")
        lines += ["", *_table(names, rows)]
    lines += [
        f"  {each.second} against {each.first}: {share(each.difference, sign=True)}, "
        f"{_counted(each.hours, 'hour')} of the day"
        for each in found.compared
    ]
    return "\n".join(lines)


def _section_lines(found: Figures) -> Iterable[str]:
    if not found.parts:
        return ["No survey of this period saw a section"]
    rows = [
        (use.name, NONE if use.capacity is None else use.capacity, use.surveys, share(use.occupancy),
         number(use.accumulation), NONE if use.peak is None else use.peak.begin.replace("T", " "))
        for use in found.parts
    ]  # fmt: skip
    names = ("section", "places", "surveys", "occupancy", "vehicles", "peak")
    return ["vehicles counted, and their share of the places", *_table(names, rows)]


def _left_out(surveys: Iterable[LeftOut]) -> Iterable[str]:
    return (f"  left out: survey {each.survey} of {each.ended:%Y-%m-%dT%H:%M:%SZ}: {each.why}" for each in surveys)


def asked_text(found: AskedUse) -> str:
    """Return an answer as a sentence and a table for a terminal."""
    part, asked = _part(found.asked), found.asked
    when = f"on {_weekdays(asked.weekdays)}, {_hours(asked.hours) if len(asked.hours) < 24 else 'at any hour'}"
    lines = [f"{found.name}, {part}: nobody flew {when}, or every survey was left out"]
    if found.fullest is not None and found.emptiest is not None:
        lines[0] = f"{found.name}, {part}: {when}, {_answer(found)}"
        lines += [
            f"  from {_counted(found.accumulation.surveys, 'survey')} in {_counted(found.hours, 'hour')} of "
            f"{_counted(found.days, 'day')}, times by {found.clock}; {found.interval:.0%} intervals",
            f"  fullest: {_moment(found.fullest)}, {_taken(found.fullest)}; "
            f"emptiest: {_moment(found.emptiest)}, {_taken(found.emptiest)}",
        ]
    cells = [cell for cell in found.cells if cell.is_asked]
    without = [hour for hour in asked.hours if not any(cell.days for cell in cells if cell.hour == hour)]
    if lines[1:] and without and len(asked.hours) < 24:
        lines.append(f"  nobody flew {_hours(without)}")
    lines += _left_out(found.left_out)
    rows = [(_moment(cell), cell.days, cell.accumulation.surveys, _taken(cell)) for cell in cells if cell.days]
    if rows:
        lines += ["", *_table(("when", "days", "surveys", "taken"), rows)]
    if found.others:
        lines += ["", "the same hours in the other rows:"]
        lines += _table(
            ("row", "stalls", "surveys", "taken"),
            [(each.row, each.stalls, each.occupancy.surveys, share(each.occupancy)) for each in found.others],
        )
    return "\n".join(lines)


def _answer(found: AskedUse) -> str:
    """Return how much of what is asked is taken, with its unit."""
    if found.unit == "vehicles":
        return f"{number(found.accumulation)} vehicles are parked; nobody said how many places there are"
    if found.unit == "places":
        places = _counted(found.places or 0, "place")
        return f"{share(found.occupancy)} of the places: {number(found.accumulation)} vehicles, {places}"
    return f"{share(found.occupancy)} is taken, {amount(found.accumulation)} of {_counted(found.stalls, 'stall')}"


def _taken(cell: Cell) -> str:
    return number(cell.accumulation) if cell.occupancy.value is None else share(cell.occupancy)


def _moment(cell: Cell) -> str:
    return f"{cell.weekday} {cell.hour}:00"


def _part(asked: Asked) -> str:
    """Return the parts that are asked in words."""
    named = ((asked.rows, "row"), (asked.zones, "zone"), (asked.kinds, "kind"), (asked.sections, "section"))
    shown = [f"{name}{'s' * (len(each) > 1)} {' and '.join(each)}" for each, name in named if each]
    return ", ".join(shown) or "all stalls"


def _weekdays(days: Sequence[Weekday]) -> str:
    if len(days) == len(WEEKDAYS):
        return "any day"
    runs = runs_of([WEEKDAYS.index(day) for day in days])
    return ", ".join(
        WEEKDAYS[first] if first == last else f"{WEEKDAYS[first]} to {WEEKDAYS[last]}" for first, last in runs
    )


def _hours(hours: Sequence[int]) -> str:
    return ", ".join(f"{first}:00 to {last + 1}:00" for first, last in runs_of(hours))


def runs_of(numbers: Sequence[int]) -> list[tuple[int, int]]:
    """Return the first and the last of each run of numbers that follow each other."""
    firsts = [each for each in numbers if each - 1 not in numbers]
    lasts = [each for each in numbers if each + 1 not in numbers]
    return list(zip(firsts, lasts, strict=True))


def _use_lines(use: Use) -> Iterable[str]:
    turnover = use.turnover
    yield f"  capacity: {use.capacity} stalls"
    yield f"  occupancy over {_counted(use.hours, 'surveyed hour')}: {share(use.occupancy)}"
    yield f"  accumulation: {amount(use.accumulation)}; load: {amount(use.load_space_hours)} space-hours"
    rivals = 0 if use.peak is None else use.peak.rivals
    more = f"; {_counted(rivals, 'other hour')} may be" if rivals else ""
    yield f"  peak: {_peak(use)}{more}"
    for limit, each in use.above.items():
        yield f"  surveyed hours at {float(limit):.0%} or more: {share(each)}"
    yield f"  never taken: {amount(use.never_taken)}; always taken: {amount(use.always_taken)}"
    if not turnover.pairs:
        yield "  arrivals: not known, since no two surveys of this period follow each other over the same stalls"
    else:
        yield f"  arrivals in {turnover.hours:.1f} h between surveys: {bracket(turnover.arrivals)}"
    if turnover.stay_hours.low is None and turnover.stay_hours.high is None:
        yield "  mean stay: not known, since no arrivals are known that limit it"
    else:
        yield f"  mean stay: {bracket(turnover.stay_hours, 1, ' h')}"


def _peak(use: Use) -> str:
    return NONE if use.peak is None else f"{use.peak.begin.replace('T', ' ')} {share(use.peak.occupancy)}"


def share(found: Estimate, *, sign: bool = False) -> str:
    """Return a share as percent with its interval."""
    if found.value is None or found.low is None or found.high is None:
        return NONE
    form = "+.1%" if sign else ".1%"
    return f"{found.value:{form}} ({found.low:{form}} to {found.high:{form}})"


def amount(found: Estimate) -> str:
    """Return a number of stalls or space-hours with its interval."""
    if found.value is None or found.low is None or found.high is None:
        return NONE
    return f"{found.value:.0f} ({found.low:.0f} to {found.high:.0f})"


def number(found: Estimate) -> str:
    """Return a mean number of vehicles with its interval."""
    if found.value is None or found.low is None or found.high is None:
        return NONE
    return f"{found.value:.1f} ({found.low:.1f} to {found.high:.1f})"


def bracket(found: Bracket, digits: int = 0, unit: str = "") -> str:
    """Return a bracket with its unit, as " h"; an end that is not known is named as such."""
    if found.low is None and found.high is None:
        return NONE
    if found.high is None:
        return f"{found.low:.{digits}f}{unit} or more"
    if found.low is None:
        return f"{found.high:.{digits}f}{unit} or less"
    return f"{found.low:.{digits}f} to {found.high:.{digits}f}{unit}"


def _counted(number: int, name: str) -> str:
    return f"{number} {name}{'' if number == 1 else 's'}"


def _table(names: Sequence[str], rows: Sequence[Sequence[object]]) -> list[str]:
    shown = [list(names), *([str(cell) for cell in row] for row in rows)]
    widths = [max(len(row[k]) for row in shown) for k in range(len(names))]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in shown]
