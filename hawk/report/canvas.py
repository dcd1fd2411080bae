"""Drawings of a report as SVG, for the width of the paper: the curve by survey, and the stalls over a lot's picture."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import date, datetime, timedelta
from itertools import groupby
from typing import Final

from markupsafe import Markup

from hawk.report.values import DrawnRow, DrawnStall, LotPicture, Point, Report
from hawk.report.words import Words
from hawk.results.map_picture import scale_bar_m
from hawk.stats.hour_use import SurveyShare
from hawk.stats.values import WEEKDAYS

_HIGH: Final = 176.0
"""Height of the curve, with the names of its days; units are pixels of 1/96 inch."""
_LEFT, _TOP, _FLOOR, _RIGHT = 30.0, 8.0, 152.0, 6.0
_MOST_NAMED: Final = 8
"""Days that the curve names each; of more it names weeks or months."""
_WEEK, _MONTH = 7, 31
_MOST_ROWS: Final = 80
"""Rows whose names stand in the picture."""
_NUMBERS_FROM: Final = 9.5
"""Width of a stall on paper from which its number is read, pixels."""
_LEGEND: Final = 25.0
"""Height of what stands below a picture."""
_ZONE_LETTERS: Final = 0.56
"""Width of a letter over its size."""
_DIGIT: Final = 0.696
"""Width of a bold digit of DejaVu Sans over its size, as the font has it."""


@dataclass(frozen=True, slots=True)
class _Axis:
    """Days from ``first`` on, ``day`` pixels each."""

    first: date
    day: float

    def at(self, day: date, hours: float = 0.0) -> float:
        return _LEFT + ((day - self.first).days + hours / 24) * self.day


def curve(report: Report, words: Words, width: float) -> Markup:
    """Return the shares of what is asked by survey; empty without a survey.

    Points are joined within a day only; days that nobody flew are hatched. ``width``: pixels of 1/96 inch.
    """
    if report.first is None or report.last is None or not report.asked.surveys:
        return Markup("")
    days = [report.first + timedelta(number) for number in range((report.last - report.first).days + 1)]
    axis = _Axis(report.first, (width - _LEFT - _RIGHT) / len(days))
    parts = [*_hatched(report, axis, days), *_grid(axis, days, width, words)]
    by_day = groupby(report.asked.surveys, key=lambda survey: survey.at[:10])
    radius = min(max(width / (2.2 * len(report.asked.surveys)), 1.2), 3.2)
    parts += [part for _, surveys in by_day for part in _day(axis, tuple(surveys), radius)]
    return _svg(width, _HIGH, parts, words("curve-words"))


def _hatched(report: Report, axis: _Axis, days: Sequence[date]) -> Iterable[str]:
    """Yield the days that are asked on which nobody flew: those that follow each other as one."""
    empty = [day for day in days if day in report.empty]
    yield (
        '<defs><pattern id="nobody" width="5" height="5" patternUnits="userSpaceOnUse">'
        '<path d="M-1 6L6 -1M-1 1L1 -1M4 6L6 4" stroke="#9fb0bf" stroke-width="1"/></pattern></defs>'
    )
    for _, run in groupby(enumerate(empty), key=lambda each: each[1].toordinal() - each[0]):
        members = [day for _, day in run]
        left, right = axis.at(members[0]), axis.at(members[-1]) + axis.day
        yield _box(left, _TOP, right - left, _FLOOR - _TOP, 'fill="#eef2f5"')
        yield _box(left, _TOP, right - left, _FLOOR - _TOP, 'fill="url(#nobody)"')


def _grid(axis: _Axis, days: Sequence[date], width: float, words: Words) -> Iterable[str]:
    for percent in (0, 25, 50, 75, 100):
        y = _height(percent / 100)
        yield _line(_LEFT, y, width - _RIGHT, y, "#d7dee5")
        yield _text(_LEFT - 6, y + 3.5, str(percent), "end")
    last = -1e9
    for day, name in _names(days, words):
        x = axis.at(day)
        yield _line(x, _TOP, x, _FLOOR, "#d7dee5")
        middle = x + axis.day / 2 if len(days) <= _MOST_NAMED else x
        anchor = "middle" if len(days) <= _MOST_NAMED else "start"
        if x - last >= 52 or len(days) <= _MOST_NAMED:
            yield _text(middle, _FLOOR + 16, name, anchor, 9)
            last = x
    yield _line(width - _RIGHT, _TOP, width - _RIGHT, _FLOOR, "#d7dee5")


def _names(days: Sequence[date], words: Words) -> Iterable[tuple[date, str]]:
    if len(days) <= _MOST_NAMED:
        return [(day, f"{words.weekday(WEEKDAYS[day.weekday()], is_short=True)} {day.day}") for day in days]
    if len(days) <= _MOST_NAMED * _WEEK:
        return [(day, words.day(day).partition(" ")[2]) for day in days if day.weekday() == 0]
    return [(day, words.month(day)) for day in days if day.day == 1]


def _day(axis: _Axis, surveys: Sequence[SurveyShare], radius: float) -> Iterable[str]:
    """Yield the surveys of a day: their line, then whiskers and points over it."""
    places = []
    for survey in surveys:
        at, found = datetime.fromisoformat(survey.at), survey.occupancy
        if found.value is None or found.low is None or found.high is None:
            continue
        places.append((axis.at(at.date(), at.hour + at.minute / 60), found.value, found.low, found.high))
    if len(places) > 1:
        line = "L".join(f"{x:.1f} {_height(value):.1f}" for x, value, _, _ in places)
        yield f'<path d="M{line}" fill="none" stroke="#c05000" stroke-width="1.6"/>'
    cap = min(radius, axis.day / 3)
    for x, value, low, high in places:
        top, floor = _height(high), _height(low)
        yield _line(x, top, x, floor, "#15202b", 1.1)
        yield _line(x - cap, top, x + cap, top, "#15202b", 1.1)
        yield _line(x - cap, floor, x + cap, floor, "#15202b", 1.1)
        look = f'r="{radius:.1f}" fill="#ff7a1a" stroke="#15202b" stroke-width="{radius / 3.2:.1f}"'
        yield f'<circle cx="{x:.1f}" cy="{_height(value):.1f}" {look}/>'


def _height(share: float) -> float:
    return _FLOOR - share * (_FLOOR - _TOP)


# -- the picture -------------------------------------------------------------------------------------------------------


def lot_drawing(picture: LotPicture, words: Words, width: float, height: float) -> Markup:
    """Return the lot with its stalls, letters and numbers, zones, scale and legend, within a width and a height."""
    scale = min(width / picture.width, (height - _LEGEND) / picture.height)
    seen = _Sheet(scale, (width - picture.width * scale) / 2)
    high = picture.height * scale
    parts = [_STATES, _box(0, 0, width, high, 'fill="#ececec"')]
    if picture.jpeg:
        data = base64.b64encode(picture.jpeg).decode()
        parts.append(
            f'<image x="{seen.left:.1f}" y="0" width="{picture.width * scale:.1f}" height="{high:.1f}" '
            f'href="data:image/jpeg;base64,{data}"/>'
        )
    parts += _stalls(picture.stalls, seen)
    if picture.stall_width * scale >= _NUMBERS_FROM:
        parts += [part for each in picture.stalls for part in _number(each, seen, picture.stall_width * scale)]
    for zone in picture.zones:
        ring = seen.ring(zone.ring)
        parts.append(f'<polygon points="{ring}" fill="none" stroke="#10161c" stroke-opacity=".7" stroke-width="3.4"/>')
        parts.append(
            f'<polygon points="{ring}" fill="none" stroke="#ffe27a" stroke-width="1.8" stroke-dasharray="1.5 3.5"/>'
        )
    parts += [_zone_name(zone.name, zone.ring, seen, width, high) for zone in picture.zones]
    if len(picture.rows) <= _MOST_ROWS:
        beyond = picture.stall_width * scale / 2
        parts += [part for row in picture.rows for part in _letter(row, seen, beyond, width, high)]
    parts.append(_box(0, high, width, _LEGEND, 'fill="#ffffff"'))  # over zones that reach beyond the picture
    parts += _legend(picture, words, scale, high)
    return _svg(width, high + _LEGEND, parts, words("picture"))


@dataclass(frozen=True, slots=True)
class _Sheet:
    """Scale of a picture on paper, and the paper to its left."""

    scale: float
    left: float

    def at(self, place: Point) -> Point:
        return place[0] * self.scale + self.left, place[1] * self.scale

    def ring(self, places: Sequence[Point]) -> str:
        return " ".join(f"{x:.1f},{y:.1f}" for x, y in map(self.at, places))


_STATES: Final = (
    '<defs><pattern id="taken" width="5" height="5" patternUnits="userSpaceOnUse">'
    '<rect width="5" height="5" fill="#ff7a1a" fill-opacity=".12"/>'
    '<path d="M-1 6L6 -1M-1 1L1 -1M4 6L6 4" stroke="#ff7a1a" stroke-width="1.5"/></pattern></defs>'
)
_LOOKS: Final = {
    "free": 'fill="#2f8fff" fill-opacity=".46" stroke="#e3f1ff" stroke-width=".9"',
    "taken": 'fill="url(#taken)" stroke="#e05a00" stroke-width="1"',
    "unknown": 'fill="#10161c" fill-opacity=".45" stroke="#ffffff" stroke-width="1" stroke-dasharray="3 2"',
}
"""Looks of a state, which do not rest on colour alone."""


def _stalls(stalls: Sequence[DrawnStall], seen: _Sheet) -> Iterable[str]:
    """Yield the stalls of each state as one path: a PDF has a hatch of its own for each path."""
    rings: dict[str, list[str]] = {state: [] for state in _LOOKS}
    for each in stalls:
        rings[each.state if each.state in rings else "unknown"].append(f"M{seen.ring(each.corners)}Z")
    yield from (f'<path d="{"".join(rings[state])}" {look}/>' for state, look in _LOOKS.items() if rings[state])


def _number(stall: DrawnStall, seen: _Sheet, wide: float) -> Iterable[str]:
    x, y = seen.at((_mean([x for x, _ in stall.corners]), _mean([y for _, y in stall.corners])))
    size = min(8.0, wide * 0.5, 1.6 * wide / max(len(stall.number), 1))
    text = stall.number if stall.state in ("free", "taken") else f"{stall.number} ?"
    yield from _on_ground(text, x, y + size * 0.36, size)


def _on_ground(text: str, x: float, y: float, size: float) -> Iterable[str]:
    """Yield a text twice: its dark edge first, since not every reader paints the edge below the letters.

    Digits are centred by their width, which is one: WeasyPrint makes an object of each text that has another anchor
    than its start, and these would be most of a PDF.
    """
    is_number = text.isascii() and text.isdigit()
    x, anchor = (x - len(text) * size * _DIGIT / 2, "start") if is_number else (x, "middle")
    for paint in ('fill="#10161c" stroke="#10161c" stroke-width="2" stroke-linejoin="round"', 'fill="#ffffff"'):
        yield _text(x, y, text, anchor, size, f'font-weight="bold" {paint}')


def _zone_name(name: str, ring: Sequence[Point], seen: _Sheet, width: float, high: float) -> str:
    """Return the name of a zone on a plate below its lowest corner, within the picture."""
    room = int((width - 12) / (8.5 * _ZONE_LETTERS))
    name = name if len(name) <= room else name[: room - 1] + "\N{HORIZONTAL ELLIPSIS}"
    wide = len(name) * 8.5 * _ZONE_LETTERS + 12
    x, y = seen.at((_mean([x for x, _ in ring]), max(y for _, y in ring)))
    x, y = min(max(x, wide / 2), width - wide / 2), min(max(y, 0.0), high - 20)
    plate = f'<rect x="{x - wide / 2:.1f}" y="{y + 3:.1f}" width="{wide:.1f}" height="14" rx="7" fill="#ffffff"/>'
    return plate + _text(x, y + 13, name, "middle", 8.5)


def _letter(row: DrawnRow, seen: _Sheet, beyond: float, width: float, height: float) -> Iterable[str]:
    """Yield the name of a row on a plate that begins ``beyond`` the middle of its first stall."""
    name, radius = row.name, 8.0 if len(row.name) <= 2 else 3.2 * len(row.name)
    off = beyond + 1 + max(radius * abs(row.out[0]), 8 * abs(row.out[1]))
    x, y = seen.at(row.first)
    x, y = x + row.out[0] * off, y + row.out[1] * off
    x, y = min(max(x, radius + 1), width - radius - 1), min(max(y, 9.0), height - 9.0)
    yield (
        f'<rect x="{x - radius:.1f}" y="{y - 8:.1f}" width="{2 * radius:.1f}" height="16" rx="8" fill="#ffffff" '
        'stroke="#15202b" stroke-width="1"/>'
    )
    yield _text(x, y + 3.5, name, "middle", 9.5, 'font-weight="bold"')


def _legend(picture: LotPicture, words: Words, scale: float, top: float) -> Iterable[str]:
    """Yield north, scale and states below the picture, which they never cover."""
    metres = scale_bar_m(picture.metres / scale, 680)
    bar = metres / picture.metres * scale
    y = top + 3
    turn = f' transform="rotate(90 14 {y + 11:.1f})"' if picture.is_turned else ""
    yield f'<path d="M14 {y + 3:.1f}l5 16-5-4-5 4z" fill="#15202b"{turn}/>'
    yield _text(26, y + 15, words("north"), "start", 10)
    x = 44.0
    yield f'<path d="M{x:.1f} {y + 7:.1f}v8h{bar:.1f}v-8" fill="none" stroke="#15202b" stroke-width="1.6"/>'
    yield _text(x + bar + 6, y + 15, words("metres", metres=metres), "start", 10)
    x += bar + 56
    for state, name in (("free", "free"), ("taken", "taken"), ("unknown", "unclear")):
        yield _box(x, y + 5, 18, 12, 'fill="#5d6a75"' if state == "free" else 'fill="#16222c"')
        yield _box(x + 1, y + 6, 16, 10, _LOOKS[state])
        yield _text(x + 24, y + 15, words(name), "start", 10)
        x += 42 + len(words(name)) * 6


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)


# -- SVG ---------------------------------------------------------------------------------------------------------------


def _svg(width: float, height: float, parts: Iterable[str], title: str) -> Markup:
    """Return a drawing; the texts of its parts are escaped."""
    head = Markup('<svg class="drawing" viewBox="0 0 {} {}" width="{}" height="{}" role="img" aria-label="{}">').format(
        f"{width:.1f}", f"{height:.1f}", f"{width:.1f}", f"{height:.1f}", title
    )
    return head + Markup("".join(parts)) + Markup("</svg>")  # noqa: S704 - numbers, and texts that _text escaped


def _text(x: float, y: float, text: str, anchor: str, size: float = 10, more: str = "") -> str:
    return str(
        Markup('<text x="{}" y="{}" text-anchor="{}" font-size="{}" {}>{}</text>').format(
            f"{x:.1f}",
            f"{y:.1f}",
            anchor,
            f"{size:.1f}",
            Markup(more),  # noqa: S704 - words of this module
            text,
        )
    )


def _line(x: float, y: float, to_x: float, to_y: float, colour: str, width: float = 1.0) -> str:
    return (
        f'<path d="M{x:.1f} {y:.1f}L{to_x:.1f} {to_y:.1f}" stroke="{colour}" stroke-width="{width:.1f}" fill="none"/>'
    )


def _box(x: float, y: float, width: float, height: float, look: str) -> str:
    return f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" {look}/>'
