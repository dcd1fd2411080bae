"""The recording of a flight (MCAP, https://mcap.dev): every input, decision and command, written off the loop.

One file a flight; it begins with what came in the last minute before. Messages are flushed four times a second: a crash
loses less than a second, and the rest can be read. The queue is bounded by bytes; messages beyond it are dropped,
counted and shown in health.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import shutil
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Literal

from hawk.config.sections import StoreSettings
from hawk.model.operation import Health
from hawk.model.sentences import say
from hawk.store.frame_codec import FRAME_INPUT, View
from hawk.store.recordings import Recordings
from hawk.store.ring_buffer import Item, Ring

if TYPE_CHECKING:
    from hawk.store.recording_file import JsonSchemas, RecordingFile

_LOG = logging.getLogger(__name__)

MEMORY = "memory"
"""Topic of what the decider remembers (`hawk.ddc.recorder`): a reader can begin there."""
FLUSH_S = 0.25
_DROPS_SHOWN_S = 10.0
_QUEUE_BYTES = 64_000_000
_SMALL = 2_000
_STALL = 1_000
_CLOSE_S = 5.0
_STOPPED = "Recording stopped"
_MB = 1_000_000
TIDY_S = 10.0
"""Real seconds between two looks at the folder on the ground."""


class NoRecordingError(Exception):
    """There is no complete recording; the message says why."""


class Recording:
    """Writes recordings. `begin` opens a file, `end` finishes it; of messages outside the last minute is held."""

    def __init__(
        self,
        settings: StoreSettings,
        clock: Callable[[], float],
        metadata: Mapping[str, str],
        *,
        utc: Callable[[], datetime] = lambda: datetime.now(UTC),
        free_bytes: Callable[[Path], int] = lambda path: shutil.disk_usage(path).free,
        opener: Callable[[Path], IO[bytes]] = lambda path: path.open("xb"),
        queue_bytes: int = _QUEUE_BYTES,
        retry_s: float = 2.0,
        json_schemas: JsonSchemas = dict,
        about: Callable[[], Mapping[str, str]] = dict,
        ring: Ring | None = None,
    ) -> None:
        """Start the thread; nothing is written before `begin`.

        ``metadata`` goes into every file: seed, configuration and version of this run. ``retry_s``: real seconds
        between two looks at the free space, and before a new file after a failure. ``json_schemas`` and
        ``about``, more metadata of a file that begins, are called by the thread.
        """
        self.folder = Recordings(settings, self._under_way, lambda: self._utc().timestamp())
        """The files on the disk."""
        self._folder = self.folder.folder
        self._least_free = settings.minimum_free_mb * 1_000_000
        self._enabled = settings.record
        self._clock = clock
        self._metadata = dict(metadata)
        self._utc = utc
        self._free_bytes = free_bytes
        self._opener = opener
        self._limit = queue_bytes
        self._retry_s = retry_s
        self._ready = threading.Condition()
        self._queue: deque[Item] = deque()
        self._queued = 0
        self._wanted = self._closing = self._is_on_ground = self._has_entry = False
        self._ended: Callable[[], None] = lambda: None
        self.dropped = 0
        """Number of messages that did not fit into the queue or could not be written."""
        self._dropped_at = self._tidied = float("-inf")
        self._health = Health()
        self._file: RecordingFile | None = None
        self._json_schemas = json_schemas
        self._about = about
        self._ring = ring or Ring()
        self.path: Path | None = None
        """The newest file."""
        self._thread = threading.Thread(target=self._run, name="recording", daemon=True)
        self._thread.start()

    def begin(self) -> None:
        """Record into a new file from now on. Does nothing while it records, or when it is switched off."""
        with self._ready:
            self._is_on_ground = False
            if self._enabled and not self._wanted and not self._closing:
                self._wanted = True
                before = self._ring.take()
                self._queue.extend(before)
                self._queued += sum(item.size for item in before)
            self._ready.notify_all()

    def end(self) -> None:
        """Finish the file: the motors are off. Old recordings may be removed from now on."""
        with self._ready:
            if self._wanted:
                self._wanted = self._has_entry = False
            if not self._is_on_ground:
                self._is_on_ground, self._tidied = True, float("-inf")
            self._ready.notify_all()

    def wants_memory(self) -> bool:
        """Return True while what was recorded last has no `MEMORY` from which a reader could begin."""
        return self._enabled and not self._has_entry

    def record(self, kind: str, payload: Mapping[str, Any]) -> None:
        """Record inputs, a decision or a command under a topic. ``payload`` must not change afterwards."""
        self._put(kind, payload, "json", _SMALL)

    def show(self, view: View) -> None:
        """Record a value for viewers: a pose, a message, or stalls. It must not change afterwards."""
        self._put("", view, "view", _SMALL + _STALL * len(getattr(view, "stalls", ())))

    def record_frame(self, frame: Any) -> None:
        """Record a frame of the algorithms: a frozen dataclass with a ``jpeg`` field, kept without loss."""
        self._put(FRAME_INPUT, frame, "frame", _SMALL + len(frame.jpeg))

    def newest(self) -> Path:
        """Return the newest complete file, of an earlier run too. Reads the folder. Raises NoRecordingError."""
        if self.recording or self._queue:
            raise NoRecordingError(say("The recording is not complete yet."))
        try:
            return newest_file(self._folder)
        except (ValueError, OSError):
            reason = (
                say("There is no recording yet.")
                if self._enabled
                else say("Nothing is recorded: [store] record is false.")
            )
            raise NoRecordingError(reason) from None

    @property
    def waiting(self) -> int:
        """Messages that wait for the disk."""
        return len(self._queue)

    @property
    def recording(self) -> bool:
        """True while a file is written."""
        return self._file is not None

    @property
    def health(self) -> Health:
        """Unhealthy while messages are missing."""
        if self._health.is_healthy and self._clock() - self._dropped_at < _DROPS_SHOWN_S:
            return Health.bad(
                say("Recording: the disk is too slow, {dropped} messages are missing", dropped=self.dropped)
            )
        return self._health

    async def close(self) -> None:
        """Finish the file and end the thread; no longer than 5 s."""
        loop = asyncio.get_running_loop()
        ended = asyncio.Event()

        def wake() -> None:
            with contextlib.suppress(RuntimeError):  # the loop has ended
                loop.call_soon_threadsafe(ended.set)

        with self._ready:
            if self._closing:
                return
            self._ended, self._wanted, self._closing = wake, False, True
            self._ready.notify_all()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_CLOSE_S):
                await ended.wait()
            self._thread.join(_CLOSE_S)  # its last act was to wake us

    # --- inside ----------------------------------------------------------------------------------------------------

    def _put(self, topic: str, payload: Any, kind: Literal["json", "frame", "view"], size: int) -> None:
        now = self._clock()
        item, is_entry = Item(topic, payload, kind, round(now * 1e9), size), topic == MEMORY
        with self._ready:
            if not self._enabled or self._closing:
                return
            if not self._wanted:
                goes_on = self._ring.add(item, is_entry=is_entry)
                self._has_entry = goes_on and (self._has_entry or is_entry)
                return
            if self._queued + size > self._limit:
                self.dropped += 1
                self._dropped_at = now
                self._has_entry = self._has_entry and kind != "json"
                return
            self._has_entry = self._has_entry or is_entry
            self._queue.append(item)
            self._queued += size

    def _run(self) -> None:
        space_checked = float("-inf")
        while True:
            with self._ready:
                if not self._closing:
                    self._ready.wait(FLUSH_S if self._wanted or self._queue or self._file else self._idle_s())
                items, self._queue, self._queued = self._queue, deque(), 0
                wanted, closing = self._wanted, self._closing
            try:
                if wanted and time.monotonic() - space_checked >= self._retry_s:
                    space_checked = time.monotonic()
                    self._check_space()
                self._write(items, wanted)
                items = deque()  # none is lost by what follows
                self._tidy()
            except Exception as error:  # a recording that fails must not end
                self._fail(
                    say(
                        "Recording: {error} ({folder})",
                        error=str(getattr(error, "strerror", None) or error),
                        folder=str(self._folder),
                    ),
                    len(items),
                )
                with self._ready:
                    self._ready.wait_for(lambda: self._closing, 0 if closing else self._retry_s)
            if closing:
                break
        self._ended()

    def _idle_s(self) -> float | None:
        return TIDY_S if self._enabled and self._is_on_ground else None

    def _under_way(self) -> Path | None:
        return self.path if self._file is not None else None

    def _tidy(self) -> None:
        """Keep the folder within its limits, and the disk free: on the ground alone, and between flights."""
        if not self._enabled or not self._is_on_ground or self._file or time.monotonic() - self._tidied < TIDY_S:
            return
        self._tidied = time.monotonic()
        _load(self._json_schemas)
        if not self._folder.is_dir():
            return
        removed = self.folder.tidy()
        free = self._free_bytes(self._folder)
        if free < self._least_free:
            removed += self.folder.make_room(2 * self._least_free - free)
        if removed:
            _LOG.info("Recordings removed, the oldest first: %s", ", ".join(removed))
        self._check_space()

    def _write(self, items: deque[Item], wanted: bool) -> None:
        if self._file is None and (items or wanted) and self._has_space():
            self._open()
        if self._file is None:
            self._lose(len(items))
            return
        for item in items:
            try:
                self._file.write(item)
            except (TypeError, ValueError) as error:
                _LOG.error("Recording: a message of %s cannot be kept: %s", item.topic or item.kind, error)
                self._lose(1)
        self._file.stream.flush()
        if not wanted:
            self._finish()

    def _open(self) -> None:
        self._folder.mkdir(parents=True, exist_ok=True)
        now = self._utc()
        path = self._folder / self.folder.free_name(now.strftime("%Y%m%dT%H%M%SZ"))
        # Imported here, by the thread: the encoder takes a tenth of a second, in which a start in the air must act.
        from hawk.store.recording_file import RecordingFile, start_metadata

        metadata = start_metadata({**self._metadata, **self._about()}, now, self._clock())
        self._file = RecordingFile(self._opener(path), metadata, self._json_schemas)
        self.path = path
        self._health = Health()

    def _finish(self) -> None:
        file, self._file = self._file, None
        if file is not None:
            file.close()

    def _has_space(self) -> bool:
        return not self._health.reason.startswith(_STOPPED)

    def _check_space(self) -> None:
        self._folder.mkdir(parents=True, exist_ok=True)
        free = self._free_bytes(self._folder)
        if free >= self._least_free:
            if not self._has_space():
                self._health = Health()
            return
        self._finish()
        taken, kept = self.folder.taken()
        reason = say(
            "Recording stopped: {free} MB are free, store.minimum_free_mb is {least}. Recordings take {taken} MB, "
            "{kept} MB of them are kept; other files fill the rest: delete some ({folder})",
            free=free // _MB,
            least=self._least_free // _MB,
            taken=taken // _MB,
            kept=kept // _MB,
            folder=str(self._folder),
        )
        if self._has_space():
            _LOG.warning(reason)
        self._health = Health.bad(reason)

    def _lose(self, count: int) -> None:
        with self._ready:
            self.dropped += count
            self._has_entry = self._has_entry and count == 0

    def _fail(self, reason: str, lost: int) -> None:
        self._lose(lost)
        if self._health.reason != reason:
            _LOG.error("%s; trying again", reason)
        self._health = Health.bad(reason)
        file, self._file = self._file, None
        if file is not None:
            file.abandon()


def _load(json_schemas: JsonSchemas) -> None:
    """Load the encoder and make the schemas before Arm: the flight's first seconds need the processor."""
    import hawk.store.recording_file  # noqa: F401

    json_schemas()


def newest_file(folder: Path) -> Path:
    """Return the newest file of recordings in a folder. Raises ValueError when it has none, and OSError."""
    return max(folder.glob("*.mcap"), key=lambda path: path.stat().st_mtime_ns)
