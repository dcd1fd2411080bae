"""The flight journal: what a daemon that is killed in the air needs to go on, on disk within half a second.

Map, stalls, datum, arm place, the flight under way and starts in the air are values by key, the newest of each wins.
Every survey has a folder of its own with append-only segments (`hawk.store.journal_file`). A thread of its own writes
them; what is put while it writes is merged by key, so that a slow disk costs memory for the newest values only. A disk
that is full or cannot be written makes the journal unhealthy and is tried again; nothing ever waits for it.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import os
import re
import shutil
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import IO, TypeVar

from pydantic import TypeAdapter, ValidationError

from hawk.model import ArmPlace, FlightSoFar, GlobalPose, Health
from hawk.store.journal_file import Records, check, pack

_LOG = logging.getLogger(__name__)
T = TypeVar("T")

SYNC_S = 0.25
"""Real seconds between two writes to the disk."""
_RETRY_S = 1.0
_CLOSE_S = 2.0
_CLOSE_UNHEALTHY_S = 0.2
_COMPACT_FACTOR = 4
_STARTS_KEPT_S = 600.0
_MAP = "map/"
_START = "start/"
_DATUM = "datum"
_ARM_PLACE = "arm_place"
_FLIGHT = "flight"
_SURVEY = re.compile(r"(\d{6})-[\w-]+")
_SEGMENT = re.compile(r"(\d{6})\.journal")


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
    surveys = _surveys(directory)
    if not surveys:
        return JournalState()
    values, lost, problem = _read_values(surveys[-1])
    return replace(_state(surveys[-1].name, values, lost, problem), last_written=_last_written(surveys[-1]))


class FlightJournal:
    """Writes the journal. Make it (reads what is there), then put; `close` at the end. Puts never block."""

    def __init__(
        self,
        directory: Path,
        wall: Callable[[], float] = time.time,
        keep: int = 10,
        opener: Callable[[Path], IO[bytes]] | None = None,
        compact_bytes: int = 64_000_000,
    ) -> None:
        """Begin to write. Puts of keys or values beyond the format's limits raise ValueError.

        ``keep``: older surveys that are kept. ``opener`` opens a new segment for appending. ``compact_bytes``: a
        segment larger than this and than four times what is live in it is written anew.
        """
        self._directory = directory
        self._wall = wall
        self._keep = keep
        self._opener = opener or _create
        self._compact_bytes = compact_bytes
        self._ready = threading.Condition()
        self._pending: dict[str, bytes] = {}
        self._put = 0
        self._synced = 0
        self._urgent = False
        self._waiters: list[tuple[int, Callable[[], None]]] = []
        self._jobs: list[Callable[[], None]] = []
        self._closing = False
        self._health = Health()
        surveys = _surveys(directory)
        self._survey = surveys[-1] if surveys else directory / self._name(0)
        self._newest = self._survey
        self._values, lost, problem = _read_values(self._survey) if surveys else ({}, 0, "")
        kept = _state(self._survey.name, self._values, lost, problem)
        self.state = replace(kept, last_written=_last_written(self._survey) if surveys else 0.0)
        self._file: IO[bytes] | None = None
        self._written = 0
        self._dirty = False
        self._thread = threading.Thread(target=self._run, name="journal", daemon=True)
        self._thread.start()

    # --- what is kept ----------------------------------------------------------------------------------------------

    def set_datum(self, datum: GlobalPose | None) -> None:
        """Keep the map frame's origin."""
        self._put_json(_DATUM, None if datum is None else asdict(datum))

    def set_arm_place(self, place: ArmPlace) -> None:
        """Keep where the drone was armed."""
        self._put_json(_ARM_PLACE, asdict(place))

    def set_flight(self, flight: FlightSoFar | None) -> None:
        """Keep how long and how far this flight went so far; None: it has ended."""
        self._put_json(_FLIGHT, None if flight is None else asdict(flight))

    def put_map(self, parts: Mapping[str, bytes]) -> None:
        """Keep changed parts of the map; empty bytes: the part is no more."""
        self._put_values({_MAP + key: bytes(value) for key, value in parts.items()})

    def note(self, name: str, text: str) -> None:
        """Keep a short text by name, for example where the parameters are stored."""
        self._put_values({f"note/{name}": text.encode()})

    def add_start_in_air(self) -> tuple[float, ...]:
        """Count a start in the air at this moment; return all of the last ten minutes, this one last.

        It is written at once: a program that crashes right after its start must be counted too.
        """
        now = self._wall()
        starts = tuple(start for start in self.state.starts_in_air if 0 <= now - start <= _STARTS_KEPT_S)
        with self._ready:
            self._urgent = True
            self._put_values({f"{_START}{now:.3f}": b"1"})
        return (*starts, now)

    def new_survey(self) -> str:
        """Begin a new survey: an empty journal beside the old one, which is kept. Returns its id."""
        with self._ready:
            folder = self._directory / self._name(int(self._newest.name[:6]))
            self._newest = folder
            before, self._pending = self._pending, {}
            self._jobs.append(lambda: self._change_survey(folder, before))
            self._put += 1
            self._ready.notify_all()
        return folder.name

    # --- life ------------------------------------------------------------------------------------------------------

    @property
    def survey_id(self) -> str:
        """The survey that is written to."""
        return self._newest.name

    @property
    def health(self) -> Health:
        """Whether what was put is on disk."""
        return self._health

    async def flush(self, timeout_s: float = 2.0) -> bool:
        """Wait until everything put so far is on disk; False when that did not happen in time."""
        loop = asyncio.get_running_loop()
        done = asyncio.Event()
        with self._ready:
            if self._synced >= self._put:
                return True
            self._waiters.append((self._put, lambda: _tell(loop, done)))
            self._urgent = True
            self._ready.notify_all()
        try:
            await asyncio.wait_for(done.wait(), timeout_s)
        except TimeoutError:
            return False
        return True

    async def close(self) -> None:
        """Write what is pending, as far as the disk allows, and end the thread."""
        await self.flush(_CLOSE_S if self._health.is_healthy else _CLOSE_UNHEALTHY_S)
        loop = asyncio.get_running_loop()
        ended = asyncio.Event()
        with self._ready:
            if self._closing:
                return
            self._closing = True
            self._put += 1
            self._waiters.append((self._put, lambda: _tell(loop, ended)))
            self._ready.notify_all()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(ended.wait(), _CLOSE_S)
            self._thread.join(_CLOSE_S)  # its last act was to tell

    # --- inside ----------------------------------------------------------------------------------------------------

    def _put_json(self, key: str, value: object) -> None:
        self._put_values({key: b"" if value is None else json.dumps(value, allow_nan=False).encode()})

    def _put_values(self, values: Mapping[str, bytes]) -> None:
        for key, value in values.items():
            check(key, value)
        with self._ready:
            self._pending.update(values)
            self._put += 1
            self._ready.notify_all()

    def _run(self) -> None:
        written = self._attempt(self._start)
        while not (self._closing and (not written or self._synced >= self._put)):
            self._pause(SYNC_S if written else _RETRY_S)
            with self._ready:
                while written and self._synced >= self._put and not self._closing:
                    self._ready.wait()
            written = self._attempt(self._write_pending)
        with contextlib.suppress(OSError):
            self._close_file()
        self._tell_synced(self._put)

    def _attempt(self, work: Callable[[], None]) -> bool:
        try:
            work()
        except Exception as error:  # a journal that cannot write must not end
            reason = f"Journal: {getattr(error, 'strerror', None) or error} ({self._survey})"
            if self._health.reason != reason:
                _LOG.error("%s; trying again", reason)
            self._health = Health.bad(reason)
            with contextlib.suppress(OSError):
                self._close_file()
            return False
        if not self._health.is_healthy:
            _LOG.info("Journal: written again")
        self._health = Health()
        return True

    def _pause(self, seconds: float) -> None:
        deadline = time.monotonic() + seconds
        with self._ready:
            while not (self._closing or self._urgent) and (left := deadline - time.monotonic()) > 0:
                self._ready.wait(left)
            self._urgent = False

    def _start(self) -> None:
        self._open_file()
        self._prune()

    def _write_pending(self) -> None:
        with self._ready:
            jobs, self._jobs = self._jobs, []
            taken, self._pending = self._pending, {}
            target = self._put
        for job in jobs:
            job()
        try:
            if self._file is None:
                self._open_file()
                self._prune()
            self._append(taken)
        except OSError:
            with self._ready:  # what came meanwhile is newer
                self._pending = taken | self._pending
            raise
        self._tell_synced(target)
        if self._written > max(self._compact_bytes, _COMPACT_FACTOR * self._live_bytes()):
            self._open_file()

    def _tell_synced(self, target: int) -> None:
        with self._ready:
            self._synced = max(self._synced, target)
            due = [tell for number, tell in self._waiters if number <= self._synced]
            self._waiters = [waiter for waiter in self._waiters if waiter[0] > self._synced]
        for tell in due:
            tell()

    def _change_survey(self, folder: Path, before: Mapping[str, bytes]) -> None:
        """Write what belongs to the old survey, then turn to the new one with nothing but the starts in the air."""
        with contextlib.suppress(OSError):
            if self._file is not None:
                self._append(before)
            self._close_file()
        _merge(self._values, before)
        self._survey = folder
        self._values = {key: value for key, value in self._values.items() if key.startswith(_START)}

    def _append(self, values: Mapping[str, bytes]) -> None:
        assert self._file is not None  # noqa: S101
        data = b"".join(pack(key, value) for key, value in values.items())
        _write_all(self._file, data)
        self._written += len(data)
        _merge(self._values, values)

    def _open_file(self) -> None:
        """Begin a segment with everything that is live; then the older ones are not needed any more."""
        self._close_file()
        self._survey.mkdir(parents=True, exist_ok=True)
        old = _segments(self._survey)
        path = self._survey / f"{1 + (int(old[-1].stem) if old else 0):06d}.journal"
        file = self._opener(path)
        self._drop_old_starts()
        data = b"".join(pack(key, value) for key, value in self._values.items())
        try:
            _write_all(file, data)
            _sync_folder(self._survey)
        except OSError:
            file.close()
            with contextlib.suppress(OSError):
                path.unlink()
            raise
        self._file, self._written = file, len(data)
        for segment in old:
            with contextlib.suppress(OSError):
                segment.unlink()

    def _drop_old_starts(self) -> None:
        now = self._wall()
        for key in [key for key in self._values if key.startswith(_START)]:
            if not any(0 <= now - start <= _STARTS_KEPT_S for start in _start_times([key])):
                del self._values[key]

    def _close_file(self) -> None:
        file, self._file = self._file, None
        if file is not None:
            file.close()

    def _live_bytes(self) -> int:
        return sum(len(value) for value in self._values.values())

    def _name(self, after: int) -> str:
        stamp = time.strftime("%Y%m%dT%H%M%SZ", time.gmtime(self._wall()))
        return f"{after + 1:06d}-{stamp}"

    def _prune(self) -> None:
        for survey in _surveys(self._directory)[: -self._keep - 1]:
            shutil.rmtree(survey, ignore_errors=True)


def _surveys(directory: Path) -> list[Path]:
    """Return the folders of surveys, oldest first."""
    try:
        return sorted(path for path in directory.iterdir() if _SURVEY.fullmatch(path.name) and path.is_dir())
    except OSError:
        return []


def _segments(survey: Path) -> list[Path]:
    return sorted(path for path in survey.iterdir() if _SEGMENT.fullmatch(path.name))


def _read_values(survey: Path) -> tuple[dict[str, bytes], int, str]:
    """Return the newest value of each key, the bytes that were lost, and what could not be read."""
    values: dict[str, bytes] = {}
    lost, problem = 0, ""
    try:
        segments = _segments(survey)
    except OSError as error:
        return values, lost, f"{survey}: {error.strerror or error}"
    for segment in segments:
        try:
            records = Records(segment.read_bytes())
        except OSError as error:
            problem = f"{segment}: {error.strerror or error}"
            continue
        for record in records:
            _merge(values, {record.key: record.value})
        lost += records.lost
    return values, lost, problem


def _last_written(survey: Path) -> float:
    """Return when its newest segment was written to; asked before this run writes anything."""
    with contextlib.suppress(OSError):
        return max((segment.stat().st_mtime for segment in _segments(survey)), default=0.0)
    return 0.0


def _merge(values: dict[str, bytes], news: Mapping[str, bytes]) -> None:
    for key, value in news.items():
        if value:
            values[key] = value
        else:
            values.pop(key, None)


def _state(survey_id: str, values: Mapping[str, bytes], lost: int, problem: str) -> JournalState:
    datum, datum_problem = _parse(GlobalPose, values.get(_DATUM))
    place, place_problem = _parse(ArmPlace, values.get(_ARM_PLACE))
    flight, flight_problem = _parse(FlightSoFar, values.get(_FLIGHT))
    starts = sorted(_start_times(values))
    return JournalState(
        survey_id=survey_id,
        datum=datum,
        arm_place=place,
        flight=flight,
        map_parts={key.removeprefix(_MAP): value for key, value in values.items() if key.startswith(_MAP)},
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


def _start_times(keys: Iterable[str]) -> list[float]:
    times = []
    for key in keys:
        if key.startswith(_START):
            with contextlib.suppress(ValueError):
                times.append(float(key.removeprefix(_START)))
    return times


def _tell(loop: asyncio.AbstractEventLoop, event: asyncio.Event) -> None:
    with contextlib.suppress(RuntimeError):  # the loop has ended
        loop.call_soon_threadsafe(event.set)


def _create(path: Path) -> IO[bytes]:
    return path.open("xb", buffering=0)


def _write_all(file: IO[bytes], data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[file.write(view) :]
    os.fsync(file.fileno())


def _sync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
