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
from hawk.sim import photos_command
from hawk.sim.autopilot.parameters import AutopilotOptions, Other
from hawk.sim.camera.camera import default_intrinsics
from hawk.sim.geometry import Origin, Slope
from hawk.sim.launch import SIMULATOR_MISSING, SPEED_HELP, simulator_installed
from hawk.sim.link.udp import UdpUrl
from hawk.sim.world_options import UsageError, add_world, load_world
from hawk.worlds.camera import WorldCamera
from hawk.worlds.world import World, WorldError

if TYPE_CHECKING:  # needs the extra; `main` reports where it is missing
    from hawk.sim.runner import RunOptions

EXIT_FAILED, EXIT_USAGE = 1, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGTERM, SIGINT or the parent's end, or write photographs; return the exit status."""
    logging.basicConfig(level=logging.WARNING, format="hawk-sim: %(message)s")
    words = list(sys.argv[1:] if arguments is None else arguments)
    parser = make_parser()
    options = parser.parse_args(words)
    if options.command is not None and words[0] != options.command:
        parser.error(f"{options.command}: must be the first word, its options behind it")
    if not simulator_installed():
        print(f"hawk-sim: {SIMULATOR_MISSING}", file=sys.stderr)
        return EXIT_USAGE
    if options.command == photos_command.NAME:
        return photos_command.run(options)
    from hawk.sim.runner import fly, follow  # needs the extra

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
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", title="commands")
    photos = commands.add_parser(
        photos_command.NAME, help=photos_command.PURPOSE, description=photos_command.DESCRIPTION
    )
    photos_command.add_photos(photos)
    return parser


def run_options(options: argparse.Namespace, world: World) -> RunOptions:
    """Return the options of a run over this world. Raises UsageError."""
    from hawk.sim.runner import RunOptions  # needs the extra

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
    add_world(world)
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
    _add_battery_and_faults(flight)


def _add_battery_and_faults(flight: argparse._ArgumentGroup) -> None:
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
