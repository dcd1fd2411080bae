"""The result of one check, and how checks run: at the same time, each with a deadline."""

from __future__ import annotations

import asyncio
import contextlib
import json
import threading
from collections import Counter
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final, TypeVar

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from hawk.runtime.repeated_log import plain

T = TypeVar("T")

END_S: Final = 2.0
"""Real seconds in which a check that passed its deadline must release what it holds."""


class Outcome(StrEnum):
    """Verdict of a check."""

    PASSED = "passed"
    WARNING = "warning"
    FAILED = "failed"
    NOT_LOOKED_AT = "not looked at"


@dataclass(frozen=True, slots=True)
class CheckResult:
    """One check: ``value`` states in a sentence what was found, ``remedy`` what to do; it is empty when all is well."""

    name: str
    outcome: Outcome
    value: str
    remedy: str = ""

    @property
    def is_well(self) -> bool:
        """True for a check that was made and found nothing that stops a flight."""
        return self.outcome in (Outcome.PASSED, Outcome.WARNING)


def passed(name: str, value: str) -> CheckResult:
    """Return a check that found everything well."""
    return CheckResult(name, Outcome.PASSED, value)


def warning(name: str, value: str, remedy: str) -> CheckResult:
    """Return a check that found something to know; it stops no flight."""
    return CheckResult(name, Outcome.WARNING, value, remedy)


def failed(name: str, value: str, remedy: str) -> CheckResult:
    """Return a check that found something to put right."""
    return CheckResult(name, Outcome.FAILED, value, remedy)


def not_looked_at(name: str, value: str, remedy: str = "") -> CheckResult:
    """Return a check that could not be made: it has not passed."""
    return CheckResult(name, Outcome.NOT_LOOKED_AT, value, remedy)


def all_passed(results: Sequence[CheckResult]) -> bool:
    """Return True when every check was made and none failed."""
    return bool(results) and all(each.is_well for each in results)


@dataclass(frozen=True, slots=True)
class Look:
    """A check to make: ``work`` returns its results within ``deadline_s`` real seconds."""

    name: str
    work: Callable[[], Awaitable[Sequence[CheckResult]]]
    deadline_s: float


async def run_look(look: Look) -> list[CheckResult]:
    """Return a check's results; a failed one when it passes its deadline or ends by a fault of its own."""
    task = asyncio.ensure_future(look.work())
    try:
        await asyncio.wait({task}, timeout=look.deadline_s)
        if task.done():
            return list(task.result())
    except Exception as error:  # the other checks are still of use
        return [failed(look.name, f"The check ended by a fault: {type(error).__name__}: {error}.", "Report it.")]
    finally:
        if not task.done():
            task.cancel()
            await asyncio.wait({task}, timeout=END_S)
    return [failed(look.name, f"No result came within {look.deadline_s:g} s.", "Check again; is the computer busy?")]


async def run_looks(looks: Sequence[Look]) -> list[CheckResult]:
    """Make all checks at the same time; return the results in the order of the checks."""
    found = await asyncio.gather(*(run_look(look) for look in looks))
    return [result for results in found for result in results]


async def on_thread(function: Callable[[], T]) -> T:
    """Return what a blocking function returns, from a thread that nobody waits for when it hangs."""
    loop = asyncio.get_running_loop()
    outcome: asyncio.Future[T] = loop.create_future()

    def settle(value: T | None, error: Exception | None) -> None:
        if outcome.done():
            return
        if error is not None:
            outcome.set_exception(error)
        else:
            outcome.set_result(value)  # type: ignore[arg-type]

    def work() -> None:
        value, error = None, None
        try:
            value = function()
        except Exception as caught:
            error = caught
        with contextlib.suppress(RuntimeError):  # the loop has ended
            loop.call_soon_threadsafe(settle, value, error)

    threading.Thread(target=work, name=f"check: {getattr(function, '__name__', '')}", daemon=True).start()
    return await outcome


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
