"""Statistics of drawn lots against the simulator's exact history: does each interval hold what it says?

``python -m benchmarks.study [--seeds 2-4] [--surveys N] [--json FILE]`` (``make study``)

Each lot is flown once, its plan corrected as a person does on the page, and then surveyed twelve times on a Monday and
six times in another week, through the daemon's store and registration. A survey is what vision finds in one picture
from 250 m, shifted by up to 3 m and turned by up to 2°, as of `benchmarks.lots`. The truth is every stay of the
simulator.

A cell is a group of stalls (lot, row, zone, kind) and a flown hour; of turnover, a group and a pair of surveys.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import cv2

from benchmarks.figures import Figure, Limit, Section, print_and_write, share
from benchmarks.lots.looks import StillEye
from benchmarks.options import make_parser, seeds_option
from benchmarks.study.judged import Judged, judged, total
from benchmarks.study.survey import study
from benchmarks.study.visits import StudyLot
from hawk.algo.vision.network import StallNetwork


def main(arguments: Sequence[str] | None = None) -> int:
    """Survey all lots, print a line each and a table of all; return 1 when a figure lies outside its limits."""
    parser = make_parser("benchmarks.study", __doc__, model=True)
    parser.add_argument("--seeds", type=seeds_option, default="2-4", metavar="A-B", help="drawn lots (2-4)")
    parser.add_argument("--surveys", type=int, metavar="N", help="surveys of each lot after the first (18)")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    eye = StillEye(StallNetwork.load(options.model))

    def say(words: str) -> None:
        print(words, file=sys.stderr, flush=True)

    found = [studied(StudyLot(seed), eye, options.surveys, say) for seed in options.seeds]
    for one in found:
        say(line(one))
    return print_and_write([Section("study", figures(found))], options.json)


def studied(lot: StudyLot, eye: StillEye, surveys: int | None, say: Callable[[str], None]) -> Judged:
    """Survey a lot in a store of its own and judge its figures."""
    with tempfile.TemporaryDirectory(prefix="hawk-study-") as folder:
        one = study(lot, eye, Path(folder), surveys, say)
    assert one.world.stays is not None, "a world at a moment has stays"
    return judged(one.name, one.panel, one.world.stays, one.true, one.doubts)


def line(one: Judged) -> str:
    """Return a lot in one line."""
    doubts = f"; not registered: {', '.join(one.doubts)}" if one.doubts else ""
    held = f"{one.hours[1]} of {one.hours[0]} hours and {one.brackets[1]} of {one.brackets[0]} brackets hold"
    looks = f"{one.wrong} wrong states, {one.unseen:.1%} unseen"
    return f"{one.name}: {one.surveys} surveys, occupancy off by {max(one.errors):.1%} at most, {held}; {looks}{doubts}"


def figures(found: Sequence[Judged]) -> list[Figure]:
    """Return the figures over all lots."""
    hours, moments = total(one.hours for one in found), total(one.moments for one in found)
    brackets, changed = total(one.brackets for one in found), total(one.changed for one in found)
    right, false, gone = changed
    errors = sorted(error for one in found for error in one.errors)
    return [
        Figure("occupancy_error_max", "occupancy of a survey off the truth, at most", errors[-1],
               limit=Limit(highest=0.01)),
        Figure("occupancy_error_mean", "the same, mean", sum(errors) / len(errors)),
        Figure("interval_holds", "hours whose 90 % interval holds the truth", share(hours[1], hours[0]),
               limit=Limit(lowest=0.85, highest=0.95)),
        Figure("moment_holds", "surveys whose interval holds the truth of their moment",
               share(moments[1], moments[0])),
        Figure("bracket_holds", "brackets of arrivals that hold the truth", share(brackets[1], brackets[0]),
               limit=Limit(lowest=0.95)),
        Figure("bracket_closed", "brackets that have an upper end", share(brackets[2], brackets[0])),
        Figure("changed_precision", "stalls called changed that did", share(right, right + false),
               limit=Limit(lowest=0.97)),
        Figure("changed_recall", "changed stalls that were called so", share(right, right + gone),
               limit=Limit(lowest=0.97)),
        Figure("peak_right", "lots whose peak hour is right, or a neighbour",
               share(sum(one.peak_is_right for one in found), len(found)), limit=Limit(lowest=0.97)),
        Figure("hour_cells", "hours judged, by group", float(hours[0])),
        Figure("bracket_cells", "brackets judged", float(brackets[0])),
        Figure("unregistered", "surveys that were not registered", float(sum(len(one.doubts) for one in found))),
        Figure("surveys", "surveys", float(sum(one.surveys for one in found))),
        Figure("lots", "lots", float(len(found))),
    ]  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
