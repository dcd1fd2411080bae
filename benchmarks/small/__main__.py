"""The daemon on a small computer: a whole survey of three hectares on one core and 1 GiB.

``make bench-small`` or ``python -m benchmarks.small [--seed 1] [--core N] [--memory 1024] [--out DIR] [--json FILE]``

The daemon and its vision run in a control group with one core of this machine alone; simulator and benchmark have the
others. The lot is drawn, and flown over at speed 1: ten minutes. Lag and frames are the daemon's own account of each
whole minute, the worst of which counts; heartbeats are those that a client receives. Control groups need root. The
core of a larger machine is faster than that of a small computer: its name is printed.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import os
import re
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks.figures import BenchmarkError, Section, print_and_write
from benchmarks.options import make_parser
from benchmarks.small.box import make_box, other_cores
from benchmarks.small.lot import draw_lot
from benchmarks.small.measure import measure

EXIT_FAILED = 1
_MIB = 2**20


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print, write; return 1 when it could not be measured or a limit is missed."""
    parser = make_parser("benchmarks.small", __doc__)
    parser.add_argument("--seed", type=int, default=1, help="first seed that is tried for the lot (1)")
    parser.add_argument("--core", type=int, metavar="N", help="core of the daemon (default: the last)")
    parser.add_argument("--memory", type=float, default=1024.0, metavar="MIB", help="memory of the group (1024)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="keep the lot, logs and journal here")
    options = parser.parse_args(arguments)
    with contextlib.ExitStack() as stack:
        folder = options.out or Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="hawk-small-")))
        try:
            section = _measured(options, folder)
        except BenchmarkError as error:
            print(f"small: {error}", file=sys.stderr)
            return EXIT_FAILED
    return print_and_write([section], options.json)


def processor(path: Path = Path("/proc/cpuinfo")) -> str:
    """Return the processor's name as the kernel has it; empty when it has none."""
    try:
        found = re.search(r"^(?:model name|Model)\s*: (.+)$", path.read_text(), re.MULTILINE)
    except OSError:
        return ""
    return found[1] if found else ""


def _measured(options: argparse.Namespace, folder: Path) -> Section:
    cores = sorted(os.sched_getaffinity(0))
    core = cores[-1] if options.core is None else options.core
    others = other_cores(core, cores)
    print(f"one core of: {processor() or 'a processor without a name'}; drawing the lot ...", file=sys.stderr)
    lot = draw_lot(options.seed, folder)
    box = make_box(core, round(options.memory * _MIB))
    try:
        os.sched_setaffinity(0, others)
        found, problem = asyncio.run(measure(lot, box, folder))
    finally:
        os.sched_setaffinity(0, cores)
        box.remove()
    return Section("small", found, problem)


if __name__ == "__main__":
    sys.exit(main())
