"""The report in words that lies in the folder of a flight."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path

from hawk.lots.values import utc
from hawk.model.lot_map import HELD_SHARE
from hawk.picture.inbox.folder import HEADING, SURVEY
from hawk.picture.inbox.journal import PICTURES, Flight
from hawk.picture.inbox.map_process import MapReport


def mapped(flight: Flight, report: MapReport, pictures: int, now: float) -> str:
    """Return the report of a flight that was mapped. ``now``: Unix seconds."""
    return "\n".join([*_heading(flight, "mapped", now), *_mapped_lines(flight, report, pictures), ""])


def _mapped_lines(flight: Flight, report: MapReport, pictures: int) -> Iterator[str]:
    yield f"{report.store}."
    yield f"The survey's id is {report.stored_survey}."
    bounds = report.free_range
    held = "nine of ten surveys" if HELD_SHARE == 0.9 else f"{HELD_SHARE:.0%} of surveys"
    within = "" if bounds is None else f" ({bounds[0]} to {bounds[1]} in {held})"
    yield f"Stalls: {report.stalls}. Free {report.free}{within}, taken {report.taken}, unclear {report.unknown}."
    yield f"Pictures: {pictures}" + (f", which came in {flight.parts} parts." if flight.parts > 1 else ".")
    yield f"Table, GeoJSON and picture of the survey: {SURVEY}/"
    yield from report.notes
    if not report.time_is_sure:
        yield "The survey's time is not sure: statistics and feeds do not use it."
    if report.left_out:
        yield f"Left out: {len(report.left_out)}"
        yield from (f"  {each.name}: {each.reason}" for each in report.left_out)


def finished(flight: Flight, now: float) -> str:
    """Return the report of a flight whose survey was stored when the inbox was cut off: its files say the rest."""
    lines = [f"The survey's id is {flight.survey}.", f"Table, GeoJSON, picture and report of the survey: {SURVEY}/"]
    return "\n".join([*_heading(flight, "mapped", now), *lines, ""])


def known(flight: Flight, now: float) -> str:
    """Return the report of a flight whose pictures were mapped before."""
    lines = [
        f"All of these pictures were mapped before, as {flight.known_as}: already mapped as survey {flight.survey}.",
        "The store is as it was. This folder can be deleted.",
    ]
    return "\n".join([*_heading(flight, "mapped before", now), *lines, ""])


def failed(flight: Flight, words: str, folder: Path, store: Path, now: float) -> str:
    """Return the report of a flight that could not be mapped. ``folder``: where it lies from now on."""
    source = folder / PICTURES / flight.source
    command = shlex.join(["hawk-drone", "map", str(source), "--out", f"{flight.name}-survey", "--store", str(store)])
    before = (
        [f"The survey of the pictures that came before stays in the store: {flight.survey}."] if flight.survey else []
    )
    lines = [
        f"{words.rstrip('.')}.",
        *before,
        "The pictures are all here. Move this folder back into the inbox to try again, or map it with other options:",
        f"  {command}",
    ]
    return "\n".join([*_heading(flight, "not mapped", now), *lines, ""])


def _heading(flight: Flight, outcome: str, now: float) -> list[str]:
    return [f"{HEADING}{flight.name}, {outcome}, {utc(now)}", ""]
