"""What is in the flight journal: its keys, how the newest value of each wins, and what a survey's folder holds."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

from pydantic import TypeAdapter, ValidationError

from hawk.model import ArmPlace, FlightSoFar, GlobalPose
from hawk.store.journal_file import Records

T = TypeVar("T")

MAP = "map/"
START = "start/"
DATUM = "datum"
ARM_PLACE = "arm_place"
FLIGHT = "flight"
SURVEY = re.compile(r"(\d{6})-[\w-]+")
SEGMENT = re.compile(r"(\d{6})\.journal")


@dataclass(frozen=True, slots=True)
class JournalState:
    """What the journal holds. ``starts_in_air``: wall clock seconds, oldest first. ``map_parts``: the map by key."""

    survey_id: str = ""
    datum: GlobalPose | None = None
    arm_place: ArmPlace | None = None
    flight: FlightSoFar | None = None
    """The flight that was under way; None on the ground."""
    map_parts: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    starts_in_air: tuple[float, ...] = ()
    notes: Mapping[str, str] = field(default_factory=dict)
    lost_bytes: int = 0
    """Bytes that were torn or damaged and passed over."""
    problem: str = ""
    """Why it could not be read whole, in words."""
    last_written: float = 0.0
    """When the newest of it was written, wall clock seconds; 0 where there is nothing."""


def read_journal(directory: Path) -> JournalState:
    """Return what the newest survey in ``directory`` left. Never raises: what cannot be read is told in `problem`."""
    surveys = surveys_of(directory)
    if not surveys:
        return JournalState()
    values, lost, problem = read_values(surveys[-1])
    return replace(state_of(surveys[-1].name, values, lost, problem), last_written=last_written(surveys[-1]))


def surveys_of(directory: Path) -> list[Path]:
    """Return the folders of surveys, oldest first."""
    try:
        return sorted(path for path in directory.iterdir() if SURVEY.fullmatch(path.name) and path.is_dir())
    except OSError:
        return []


def segments_of(survey: Path) -> list[Path]:
    """Return a survey's files, oldest first. Raises OSError."""
    return sorted(path for path in survey.iterdir() if SEGMENT.fullmatch(path.name))


def read_values(survey: Path) -> tuple[dict[str, bytes], int, str]:
    """Return the newest value of each key, the bytes that were lost, and what could not be read."""
    values: dict[str, bytes] = {}
    lost, problem = 0, ""
    try:
        segments = segments_of(survey)
    except OSError as error:
        return values, lost, f"{survey}: {error.strerror or error}"
    for segment in segments:
        try:
            records = Records(segment.read_bytes())
        except OSError as error:
            problem = f"{segment}: {error.strerror or error}"
            continue
        for record in records:
            merge(values, {record.key: record.value})
        lost += records.lost
    return values, lost, problem


def last_written(survey: Path) -> float:
    """Return when its newest segment was written to; asked before this run writes anything."""
    with contextlib.suppress(OSError):
        return max((segment.stat().st_mtime for segment in segments_of(survey)), default=0.0)
    return 0.0


def merge(values: dict[str, bytes], news: Mapping[str, bytes]) -> None:
    """Put news over what is known; an empty value forgets its key."""
    for key, value in news.items():
        if value:
            values[key] = value
        else:
            values.pop(key, None)


def state_of(survey_id: str, values: Mapping[str, bytes], lost: int, problem: str) -> JournalState:
    """Return what the values of a survey say; what cannot be read is told in `problem`."""
    datum, datum_problem = _parse(GlobalPose, values.get(DATUM))
    place, place_problem = _parse(ArmPlace, values.get(ARM_PLACE))
    flight, flight_problem = _parse(FlightSoFar, values.get(FLIGHT))
    starts = sorted(start_times(values))
    return JournalState(
        survey_id=survey_id,
        datum=datum,
        arm_place=place,
        flight=flight,
        map_parts={key.removeprefix(MAP): value for key, value in values.items() if key.startswith(MAP)},
        starts_in_air=tuple(starts),
        notes={
            key.removeprefix("note/"): value.decode("utf-8", "replace")
            for key, value in values.items()
            if key.startswith("note/")
        },
        lost_bytes=lost,
        problem="; ".join(text for text in (problem, datum_problem, place_problem, flight_problem) if text),
    )


def _parse(kind: type[T], data: bytes | None) -> tuple[T | None, str]:
    if data is None:
        return None, ""
    try:
        return TypeAdapter(kind).validate_json(data), ""
    except ValidationError as error:
        return None, f"{kind.__name__} in the journal cannot be read: {error.error_count()} errors"


def start_times(keys: Iterable[str]) -> list[float]:
    """Return when the program started in the air, wall clock seconds, from such keys."""
    times = []
    for key in keys:
        if key.startswith(START):
            with contextlib.suppress(ValueError):
                times.append(float(key.removeprefix(START)))
    return times
