"""The last measured outcome of each fault, in a file of JSON: one line a fault."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from proving.faults.fault import Fault, Outcome

DOCS: Final = Path(__file__).resolve().parents[2] / "docs"
SIMULATED: Final = DOCS / "results" / "faults.json"
"""Outcomes on the simulated drone."""
REAL: Final = DOCS / "results" / "ardupilot.json"
"""Outcomes on a real ArduCopter."""


def name_of(fault: Fault) -> str:
    """Return what identifies a fault: its part of a flight and its words."""
    return f"{fault.when.value}: {fault.name}"


def with_words(faults: Iterable[Fault], words: Sequence[str]) -> tuple[Fault, ...]:
    """Return the faults that have one of these words in what identifies them; all without words."""
    return tuple(fault for fault in faults if not words or any(each in name_of(fault) for each in words))


def read_outcomes(file: Path, faults: Sequence[Fault]) -> tuple[Outcome, ...]:
    """Return the recorded outcomes of those of the faults that were flown, in the faults' order."""
    entries = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    return tuple(_outcome(fault, entries[name_of(fault)]) for fault in faults if name_of(fault) in entries)


def keep_outcome(file: Path, outcome: Outcome, faults: Sequence[Fault]) -> None:
    """Put an outcome in the place of the one before. The file holds these faults alone, in their order."""
    recorded = {name_of(each.fault): each for each in (*read_outcomes(file, faults), outcome)}
    lines = (
        f"{json.dumps(name, ensure_ascii=False)}: {json.dumps(_entry(recorded[name]), ensure_ascii=False)}"
        for name in map(name_of, faults)
        if name in recorded
    )
    file.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def _outcome(fault: Fault, entry: Mapping[str, Any]) -> Outcome:
    return Outcome(
        fault,
        seconds=tuple(entry["seconds"]),
        problems=tuple(entry.get("problems", ())),
        kept=tuple(entry.get("kept", ())),
        figures=tuple(entry.get("figures", ())),
    )


def _entry(outcome: Outcome) -> dict[str, Any]:
    entry: dict[str, Any] = {"seconds": outcome.seconds}
    for key in ("kept", "figures", "problems"):
        if values := getattr(outcome, key):
            entry[key] = values
    return entry
