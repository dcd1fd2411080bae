"""Surveys by pictures of others, mapped as ``hawk-drone map`` does, against the truth.

``python -m benchmarks.pictures --photos [--seeds 1-10] [--places DIR] [--json FILE]`` (``make bench-pictures``)
``python -m benchmarks.pictures --photos --real-lot DIR --park DIR``
``python -m benchmarks.pictures --scale 40``

``--photos``: photographs that ``hawk-sim photos`` draws over worlds and, with ``--places``, over PLACE.jpg with
PLACE.json: 60 m high, overlapping by 70 and 60 %, whose places err by 1.5 m and one bias of 2 m, yaws by 3 degrees,
heights by 5 % and lenses by 2 %. Places are flown over, too (`benchmarks.chain_flight`), for the recall that
photographs lose. ``--real-lot``: photographs of OpenDroneMap/odm_data_garfield_msp; ``--park``: those
of pierotofy/drone_dataset_brighton_beach. ``--scale``: drawn folders whose heights err by up to half; whether the bound
of the scale holds the true one.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import cv2

from benchmarks.chain_flight.campaign import fly_one, lots, seeds
from benchmarks.chain_flight.flight import Errors
from benchmarks.figures import Figure, Section, print_and_write
from benchmarks.options import folder_option, make_parser, seeds_option
from benchmarks.pictures.photos import judge_all, photo_figures, recall_loss
from benchmarks.pictures.real import lot_figures, park_figures
from benchmarks.pictures.scale import measure as measure_scale
from benchmarks.pictures.scale import scale_figures


def main(arguments: Sequence[str] | None = None) -> int:
    """Map everything that is asked for, print a line each and a table of all."""
    options = _parser().parse_args(arguments)
    cv2.setNumThreads(1)
    sections = []
    if options.photos:
        sections.append(Section("photographs", _photographs(options)))
    if options.scale:
        sections.append(Section("scale", scale_figures(measure_scale(options.scale))))
    print_and_write(sections, options.json)
    return 0


def _photographs(options: argparse.Namespace) -> list[Figure]:
    figures = photo_figures(judge_all(seeds(options.seeds)), "photos_", "drawn worlds", is_drawn=True)
    if options.places is not None:
        judged = judge_all(lots(options.places))
        figures += photo_figures(judged, "photos_places_", "places", is_drawn=False)
        flown = [fly_one(name, world, Errors(), None, None).report for name, world in lots(options.places)]
        figures.append(recall_loss([one.measures for one in judged], flown))
    if options.real_lot is not None:
        figures += lot_figures(options.real_lot)
    if options.park is not None:
        figures += park_figures(options.park)
    return figures


def _folders(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text}: name a number of folders from 1, as 40")
    return int(text)


def _parser() -> argparse.ArgumentParser:
    parser = make_parser("benchmarks.pictures", __doc__)
    parser.add_argument("--photos", action="store_true", help="photographs")
    parser.add_argument("--scale", type=_folders, metavar="N", help="drawn folders with wrong heights")
    parser.add_argument("--seeds", type=seeds_option, default="1-10", metavar="A-B", help="drawn worlds (1-10)")
    parser.add_argument("--places", type=folder_option, metavar="DIR", help="PLACE.jpg with PLACE.json")
    parser.add_argument("--real-lot", type=folder_option, metavar="DIR", help="photographs of the labelled lot")
    parser.add_argument("--park", type=folder_option, metavar="DIR", help="photographs of the park")
    return parser


if __name__ == "__main__":
    sys.exit(main())
