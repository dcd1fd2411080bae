"""Outcomes of faults in words: lines for the terminal, tables in Markdown, and their place in a page."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Final

from proving.faults.fault import (
    Act,
    Bring,
    ChangeLot,
    CountAgain,
    Disk,
    Drone,
    Fault,
    Flood,
    Forge,
    HalfRequests,
    Hide,
    KillMotors,
    KnowLot,
    Leave,
    Link,
    Order,
    Outcome,
    Return,
    SecondDaemon,
    See,
    Signal,
    StartAgain,
    Station,
    Survey,
    TakePlan,
    WallClock,
)
from proving.faults.record import name_of

BEGIN: Final = "<!-- `make faults` writes from here ... -->"
END: Final = "<!-- ... to here -->"


def table(outcomes: Iterable[Outcome]) -> str:
    """Return a row for each outcome: what had to be seen with its limit, when it was seen, and what was not lost."""
    head = "| fault | when | seen after it, of the time allowed | nothing lost |\n|---|---|---|---|"
    return "\n".join([head, *(_row(outcome, ", ".join(outcome.kept) or "-") for outcome in outcomes)])


def short_table(outcomes: Iterable[Outcome]) -> str:
    """Return a row for each outcome with what was seen and when alone, without acts, limits and sights that last."""
    rows = (f"| {each.fault.name} | {each.fault.when.value} | {_times(each)} |" for each in outcomes)
    return "\n".join(["| fault | when | seen after it, or after the last act, s |", "|---|---|---|", *rows])


def _times(outcome: Outcome) -> str:
    sights = (step for step in outcome.fault.steps if isinstance(step, See))
    timed = zip(sights, outcome.seconds, strict=False)
    seen = (f"{see.sight.words}: {value:g}" for see, value in timed if not see.lasts)
    return "; ".join((*seen, *outcome.figures, *_failed(outcome)))


def rewrite(page: Path, text: str, mark: str = BEGIN) -> None:
    """Replace the section of a page that begins with a mark. Raises ValueError when it has none."""
    page.write_text(rewritten(page.read_text(encoding="utf-8"), text, mark), encoding="utf-8")


def rewritten(page: str, text: str, mark: str = BEGIN) -> str:
    """Return a page's text with another section behind a mark. Raises ValueError when it has none."""
    before, begin, rest = page.partition(mark)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"the page has no section between {mark!r} and {END!r}: add the two lines")
    return f"{before}{mark}\n\n{text}\n\n{END}{after}"


def reporter(keep: Callable[[Outcome], None]) -> Callable[[Outcome], None]:
    """Return a function that prints an outcome and keeps it at once: a run that is broken off loses none."""

    def report(outcome: Outcome) -> None:
        print(line(outcome), flush=True)
        keep(outcome)

    return report


def line(outcome: Outcome) -> str:
    """Return an outcome in a line for the terminal."""
    mark = "ok    " if outcome.passed else "FAILED"
    seen = [*(f"{value:g} s" for value in outcome.seconds), *outcome.figures]
    tail = ", ".join(seen) if outcome.passed else "; ".join(outcome.problems)
    return f"{mark} {outcome.fault.when.value}: {outcome.fault.name}: {tail}"


def _row(outcome: Outcome, *more: str) -> str:
    cells = (outcome.fault.name, outcome.fault.when.value, _seen(outcome), *more)
    return "| " + " | ".join(cell.replace("|", "/") for cell in cells) + " |"


def _seen(outcome: Outcome) -> str:
    """Return the sights in order, each with its seconds and limit, the acts that come between them, and problems."""
    parts: list[str] = []
    seconds = iter(outcome.seconds)
    has_seen = False
    for step in outcome.fault.steps:
        if isinstance(step, See):
            has_seen = True
            parts.append(step.words_with(next(seconds, None)))
        elif has_seen and not isinstance(step, CountAgain):
            parts.append(f"then {act(step)}")
    return "; ".join((*parts, *outcome.figures, *_failed(outcome)))


def _failed(outcome: Outcome) -> tuple[str, ...]:
    return () if outcome.passed else (f"**failed**: {'; '.join(outcome.problems)}",)


def act(step: Act) -> str:
    """Return an act in words."""
    match step:
        case Link(rules):
            return "the link fails" if rules else "the link is well again"
        case Drone(values):
            return ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in values.items())
        case Forge(kind) | Station(kind):
            return f"another {kind}"
        case Signal(number):
            return f"signal {number}"
        case StartAgain():
            return "the daemon is started again"
        case CountAgain():
            return "counted from here"
        case Survey():
            return "a survey"
        case Order(command):
            return f"the order {command.type}"
        case KillMotors():
            return "the operator cuts the motors"
        case Leave():
            return "the operator is gone"
        case Return():
            return "the operator takes control"
        case Hide(hidden):
            return "the operator's page is hidden" if hidden else "the operator's page is shown again"
        case KnowLot():
            return "a known lot is surveyed again"
        case ChangeLot(what):
            return f"somebody changes the lot's {what}"
        case TakePlan(stranger):
            return f"{'somebody else' if stranger else 'the operator'} takes the changed plan"
        case Bring(when):
            return f"the drone is {when.value}"
        case SecondDaemon(shared):
            return "a second daemon on the same store" if shared else "a second daemon on the same autopilot"
        case Disk(full):
            return "the disk is full" if full else "the disk has room again"
        case WallClock(step_s):
            return f"the wall clock is off by {step_s:g} s"
        case HalfRequests(count):
            return f"{count} half requests"
        case Flood(command, count):
            return f"{count} times {command.type}"


def summary(outcomes: Sequence[Outcome]) -> str:
    """Return how many ended as they must."""
    return f"{sum(outcome.passed for outcome in outcomes)} of {len(outcomes)} faults ended as they must"


def names(faults: Iterable[Fault]) -> list[str]:
    """Return what identifies each fault."""
    return [name_of(fault) for fault in faults]
