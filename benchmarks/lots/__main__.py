"""The same stall in later surveys of the same lot: ids that last, and surveys that are not certain.

``python -m benchmarks.lots [--seeds 1-20] [--json FILE]`` (``make bench-lots``)
``python -m benchmarks.lots --places DIR``

Six surveys of each drawn lot go into a store of its own, through the daemon's registration: other cars at other hours
(`hawk-sim --at`), a receiver that is off by up to 3 m and a compass that is off by up to 2° for a whole survey, the
third one of half the lot, the fourth one of the lot next door, the fifth and sixth after a repaint (`--repaint 1`).
Before the sixth, all that the fifth proposes is taken over.
``--places``: pictures PLACE.jpg with PLACE.json, their cars moved (`--cars`), every second survey darkened; neither
repainted nor beside another lot. A survey is what vision finds in one picture from 250 m, shifted and turned by the
errors.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence

import cv2

from benchmarks.figures import Figure, Limit, Section, print_and_write, share
from benchmarks.lots.archive import Judged, survey_lot
from benchmarks.lots.looks import StillEye
from benchmarks.lots.visits import DrawnLot, PictureLot, pictures
from benchmarks.options import folder_option, make_parser, seeds_option
from hawk.algo.vision.network import StallNetwork


def main(arguments: Sequence[str] | None = None) -> int:
    """Survey all lots, print a line each and a table of all."""
    parser = make_parser("benchmarks.lots", __doc__, model=True)
    parser.add_argument("--seeds", type=seeds_option, default="1-20", metavar="A-B", help="drawn lots (1-20)")
    parser.add_argument("--places", type=folder_option, metavar="DIR", help="pictures of real places instead")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    eye = StillEye(StallNetwork.load(options.model))
    lots: Iterable[DrawnLot | PictureLot] = (
        [DrawnLot(seed) for seed in options.seeds] if options.places is None else pictures(options.places)
    )
    found = []
    for lot in lots:
        found.append(survey_lot(lot, eye))
        print(line(found[-1]), file=sys.stderr, flush=True)
    print_and_write([Section("lots that last", figures(found))], options.json)
    return 0


def line(one: Judged) -> str:
    """Return a lot in one line."""
    doubts = f"; not registered: {', '.join(one.doubts)}" if one.doubts else ""
    paint = (
        f"; repaint: {one.kept} of {one.stayed} kept, {one.reported} of {one.changed} reported" if one.stayed else ""
    )
    found = f"{one.surveys} surveys, {one.same} of {one.again} stalls again, {one.wrong} wrong"
    return f"{one.name}: {found}{paint}{doubts}"


def figures(found: Sequence[Judged]) -> list[Figure]:
    """Return the figures over all lots."""
    surveys, again, same, wrong = (sum(getattr(one, n) for one in found) for n in ("surveys", "again", "same", "wrong"))
    stayed, kept, changed, reported = (
        sum(getattr(one, n) for one in found) for n in ("stayed", "kept", "changed", "reported")
    )
    doubtful = sum(len(one.doubts) for one in found)
    return [
        Figure("same_id", "stalls seen again with the id of before", share(same, again), limit=Limit(lowest=0.995)),
        Figure("wrong_id", "stalls with the id of another one", float(wrong), limit=Limit(highest=0.0)),
        Figure(
            "unregistered", "surveys of a known lot that are not certain", share(doubtful, surveys - len(found)),
            limit=Limit(highest=0.03),
        ),
        Figure("repaint_kept", "unchanged stalls with their ids after a take-over", share(kept, stayed)),
        Figure("repaint_reported", "stalls changed by a repaint that its survey reported", share(reported, changed)),
        Figure("repaint_changed", "stalls changed by repaints", float(changed)),
        Figure("stalls_again", "stalls seen again", float(again)),
        Figure("surveys", "surveys", float(surveys)),
        Figure("lots", "lots", float(len(found))),
    ]  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
