"""The last flight, read from the lines of `hawk.daemon.flight_trace` in the journal (journalctl -o json)."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Final

from hawk.runtime.program_log import TRACE

LINES: Final = 20_000
"""Lines of the journal that are looked through: some hundred flights, or one with a fault that is logged often."""
COMMAND: Final = ("journalctl", "-u", "hawk-drone", "-n", str(LINES), "--no-pager", "-o", "json")
_WARNING: Final = 4
"""Priority of syslog; lower is worse."""
NO_FLIGHT: Final = "The journal holds no flight."


@dataclass(frozen=True, slots=True)
class Line:
    """A line of the journal: ``when`` seconds since 1970, ``priority`` as syslog's, ``run`` boot and process."""

    when: float
    priority: int
    run: tuple[str, str]
    text: str

    @property
    def event(self) -> str:
        """Name of the trace's event; empty for a line of another logger."""
        mark = f"{TRACE}: "
        return self.text.removeprefix(mark).partition(": ")[0] if self.text.startswith(mark) else ""

    @property
    def words(self) -> str:
        """The event's words."""
        return self.text.removeprefix(f"{TRACE}: ").partition(": ")[2]


def read_journal(text: str) -> list[Line]:
    """Return the lines that ``journalctl -o json`` printed; what cannot be read is left out."""
    found = (_line(each) for each in text.splitlines())
    return [line for line in found if line is not None]


def _line(text: str) -> Line | None:
    try:
        entry: dict[str, Any] = json.loads(text)
        message = entry["MESSAGE"]
        if isinstance(message, list):  # bytes, where it is not plain text
            message = bytes(message).decode("utf-8", "replace")
        run = (str(entry.get("_BOOT_ID", "")), str(entry.get("_PID", "")))
        when = int(entry["__REALTIME_TIMESTAMP"]) / 1e6
        return Line(when, int(entry.get("PRIORITY", 6)), run, str(message))
    except (ValueError, KeyError, TypeError, AttributeError):
        return None


def last_flight(lines: Sequence[Line]) -> list[Line]:
    """Return the lines from the last Arm to the end of its flight, with the start before it; none without a flight.

    A flight ends when the motors are off. A program that ends in the air and starts again goes on with it.
    """
    begun = [number for number, line in enumerate(lines) if line.event == "arm"]
    if not begun:
        return []
    first = begun[-1]
    after = (number for number in range(first + 1, len(lines)) if lines[number].event == "disarm")
    last = next(after, len(lines) - 1)
    start = max((number for number in range(first) if lines[number].event == "start"), default=first)
    kept = [lines[start]] if start < first else []
    flown = [line for line in lines[first : last + 1] if line.event or line.priority <= _WARNING]
    return kept + flown


def tell(lines: Sequence[Line]) -> str:
    """Return the flight in words: when, how long, how it ended, then each line with its time."""
    armed = next((line for line in lines if line.event == "arm"), None)
    if armed is None:
        return f"{NO_FLIGHT}\n"
    last = lines[-1]
    ended = "The motors were off at its end" if last.event == "disarm" else "The journal does not hold its end"
    landing = next((line for line in reversed(lines) if line.event == "landing"), None)
    faults = _worst(line for line in lines if line.priority <= _WARNING and not line.text.startswith(" "))
    parts = [
        f"Last flight: {_time(armed.when)} to {_time(last.when)}, {last.when - armed.when:.0f} s.",
        f"Landed {landing.words}." if landing is not None else "No landing is noted.",
        f"{ended}.",
        f"{len(faults)} warnings and faults{': ' + '; '.join(faults[:5]) if faults else ''}.",
    ]
    runs = len({line.run for line in lines[lines.index(armed) :]})
    if runs > 1:
        parts.insert(1, f"The program was started {runs - 1} times in this flight.")
    return "\n".join([" ".join(parts), "", *(f"{_time(line.when)} {line.text}" for line in lines)]) + "\n"


def _worst(lines: Iterable[Line]) -> list[str]:
    return list(dict.fromkeys(line.text.removeprefix(f"{TRACE}: ").strip() for line in lines))


def _time(when: float) -> str:
    return datetime.fromtimestamp(when, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
