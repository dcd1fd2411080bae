"""The flight journal on disk: its records, its keys, and the state that a survey's folder holds.

A segment is an append-only list of records: ``magic, length of key (u16), length of value (u32), CRC-32 of lengths, key
and value, key, value``, little endian. The newest value of each key wins; an empty value removes its key. Torn or
damaged bytes (a crash while writing) are skipped: reading goes on at the next whole record.
"""

from __future__ import annotations

import contextlib
import re
import struct
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from pydantic import TypeAdapter, ValidationError

from hawk.model.moment import Moment
from hawk.model.operation import Fall, FlightDrain, FlightSoFar, SurveyLeft
from hawk.model.plans import Outline
from hawk.model.poses import ArmPlace, GlobalPose

T = TypeVar("T")

MAX_KEY = 1000
"""Bytes of the longest key."""
MAX_VALUE = 64_000_000
"""Bytes of the largest value."""

_MAGIC = b"\xa5HJ1"
_LENGTHS = struct.Struct("<HI")
_CRC = struct.Struct("<I")
_HEAD = len(_MAGIC) + _LENGTHS.size + _CRC.size
MAP = "map/"
START = "start/"
DATUM = "datum"
ARM_PLACE = "arm_place"
FLIGHT = "flight"
LEFT = "left"
OUTLINE = "outline"
DRAINS = "drains"
WRITTEN = "written"
FALL = "fall"
SURVEY = re.compile(r"(\d{6})-[\w-]+")
SEGMENT = re.compile(r"(\d{6})\.journal")


@dataclass(frozen=True, slots=True)
class JournalState:
    """The journal's contents. ``starts_in_air``: oldest first. ``map_parts``: the map by key."""

    survey_id: str = ""
    datum: GlobalPose | None = None
    arm_place: ArmPlace | None = None
    flight: FlightSoFar | None = None
    """The current flight; None on the ground."""
    left: SurveyLeft | None = None
    """Rest of the survey after its last exploration; None before the first."""
    outline: Outline | None = None
    """Outline of the survey as an operator set it; without polygons when it was cleared, None when it was never set."""
    drains: tuple[FlightDrain, ...] = ()
    """Drain of the last flights, of any survey, oldest first."""
    fall: Fall | None = None
    """Motors that went off in the air, on any survey, until an operator clears it."""
    map_parts: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    starts_in_air: tuple[Moment, ...] = ()
    lost_bytes: int = 0
    """Bytes that were torn or damaged and skipped."""
    problem: str = ""
    """Reason why it could not be read whole; empty when it could."""
    is_read: bool = True
    """False: a file could not be read, and what it holds is not known."""
    last_written: Moment | None = None
    """Moment of the newest write; None for an empty journal."""


def read_records(data: bytes) -> tuple[list[tuple[str, bytes]], int]:
    """Return key and value of the whole records of a segment in order, and the number of the other bytes."""
    found: list[tuple[str, bytes]] = []
    position = lost = 0
    while position < len(data):
        record = _record_at(data, position)
        if record is None:
            after = data.find(_MAGIC, position + 1)
            after = len(data) if after < 0 else after
            lost += after - position
            position = after
        else:
            key, value, position = record
            found.append((key, value))
    return found, lost


def check(key: str, value: bytes) -> None:
    """Raise ValueError when key or value is too long."""
    if not 0 < len(key.encode()) <= MAX_KEY:
        raise ValueError(f"journal key {key[:40]!r}: must have 1 to {MAX_KEY} bytes")
    if len(value) > MAX_VALUE:
        raise ValueError(f"journal value of {key!r} has {len(value)} bytes, at most {MAX_VALUE} can be kept")


def pack(key: str, value: bytes) -> bytes:
    """Return a record's bytes. Raises ValueError when key or value is too long."""
    check(key, value)
    name = key.encode()
    lengths = _LENGTHS.pack(len(name), len(value))
    return b"".join((_MAGIC, lengths, _CRC.pack(_checksum(lengths, name, value)), name, value))


def _record_at(data: bytes, start: int) -> tuple[str, bytes, int] | None:
    if not data.startswith(_MAGIC, start) or start + _HEAD > len(data):
        return None
    lengths = data[start + len(_MAGIC) : start + len(_MAGIC) + _LENGTHS.size]
    key_length, value_length = _LENGTHS.unpack(lengths)
    key_end = start + _HEAD + key_length
    end = key_end + value_length
    if not 0 < key_length <= MAX_KEY or value_length > MAX_VALUE or end > len(data):
        return None
    name, value = data[start + _HEAD : key_end], data[key_end:end]
    (checksum,) = _CRC.unpack_from(data, start + len(_MAGIC) + _LENGTHS.size)
    if checksum != _checksum(lengths, name, value):
        return None
    try:
        return name.decode(), value, end
    except UnicodeDecodeError:
        return None


def _checksum(lengths: bytes, name: bytes, value: bytes) -> int:
    return zlib.crc32(value, zlib.crc32(name, zlib.crc32(lengths)))


def surveys_of(directory: Path) -> list[Path]:
    """Return the folders of surveys, oldest first; none where there is no journal."""
    try:
        return sorted(path for path in directory.iterdir() if SURVEY.fullmatch(path.name) and path.is_dir())
    except OSError:
        return []


def segments_of(survey: Path) -> list[Path]:
    """Return a survey's files, oldest first. Raises OSError."""
    return sorted(path for path in survey.iterdir() if SEGMENT.fullmatch(path.name))


def read_values(survey: Path) -> tuple[dict[str, bytes], int, str]:
    """Return the newest value of each key, the number of lost bytes, and the problem with reading (else empty)."""
    values: dict[str, bytes] = {}
    lost, problem = 0, ""
    try:
        segments = segments_of(survey)
    except OSError as error:
        return values, lost, f"{survey}: {error.strerror or error}"
    for segment in segments:
        try:
            records, damaged = read_records(segment.read_bytes())
        except OSError as error:
            problem = f"{segment}: {error.strerror or error}"
            continue
        merge(values, dict(records))
        lost += damaged
    return values, lost, problem


def merge(values: dict[str, bytes], news: Mapping[str, bytes]) -> None:
    """Merge newer values into ``values``; an empty value removes its key."""
    for key, value in news.items():
        if value:
            values[key] = value
        else:
            values.pop(key, None)


def read_survey(survey: Path) -> tuple[dict[str, bytes], JournalState]:
    """Return the values of a survey's folder, and their meaning. Never raises: see `JournalState.problem`."""
    values, lost, problem = read_values(survey)
    datum, datum_problem = _parse(GlobalPose, values.get(DATUM))
    place, place_problem = _parse(ArmPlace, values.get(ARM_PLACE))
    flight, flight_problem = _parse(FlightSoFar, values.get(FLIGHT))
    left, left_problem = _parse(SurveyLeft, values.get(LEFT))
    drains, drains_problem = _parse(tuple[FlightDrain, ...], values.get(DRAINS))
    outline, outline_problem = _parse(Outline, values.get(OUTLINE))
    fall, fall_problem = _parse(Fall, values.get(FALL))
    written, written_problem = _parse(Moment, values.get(WRITTEN))
    problems = (
        problem,
        datum_problem,
        place_problem,
        flight_problem,
        left_problem,
        drains_problem,
        outline_problem,
        written_problem,
        fall_problem,
    )
    return values, JournalState(
        survey_id=survey.name,
        datum=datum,
        arm_place=place,
        flight=flight,
        left=left,
        outline=outline,
        drains=drains or (),
        fall=fall,
        map_parts={key.removeprefix(MAP): value for key, value in values.items() if key.startswith(MAP)},
        starts_in_air=starts_of(values),
        lost_bytes=lost,
        problem="; ".join(filter(None, problems)),
        is_read=not problem,
        last_written=written or _last_written(survey),
    )


def _parse(kind: type[T], data: bytes | None) -> tuple[T | None, str]:
    if data is None:
        return None, ""
    try:
        return TypeAdapter(kind).validate_json(data), ""
    except ValidationError as error:
        return None, f"{getattr(kind, '__name__', kind)} in the journal cannot be read: {error.error_count()} errors"


def start_key(start: Moment) -> str:
    """Return the key that notes a start in the air."""
    return f"{START}{start.boot_id}/{start.seconds:.3f}/{start.utc:.3f}"


def starts_of(keys: Iterable[str]) -> tuple[Moment, ...]:
    """Return the starts in the air among the keys, those of one boot together and oldest first."""
    found = []
    for key in keys:
        boot, _, times = key.removeprefix(START).partition("/")
        seconds, _, utc = times.partition("/")
        if key.startswith(START) and boot:
            with contextlib.suppress(ValueError):
                found.append(Moment(boot, float(seconds), float(utc)))
    return tuple(sorted(found, key=lambda start: (start.boot_id, start.seconds)))


def _last_written(survey: Path) -> Moment | None:
    """Return the time of the newest file: for a journal of a version that did not note it."""
    with contextlib.suppress(OSError):
        times = [segment.stat().st_mtime for segment in segments_of(survey)]
        return Moment(utc=max(times)) if times else None
    return None
