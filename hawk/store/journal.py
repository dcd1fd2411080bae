"""The flight journal: the data that a daemon killed in the air needs to go on, on disk within half a second.

Map, stalls, datum, arm place, the current flight and starts in the air are values by key; the newest of each wins.
Every survey has a folder of its own with append-only segments (`hawk.store.journal_state`). A thread writes them;
values put meanwhile are merged by key, so a slow disk costs memory for the newest values only. A disk that is full or
cannot be written makes the journal unhealthy and is tried again; nothing ever waits for it.
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
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import IO

from hawk.model.moment import Moment, this_moment
from hawk.model.operation import Fall, FlightDrain, FlightSoFar, Health, SurveyLeft
from hawk.model.plans import Outline
from hawk.model.poses import ArmPlace, GlobalPose
from hawk.model.sentences import say
from hawk.runtime.files import sync_folder
from hawk.store.journal_state import (
    ARM_PLACE,
    DATUM,
    DRAINS,
    FALL,
    FLIGHT,
    LEFT,
    MAP,
    OUTLINE,
    START,
    WRITTEN,
    JournalState,
    check,
    merge,
    pack,
    read_survey,
    segments_of,
    start_key,
    starts_of,
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
    """Reads the newest survey when made (`state`), then writes. Puts never block; `close` at the end."""

    def __init__(
        self,
        directory: Path,
        moment: Callable[[], Moment] = this_moment,
        keep: int = 10,
        opener: Callable[[Path], IO[bytes]] | None = None,
        compact_bytes: int = 8_000_000,
    ) -> None:
        """Read the newest survey and start the thread. Puts beyond the format's limits raise ValueError.

        ``keep``: number of older surveys to keep. ``opener`` opens a new segment for appending. A segment larger than
        ``compact_bytes`` and than four times its live values is compacted: a start in the air reads all of it.
        """
        self._directory = directory
        self._moment = moment
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
        self.health = Health()
        """Unhealthy while values cannot be written."""
        surveys = surveys_of(directory)
        self._survey = surveys[-1] if surveys else directory / self._name(0)
        self.survey_id = self._survey.name
        """Id of the newest survey."""
        self._values, self.state = read_survey(self._survey) if surveys else ({}, JournalState(self._survey.name))
        if self.state.lost_bytes or self.state.problem:
            _LOG.warning("Journal: %d bytes are damaged. %s", self.state.lost_bytes, self.state.problem)
        self._file: IO[bytes] | None = None
        self._written = 0
        self._thread = threading.Thread(target=self._run, name="journal", daemon=True)
        self._thread.start()

    # --- values ----------------------------------------------------------------------------------------------------

    def set_datum(self, datum: GlobalPose | None) -> None:
        """Keep the map frame's origin."""
        self._put_json(DATUM, None if datum is None else asdict(datum))

    def set_arm_place(self, place: ArmPlace) -> None:
        """Keep the arm place."""
        self._put_json(ARM_PLACE, asdict(place))

    def set_flight(self, flight: FlightSoFar | None) -> None:
        """Keep duration and distance of this flight so far; None: it has ended."""
        self._put_json(FLIGHT, None if flight is None else asdict(flight))

    def set_left(self, left: SurveyLeft) -> None:
        """Keep what the survey has left to fly."""
        self._put_json(LEFT, asdict(left))

    def set_outline(self, outline: Outline) -> None:
        """Keep the outline of the survey; one without polygons was cleared."""
        self._put_json(OUTLINE, asdict(outline))

    def set_drains(self, drains: Sequence[FlightDrain]) -> None:
        """Keep the drain of the last flights; a new survey keeps it too."""
        self._put_json(DRAINS, [asdict(each) for each in drains])

    def set_fall(self, fall: Fall | None) -> None:
        """Keep that the motors went off in the air, and where; None: an operator cleared it. A new survey keeps it."""
        self._put_json(FALL, None if fall is None else asdict(fall))

    def put_map(self, parts: Mapping[str, bytes]) -> None:
        """Keep changed parts of the map; empty bytes remove a part."""
        self._put_values({MAP + key: bytes(value) for key, value in parts.items()})

    def add_start_in_air(self, start: Moment) -> None:
        """Note this run's start in the air.

        It is written at once: a crash right after the start must be counted too.
        """
        with self._ready:
            self._urgent = True
            self._put_values({start_key(start): b"1"})

    def withdraw_start(self, start: Moment) -> None:
        """Take a start in the air back: it was on the ground, or ended in order."""
        self._put_values({start_key(start): b""})

    def try_disk(self) -> None:
        """Have something written at once, so that `flush` shows whether the disk can be written."""
        with self._ready:
            self._urgent = True
            self._put_values(self._written_now())

    def new_survey(self) -> str:
        """Begin a new survey with an empty journal beside the old one, and return its id."""
        with self._ready:
            folder = self._directory / self._name(int(self.survey_id[:6]))
            self.survey_id = folder.name
            before, self._pending = self._pending, {}
            self._jobs.append(lambda: self._change_survey(folder, before))
            self._put += 1
            self._ready.notify_all()
        return folder.name

    # --- life ------------------------------------------------------------------------------------------------------

    @property
    def waiting(self) -> int:
        """Values that wait for the disk."""
        return len(self._pending)

    async def flush(self, timeout_s: float = 2.0) -> bool:
        """Wait until everything put so far is on disk; return False when ``timeout_s`` ran out."""
        loop = asyncio.get_running_loop()
        done = asyncio.Event()
        with self._ready:
            if self._synced >= self._put:
                return True
            self._waiters.append((self._put, lambda: _set(loop, done)))
            self._urgent = True
            self._ready.notify_all()
        try:
            async with asyncio.timeout(timeout_s):
                await done.wait()
        except TimeoutError:
            return False
        return True

    async def close(self) -> None:
        """Write the pending values, as far as the disk allows, and end the thread."""
        await self.flush(_CLOSE_S if self.health.is_healthy else _CLOSE_UNHEALTHY_S)
        loop = asyncio.get_running_loop()
        ended = asyncio.Event()
        with self._ready:
            if self._closing:
                return
            self._closing = True
            self._put += 1
            self._waiters.append((self._put, lambda: _set(loop, ended)))
            self._ready.notify_all()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_CLOSE_S):
                await ended.wait()
            self._thread.join(_CLOSE_S)  # its last act was to wake us

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

    def _written_now(self) -> dict[str, bytes]:
        return {WRITTEN: json.dumps(asdict(self._moment())).encode()}

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
        self._wake_synced(self._put)

    def _attempt(self, work: Callable[[], None]) -> bool:
        try:
            work()
        except Exception as error:  # a journal that cannot write must not end
            what = str(getattr(error, "strerror", None) or error)
            reason = say("Journal: {error} ({file})", error=what, file=str(self._survey))
            if self.health.reason != reason:
                _LOG.error("%s; trying again", reason)
            self.health = Health.bad(reason)
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
                self._start()
            self._append(taken)
        except OSError:
            with self._ready:  # values put meanwhile are newer
                self._pending = taken | self._pending
            raise
        if not self.health.is_healthy:
            _LOG.info("Journal: written again")
        self.health = Health()  # before the waiters wake
        self._wake_synced(target)
        if self._written > max(self._compact_bytes, _COMPACT_FACTOR * self._live_bytes()):
            self._open_file()

    def _wake_synced(self, target: int) -> None:
        with self._ready:
            self._synced = max(self._synced, target)
            due = [wake for number, wake in self._waiters if number <= self._synced]
            self._waiters = [waiter for waiter in self._waiters if waiter[0] > self._synced]
        for wake in due:
            wake()

    def _change_survey(self, folder: Path, before: Mapping[str, bytes]) -> None:
        """Write the old survey's values, then begin the new one with the values that outlast a survey."""
        with contextlib.suppress(OSError):
            if self._file is not None:
                self._append(before)
            self._close_file()
        merge(self._values, before)
        self._survey = folder
        self._values = {key: value for key, value in self._values.items() if _outlasts(key)}

    def _append(self, values: Mapping[str, bytes]) -> None:
        assert self._file is not None  # noqa: S101
        values = self._written_now() | {key: value for key, value in values.items() if key != WRITTEN}
        data = b"".join(pack(key, value) for key, value in values.items())
        _write_all(self._file, data)
        self._written += len(data)
        merge(self._values, values)

    def _open_file(self) -> None:
        """Begin a segment with all live values, and delete the older segments."""
        self._close_file()
        self._survey.mkdir(parents=True, exist_ok=True)
        old = segments_of(self._survey)
        path = self._survey / f"{1 + (int(old[-1].stem) if old else 0):06d}.journal"
        file = self._opener(path)
        self._drop_old_starts()
        data = b"".join(pack(key, value) for key, value in self._values.items())
        try:
            _write_all(file, data)
            sync_folder(self._survey)
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
        now = self._moment()
        for key in [key for key in self._values if key.startswith(START)]:
            if not any(_is_kept(start, now) for start in starts_of([key])):
                del self._values[key]

    def _close_file(self) -> None:
        file, self._file = self._file, None
        if file is not None:
            file.close()

    def _live_bytes(self) -> int:
        return sum(len(value) for value in self._values.values())

    def _name(self, after: int) -> str:
        stamp = time.strftime("%Y%m%dT%H%M%SZ", time.gmtime(self._moment().utc))
        return f"{after + 1:06d}-{stamp}"

    def _prune(self) -> None:
        for survey in surveys_of(self._directory)[: -self._keep - 1]:
            shutil.rmtree(survey, ignore_errors=True)


def _is_kept(start: Moment, now: Moment) -> bool:
    """Return True for a start that may still count; one of an earlier boot counts for a while after this one."""
    passed = now.since(start)
    return (now.seconds if passed is None else passed) <= _STARTS_KEPT_S


def _outlasts(key: str) -> bool:
    """Return True for a value that does not belong to one survey."""
    return key.startswith(START) or key in (DRAINS, FALL)


def _set(loop: asyncio.AbstractEventLoop, event: asyncio.Event) -> None:
    with contextlib.suppress(RuntimeError):  # the loop has ended
        loop.call_soon_threadsafe(event.set)


def _create(path: Path) -> IO[bytes]:
    return path.open("xb", buffering=0)


def _write_all(file: IO[bytes], data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[file.write(view) :]
    os.fsync(file.fileno())
