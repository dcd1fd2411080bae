"""The command line of ``hawk-drone calibrate``.

Other commands pay nothing for it: what reads pictures and computes is imported when it is run.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hawk.config import options as values
from hawk.config.loader import load_settings, refuse_existing
from hawk.config.sections import ConfigError
from hawk.runtime.late import late

if TYPE_CHECKING:
    from hawk.calibrate import board, camera_command, flight_command
else:  # they read pictures, or draw with OpenCV
    board = late("hawk.calibrate.board")
    camera_command = late("hawk.calibrate.camera_command")
    flight_command = late("hawk.calibrate.flight_command")

COMMAND: Final = "calibrate"
_NEWEST: Final = Path()
"""Stands for the newest recording of the store."""
_LONGEST_S: Final = 600.0
_LONGEST_LIMIT_S: Final = 86_400.0


def add_calibrate_command(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    parser = commands.add_parser(
        COMMAND, help="calibrate the camera with a printed board; or its latency and mount by a flight (--in-flight)"
    )
    parser.set_defaults(action=_run)
    parser.add_argument(
        "work", nargs="?", choices=("camera", "board"), default="camera", help="board: write the board to print (PDF)"
    )
    values.add_settings(parser)
    parser.add_argument(
        "--out",
        type=values.new(),
        metavar="FILE",
        help="file to write (default: camera.yaml in the store; board-A4.pdf)",
    )
    parser.add_argument("--replace", action="store_true", help="replace a file that is there")
    parser.add_argument("--apply", action="store_true", help="write the result into the settings file of --config")
    board = parser.add_argument_group("with the board")
    board.add_argument("--paper", choices=("A4", "A3"), help="paper of the board (default A4)")
    board.add_argument("--camera", metavar="URL", help="URL of the camera")
    board.add_argument(
        "--pictures", type=values.folder, metavar="DIR", help="use the pictures of this folder, not the camera"
    )
    board.add_argument(
        "--preview",
        type=values.new(".jpg", ".jpeg"),
        metavar="FILE",
        help="keep writing what the camera sees there (.jpg)",
    )
    board.add_argument(
        "--time-limit",
        type=values.number(1, _LONGEST_LIMIT_S),
        metavar="S",
        help=f"give up after so long (default {_LONGEST_S:g})",
    )
    flight = parser.add_argument_group("by a flight")
    flight.add_argument(
        "--in-flight",
        type=values.file,
        nargs="?",
        const=_NEWEST,
        metavar="RECORDING",
        help="estimate latency and mount from this recording (default: the newest of the store)",
    )
    flight.add_argument("--in-background", action="store_true", help=argparse.SUPPRESS)
    flight.add_argument("--json", action="store_true", help="print one JSON object and no table")


def _run(options: argparse.Namespace) -> int:
    _refuse_what_changes_nothing(options)
    config = load_settings(options)
    if options.apply and options.config is None:
        raise ConfigError("--apply: name the settings file to change with --config")
    target = options.config if options.apply else None
    if options.in_flight is not None:
        if options.in_background:
            flight_command.use_least_priority()
        recording = None if options.in_flight == _NEWEST else options.in_flight
        return flight_command.run_in_flight(config, recording, target, as_json=options.json)
    if options.work == "board":
        return _board(options)
    plan = camera_command.CameraPlan(
        options.out or config.store.directory / "camera.yaml",
        options.replace,
        target,
        options.pictures,
        options.preview,
        options.time_limit or _LONGEST_S,
    )
    return camera_command.run_camera(config, plan)


def _refuse_what_changes_nothing(options: argparse.Namespace) -> None:
    """Raise ConfigError naming the first option that the work has no use for."""
    names: tuple[str, ...]
    if options.in_flight is not None:
        names, remedy = (
            ("out", "replace", "paper", "camera", "pictures", "preview", "time_limit"),
            "not with --in-flight",
        )
    elif options.work == "board":
        names, remedy = ("json", "apply", "camera", "pictures", "preview", "time_limit"), "not for the board"
    elif options.pictures is not None:
        names, remedy = ("json", "paper", "camera", "preview", "time_limit"), "not with --pictures"
    else:
        names, remedy = ("json", "paper"), "only for another work: see hawk-drone calibrate --help"
    for name in names:
        if getattr(options, name):
            raise ConfigError(f"--{name.replace('_', '-')}: {remedy}")


def _board(options: argparse.Namespace) -> int:
    paper = board.PAPERS[options.paper or "A4"]
    path = options.out or Path(f"board-{paper.name}.pdf")
    if path.suffix.lower() != ".pdf":
        raise ConfigError(f"--out: {path} must end in .pdf")
    if not options.replace:
        refuse_existing(path, "name another file, or give --replace")
    try:
        path.write_bytes(board.board_pdf(paper))
    except OSError as error:
        raise ConfigError(f"--out: {path} cannot be written: {error.strerror or error}") from error
    print(f"{path}: print it at 100 %, check that both rulers are 100 mm long, and glue it onto a flat plate.")
    return 0
