"""Perception on still pictures, without a flight: network, votes and rows.

``python -m benchmarks.perception --lots DIR --tiles DIR --regions DIR --negatives DIR --seeds 1-5 --json FILE``

``--lots``: pictures ``PLACE.jpg`` with ``PLACE.json`` (metres_per_pixel, stalls with corners_m and state, lots_m);
``--metres`` averages them to coarser pixels besides. ``--tiles``: ``images/*.jpg`` with ``labels/*.txt`` (class,
polygon in fractions; 0 car, 1 lot, 3 stall); tiles with fewer than five stalls are left out. ``--regions``: as
``--lots``, without states and outlines, perhaps with the kind of ``ground``; ``--streets PATTERN`` names those that are
streets, ``--left-out FILE=PATTERN`` a network that was not trained on some of them and looks at those.
``--negatives``: pictures without any stall. ``--seeds``: single frames over drawn worlds.

The measures are those of `hawk.survey.accuracy`; labels that a picture's edge or missing ground cuts are counted as
neither right nor wrong. In JSON the figures of tiles have no prefix, those of places ``lots_``, those of regions
``regions_``, those of frames over drawn worlds ``frames_``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import cv2

from benchmarks.figures import print_and_write
from benchmarks.options import folder_option, make_parser, seeds_option
from benchmarks.perception.regions import Regions, left_out_option
from benchmarks.perception.sections import NEGATIVES_SCALE, Material, network_sections
from hawk.algo.vision.network import StallNetwork


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure by command line."""
    options = _parser().parse_args(arguments)
    cv2.setNumThreads(1)
    network = StallNetwork.load(options.model)
    regions = None
    if options.regions is not None:
        regions = Regions(options.regions, tuple(options.streets), tuple(options.left_out))
        try:
            regions.read()
        except (OSError, ValueError, KeyError) as error:
            print(f"--regions: {error}", file=sys.stderr)
            return 2
    material = Material(
        options.lots, options.tiles, options.negatives, options.negatives_scale, options.seeds, regions, options.metres
    )
    print_and_write(network_sections(network, material), options.json)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = make_parser("benchmarks.perception", __doc__, model=True)
    parser.add_argument("--lots", type=folder_option)
    parser.add_argument("--metres", type=float, nargs="+", default=[], help="of coarser pixels, as 0.12 0.15 0.2")
    parser.add_argument("--tiles", type=folder_option)
    parser.add_argument("--regions", type=Path, help="places whose labels have neither states nor outlines of lots")
    parser.add_argument(
        "--streets", action="append", default=[], metavar="PATTERN", help="names of the regions that are streets"
    )
    parser.add_argument(
        "--left-out", action="append", default=[], type=left_out_option, metavar="FILE=PATTERN",
        help="a network that was not trained on the regions of these names looks at them",
    )  # fmt: skip
    parser.add_argument("--negatives", type=folder_option)
    parser.add_argument(
        "--negatives-scale", type=float, default=NEGATIVES_SCALE, help="metres per pixel of the negatives (0.03)"
    )
    parser.add_argument("--seeds", type=seeds_option, default=[], help="drawn worlds to see in single frames, as 1-5")
    return parser


if __name__ == "__main__":
    sys.exit(main())
