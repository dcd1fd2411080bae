"""The command ``hawk-sim``: a simulated drone over a simulated parking lot, or over a picture of a real one."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import logging
import math
import signal
import sys
from collections.abc import Coroutine, Iterator, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hawk.config import options as values
from hawk.config.addresses import check_host, check_port
from hawk.runtime.process import SIMULATOR_NICENESS, ParentGoneError, set_session_niceness, watched_parent
from hawk.sim import launch as simulator
from hawk.sim.autopilot.parameters import AutopilotOptions, Other
from hawk.sim.camera.camera import default_intrinsics
from hawk.sim.geometry import Origin, Slope
from hawk.sim.launch import SIMULATOR_MISSING, SPEED_HELP, simulator_installed
from hawk.sim.link.udp import UdpUrl
from hawk.worlds.camera import WorldCamera
from hawk.worlds.conditions import Condition
from hawk.worlds.generate import WorldOptions, generate_world
from hawk.worlds.moment import read_moment
from hawk.worlds.moved_cars import move_cars
from hawk.worlds.world import World, WorldError, picture_world

if TYPE_CHECKING:  # needs the extra; `main` reports where it is missing
    from hawk.sim.runner import RunOptions

EXIT_FAILED, EXIT_USAGE = 1, 2


class UsageError(Exception):
    """Options that exclude each other; the text names the option."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGTERM, SIGINT or the parent's end; return the exit status."""
    logging.basicConfig(level=logging.WARNING, format="hawk-sim: %(message)s")
    options = make_parser().parse_args(arguments)
    if not simulator_installed():
        print(f"hawk-sim: {SIMULATOR_MISSING}", file=sys.stderr)
        return EXIT_USAGE
    from hawk.sim.runner import fly, follow

    set_session_niceness(SIMULATOR_NICENESS)
    try:
        world = load_world(options)
        run = run_options(options, world)
        if options.save_truth is not None:
            _save(options.save_truth, world)
        half = follow if options.follow is not None else fly
        camera = WorldCamera(world, default_intrinsics())
        return asyncio.run(_run(half(world.truth_json(), camera, run, _say, world.stays), options.parent_pid))
    except (UsageError, WorldError) as error:
        print(f"hawk-sim: {error}", file=sys.stderr)
        return EXIT_USAGE
    except ParentGoneError as error:
        print(f"hawk-sim: --parent-pid: {error}", file=sys.stderr)
        return EXIT_USAGE
    except OSError as error:
        print(f"hawk-sim: {error}; is the address of --http or --mavlink free?", file=sys.stderr)
        return EXIT_FAILED


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(prog="hawk-sim", description=__doc__)
    parser.add_argument("--version", action="version", version=f"hawk-sim {version('hawk-drone')}")
    _add_world(parser.add_argument_group("world"))
    _add_flight(parser.add_argument_group("flight"))
    _add_links(parser.add_argument_group("links"))
    return parser


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


def run_options(options: argparse.Namespace, world: World) -> RunOptions:
    """Return the options of a run over this world. Raises UsageError."""
    from hawk.sim.runner import RunOptions

    if options.follow is not None and options.mavlink is not None:
        raise UsageError("--follow: not together with --mavlink; the other vehicle is the autopilot")
    width, height = world.size_m
    start = options.start or world.start()
    if not (0.0 <= start[0] <= width and 0.0 <= start[1] <= height):
        raise UsageError(f"--start: must lie in the picture, 0..{width:.1f},0..{height:.1f} metres")
    autopilot = AutopilotOptions(
        start=(-start[1], start[0]),
        yaw=math.radians(options.heading),
        gnss_sigma=options.gnss_sigma,
        gnss_wait_s=options.gnss_wait,
        wind=options.wind,
        wind_heading=math.radians(options.seed * 137.5 % 360.0),
        battery_minutes=options.battery_minutes,
        battery_cells=options.battery_cells,
        gnss_bias=options.gnss_bias,
        compass_error=math.radians(options.compass_error),
        gcs_parameter=options.gcs_param_name,
        real_time_factor=options.speed,
        rangefinder_m=options.rangefinder,
        slope=Slope(options.slope[0], math.radians(options.slope[1]), (-start[1], start[0])),
        utc_s=None if world.at is None else world.at.timestamp(),
    )
    return RunOptions(
        start=start,
        mavlink=options.follow or options.mavlink or UdpUrl("udpout", "127.0.0.1", 14550),
        http=options.http,
        origin=Origin(options.latitude, options.longitude),
        speed=options.speed,
        latency=options.latency,
        camera_rate=options.camera_rate,
        seed=options.seed if options.noise_seed is None else options.noise_seed,
        mavlink_version=options.mavlink_version,
        others=options.others,
        autopilot=autopilot,
    )


def _add_world(world: argparse._ArgumentGroup) -> None:
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
        "--start", type=values.place, metavar="X,Y", help="where the drone stands, metres in the picture"
    )
    world.add_argument(
        "--heading",
        type=values.number(-360, 360),
        default=0.0,
        metavar="DEG",
        help="where the drone looks at the start, clockwise from north (default 0)",
    )
    world.add_argument(
        "--slope",
        type=simulator.slope,
        default=(0.0, 0.0),
        metavar="PERCENT,DEG",
        help="the ground rises towards this direction, clockwise from north; the picture shows level ground at the "
        "distance below the drone (default 0,0)",
    )
    world.add_argument(
        "--latitude", type=values.number(-90, 90), default=43.2609, metavar="DEG", help="of the upper left corner"
    )
    world.add_argument("--longitude", type=values.number(-180, 180), default=-79.9192, metavar="DEG", help="the same")
    world.add_argument("--save-truth", type=values.new(), metavar="FILE", help="write the world's truth there (JSON)")


def _add_flight(flight: argparse._ArgumentGroup) -> None:
    flight.add_argument("--speed", type=simulator.speed, default=1.0, metavar="N", help=SPEED_HELP)
    flight.add_argument(
        "--gnss-sigma",
        type=simulator.gnss_sigma,
        default=0.5,
        metavar="M",
        help="slow error of the position (default 0.5)",
    )
    flight.add_argument(
        "--noise-seed", type=values.whole(), metavar="N", help="of the errors of position and sensors (default: --seed)"
    )
    flight.add_argument(
        "--gnss-wait",
        type=values.number(0, 600),
        default=5.0,
        metavar="S",
        help="from boot to a good position (default 5)",
    )
    flight.add_argument(
        "--rangefinder",
        type=simulator.rangefinder,
        default=0.0,
        metavar="M",
        help="reach of a rangefinder that looks down (sets RNGFND1_TYPE and RNGFND1_MAX; default 0: none)",
    )
    flight.add_argument("--wind", type=simulator.wind, default=0.0, metavar="M/S", help="mean wind (default 0)")
    flight.add_argument(
        "--battery-minutes",
        type=values.number(0.1, 600),
        default=20.0,
        metavar="MIN",
        help="hover time of a full battery",
    )
    flight.add_argument(
        "--battery-cells",
        type=int,
        choices=range(1, 15),
        default=3,
        metavar="N",
        help="lithium-polymer cells in series, 1 to 14; the autopilot's parameters stay as they are (default 3)",
    )
    flight.add_argument(
        "--gnss-bias",
        type=simulator.gnss_bias,
        default=(0.0, 0.0),
        metavar="N,E",
        help="constant error of GNSS, north and east, metres (default 0,0)",
    )
    flight.add_argument(
        "--compass-error",
        type=simulator.compass_error,
        default=0.0,
        metavar="DEG",
        help="constant error of all compasses, clockwise, -30 to 30: the autopilot's heading is off by it (default 0)",
    )
    flight.add_argument("--gcs-param-name", choices=("old", "new"), default="old", help="SYSID_MYGCS or MAV_GCS_SYSID")


def _add_links(links: argparse._ArgumentGroup) -> None:
    links.add_argument(
        "--mavlink",
        type=_url,
        metavar="URL",
        help="udpout:HOST:PORT or udpin:HOST:PORT (default udpout:127.0.0.1:14550)",
    )
    links.add_argument("--follow", type=_url, metavar="URL", help="only the camera, over another MAVLink vehicle")
    links.add_argument(
        "--http",
        type=_address,
        default=("127.0.0.1", 8090),
        metavar="HOST:PORT",
        help="camera, truth, faults; port 0: a free one",
    )
    links.add_argument(
        "--latency",
        type=values.number(0, 5),
        default=0.05,
        metavar="S",
        help="from exposure to delivery (default 0.05)",
    )
    links.add_argument(
        "--camera-rate",
        type=simulator.camera_rate,
        default=15.0,
        metavar="HZ",
        help="pictures in a simulated second (default 15); fewer leave the processor to others",
    )
    links.add_argument(
        "--mavlink-version", type=int, choices=(1, 2), default=2, help="of the messages from the drone (default 2)"
    )
    links.add_argument(
        "--others",
        type=_others,
        default=(),
        metavar="KIND,...",
        help="others on the link, heard before the drone: tracker, gimbal, copter, station (default none)",
    )
    links.add_argument("--parent-pid", type=values.pid, metavar="PID", help="end when that process ends")


async def _run(drone: Coroutine[Any, Any, None], parent_pid: int | None) -> int:
    """Fly until the end signal."""
    flight = asyncio.ensure_future(drone)
    try:
        with end_signal(parent_pid) as end:
            ending = asyncio.create_task(end.wait(), name="hawk-sim end")
            await asyncio.wait({flight, ending}, return_when=asyncio.FIRST_COMPLETED)
            ending.cancel()
            if flight.done():
                await flight
    finally:
        flight.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await flight
    return 0


def _say(line: str) -> None:
    print(line, flush=True)


def _save(path: Path, world: World) -> None:
    try:
        path.write_text(json.dumps(world.truth_json()), encoding="utf-8")
    except OSError as error:
        raise UsageError(f"--save-truth: {path} cannot be written ({error.strerror})") from error


def _others(text: str) -> tuple[Other, ...]:
    try:
        return tuple(Other(kind) for kind in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be some of {', '.join(Other)}, not {text!r}") from None


def _url(text: str) -> UdpUrl:
    try:
        return UdpUrl.parse(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _address(text: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    try:
        return check_host(host.strip("[]")), check_port(port, least=0)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"must be HOST:PORT, not {text!r}: {error}") from None


@contextlib.contextmanager
def end_signal(parent_pid: int | None = None) -> Iterator[asyncio.Event]:
    """Give the event that SIGTERM, SIGINT or the end of the parent sets, on the running loop.

    Raises ParentGoneError where the parent has ended before.
    """
    loop, event = asyncio.get_running_loop(), asyncio.Event()
    with watched_parent(parent_pid, event.set):
        for number in (signal.SIGTERM, signal.SIGINT):
            loop.add_signal_handler(number, event.set)
        try:
            yield event
        finally:
            for number in (signal.SIGTERM, signal.SIGINT):
                loop.remove_signal_handler(number)


if __name__ == "__main__":
    sys.exit(main())
