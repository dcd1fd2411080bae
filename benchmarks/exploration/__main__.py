"""Distance that the planner flies to see a whole lot, against the best tour over the known lot and a simple rule.

``python -m benchmarks.exploration --seeds 1-200 --json FILE``; docs/exploration.md explains the
figures. Every seed gives the same flights each time; only milliseconds differ.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Final

from benchmarks.exploration.campaign import fly_all
from benchmarks.exploration.report import figures, rows
from benchmarks.figures import Section, print_and_write
from benchmarks.options import make_parser, seeds_option

DEFAULT_SEEDS: Final = "1-200"


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly, print, write; status 0 whatever the figures say."""
    options = _parser().parse_args(arguments)
    if options.json is not None:
        options.json.parent.mkdir(parents=True, exist_ok=True)
    runs = fly_all(options.seeds, options.workers)
    print_and_write([Section("exploration", figures(runs))], options.json, flights=rows(runs))
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = make_parser("benchmarks.exploration", __doc__)
    parser.add_argument("--seeds", type=seeds_option, default=DEFAULT_SEEDS, metavar="A-B", help="lots (1-200)")
    parser.add_argument(
        "--workers", type=int, default=1, metavar="N", help="processes (1); more of them flatter no figure"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
