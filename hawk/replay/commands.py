"""The command line of ``hawk-drone replay``; `hawk.replay.actions` does the work."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Final

from hawk.config import options as values
from hawk.config.addresses import MOST_PORT
from hawk.config.sections import ConfigError

COMMAND: Final = "replay"
PORT: Final = 3001


def add_replay_command(commands: Any, show: Callable[[Path, int], int]) -> None:
    """Add the command to the subparsers of the command line.

    ``show``: shows a recording on the page at a port, and returns the exit status.
    """
    replay = commands.add_parser(COMMAND, help="show a recorded flight, or decide or process it again")
    replay.add_argument("recording", type=values.file, metavar="RECORDING", help="a file of STORE/recordings (.mcap)")
    what = replay.add_mutually_exclusive_group()
    what.add_argument("--check", action="store_true", help="make every decision again; exit status 1 where one differs")
    what.add_argument(
        "--process", action="store_true",
        help="run vision, mapper and planner again over its pictures; exit status 1 where map or plan differs",
    )  # fmt: skip
    what.add_argument(
        "--to-odm", type=values.new_folder, metavar="DIR",
        help="write its pictures, geo.txt and cameras.json for OpenDroneMap into a folder; new or empty",
    )  # fmt: skip
    replay.add_argument(
        "--model", type=values.file, metavar="FILE", help="process by this network (.onnx) in place of the flight's"
    )
    replay.add_argument(
        "--out", type=values.new_folder, metavar="DIR",
        help="folder for the map of --process: stalls.csv, stalls.geojson, map.png; new or empty",
    )  # fmt: skip
    replay.add_argument(
        "--port", type=values.whole(0, MOST_PORT), metavar="PORT",
        help=f"port of the page that shows the flight without any of these ({PORT}); 0: a free one",
    )  # fmt: skip
    replay.add_argument("--json", type=values.new(".json"), metavar="FILE", help="write what differs as JSON (.json)")
    replay.set_defaults(action=partial(_run, show), boxed=_is_shown)


def _run(show: Callable[[Path, int], int], options: argparse.Namespace) -> int:
    is_process = options.process or options.model is not None
    _check(options, is_process=is_process)
    from hawk.replay.actions import run  # it loads numpy and all of vision: not for the other commands

    return run(options, lambda path: show(path, PORT if options.port is None else options.port), is_process=is_process)


def _is_shown(options: argparse.Namespace) -> bool:
    """Return whether the flight is shown on a page: other work needs no network."""
    return not (options.check or options.process or options.model is not None or options.to_odm is not None)


def _check(options: argparse.Namespace, *, is_process: bool) -> None:
    """Refuse options that do not fit together. Raises ConfigError naming one and the remedy."""
    if options.model is not None and (options.check or options.to_odm is not None):
        raise ConfigError("--model: only together with --process, which sees by it")
    if options.out is not None and not is_process:
        raise ConfigError("--out: only together with --process, whose map is written there")
    if options.json is not None and options.to_odm is not None:
        raise ConfigError("--json: not together with --to-odm, which compares nothing")
    is_shown = _is_shown(options)
    if options.json is not None and is_shown:
        raise ConfigError("--json: only together with --check or --process, which compare")
    if options.port is not None and not is_shown:
        raise ConfigError("--port: only without --check, --process and --to-odm: nothing is shown")
