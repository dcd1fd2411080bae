"""Shows the results: a table for a person, JSON for a program."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from typing import Any, Final

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hawk.check.result import CheckResult, Outcome, all_passed
from hawk.runtime.plain_text import plain

_STYLES: Final = {
    Outcome.PASSED: "green",
    Outcome.WARNING: "yellow",
    Outcome.FAILED: "bold red",
    Outcome.NOT_LOOKED_AT: "dim",
}


def as_object(results: Sequence[CheckResult]) -> dict[str, Any]:
    """Return the results as JSON holds them: ``checks`` and ``passed``."""
    checks = [
        {"name": each.name, "outcome": each.outcome.value, "value": plain(each.value), "remedy": plain(each.remedy)}
        for each in results
    ]
    return {"checks": checks, "passed": all_passed(results)}


def print_json(console: Console, results: Sequence[CheckResult]) -> None:
    """Print one JSON object."""
    console.out(json.dumps(as_object(results), indent=2), highlight=False)


def print_table(console: Console, results: Sequence[CheckResult]) -> None:
    """Print a row for each check, its remedy below the value, and a last line."""
    table = Table(box=box.SIMPLE, pad_edge=False, show_header=False)
    table.add_column(no_wrap=True)
    table.add_column(no_wrap=True)
    table.add_column(ratio=1)
    for each in results:
        words = Text(plain(each.value))
        if each.remedy:
            words.append(f"\n{plain(each.remedy)}", style="bold")
        table.add_row(Text(each.outcome.value, style=_STYLES[each.outcome]), Text(each.name), words)
    console.print(table)
    console.print(Text(last_line(results)))


def last_line(results: Sequence[CheckResult]) -> str:
    """Return the sum in one line."""
    count = Counter(each.outcome for each in results)
    parts = [f"{count[outcome]} {outcome.value}" for outcome in Outcome if count[outcome]]
    end = "The daemon can be started." if all_passed(results) else "Put right what failed, then check again."
    return f"{', '.join(parts)}. {end}"
