"""Processor time, memory and size of a report of a lot's use: a week of a usual lot, and 400 surveys of 2,000 stalls.

python -m benchmarks.report
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from sqlalchemy import select

from benchmarks.archive import drawn_lot, flight
from benchmarks.archive_calls import fill
from benchmarks.archive_files import ground
from hawk.lots.registration.frames import Move
from hawk.lots.schema import LOT, SURVEY
from hawk.lots.storage.database import Database
from hawk.lots.store import FILE
from hawk.lots.survey.pictures import pictures_of

SIZES: Final = ((98, 12), (2000, 400))
"""Stalls and surveys of each lot."""
KINDS: Final = ("html", "pdf", "xlsx")


_MEASURED: Final = (
    "import sys, pathlib, time, hawk.cli; status = hawk.cli.main(sys.argv[1:]);"
    "print(pathlib.Path('/proc/self/status').read_text(), 'CPU:', time.process_time()); sys.exit(status)"
)


@dataclass(frozen=True, slots=True)
class Cost:
    """Cost of a command: seconds of the processor, the most memory, MB, and MB of its file."""

    cpu_s: float
    memory_mb: float
    file_mb: float


def filled(folder: Path, stalls: int, surveys: int) -> str:
    """Write a store with an archive of one lot, its newest survey with a picture; return the id of the lot."""
    store = Database(folder / FILE, {"synchronous": 0})
    rng = np.random.default_rng(39)
    lot = fill(store, flight(1, drawn_lot(stalls, rng), Move(), rng), surveys)
    with store.reading() as connection:
        newest = connection.execute(select(SURVEY.c.id).order_by(SURVEY.c.seq.desc()).limit(1)).scalar_one()
        assert connection.execute(select(LOT.c.id)).scalar_one() == lot
    store.close()
    pictures_of(folder / FILE).write(newest, ground())
    return lot


def cost(folder: Path, lot: str, kind: str) -> Cost:
    """Write a report by the command, and return what it cost."""
    out = folder / f"report.{kind}"
    command = [sys.executable, "-c", _MEASURED, "report", lot, "--out", str(out), "--store", str(folder)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    memory, cpu = (float(done.stdout.rpartition(name)[2].split()[0]) for name in ("VmHWM:", "CPU:"))
    return Cost(cpu, memory / 1e3, out.stat().st_size / 1e6)


def main() -> int:
    """Print a line a lot and kind of file."""
    for stalls, surveys in SIZES:
        with tempfile.TemporaryDirectory() as folder:
            lot = filled(Path(folder), stalls, surveys)
            for kind in KINDS:
                found = cost(Path(folder), lot, kind)
                print(
                    f"{stalls} stalls, {surveys} surveys, {kind}: {found.cpu_s:.1f} s, "
                    f"{found.memory_mb:.0f} MB of memory, {found.file_mb:.2f} MB"
                )
    return 0


if __name__ == "__main__":
    sys.exit(main())
