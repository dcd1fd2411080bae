"""Measure the place's witness over drawn flights: ``python -m benchmarks.witness --json FILE``.

Honest receivers wander by 2.5 m (CEP) with a time of ten minutes: wind to 9 m/s, trucks, roofs, ground with little
texture, pictures 0.1 s late, a height 3 % and a compass 2° off. Walks of 0.1 to 1.4 m/s begin in a first hover, in a
long one, and in one after a tour, at 14 to 38 m and at 38 to 100 m; half of the honest flights are as high. How late a
doubt is counts in metres that the drone has left its place since the walk began. Exit status 1: a limit is missed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.figures import missed, print_and_write
from benchmarks.witness.drawn import high_walks, honest, tasks, walks
from benchmarks.witness.measure import all_flown, sections


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program; return its exit status."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.witness", description=__doc__)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every figure to FILE")
    parser.add_argument("--flights", type=int, default=100, metavar="N", help="honest flights (default 100)")
    parser.add_argument("--repeats", type=int, default=1, metavar="N", help="times each walk is flown (default 1)")
    parser.add_argument("--first", type=int, default=1, metavar="SEED", help="first seed (default 1)")
    parser.add_argument("--processes", type=int, default=2, metavar="N", help="processes (default 2)")
    options = parser.parse_args(arguments)
    found = [
        list(all_flown(flights, options.processes))
        for flights in (
            honest(options.flights, options.first),
            walks(options.repeats, options.first),
            high_walks(options.repeats, options.first),
            tasks(options.repeats, options.first),
        )
    ]
    measured = sections(*found)
    print_and_write(measured, options.json)
    return int(missed(measured))


if __name__ == "__main__":
    sys.exit(main())
