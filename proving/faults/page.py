"""docs/faults.md: faults by subject as a person at the page needs them, each row tied to its flights."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Final

from proving.faults.fault import Answer, Fault, Outcome, See

_MEASURED: Final = re.compile(r"\{([^}]+)\}")
_HEAD: Final = "| fault | the drone | you | flights |\n|---|---|---|---|"


class PageError(ValueError):
    """A row that its flights do not carry; the text names it."""


@dataclass(frozen=True, slots=True)
class Row:
    """Faults that the drone answers alike.

    ``drone`` is its answer; ``{WORDS}`` in it stands for the seconds until a sight with these words (a pattern as of
    file names) in the row's flights, the least and the greatest. ``you``: what the operator sees and does. ``flown``:
    names of the faults of `proving.faults.run.ALL` that belong to it, whenever they happen.
    """

    fault: str
    drone: str
    you: str
    flown: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Subject:
    """Rows about one part of the drone."""

    title: str
    rows: tuple[Row, ...]


def with_answers(subjects: Iterable[Subject], faults: Iterable[Fault]) -> tuple[Subject, ...]:
    """Return the subjects with the rows that faults bring themselves, behind those of their subject; new ones last."""
    rows = {subject.title: list(subject.rows) for subject in subjects}
    named: dict[Answer, dict[str, None]] = {}
    for fault in faults:
        if fault.answer is not None:
            named.setdefault(fault.answer, {})[fault.name] = None
    for answer, names in named.items():
        rows.setdefault(answer.subject, []).append(Row(answer.fault, answer.drone, answer.you, tuple(names)))
    return tuple(Subject(title, tuple(found)) for title, found in rows.items())


def section(subjects: Iterable[Subject], outcomes: Sequence[Outcome]) -> str:
    """Return the page's section: a table a subject, with what was measured. Raises PageError."""
    parts: list[str] = []
    for subject in subjects:
        parts.append(f"## {subject.title}\n")
        parts.append("\n".join([_HEAD, *(_line(row, outcomes) for row in subject.rows)]) + "\n")
    return "\n".join(parts).rstrip()


def _line(row: Row, outcomes: Sequence[Outcome]) -> str:
    flights = [outcome for outcome in outcomes if outcome.fault.name in row.flown]
    for name in set(row.flown) - {flight.fault.name for flight in flights}:
        raise PageError(f"{row.fault!r}: {name!r} was not flown: make faults ARGS='\"{name}\"'")
    drone = _MEASURED.sub(lambda found: _measured(row, found[1], flights), row.drone)
    failed = sum(not flight.passed for flight in flights)
    count = f"{len(flights)}, **{failed} failed**" if failed else str(len(flights))
    return f"| {row.fault} | {drone} | {row.you} | {count} |"


def _measured(row: Row, words: str, flights: Sequence[Outcome]) -> str:
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
