"""docs/faults.md: faults by subject as a person at the page needs them, each row tied to its flights."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from itertools import groupby
from typing import Final

from proving.faults.fault import Answer, Fault, Outcome, See, Subject

_MEASURED: Final = re.compile(r"\{([^}]+)\}")
_HEAD: Final = "| fault | the drone | you | flights |\n|---|---|---|---|"


class PageError(ValueError):
    """A row that its flights do not carry; the text names it."""


def rows(faults: Iterable[Fault]) -> dict[Answer, tuple[str, ...]]:
    """Return each answer with the names of its faults, by subject, in the order of the faults."""
    named: dict[Answer, dict[str, None]] = {}
    for fault in faults:
        if fault.answer is not None:
            named.setdefault(fault.answer, {})[fault.name] = None
    order = list(Subject)
    return {answer: tuple(named[answer]) for answer in sorted(named, key=lambda each: order.index(each.subject))}


def section(flown: Mapping[Answer, Sequence[str]], outcomes: Sequence[Outcome]) -> str:
    """Return the page's section: a table a subject, with what was measured (``flown``: `rows`). Raises PageError."""
    parts: list[str] = []
    for subject, answers in groupby(flown, key=lambda each: each.subject):
        lines = [_line(answer, flown[answer], outcomes) for answer in answers]
        parts.append("\n".join([f"## {subject}\n", _HEAD, *lines, ""]))
    return "\n".join(parts).rstrip()


def _line(row: Answer, names: Sequence[str], outcomes: Sequence[Outcome]) -> str:
    flights = [outcome for outcome in outcomes if outcome.fault.name in names]
    for name in set(names) - {flight.fault.name for flight in flights}:
        raise PageError(f"{row.fault!r}: {name!r} was not flown: make faults ARGS='\"{name}\"'")
    drone = _MEASURED.sub(lambda found: _measured(row, found[1], flights), row.drone)
    failed = sum(not flight.passed for flight in flights)
    count = f"{len(flights)}, **{failed} failed**" if failed else str(len(flights))
    return f"| {row.fault} | {drone} | {row.you} | {count} |"


def _measured(row: Answer, words: str, flights: Sequence[Outcome]) -> str:
    """Return the least and the greatest number of seconds until a sight with these words."""
    seconds = sorted(value for flight in flights for value in _seconds_until(flight, words))
    if not seconds and not all(flight.passed for flight in flights):
        return "**not seen**"
    if not seconds:
        raise PageError(f"{row.fault!r}: no flight of it saw {words!r}")
    least, most = f"{seconds[0]:g}", f"{seconds[-1]:g}"
    return f"{least} s" if least == most else f"{least} s to {most} s"


def _seconds_until(flight: Outcome, words: str) -> Iterator[float]:
    """Yield the seconds until each sight with these words; a sight of several is known by each of them, too."""
    sights = (step for step in flight.fault.steps if isinstance(step, See))
    for see, value in zip(sights, flight.seconds, strict=False):
        parts = (see.sight.words, *see.sight.words.split(", "))
        if not see.lasts and any(fnmatchcase(part, words) for part in parts):
            yield value
