"""Figures as JSON values, as a table of text, and as rows of CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from typing import Any, Final

from hawk.lots.values import utc
from hawk.results.stall_files import table_text
from hawk.stats.changes import Changes
from hawk.stats.figures import PRACTICAL, WEEKDAYS, Figures, Hour, Use
from hawk.stats.partition import Partition
from hawk.stats.turnover import Bracket
from hawk.stats.values import LEVEL, Estimate

_DIGITS: Final = 4
NONE: Final = "–"
"""Text of what nobody flew, and of an end that is open."""


def figures_json(found: Figures) -> dict[str, Any]:
    """Return all figures as JSON values; each one with its interval and the number of surveys behind it."""
    return {
        "lot": found.lot,
        "name": found.name,
        "clock": found.clock,
        "interval": LEVEL,
        "surveys": found.surveys,
        "first": None if found.first is None else found.first.isoformat(timespec="minutes"),
        "last": None if found.last is None else found.last.isoformat(timespec="minutes"),
        "left_out": [{"survey": each.id, "ended": utc(each.at), "why": each.why} for each in found.left_out],
        "whole": None if found.whole is None else _use_json(found.whole),
        "by": found.by or None,
        "parts": [_use_json(each) for each in found.parts],
        "hours": [
            {"hour": each.hour, "days": each.days, "occupancy": estimate_json(each.occupancy)}
            | {"accumulation": estimate_json(each.accumulation)}
            for each in found.hours
        ],
        "days": [
            {
                "day": WEEKDAYS[each.weekday],
                "days": each.days,
                "hours": each.hours,
                "occupancy": estimate_json(each.occupancy),
            }
            for each in found.days
        ],
        "compared": [
            {"first": WEEKDAYS[each.first], "second": WEEKDAYS[each.second], "hours": each.hours}
            | {"difference": estimate_json(each.difference)}
            for each in found.compared
        ],
    }


def changes_json(found: Changes) -> dict[str, Any]:
    """Return the changes between two surveys as JSON values."""
    return {
        "compared": found.compared,
        "unknown": found.unknown,
        "came": estimate_json(found.came),
        "left": estimate_json(found.left),
        "stalls": [
            {"id": each.stall.id, "label": each.stall.label, "taken": each.is_taken, "chance": round(each.chance, 4)}
            for each in found.stalls
        ],
    }


def _use_json(use: Use) -> dict[str, Any]:
    peak, turnover = use.peak, use.turnover
    return {
        "name": use.name,
        "capacity": use.capacity,
        "surveys": use.surveys,
        "hours": use.hours,
        "occupancy": estimate_json(use.occupancy),
        "accumulation": estimate_json(use.accumulation),
        "load_space_hours": estimate_json(use.load),
        "peak": None
        if peak is None
        else {
            "begin": peak.begin,
            "occupancy": estimate_json(peak.occupancy),
            "accumulation": estimate_json(peak.accumulation),
        }
        | {"rivals": peak.rivals},
        "above": {f"{limit:.2f}": estimate_json(share) for limit, share in zip(PRACTICAL, use.above, strict=True)},
        "never_taken": estimate_json(use.steady.never) | {"stalls": [stall.label for stall in use.steady.never_stalls]},
        "always_taken": estimate_json(use.steady.always)
        | {"stalls": [stall.label for stall in use.steady.always_stalls]},
        "turnover": {
            "hours": round(turnover.hours, _DIGITS),
            "pairs": turnover.pairs,
            "open_pairs": turnover.open_pairs,
            "arrivals": _bracket_json(turnover.arrivals),
            "per_stall_hour": _bracket_json(turnover.per_stall),
            "stay_hours": _bracket_json(turnover.stay),
        },
    }


def estimate_json(found: Estimate) -> dict[str, Any]:
    """Return a figure with its ends and the number of surveys behind it."""
    return {
        "value": _rounded(found.value), "low": _rounded(found.low), "high": _rounded(found.high),
        "surveys": found.surveys,
    }  # fmt: skip


def _bracket_json(found: Bracket) -> dict[str, Any]:
    return {"low": _rounded(found.low), "high": _rounded(found.high)}


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, _DIGITS)


_USE_COLUMNS: Final = (
    "name", "capacity", "surveys", "hours", "occupancy", "occupancy_low", "occupancy_high", "load_space_hours",
    "load_low", "load_high", "peak_begin", "peak_occupancy", "peak_low", "peak_high", "above_85", "above_85_low",
    "above_85_high", "above_90", "above_90_low", "above_90_high", "never_taken", "always_taken", "arrivals_low",
    "arrivals_high", "stay_hours_low", "stay_hours_high",
)  # fmt: skip
_HOUR_COLUMNS: Final = (
    "hour", "days", "surveys", "occupancy", "occupancy_low", "occupancy_high", "accumulation", "accumulation_low",
    "accumulation_high",
)  # fmt: skip


def figures_csv(found: Figures) -> str:
    """Return a table as CSV: a line an hour of the day, or a line a part; without parts one of the whole lot.

    Each line ends with lot, clock, period and what was left out, so that it stands by itself.
    """
    about: dict[str, object] = {
        "lot": found.name, "lot_id": found.lot, "clock": found.clock, "interval": LEVEL,
        "first": None if found.first is None else found.first.isoformat(timespec="minutes"),
        "last": None if found.last is None else found.last.isoformat(timespec="minutes"),
        "surveys_in_period": found.surveys, "surveys_left_out": len(found.left_out),
    }  # fmt: skip
    uses = found.parts or (() if found.whole is None else (found.whole,))
    hourly = found.by == Partition.HOUR
    names, rows = (
        (_HOUR_COLUMNS, map(_hour_row, found.hours)) if hourly else (_USE_COLUMNS, map(_use_row, uses))
    )  # fmt: skip
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow((*names, *about))
    writer.writerows((_cell(cell) for cell in (*row, *about.values())) for row in rows)
    return out.getvalue()


def _cell(cell: object) -> object:
    return table_text(cell) if isinstance(cell, str) else "" if cell is None else cell


def _use_row(use: Use) -> list[object]:
    peak = use.peak
    return [
        use.name, use.capacity, use.surveys, use.hours, *_ends(use.occupancy), *_ends(use.load),
        None if peak is None else peak.begin, *(_ends(peak.occupancy) if peak else (None,) * 3),
        *(end for each in use.above for end in _ends(each)), use.steady.never.value, use.steady.always.value,
        _rounded(use.turnover.arrivals.low), _rounded(use.turnover.arrivals.high),
        _rounded(use.turnover.stay.low), _rounded(use.turnover.stay.high),
    ]  # fmt: skip


def _hour_row(hour: Hour) -> list[object]:
    return [hour.hour, hour.days, hour.occupancy.surveys, *_ends(hour.occupancy), *_ends(hour.accumulation)]


def _ends(found: Estimate) -> tuple[float | None, ...]:
    return _rounded(found.value), _rounded(found.low), _rounded(found.high)


def figures_text(found: Figures) -> str:
    """Return the figures as text for a terminal; intervals stand behind each figure."""
    lines = [f"{found.name}: {_counted(found.surveys, 'survey')}, times by {found.clock}"]
    lines += [f"  left out: survey {each.id} of {utc(each.at)}: {each.why}" for each in found.left_out]
    if found.whole is None or found.first is None or found.last is None:
        return "\n".join([*lines, "No survey of this period can be used: choose another one by --from and --to"])
    lines[0] += f", {found.first:%Y-%m-%d %H:%M} to {found.last:%Y-%m-%d %H:%M}; {LEVEL:.0%} intervals"
    lines += _use_lines(found.whole)
    if found.by == Partition.HOUR:
        hours = [
            (f"{each.hour:02d}", each.occupancy.surveys, share(each.occupancy), amount(each.accumulation))
            for each in found.hours
        ]
        lines += ["", *_table(("hour", "surveys", "occupancy", "accumulation"), hours)]
    elif found.by:
        rows = [
            (use.name, use.capacity, use.surveys, share(use.occupancy), amount(use.load),
             _peak(use), bracket(use.turnover.arrivals))
            for use in found.parts
        ]  # fmt: skip
        names = (found.by, "stalls", "surveys", "occupancy", "space-hours", "peak", "arrivals")
        lines += ["", *_table(names, rows)]
    lines += [
        f"  {WEEKDAYS[each.second]} against {WEEKDAYS[each.first]}: {share(each.difference, sign=True)}, "
        f"{_counted(each.hours, 'hour')} of the day"
        for each in found.compared
    ]
    return "\n".join(lines)


def _use_lines(use: Use) -> Iterable[str]:
    turnover = use.turnover
    yield f"  capacity: {use.capacity} stalls"
    yield f"  occupancy over {_counted(use.hours, 'surveyed hour')}: {share(use.occupancy)}"
    yield f"  accumulation: {amount(use.accumulation)}; load: {amount(use.load)} space-hours"
    rivals = 0 if use.peak is None else use.peak.rivals
    more = f"; {_counted(rivals, 'other hour')} may be" if rivals else ""
    yield f"  peak: {_peak(use)}{more}"
    for limit, each in zip(PRACTICAL, use.above, strict=True):
        yield f"  surveyed hours at {limit:.0%} or more: {share(each)}"
    yield f"  never taken: {amount(use.steady.never)}; always taken: {amount(use.steady.always)}"
    if not turnover.pairs:
        yield "  arrivals: not known, since no two surveys of this period follow each other over the same stalls"
    else:
        yield f"  arrivals in {turnover.hours:.1f} h between surveys: {bracket(turnover.arrivals)}"
    if turnover.stay.low is None and turnover.stay.high is None:
        yield "  mean stay: not known, since no arrivals are known that limit it"
    else:
        yield f"  mean stay: {bracket(turnover.stay, 1, ' h')}"


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
