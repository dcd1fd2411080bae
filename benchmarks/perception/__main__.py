"""Perception on still pictures and videos, without a flight: network, votes and rows.

``python -m benchmarks.perception --lots DIR --tiles DIR --regions DIR --negatives DIR --seeds 1-5 --json FILE``

``--lots``: pictures ``PLACE.jpg`` with ``PLACE.json`` (metres_per_pixel, stalls with corners_m and state, lots_m).
``--tiles``: ``images/*.jpg`` with ``labels/*.txt`` (class, polygon in fractions; 0 car, 1 lot, 3 stall); tiles with
fewer than five stalls are left out. ``--regions``: as ``--lots``, without states and outlines; ``--streets PATTERN``
names those that are streets, ``--ground KIND=PATTERN`` the kind of ground where the files have no ``ground``,
``--left-out FILE=PATTERN`` a network that was not trained on some of them and looks at those.
``--photos``: photographs of one flight with Pix4D's tags, of which one has labels (``--photo-labels``); the labels are
carried to the others. ``--negatives``: pictures without any stall. ``--seeds``: single frames over drawn worlds.

``--plan``: ``--lots`` and ``--regions`` with their labels as a plan, shifted and turned by a receiver's and a compass's
errors.

The measures are those of `hawk.survey.accuracy`; labels that a picture's edge or missing ground cuts are counted as
neither right nor wrong. In JSON the figures of tiles have no prefix, those of places ``lots_``, those of regions
``regions_``, those of photographs ``photo_`` and ``photos_``, those of frames over drawn worlds ``frames_``.

``python -m benchmarks.perception --video FILE --metres-per-pixel X``: a still camera straight above a lot.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

import cv2

from benchmarks.figures import print_and_write
from benchmarks.perception.photo_labels import PHOTO_LOT, read_labels
from benchmarks.perception.photos import Photos
from benchmarks.perception.places import folder_option
from benchmarks.perception.regions import Regions, ground_option, left_out_option
from benchmarks.perception.sections import NEGATIVES_SCALE, Material, network_sections, plan_sections
from benchmarks.perception.video import watch
from benchmarks.surveys import seeds_option
from hawk.algo.vision.detector import StallDetector
from hawk.algo.vision.network import StallNetwork

T = TypeVar("T")


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure by command line."""
    options = _parser().parse_args(arguments)
    cv2.setNumThreads(1)
    network = StallNetwork.load(options.model)
    if options.video is not None:
        return _video(network, options.video, options.metres_per_pixel)
    regions = _regions(options) if options.regions else None
    option, photos = "--regions", None
    try:
        if regions is not None:
            regions.read()
        option = "--photos"
        if options.photos is not None:
            photos = Photos(options.photos, read_labels(options.photo_labels, options.photos))
    except (OSError, ValueError, KeyError) as error:
        print(f"{option}: {error}", file=sys.stderr)
        return 2
    material = Material(
        options.lots, options.tiles, options.negatives, options.negatives_scale, options.seeds, regions, photos
    )
    sections = plan_sections if options.plan else network_sections
    print_and_write(sections(network, material), options.json)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.perception",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--lots", type=folder_option)
    parser.add_argument("--tiles", type=folder_option)
    parser.add_argument("--regions", type=Path, help="places whose labels have neither states nor outlines of lots")
    parser.add_argument(
        "--streets", action="append", default=[], metavar="PATTERN", help="names of the regions that are streets"
    )
    parser.add_argument(
        "--ground",
        action="append",
        default=[],
        type=_option(ground_option),
        metavar="KIND=PATTERN",
        help="ground of regions, by name",
    )
    parser.add_argument(
        "--left-out", action="append", default=[], type=_option(left_out_option), metavar="FILE=PATTERN",
        help="a network that was not trained on the regions of these names looks at them",
    )  # fmt: skip
    parser.add_argument(
        "--plan", action="store_true", help="give the labels of places and regions as a plan that is known, and no more"
    )
    parser.add_argument("--photos", type=folder_option, help="photographs of one flight over a labelled lot")
    parser.add_argument(
        "--photo-labels", type=Path, default=PHOTO_LOT, help="the labels of one of them (those of Garfield's lot)"
    )
    parser.add_argument("--negatives", type=folder_option)
    parser.add_argument(
        "--negatives-scale", type=float, default=NEGATIVES_SCALE, help="metres per pixel of the negatives (0.03)"
    )
    parser.add_argument("--seeds", type=seeds_option, default=[], help="drawn worlds to see in single frames, as 1-5")
    parser.add_argument("--model", type=Path, help="an ONNX file in place of the package's")
    parser.add_argument("--video", type=Path, help="a video of a still camera straight above a lot")
    parser.add_argument("--metres-per-pixel", type=float, default=0.1, help="of the video (0.1)")
    parser.add_argument("--json", type=Path, help="write the figures here")
    return parser


def _regions(options: argparse.Namespace) -> Regions:
    return Regions(options.regions, tuple(options.streets), tuple(options.ground), tuple(options.left_out))


def _option(read: Callable[[str], T]) -> Callable[[str], T]:
    """Return the reading of an option whose ValueError argparse prints."""

    def read_or_refuse(text: str) -> T:
        try:
            return read(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return read_or_refuse


def _video(network: StallNetwork, path: Path, metres_per_pixel: float) -> int:
    try:
        stalls = watch(StallDetector(network), path, metres_per_pixel)
    except (FileNotFoundError, ValueError) as error:
        print(f"--video: {error}", file=sys.stderr)
        return 2
    for stall in stalls:
        print(f"stall {stall.id}: {stall.state.value}, counted in {stall.frames} frames, state flipped {stall.flips} x")
    print(f"{len(stalls)} stalls, {sum(stall.flips for stall in stalls)} flips")
    return 0


if __name__ == "__main__":
    sys.exit(main())
