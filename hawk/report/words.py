"""Words of a report in its language: messages (Fluent), and numbers, days and names of days (Babel)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from datetime import date, datetime, time
from functools import lru_cache
from importlib.resources import files
from typing import Final

from babel import Locale
from babel.dates import format_date, format_datetime, format_time, format_timedelta
from babel.lists import format_list
from babel.numbers import format_decimal, format_percent
from fluent.runtime import FluentBundle, FluentResource

from hawk.report.options import Language
from hawk.stats.serialize import runs_of
from hawk.stats.use_query import Asked
from hawk.stats.values import NO_ROW, NO_ZONE, WEEKDAYS, Estimate, Weekday

NONE: Final = "–"
"""Text of what nobody flew."""
_UNIT: Final = "\N{NO-BREAK SPACE}%"
_PERCENT: Final = "#,##0" + _UNIT
_DAY: Final = "EEE d MMM"
_DAY_YEAR: Final = "EEE d MMM y"
_DATE_YEAR: Final = "d MMM y"
_MOMENT: Final = "EEE d MMM, HH:mm"
_MOMENT_YEAR: Final = "EEE d MMM y, HH:mm"


@lru_cache
def resource(language: Language) -> str:
    """Return the messages of a language, as their file has them."""
    return files("hawk.report").joinpath(f"messages/{language}.ftl").read_text("utf-8")


@lru_cache
def _bundle(language: Language) -> FluentBundle:
    bundle = FluentBundle([language], use_isolating=False)
    bundle.add_resource(FluentResource(resource(language)))
    return bundle


class Words:
    """Messages, numbers and times as a report of one language shows them."""

    def __init__(self, language: Language) -> None:
        self.language = language
        self.locale = Locale.parse(language)
        self._bundle = _bundle(language)

    def __call__(self, name: str, **values: object) -> str:
        """Return a message with its values. Raises LookupError for one that there is not, or that lacks a value."""
        pattern = self._bundle.get_message(name).value
        if pattern is None:
            raise LookupError(f"{name}: has no words in {self.language}")
        text, errors = self._bundle.format_pattern(pattern, values)
        if errors:
            raise LookupError(f"{name}: {errors[0]}")
        return str(text)

    # -- figures --------------------------------------------------------------------------------------------------

    def count(self, number: int) -> str:
        """Return a whole number."""
        return str(format_decimal(number, locale=self.locale))

    def share(self, found: Estimate) -> str:
        """Return a share as percent."""
        return NONE if found.value is None else str(format_percent(round(found.value, 2), _PERCENT, self.locale))

    def shares(self, found: Estimate) -> str:
        """Return the ends of a share's interval, with a decimal where they differ by less; the unit stands once."""
        if found.low is None or found.high is None:
            return NONE
        digits = 1 if round(found.low, 2) == round(found.high, 2) else 0
        low, high = (round(each, 2 + digits) for each in (found.low, found.high))
        form = "#,##0.0" if digits else "#,##0"
        shown = format_percent(high, form + _UNIT, self.locale, decimal_quantization=False)
        return self("range", low=str(format_decimal(100 * low, form, self.locale)), high=str(shown))

    def amount(self, found: Estimate) -> str:
        """Return a number of stalls."""
        return NONE if found.value is None else self.count(round(found.value))

    def amounts(self, found: Estimate) -> str:
        """Return the ends of the interval of a number of stalls."""
        if found.low is None or found.high is None:
            return NONE
        return self("range", low=self.count(round(found.low)), high=self.count(round(found.high)))

    def mean(self, number: float | None) -> str:
        """Return a mean number of vehicles, with a decimal."""
        return NONE if number is None else str(format_decimal(round(number, 1), "#,##0.0", self.locale))

    def means(self, found: Estimate) -> str:
        """Return the ends of the interval of a mean number."""
        if found.low is None or found.high is None:
            return NONE
        return self("range", low=self.mean(found.low), high=self.mean(found.high))

    def places(self, places: int | None) -> str:
        """Return the places of sections, where they are known."""
        return NONE if places is None else self.count(places)

    # -- times ----------------------------------------------------------------------------------------------------

    def moment(self, at: datetime, *, with_year: bool = False) -> str:
        """Return a moment, to the minute; it is on the clock of the report already."""
        return str(format_datetime(at.replace(tzinfo=None), _MOMENT_YEAR if with_year else _MOMENT, locale=self.locale))

    def day(self, day: date, *, with_year: bool = False) -> str:
        """Return a day, shortly."""
        return str(format_date(day, _DAY_YEAR if with_year else _DAY, self.locale))

    def month(self, day: date) -> str:
        """Return the month of a day, shortly."""
        return str(format_date(day, "MMM y", self.locale))

    def period(self, first: date, last: date) -> str:
        """Return the days of a period; what both ends share stands once."""
        end = str(format_date(last, _DATE_YEAR, self.locale))
        if first == last:
            return end
        form = "d" if (first.year, first.month) == (last.year, last.month) else "d MMM"
        begin = format_date(first, form if first.year == last.year else _DATE_YEAR, self.locale)
        return self("period", first=str(begin), last=end)

    def age(self, at: datetime, now: datetime) -> str:
        """Return how long ago a moment was."""
        return str(format_timedelta(at - now, granularity="minute", add_direction=True, locale=self.locale))

    def due(self, at: datetime | None, now: datetime) -> str:
        """Return when a survey is due."""
        if at is None:
            return NONE
        when = self.moment(at)
        return self("due-since", when=when) if at <= now else when

    def clock_time(self, hour: int) -> str:
        """Return an hour of the day; 24 is the end of it."""
        return f"{hour}:00" if hour == 24 else str(format_time(time(hour), "H:mm", locale=self.locale))

    def weekday(self, day: Weekday, *, is_short: bool = False) -> str:
        """Return the name of a day of the week."""
        names = self.locale.days["stand-alone"]["abbreviated" if is_short else "wide"]
        return str(names[WEEKDAYS.index(day)])

    # -- the question ---------------------------------------------------------------------------------------------

    def listed(self, names: Iterable[str]) -> str:
        """Return names as a list with "and"."""
        return str(format_list(list(names), locale=self.locale))

    def part(self, asked: Asked) -> str:
        """Return the part of the lot that is asked."""
        found = [
            self(f"part-{kind}s", count=len(names), names=self.listed(names))
            for kind, names in (
                ("row", asked.rows), ("zone", tuple(self.name("zone", each) for each in asked.zones)),
                ("kind", tuple(self.name("kind", each) for each in asked.kinds)),
            )
            if names
        ]  # fmt: skip
        return ", ".join(found) or self("part-lot")

    def question(self, asked: Asked, part: str = "") -> str:
        """Return a question; ``part``: of what it asks, that of the question without it."""
        return self(
            "asked", part=part or self.part(asked), days=self._days(asked.weekdays), hours=self._hours(asked.hours)
        )

    def _days(self, days: Sequence[Weekday]) -> str:
        if len(days) == len(WEEKDAYS):
            return self("any-day")
        numbers = [WEEKDAYS.index(day) for day in days]
        runs = [
            self.weekday(WEEKDAYS[first]) if first == last
            else self("days-run", first=self.weekday(WEEKDAYS[first]), last=self.weekday(WEEKDAYS[last]))
            for first, last in runs_of(numbers)
        ]  # fmt: skip
        return self("days", runs=self.listed(runs))

    def _hours(self, hours: Sequence[int]) -> str:
        if len(hours) == 24:
            return self("any-hour")
        runs = [
            self("hours-run", first=self.clock_time(first), last=self.clock_time(last + 1))
            for first, last in runs_of(hours)
        ]
        return self("hours", runs=self.listed(runs))

    def name(self, by: str, name: str) -> str:
        """Return the name of a row, zone or kind; those that the statistics gave are in the report's language."""
        if by == "kind":
            return self("kind", kind=name)
        return self(_OWN[by, name]) if (by, name) in _OWN else name


_OWN: Final = {("row", NO_ROW): "other-row", ("zone", NO_ZONE): "no-zone"}
