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
import shutil
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import IO

from hawk.model import ArmPlace, FlightSoFar, GlobalPose, Health
from hawk.store.journal_file import check, pack
from hawk.store.journal_state import (
    ARM_PLACE,
    DATUM,
    FLIGHT,
    MAP,
    START,
    last_written,
    merge,
    read_values,
    segments_of,
    start_times,
    state_of,
    surveys_of,
)

_LOG = logging.getLogger(__name__)

SYNC_S = 0.25
"""Real seconds between two writes to the disk."""
_RETRY_S = 1.0
_CLOSE_S = 2.0
_CLOSE_UNHEALTHY_S = 0.2
_COMPACT_FACTOR = 4
_STARTS_KEPT_S = 600.0


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
        surveys = surveys_of(directory)
        self._survey = surveys[-1] if surveys else directory / self._name(0)
        self._newest = self._survey
        self._values, lost, problem = read_values(self._survey) if surveys else ({}, 0, "")
        kept = state_of(self._survey.name, self._values, lost, problem)
        self.state = replace(kept, last_written=last_written(self._survey) if surveys else 0.0)
        self._file: IO[bytes] | None = None
        self._written = 0
        self._dirty = False
        self._thread = threading.Thread(target=self._run, name="journal", daemon=True)
        self._thread.start()

    # --- what is kept ----------------------------------------------------------------------------------------------

    def set_datum(self, datum: GlobalPose | None) -> None:
        """Keep the map frame's origin."""
        self._put_json(DATUM, None if datum is None else asdict(datum))

    def set_arm_place(self, place: ArmPlace) -> None:
        """Keep where the drone was armed."""
        self._put_json(ARM_PLACE, asdict(place))

    def set_flight(self, flight: FlightSoFar | None) -> None:
        """Keep how long and how far this flight went so far; None: it has ended."""
        self._put_json(FLIGHT, None if flight is None else asdict(flight))

    def put_map(self, parts: Mapping[str, bytes]) -> None:
        """Keep changed parts of the map; empty bytes: the part is no more."""
        self._put_values({MAP + key: bytes(value) for key, value in parts.items()})

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
            self._put_values({f"{START}{now:.3f}": b"1"})
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
        if not self._health.is_healthy:
            _LOG.info("Journal: written again")
        self._health = Health()  # before those are told who wait for it
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
        merge(self._values, before)
        self._survey = folder
        self._values = {key: value for key, value in self._values.items() if key.startswith(START)}

    def _append(self, values: Mapping[str, bytes]) -> None:
        assert self._file is not None  # noqa: S101
        data = b"".join(pack(key, value) for key, value in values.items())
        _write_all(self._file, data)
        self._written += len(data)
        merge(self._values, values)

    def _open_file(self) -> None:
        """Begin a segment with everything that is live; then the older ones are not needed any more."""
        self._close_file()
        self._survey.mkdir(parents=True, exist_ok=True)
        old = segments_of(self._survey)
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
        for key in [key for key in self._values if key.startswith(START)]:
            if not any(0 <= now - start <= _STARTS_KEPT_S for start in start_times([key])):
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
        for survey in surveys_of(self._directory)[: -self._keep - 1]:
            shutil.rmtree(survey, ignore_errors=True)


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
