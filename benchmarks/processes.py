"""Processor time by part of a run, read from proc(5): who used the machine while something was measured."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final

PARTS: Final = {"hawk.sim.cli": "simulator", "hawk.cli": "daemon", "chrom": "browser"}
"""Part of a command line -> owner of the process; the first match is used."""
OURS: Final = "benchmark"
_TICKS: Final = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True, slots=True)
class CpuTime:
    """Seconds of processor time used so far: by part of this benchmark, and by the whole machine."""

    at: float
    parts: dict[str, float]
    machine: float

    def cores_since(self, earlier: CpuTime) -> dict[str, float]:
        """Return the mean number of cores used since, by part; ``others`` is what is not of this benchmark."""
        span = self.at - earlier.at
        used = {name: (value - earlier.parts.get(name, 0.0)) / span for name, value in self.parts.items()}
        used["others"] = max(0.0, (self.machine - earlier.machine) / span - sum(used.values()))
        return used


def cpu_time(proc: Path = Path("/proc"), root: int | None = None) -> CpuTime:
    """Read the processor time of this process, of all that it started, and of the machine."""
    root = os.getpid() if root is None else root
    found = {pid: stat for pid in _pids(proc) if (stat := _stat(proc / str(pid)))}
    parts: dict[str, float] = {}
    for pid, (_, used) in found.items():
        if pid == root or _descends(pid, root, found):
            name = OURS if pid == root else part_of(_command_line(proc / str(pid)))
            parts[name] = parts.get(name, 0.0) + used
    return CpuTime(time.monotonic(), parts, _machine(proc))


def part_of(command_line: str) -> str:
    """Return whose process this is."""
    return next((name for text, name in PARTS.items() if text in command_line), OURS)


def _pids(proc: Path) -> list[int]:
    return [int(entry.name) for entry in proc.iterdir() if entry.name.isdigit()]


def _stat(folder: Path) -> tuple[int, float] | None:
    """Return the parent's id and the seconds used (stat, fields 4, 14 and 15); None when the process has ended."""
    try:
        fields = (folder / "stat").read_text().rpartition(")")[2].split()
    except OSError:
        return None
    return int(fields[1]), (int(fields[11]) + int(fields[12])) / _TICKS


def _descends(pid: int, root: int, found: dict[int, tuple[int, float]]) -> bool:
    while pid in found:
        pid = found[pid][0]
        if pid == root:
            return True
    return False


def _command_line(folder: Path) -> str:
    try:
        return (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
    except OSError:
        return ""


def _machine(proc: Path) -> float:
    """Return busy seconds of all cores (stat, first line: user, nice, system, then irq, softirq, steal)."""
    fields = (proc / "stat").read_text().split("\n", 1)[0].split()
    user, nice, system, _idle, _iowait, irq, softirq, steal = (int(field) for field in fields[1:9])
    return (user + nice + system + irq + softirq + steal) / _TICKS
