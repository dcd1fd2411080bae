"""The algorithms alone over a world: camera, vision, mapper and planner on hawk-sim's body, without MAVLink.

    python -m benchmarks.chain_flight --seeds 1-6 --drift 1 --json chain.json
    python -m benchmarks.chain_flight --lots DIR --drift 0 --only "surrey*"
    python -m benchmarks.chain_flight --lots DIR --drift 0.5 --pairs 20
    python -m benchmarks.chain_flight --seeds 1-3 --height 1.2

Prints the scores of the fused map and of single frames against the truth, the share of the labelled stalls that the
flight looked at, the distance flown beside that of the planner alone on the exploration's model of a map, and the
milliseconds of each step. It is several times faster than a survey
through the simulator, and separates errors of the algorithms from errors of the flight. Position, height, attitude and
compass drift as in the simulator.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import cv2

from benchmarks.chain_flight.campaign import Named, lots, measure_worlds, pairs, seeds
from benchmarks.chain_flight.flight import Errors
from benchmarks.figures import BenchmarkError, Section, print_and_write
from benchmarks.options import make_parser, seeds_option


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly every world, print one line each and a table of all."""
    options = _parser().parse_args(arguments)
    cv2.setNumThreads(1)
    errors = Errors(options.drift, options.height, math.radians(options.compass))
    try:
        figures = measure_worlds(_worlds(options), errors, options.model, options.out)
    except BenchmarkError as error:
        print(error, file=sys.stderr)
        return 1
    print_and_write([Section("chain", figures)], options.json)
    return 0


def _worlds(options: argparse.Namespace) -> Iterable[Named]:
    if options.lots is None:
        return seeds(options.seeds)
    return pairs(options.lots, options.pairs, options.only) if options.pairs else lots(options.lots, options.only)


def _parser() -> argparse.ArgumentParser:
    parser = make_parser("benchmarks.chain_flight", __doc__, model=True)
    parser.add_argument("--seeds", type=seeds_option, default="1-6", metavar="A-B", help="drawn worlds (1-6)")
    parser.add_argument(
        "--lots", type=Path, metavar="DIR", help="places instead: pictures with truth files beside them"
    )
    parser.add_argument(
        "--pairs", type=int, default=0, metavar="N", help="N pairs of those places with a drive between"
    )
    parser.add_argument("--only", default="*", metavar="PATTERN", help="those of such names (surrey*, 'pair 3,*')")
    parser.add_argument(
        "--drift", type=float, default=1.0, metavar="M", help="slow error of GNSS, standard deviation (1); 0: no error"
    )
    parser.add_argument("--height", type=float, default=1.0, metavar="F", help="the reported height by the true one")
    parser.add_argument("--compass", type=float, default=0.0, metavar="DEG", help="constant error of the compass")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write each place's map as a picture")
    return parser


if __name__ == "__main__":
    sys.exit(main())
