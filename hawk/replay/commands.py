"""The command ``hawk-drone replay``: decides or processes a recorded flight again, or hands its pictures on."""

from __future__ import annotations

import argparse
import asyncio
import json
import sys
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from hawk.config import options as values
from hawk.config.addresses import MOST_PORT
from hawk.config.sections import ConfigError

COMMAND: Final = "replay"
SHOWN_DIFFERENCES: Final = 10
"""Decisions that differ, of which the terminal shows this number; --json has all."""
PORT: Final = 3001
_FAILED: Final = 1
_PROGRESS: Final = 10  # pictures


def add_replay_command(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
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
    replay.set_defaults(action=_run, boxed=_is_shown)


def _run(options: argparse.Namespace) -> int:
    is_process = options.process or options.model is not None
    _check(options, is_process=is_process)
    from hawk.ddc import replay as decisions  # these load numpy: not for the other commands
    from hawk.replay.flight import ReplayError, in_a_line
    from hawk.store.replay import RecordingError

    try:
        if options.to_odm is not None:
            return _to_odm(options)
        if is_process or options.check:
            return _process(options) if is_process else _decide(options)
        return _show_page(options)
    except (ReplayError, RecordingError, decisions.ReplayError) as error:
        print(f"hawk-drone replay: {in_a_line(error)}", file=sys.stderr)
        return _FAILED


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


def _show_page(options: argparse.Namespace) -> int:
    from hawk.replay.server import serve

    try:
        asyncio.run(serve(options.recording, PORT if options.port is None else options.port))
    except KeyboardInterrupt:
        return 0
    except OSError as error:
        print(f"hawk-drone replay: --port: {error.strerror or error}; --port 0 takes a free one", file=sys.stderr)
    return _FAILED


def _decide(options: argparse.Namespace) -> int:
    from hawk.ddc.replay import compare_recording

    found = compare_recording(options.recording)
    lost = f", {found.left_out} left out: records before them are missing" if found.left_out else ""
    print(f"{options.recording}: {found.decided} decisions made again, {len(found.differences)} differ{lost}")
    if found.damage:
        print(f"  decided up to the damage at {found.seconds:.1f} s: {found.damage}")
    for each in found.differences[:SHOWN_DIFFERENCES]:
        print(f"  {each.at:.2f} s, {each.command or 'tick'}: {each.recorded} before, {each.again} now")
    _write_json(options.json, asdict(found))
    return _FAILED if found.differences else 0


def _process(options: argparse.Namespace) -> int:
    from hawk.replay.flight import RecordedFlight
    from hawk.replay.process import Again, process
    from hawk.replay.report import Report
    from hawk.replay.results import write_map

    flight = RecordedFlight(options.recording)
    again = Again(flight.settings(), version("hawk-drone"), options.model)
    processed = process(flight, again, _show if sys.stderr.isatty() else _show_nothing)
    report = Report.of(flight, again.maker, processed)
    print(report.text())
    _write_json(options.json, report.json())
    if options.out is not None:
        write_map(options.out, processed, flight.survey)
        print(f"{options.out}: stalls.csv, stalls.geojson, map.png")
    return 0 if report.is_equal else _FAILED


def _to_odm(options: argparse.Namespace) -> int:
    from hawk.replay.flight import RecordedFlight
    from hawk.replay.odm import write_odm

    flight = RecordedFlight(options.recording)
    written = write_odm(flight, options.to_odm)
    print(f"{options.to_odm}: {written.pictures} pictures, geo.txt, cameras.json; {written.left_out} left out")
    if written.unreadable:
        print(f"  pictures that could not be read: {written.unreadable}")
    if written.lens_error:
        print(f"  the lens is described to {written.lens_error:.2f} pixels")
    if flight.damage:
        print(f"  written up to the damage at {flight.seconds:.1f} s: {flight.damage}")
    return 0


def _write_json(path: Path | None, found: Any) -> None:
    """Write a report, where one is asked for. Raises ReplayError."""
    from hawk.replay.flight import ReplayError

    if path is None:
        return
    try:
        path.write_text(json.dumps(found, indent=1), encoding="utf-8")
    except OSError as error:
        words = f"--json: {path} cannot be written: {error.strerror or error}"
        raise ReplayError(f"{words}; name a file on a disk that has room") from error


def _show(count: int) -> None:
    if count % _PROGRESS == 0:
        print(f"\r{count} pictures", end="\r", file=sys.stderr)


def _show_nothing(_: int) -> None:
    """Print nothing: the output goes into a file."""
