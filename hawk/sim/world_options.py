"""The world of a command line: its options, and drawing or reading it."""

from __future__ import annotations

import argparse

from hawk.config import options as values
from hawk.sim import launch as simulator
from hawk.worlds.generate import WorldOptions, generate_world
from hawk.worlds.moment import Condition, read_moment
from hawk.worlds.moved_cars import move_cars
from hawk.worlds.world import World, WorldError, picture_world


class UsageError(Exception):
    """Options that exclude each other; the text names the option."""


def add_world(world: argparse._ArgumentGroup) -> None:
    """Add the options that say which world is drawn or read, and where on Earth it is."""
    world.add_argument("--seed", type=values.whole(), default=1, metavar="N", help="world to draw (default 1)")
    world.add_argument(
        "--condition",
        type=Condition,
        choices=list(Condition),
        default=Condition.DAY,
        help="time of day and weather of the drawn world (default day)",
    )
    world.add_argument(
        "--at",
        type=simulator.moment,
        metavar="MOMENT",
        help="the drawn world at a moment, as 2026-05-04T10:30: the cars that stand there then, the sun of that hour; "
        "without an offset from UTC it is the lot's clock, one hour for 15 degrees of longitude",
    )
    world.add_argument(
        "--repaint",
        type=simulator.repaint,
        default=0,
        metavar="K",
        help="the drawn world after K changes of its layout: a row at another pitch, an island, bays added, a row "
        "closed by fences; stalls that stay keep their ids in the truth (default 0)",
    )
    world.add_argument("--world", type=values.file, metavar="FILE", help="fly over this picture instead (north up)")
    world.add_argument("--metres-per-pixel", type=simulator.scale, metavar="X", help="scale of that picture")
    world.add_argument("--truth", type=values.file, metavar="FILE", help="what the picture really holds (JSON)")
    world.add_argument(
        "--cars",
        type=values.whole(),
        metavar="SEED",
        help="move the cars of that picture to other stalls of its truth, whose states follow",
    )
    world.add_argument(
        "--latitude", type=values.number(-90, 90), default=43.2609, metavar="DEG", help="of the upper left corner"
    )
    world.add_argument("--longitude", type=values.number(-180, 180), default=-79.9192, metavar="DEG", help="the same")


def load_world(options: argparse.Namespace) -> World:
    """Draw or read the world. Raises UsageError or WorldError."""
    if options.world is None:
        for name in ("metres_per_pixel", "truth", "cars"):
            if getattr(options, name) is not None:
                raise UsageError(f"--{name.replace('_', '-')}: only together with --world")
        return generate_world(options.seed, _world_options(options))
    if options.at is not None:
        raise UsageError("--at: only for drawn worlds; the light of a picture stays")
    if options.repaint:
        raise UsageError("--repaint: only for drawn worlds; the layout of a picture stays")
    if options.metres_per_pixel is None:
        raise UsageError("--metres-per-pixel: is needed with --world (metres on the ground that a pixel covers)")
    world = picture_world(options.world, options.metres_per_pixel, options.truth)
    if options.cars is None:
        return world
    if options.truth is None:
        raise UsageError("--cars: needs --truth, which says where stalls and cars are")
    return move_cars(world, options.cars)


def _world_options(options: argparse.Namespace) -> WorldOptions:
    try:
        at = None if options.at is None else read_moment(options.at, options.longitude)
    except ValueError as error:  # at the limits the lot's clock decides
        raise UsageError(f"--at: {error}") from None
    place = options.latitude, options.longitude
    try:
        return WorldOptions(condition=options.condition, repaint=options.repaint, at=at, place=place)
    except WorldError as error:
        raise UsageError(f"--{error}") from None
