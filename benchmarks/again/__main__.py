"""A known lot surveyed again: the distance of the second flight, and what it reports.

``python -m benchmarks.again [--seeds 1-20] [--json FILE]`` (``make bench-again``)
``python -m benchmarks.again --places DIR``

Each drawn lot is flown three times (camera, vision, mapper, planner on hawk-sim's body; three to six minutes): the
first survey finds it by looking and goes into a store, the others, 26 hours of cars later, fly the shortest tour over
the plan that the store has: corrected once by a person, and as the first survey left it. Receiver and compass err
otherwise at each visit. The limits are for the corrected plan, whose stalls are all there. ``--places``: pictures
PLACE.jpg with PLACE.json, their cars moved (`--cars`) between the visits.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from statistics import median

import cv2

from benchmarks.again.visits import Again, Twice, survey_again
from benchmarks.figures import Figure, Limit, Section, print_and_write, share
from benchmarks.lots.visits import DrawnLot, pictures
from benchmarks.options import folder_option, make_parser, seeds_option


def main(arguments: Sequence[str] | None = None) -> int:
    """Survey all lots twice, print a line each and a table of all."""
    parser = make_parser("benchmarks.again", __doc__)
    parser.add_argument("--seeds", type=seeds_option, default="1-20", metavar="A-B", help="drawn lots (1-20)")
    parser.add_argument("--places", type=folder_option, metavar="DIR", help="pictures of real places instead")
    options = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    found: list[Twice] = []
    for lot in map(DrawnLot, options.seeds) if options.places is None else pictures(options.places):
        found.append(survey_again(lot))
        print(f"as found, {line(found[-1].found)}", file=sys.stderr)
        print(f"{found[-1].corrections} corrections, {line(found[-1].corrected)}", file=sys.stderr, flush=True)
    print_and_write(sections(found), options.json)
    return 0


def sections(found: Sequence[Twice]) -> list[Section]:
    """Return the figures of both plans; those of the plan as it was found have no limits, and keys of their own."""
    by_finds = [
        replace(figure, key=f"{figure.key}_by_finds", limit=None) for figure in figures([one.found for one in found])
    ]
    mended = float(sum(one.corrections for one in found))
    corrections = Figure("corrections", "stalls that a person removed and added", mended)
    return [
        Section("known lots again, plan corrected", [*figures([one.corrected for one in found]), corrections]),
        Section("known lots again, plan as found", by_finds),
    ]


def line(one: Again) -> str:
    """Return a lot in one line."""
    flown = f"{one.flown_m:.0f} m flown, {one.planned_m:.0f} m planned, {one.first_m:.0f} m the first survey"
    looked = f"{one.looked_at} of {one.stalls} looked at, {one.looked_at_well} in a good part"
    reported = f"{one.reported} of {one.changed} changed reported, {one.false} of {one.unchanged} unchanged"
    return f"{one.name}: {flown}, {looked}, {reported}, {one.placed}{'' if one.finished else ', not finished'}"


def figures(found: Sequence[Again]) -> list[Figure]:
    """Return the figures over all lots; a survey that was not registered reports nothing."""
    changed, reported, unchanged, false = (
        sum(getattr(one, name) for one in found) for name in ("changed", "reported", "unchanged", "false")
    )
    return [
        Figure(
            "way_over_told_median", "distance over that planned before the start, median",
            median(one.flown_m / one.planned_m for one in found), limit=Limit(highest=1.10),
        ),
        Figure(
            "way_over_first_median", "distance over that of the first survey, median",
            median(one.flown_m / one.first_m for one in found), limit=Limit(highest=0.80),
        ),
        Figure(
            "looked_at_min", "stalls whole in a picture, worst lot",
            min(one.looked_at / one.stalls for one in found), limit=Limit(lowest=0.99),
        ),
        Figure("changed_found", "changed stalls with the new state", share(reported, changed), limit=Limit(0.97)),
        Figure(
            "changed_false", "unchanged stalls reported as changed", share(false, unchanged),
            limit=Limit(highest=0.01),
        ),
        Figure("looked_at_well", "stalls in the good part of a picture",
               share(sum(one.looked_at_well for one in found), sum(one.stalls for one in found))),
        Figure("way_over_told_max", "distance over that planned, worst lot",
               max(one.flown_m / one.planned_m for one in found)),
        Figure("way_over_first_max", "distance over that of the first survey, worst lot",
               max(one.flown_m / one.first_m for one in found)),
        Figure("again_registered", "second surveys that were registered",
               float(sum(one.placed == "registered" for one in found))),
        Figure("again_finished", "flights to their end", float(sum(one.finished for one in found)),
               limit=Limit(float(len(found)))),
        Figure("again_changed", "changed stalls", float(changed)),
        Figure("again_lots", "lots", float(len(found))),
    ]  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
