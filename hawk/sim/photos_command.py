"""The command ``hawk-sim photos``: photographs of a flight over a drawn lot, or over a picture of a real one."""

from __future__ import annotations

import argparse
import sys
from typing import Final

from hawk.config import options as values
from hawk.sim import launch as simulator
from hawk.sim.geometry import Origin
from hawk.sim.photos import Errors, PhotoOptions, PhotosError, write_photos
from hawk.sim.photos_tags import CAMERAS, TagsError
from hawk.sim.world_options import UsageError, add_world, load_world
from hawk.worlds.world import WorldError

NAME: Final = "photos"
PURPOSE: Final = "write photographs of a flight over the world, with the tags of a DJI, and their truth"
DESCRIPTION: Final = "Photographs of a flight over a drawn lot, or over a picture of a real one."
EXIT_FAILED, EXIT_USAGE = 1, 2


def add_photos(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_world(parser.add_argument_group("world"))
    _add_flight(parser.add_argument_group("flight"))
    _add_errors(parser.add_argument_group("errors of the tags"))


def run(options: argparse.Namespace) -> int:
    """Write the photographs; return the exit status."""
    errors = Errors(options.gps_sigma, options.gps_bias, options.yaw_error, options.height_error, options.lens_error)
    try:
        world = load_world(options)
        flight = PhotoOptions(
            height=options.height,
            overlap=options.overlap,
            camera=CAMERAS[options.camera],
            width=options.width,
            errors=errors,
            noise_seed=options.seed if options.noise_seed is None else options.noise_seed,
            origin=Origin(options.latitude, options.longitude),
        )
        count = write_photos(world, flight, options.out, lambda line: print(line, flush=True))
    except (UsageError, WorldError, PhotosError, TagsError) as error:
        print(f"hawk-sim photos: {error}", file=sys.stderr)
        return EXIT_USAGE
    except OSError as error:
        print(f"hawk-sim photos: --out: {error}; name a folder that this user may write", file=sys.stderr)
        return EXIT_FAILED
    print(f"{count} photographs in {options.out}, their truth in truth.json beside them")
    return 0


def overlap(text: str) -> tuple[float, float]:
    """Return the shares of ALONG/BETWEEN in percent."""
    try:
        along, between = (float(part) for part in text.split("/"))
    except ValueError:
        along = between = -1.0
    if not (0.0 <= along <= 95.0 and 0.0 <= between <= 95.0):
        raise argparse.ArgumentTypeError(f"must be ALONG/BETWEEN, each 0 to 95 percent, not {text!r}")
    return along / 100.0, between / 100.0


def _add_flight(flight: argparse._ArgumentGroup) -> None:
    flight.add_argument(
        "--out", type=values.new_folder, required=True, metavar="DIR", help="new folder for the photographs"
    )
    flight.add_argument(
        "--height", type=values.number(5, 500), default=60.0, metavar="M", help="above the ground (default 60)"
    )
    flight.add_argument(
        "--overlap",
        type=overlap,
        default=(0.7, 0.6),
        metavar="ALONG/BETWEEN",
        help="of photographs along a lane and between lanes, percent (default 70/60)",
    )
    flight.add_argument(
        "--camera", choices=tuple(CAMERAS), default="FC6310", metavar="MODEL",
        help=f"EXIF's model of the camera: {', '.join(CAMERAS)} (default FC6310)",
    )  # fmt: skip
    flight.add_argument(
        "--width", type=values.whole(320, 8192), default=2000, metavar="PX", help="of a photograph (default 2000)"
    )


def _add_errors(errors: argparse._ArgumentGroup) -> None:
    plain = Errors()
    errors.add_argument(
        "--gps-sigma",
        type=simulator.gnss_sigma,
        default=plain.gps_sigma,
        metavar="M",
        help="noise of each place, standard deviation along each axis (default 1.5)",
    )
    errors.add_argument(
        "--gps-bias",
        type=values.number(0, 50),
        default=plain.gps_bias,
        metavar="M",
        help="error that all places share, in a direction of the noise's seed (default 2)",
    )
    errors.add_argument(
        "--yaw-error",
        type=values.number(0, 45),
        default=plain.yaw,
        metavar="DEG",
        help="most error of a yaw, half of it shared by all (default 3)",
    )
    errors.add_argument(
        "--height-error",
        type=values.number(0, 50),
        default=plain.height,
        metavar="PERCENT",
        help="most error of the height, one factor for all (default 5)",
    )
    errors.add_argument(
        "--lens-error",
        type=values.number(0, 20),
        default=plain.lens,
        metavar="PERCENT",
        help="most difference of the true focal length from the one that is written (default 2)",
    )
    errors.add_argument(
        "--noise-seed", type=values.whole(), metavar="N", help="of the errors and the pictures' noise (default: --seed)"
    )
