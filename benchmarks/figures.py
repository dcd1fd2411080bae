"""Results of a benchmark: figures with their references and limits, as one table and as one flat JSON object."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

from rich.console import Console
from rich.table import Table

MISSING: Final = "–"
TABLE_COLUMNS: Final = 130
"""Width of a table that goes into a file."""


class BenchmarkError(Exception):
    """A section could not be measured; the text says why and where to look."""


@dataclass(frozen=True, slots=True)
class Reference:
    """A named figure of the same run with which another one is compared."""

    name: str
    value: float | None


@dataclass(frozen=True, slots=True)
class Limit:
    """Limits of a figure: a lowest or a highest value, or both."""

    lowest: float = -math.inf
    highest: float = math.inf

    def holds(self, value: float | None) -> bool:
        """Return True when the value was measured and lies within the limits; NaN does not."""
        return value is not None and self.lowest <= value <= self.highest

    def __str__(self) -> str:
        parts = []
        if self.lowest > -math.inf:
            parts.append(f"≥ {number(self.lowest)}")
        if self.highest < math.inf:
            parts.append(f"≤ {number(self.highest)}")
        return ", ".join(parts)


@dataclass(frozen=True, slots=True)
class Figure:
    """One measured figure. ``key`` is its name in JSON; ``value`` is None when it could not be measured."""

    key: str
    text: str
    value: float | None
    unit: str = ""
    reference: Reference | None = None
    limit: Limit | None = None

    @property
    def ratio(self) -> float | None:
        """The value by its reference; None without one, or when the reference is zero."""
        if self.reference is None or not self.reference.value or self.value is None:
            return None
        return self.value / self.reference.value

    @property
    def passed(self) -> bool | None:
        """True when the limit holds; None without one."""
        return None if self.limit is None else self.limit.holds(self.value)


@dataclass(frozen=True, slots=True)
class Section:
    """The figures of one part of the benchmark. ``problem``: why it is void or was not measured at all."""

    name: str
    figures: Sequence[Figure]
    problem: str = ""


def interval_jitter(arrivals: Sequence[float], interval_s: float) -> list[float]:
    """Return by how many milliseconds each interval between arrivals (seconds) is off, without sign."""
    return [abs(later - earlier - interval_s) * 1e3 for earlier, later in pairwise(arrivals)]


def share(part: float, whole: float) -> float | None:
    """Return a part of a whole; None of nothing."""
    return part / whole if whole else None


def number(value: float | None) -> str:
    """Return a figure for people: three significant digits, no exponent."""
    if value is None or math.isnan(value):
        return MISSING
    if value == 0 or abs(value) >= 100:
        return f"{value:.0f}"
    digits = max(0, 2 - math.floor(math.log10(abs(value))))
    text = f"{value:.{min(digits, 4)}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def flat(sections: Iterable[Section]) -> dict[str, float | None]:
    """Return every figure by its key, references too where they have one of their own. Raises ValueError on a clash."""
    values: dict[str, float | None] = {}
    for section in sections:
        for figure in section.figures:
            if figure.key in values:
                raise ValueError(f"two figures are called {figure.key}")
            finite = figure.value is not None and math.isfinite(figure.value)
            values[figure.key] = figure.value if finite else None
    return values


def write_json(path: Path, values: Mapping[str, object]) -> None:
    """Write the flat object."""
    path.write_text(json.dumps(values, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def print_and_write(sections: Sequence[Section], path: Path | None, **more: object) -> int:
    """Print everything as one table, and write it to ``path`` as one flat object with ``more`` beside the figures.

    Returns 1 when a figure lies outside its limits, 0 otherwise: the status of a program.
    """
    print_table(sections, Console(width=None if sys.stdout.isatty() else TABLE_COLUMNS))
    if path is not None:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_json(path, {**flat(sections), **more})
    return int(missed(sections))


def missed(sections: Iterable[Section]) -> bool:
    """Return True when a figure lies outside its limits."""
    return any(figure.passed is False for section in sections for figure in section.figures)


def print_table(sections: Sequence[Section], console: Console) -> None:
    """Print everything as one table, then what was void."""
    table = Table("", "figure", "", "reference", "ratio", "limit", "", title="hawk-drone benchmarks")
    for column in (1, 4):
        table.columns[column].justify = "right"
    for section in sections:
        table.add_section()
        table.add_row(f"[bold]{section.name}[/bold]", "", "", "", "", "", "")
        for figure in section.figures:
            table.add_row(*_row(figure))
    console.print(table)
    for section in sections:
        if section.problem:
            console.print(f"{section.name}: {section.problem}", markup=False)


def _row(figure: Figure) -> tuple[str, ...]:
    reference = "" if figure.reference is None else f"{figure.reference.name} {number(figure.reference.value)}"
    ratio = "" if figure.ratio is None else f"{figure.ratio:.2f}"
    verdict = {None: "", True: "ok", False: "MISSED"}[figure.passed]
    limit = "" if figure.limit is None else str(figure.limit)
    return figure.text, number(figure.value), figure.unit, reference, ratio, limit, verdict
