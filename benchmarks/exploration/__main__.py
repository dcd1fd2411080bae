"""Distance that the planner flies to see a whole lot, against the best tour over the known lot and simple rules.

``python -m benchmarks.exploration --seeds 1-200 --json FILE [--picture DIR]``; docs/exploration.md
explains the figures. Every seed gives the same flights each time; only milliseconds differ.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from benchmarks.exploration.campaign import SETUPS, fly_all
from benchmarks.exploration.picture import draw_worst
from benchmarks.exploration.report import figures, rows
from benchmarks.figures import Section, print_and_write
from benchmarks.options import make_parser, names_option, seeds_option

DEFAULT_SEEDS: Final = "1-200"


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly, print, write; status 0 whatever the figures say."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if options.json is not None:
        options.json.parent.mkdir(parents=True, exist_ok=True)
    if options.shorten and options.tours is None:
        parser.error("argument --shorten: name with --tours where the shorter tours are to be kept")
    runs = {
        name: fly_all(name, options.seeds, options.tours, options.workers, shorten=options.shorten)
        for name in options.setups
    }
    found = figures(runs.get("flown", []), runs.get("prototype", []))
    flights = [row for name, one in runs.items() for row in rows(name, one)]
    print_and_write([Section("exploration", found)], options.json, flights=flights)
    if options.picture is not None:
        for name, one in runs.items():
            draw_worst(one, options.picture, name)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = make_parser("benchmarks.exploration", __doc__)
    parser.add_argument("--seeds", type=seeds_option, default=DEFAULT_SEEDS, metavar="A-B", help="lots (1-200)")
    parser.add_argument("--picture", type=Path, metavar="DIR", help="draw the ten worst flights of each set-up there")
    parser.add_argument(
        "--setups", type=names_option(SETUPS), default=tuple(SETUPS), metavar="A,B", help=f"of {', '.join(SETUPS)}"
    )
    parser.add_argument(
        "--tours", type=Path, metavar="FILE", help="keep the oracle's tours there, and use none that come with this"
    )
    parser.add_argument(
        "--shorten", action="store_true", help="the oracle begins with the flights of the other pilots as well"
    )
    parser.add_argument(
        "--workers", type=int, default=1, metavar="N", help="processes (1); more of them flatter no figure"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
