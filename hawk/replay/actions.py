"""Work of ``hawk-drone replay``: shows a recorded flight, decides or processes it again, or hands its pictures on."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from hawk.ddc import replay as decisions
from hawk.ddc.replay import compare_recording
from hawk.replay.flight import RecordedFlight, ReplayError, in_a_line
from hawk.replay.odm import write_odm
from hawk.replay.report import Report
from hawk.replay.results import write_map
from hawk.store.replay import RecordingError

SHOWN_DIFFERENCES: Final = 10
"""Decisions that differ, of which the terminal shows this number; --json has all."""
_FAILED: Final = 1
_PROGRESS: Final = 10  # pictures


def run(options: argparse.Namespace, show: Callable[[Path], int], *, is_process: bool) -> int:
    """Do what the options ask for; return the exit status. ``show``: shows a recording on the page."""
    try:
        if options.to_odm is not None:
            return _to_odm(options)
        if is_process or options.check:
            return _process(options) if is_process else _decide(options)
        return show(options.recording)
    except (ReplayError, RecordingError, decisions.ReplayError) as error:
        print(f"hawk-drone replay: {in_a_line(error)}", file=sys.stderr)
        return _FAILED


def _decide(options: argparse.Namespace) -> int:
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
    from hawk.replay.process import Again, process  # vision takes half a second to load: not for the other work

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
