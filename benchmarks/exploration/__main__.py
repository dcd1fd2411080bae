"""Distance that the planner flies to see a whole lot, against the best tour over the known lot.

``python -m benchmarks.exploration --seeds 1-200 --json FILE``; docs/exploration.md explains the figures.
Every seed gives the same flights each time; only milliseconds differ.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Final

from benchmarks.exploration.campaign import SETUPS, fly_all
from benchmarks.exploration.report import figures, rows
from benchmarks.figures import BenchmarkError, Section, print_and_write
from benchmarks.options import make_parser, names_option, seeds_option

DEFAULT_SEEDS: Final = "1-200"


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly, print, write; status 0 whatever the figures say, 1 where there is no tour to compare with."""
    options = _parser().parse_args(arguments)
    try:
        runs = {name: fly_all(name, options.seeds, options.workers) for name in options.setups}
    except BenchmarkError as error:
        print(error, file=sys.stderr)
        return 1
    sections = [Section(f"exploration, {name}", figures(one)) for name, one in runs.items()]
    flights = [row for name, one in runs.items() for row in rows(name, one)]
    print_and_write(sections, options.json, flights=flights)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = make_parser("benchmarks.exploration", __doc__)
    parser.add_argument("--seeds", type=seeds_option, default=DEFAULT_SEEDS, metavar="A-B", help="lots (1-200)")
    parser.add_argument(
        "--setups", type=names_option(SETUPS), default=tuple(SETUPS), metavar="A,B", help=f"of {', '.join(SETUPS)}"
    )
    parser.add_argument(
        "--workers", type=int, default=1, metavar="N", help="processes (1); more of them flatter no figure"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
