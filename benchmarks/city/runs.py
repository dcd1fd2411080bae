"""Runs over a city as programs of their own, as a person would start them."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from benchmarks.figures import BenchmarkError

_RUN_S: Final = 1800.0


@dataclass(frozen=True, slots=True)
class Run:
    """One run that ended well: seconds from its start to its end, and what it printed (`benchmarks.city.once`).

    ``processor_s``: seconds of processors that it and all that it started used.
    """

    wall_s: float
    found: dict[str, Any]
    processor_s: float = 0.0


def once(picture: Path, out: Path, core_m: float, workers: int = 1) -> Run:
    """Map a picture. Raises BenchmarkError."""
    began, used = time.monotonic(), processor_s()
    run = finished(started(picture, out, core_m, workers=workers))
    return Run(time.monotonic() - began, run.found, processor_s() - used)


def processor_s() -> float:
    """Return the processor time of this process, and of those that it started and that have ended."""
    used = [resource.getrusage(which) for which in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


def started(picture: Path, out: Path, core_m: float, *, workers: int = 1) -> subprocess.Popen[str]:
    """Start a run."""
    words = [str(picture), str(out), "--core", str(core_m), "--workers", str(workers)]
    return subprocess.Popen(
        [sys.executable, "-m", "benchmarks.city.once", *words],
        text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env={**os.environ, "OMP_NUM_THREADS": "1"},
    )  # fmt: skip


def finished(process: subprocess.Popen[str]) -> Run:
    """Wait for a run. Raises BenchmarkError."""
    began = time.monotonic()
    said, problem = process.communicate(timeout=_RUN_S)
    if process.returncode:
        raise BenchmarkError(f"a run over the city failed: {problem[-600:]}")
    return Run(time.monotonic() - began, json.loads(said.splitlines()[-1]))
