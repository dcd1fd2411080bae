"""The table of faults as Markdown, and its place in a page."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Final

from proving.faults.fault import (
    Act,
    Bring,
    CountAgain,
    Disk,
    Drone,
    Fault,
    Flood,
    Forge,
    HalfRequests,
    KillMotors,
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
    WallClock,
)

BEGIN: Final = "<!-- `make faults` writes from here ... -->"
END: Final = "<!-- ... to here -->"
_HEAD: Final = "| fault | when | must be seen after it | seen after, s | nothing lost |\n|---|---|---|---|---|"


def table(outcomes: Iterable[Outcome]) -> str:
    """Return a row for each fault."""
    return "\n".join([_HEAD, *(_row(outcome) for outcome in outcomes)])


def merged(page: Path, outcomes: Sequence[Outcome], order: Sequence[Fault], mark: str) -> str:
    """Return the table of a page's section with the rows of these outcomes in place of those before, in this order.

    A row is known by its fault and when it happens. Rows that are in neither are left out.
    """
    _, _, rest = page.read_text().partition(mark)
    rows = {_key(row): row for row in rest.partition(END)[0].splitlines() if row.startswith("| ")}
    rows |= {_key(row): row for row in map(_row, outcomes)}
    known = [_key(_row(Outcome(fault))) for fault in order]
    return "\n".join([_HEAD, *(rows[key] for key in known if key in rows)])


def _key(row: str) -> tuple[str, ...]:
    return tuple(cell.strip() for cell in row.split("|")[1:3])


def rewrite(page: Path, text: str, mark: str = BEGIN) -> None:
    """Replace the section of a page that begins with a mark. Raises ValueError when it has none."""
    before, begin, rest = page.read_text().partition(mark)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"{page} has no section between {mark!r} and {END!r}: add the two lines")
    page.write_text(f"{before}{mark}\n\n{text}\n\n{END}{after}")


def reporter(page: Path | None, order: Sequence[Fault], mark: str = BEGIN) -> Callable[[Outcome], None]:
    """Return what prints an outcome and writes its row at once: a run that is broken off has lost none.

    Args:
        page: The page with the table; None: nothing is written.
        order: The faults in the order of their rows.
        mark: Begin of the page's section.
    """

    def report(outcome: Outcome) -> None:
        print(line(outcome), flush=True)
        if page is not None:
            rewrite(page, merged(page, (outcome,), order, mark), mark)

    return report


def line(outcome: Outcome) -> str:
    """Return an outcome in a line for the terminal."""
    mark = "ok    " if outcome.passed else "FAILED"
    seen = [*(f"{value:g} s" for value in outcome.seconds), *outcome.figures]
    tail = ", ".join(seen) if outcome.passed else "; ".join(outcome.problems)
    return f"{mark} {outcome.fault.when.value}: {outcome.fault.name}: {tail}"


def _row(outcome: Outcome) -> str:
    fault = outcome.fault
    seen = ", ".join(f"{value:g}" for value in outcome.seconds) or "-"
    seen = "; ".join((seen, *outcome.figures))
    end = ", ".join(outcome.kept) if outcome.passed else f"**failed**: {'; '.join(outcome.problems)}"
    cells = (fault.name, fault.when.value, _steps(fault.steps), seen, end)
    return "| " + " | ".join(cell.replace("|", "/") for cell in cells) + " |"


def _steps(steps: Sequence[Act | See]) -> str:
    """Return the sights in order, with the acts that come between them."""
    parts: list[str] = []
    for number, step in enumerate(steps):
        if isinstance(step, See):
            parts.append(step.words)
        elif any(isinstance(former, See) for former in steps[:number]):
            parts.append(f"then {act(step)}")
    return "; ".join(parts)


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
    return [f"{fault.when.value}: {fault.name}" for fault in faults]
