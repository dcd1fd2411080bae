"""The recording of a flight (MCAP, https://mcap.dev): every input, decision and command, written off the loop.

One file a flight. Messages are written as they come, not in chunks, and flushed four times a second: a crash loses
less than a second, and the rest can be read. The queue is bounded by bytes; messages beyond it are dropped, counted
and shown in health.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import shutil
import struct
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import IO, Any, TypeVar

from mcap.writer import CompressionType, IndexType, Writer
from pydantic import ConfigDict, TypeAdapter, ValidationError

from hawk.config.sections import StoreSettings
from hawk.model.operation import Health
from hawk.model.sentences import say

T = TypeVar("T")
_LENGTH = struct.Struct("<I")
_PICTURE = "jpeg"
_FINITE = TypeAdapter[Any](Any, config=ConfigDict(ser_json_inf_nan="strings"))


class FrameFormatError(ValueError):
    """Bytes that are no frame; the text says what is wrong."""


def encode_frame(frame: Any) -> bytes:
    """Return a dataclass with a ``jpeg: bytes`` field as bytes. Raises TypeError for anything else."""
    if not is_dataclass(frame) or isinstance(frame, type) or not isinstance(getattr(frame, _PICTURE, None), bytes):
        raise TypeError(f"{type(frame).__name__} is no dataclass with a {_PICTURE} field of bytes")
    values = {item.name: getattr(frame, item.name) for item in fields(frame) if item.name != _PICTURE}
    header = json.dumps(values, default=to_plain, separators=(",", ":")).encode()
    picture: bytes = getattr(frame, _PICTURE)
    return b"".join((_LENGTH.pack(len(header)), header, picture))


def decode_frame(data: bytes, kind: type[T]) -> T:
    """Return the dataclass of `encode_frame`, equal to the one that went in. Raises FrameFormatError."""
    if len(data) < _LENGTH.size:
        raise FrameFormatError("the frame has no header")
    (length,) = _LENGTH.unpack_from(data)
    end = _LENGTH.size + length
    if end > len(data):
        raise FrameFormatError(f"the frame's header has {length} bytes, only {len(data) - _LENGTH.size} are there")
    try:
        values = json.loads(data[_LENGTH.size : end])
        return TypeAdapter(kind).validate_python({**values, _PICTURE: data[end:]})
    except (ValidationError, ValueError, TypeError) as error:
        raise FrameFormatError(f"the frame is no {kind.__name__}: {error}") from error


def picture_of(data: bytes) -> bytes:
    """Return the picture of `encode_frame` alone. Raises FrameFormatError."""
    return data[_header_end(data) :]


def values_of(data: bytes) -> dict[str, Any]:
    """Return the fields of `encode_frame` without the picture, as JSON keeps them. Raises FrameFormatError."""
    end = _header_end(data)
    try:
        values = json.loads(data[_LENGTH.size : end])
    except ValueError as error:
        raise FrameFormatError(f"the frame's header is not JSON: {error}") from error
    if not isinstance(values, dict):
        raise FrameFormatError("the frame's header is no object")
    return values


def _header_end(data: bytes) -> int:
    if len(data) < _LENGTH.size or (end := _LENGTH.size + _LENGTH.unpack_from(data)[0]) > len(data):
        raise FrameFormatError("the frame's header is torn")
    return int(end)


def to_json(payload: Any) -> str:
    """Return a payload as JSON. JSON has no infinity: such numbers become "Infinity", "-Infinity" or "NaN"."""
    try:
        return json.dumps(payload, default=to_plain, separators=(",", ":"), allow_nan=False)
    except ValueError:
        return _FINITE.dump_json(json.loads(json.dumps(payload, default=to_plain))).decode()


def to_plain(value: Any) -> Any:
    """Return what JSON can hold of a dataclass, array scalar, set or path; for ``json.dumps(default=...)``."""
    if is_dataclass(value) and not isinstance(value, type):
        return {item.name: getattr(value, item.name) for item in fields(value)}
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, bytes):
        return f"<{len(value)} bytes>"
    if isinstance(value, set | frozenset):
        return sorted(value, key=str)
    return str(value)


_LOG = logging.getLogger(__name__)

FRAME_INPUT = "frame_input"
"""Topic of the frames of the algorithms."""
METADATA = "hawk"
"""Name of the metadata record with seed, configuration and version."""
FLUSH_S = 0.25
_DROPS_SHOWN_S = 10.0
_QUEUE_BYTES = 64_000_000
_SMALL = 2_000
_CLOSE_S = 5.0
_STOPPED = "Recording stopped"
_JSON, _FRAME = "json", "hawk-frame"


class NoRecordingError(Exception):
    """There is no complete recording; the message says why."""


@dataclass(frozen=True, slots=True)
class _Item:
    topic: str
    payload: Any
    is_frame: bool
    time_ns: int
    size: int


class Recording:
    """Writes recordings. `begin` opens a file, `end` finishes it; messages outside are ignored."""

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
    ) -> None:
        """Start the thread; nothing is written before `begin`.

        ``metadata`` goes into every file: seed, configuration and version of this run. ``retry_s``: real seconds
        between two looks at the free space, and before a new file after a failure.
        """
        self._folder = settings.directory / "recordings"
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
        self._queue: deque[_Item] = deque()
        self._queued = 0
        self._wanted = False
        self._closing = False
        self._ended: Callable[[], None] = lambda: None
        self.dropped = 0
        """Number of messages that did not fit into the queue or could not be written."""
        self._dropped_at = float("-inf")
        self._health = Health()
        self._file: _McapFile | None = None
        self.path: Path | None = None
        """The newest file."""
        self._thread = threading.Thread(target=self._run, name="recording", daemon=True)
        self._thread.start()

    def begin(self) -> None:
        """Record into a new file from now on. Does nothing while it records, or when it is switched off."""
        with self._ready:
            self._wanted = self._enabled
            self._ready.notify_all()

    def end(self) -> None:
        """Finish the file."""
        with self._ready:
            self._wanted = False
            self._ready.notify_all()

    def record(self, kind: str, payload: Mapping[str, Any]) -> None:
        """Record inputs, a decision or a command under a topic. ``payload`` must not change afterwards."""
        self._put(kind, payload, is_frame=False, size=_SMALL)

    def record_frame(self, frame: Any) -> None:
        """Record a frame of the algorithms: a frozen dataclass with a ``jpeg`` field, kept without loss."""
        self._put(FRAME_INPUT, frame, is_frame=True, size=_SMALL + len(frame.jpeg))

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
            await asyncio.wait_for(ended.wait(), _CLOSE_S)
            self._thread.join(_CLOSE_S)  # its last act was to wake us

    # --- inside ----------------------------------------------------------------------------------------------------

    def _put(self, topic: str, payload: Any, *, is_frame: bool, size: int) -> None:
        now = self._clock()
        with self._ready:
            if not self._wanted:
                return
            if self._queued + size > self._limit:
                self.dropped += 1
                self._dropped_at = now
                return
            self._queue.append(_Item(topic, payload, is_frame, round(now * 1e9), size))
            self._queued += size

    def _run(self) -> None:
        space_checked = float("-inf")
        while True:
            with self._ready:
                if not self._closing:
                    self._ready.wait(FLUSH_S if self._wanted or self._queue or self._file else None)
                items, self._queue, self._queued = self._queue, deque(), 0
                wanted, closing = self._wanted, self._closing
            try:
                if wanted and time.monotonic() - space_checked >= self._retry_s:
                    space_checked = time.monotonic()
                    self._check_space()
                self._write(items, wanted)
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

    def _write(self, items: deque[_Item], wanted: bool) -> None:
        if self._file is None and (items or wanted) and self._has_space():
            self._open()
        if self._file is None:
            self._lose(len(items))
            return
        for item in items:
            try:
                data = _encode(item)
            except (TypeError, ValueError) as error:
                _LOG.error("Recording: a message of %s cannot be kept: %s", item.topic, error)
                self._lose(1)
                continue
            self._file.write(item.topic, _FRAME if item.is_frame else _JSON, item.time_ns, data)
        self._file.stream.flush()
        if not wanted:
            self._finish()

    def _open(self) -> None:
        self._folder.mkdir(parents=True, exist_ok=True)
        now = self._utc()
        stem = now.strftime("%Y%m%dT%H%M%SZ")
        path = self._folder / f"{stem}.mcap"
        for number in range(2, 1000):
            if not path.exists():
                break
            path = self._folder / f"{stem}-{number}.mcap"
        metadata = {**self._metadata, "utc": now.isoformat(), "clock": repr(self._clock())}
        self._file = _McapFile(self._opener(path), metadata)
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
        reason = say(
            "Recording stopped: {free} MB are free, store.minimum_free_mb is {least}: delete old files in {folder}",
            free=free // 1_000_000,
            least=self._least_free // 1_000_000,
            folder=str(self._folder),
        )
        if self._has_space():
            _LOG.warning(reason)
        self._health = Health.bad(reason)

    def _lose(self, count: int) -> None:
        with self._ready:
            self.dropped += count

    def _fail(self, reason: str, lost: int) -> None:
        self._lose(lost)
        if self._health.reason != reason:
            _LOG.error("%s; trying again", reason)
        self._health = Health.bad(reason)
        file, self._file = self._file, None
        if file is not None:
            file.abandon()


def _encode(item: _Item) -> bytes:
    if item.is_frame:
        return encode_frame(item.payload)
    return to_json(item.payload).encode()


class _McapFile:
    """One MCAP file: a channel for each topic, made with its first message."""

    def __init__(self, stream: IO[bytes], metadata: Mapping[str, str]) -> None:
        self.stream = stream
        self._channels: dict[str, int] = {}
        try:
            self._writer = Writer(
                stream,
                compression=CompressionType.NONE,
                index_types=IndexType.METADATA,
                use_chunking=False,
            )
            self._writer.start(profile="hawk", library="hawk-drone")
            self._writer.add_metadata(METADATA, dict(metadata))
            stream.flush()
        except BaseException:
            self.abandon()
            raise

    def write(self, topic: str, encoding: str, time_ns: int, data: bytes) -> None:
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._channels[topic] = self._writer.register_channel(topic, encoding, schema_id=0)
        self._writer.add_message(channel, time_ns, data, time_ns)

    def close(self) -> None:
        try:
            self._writer.finish()  # type: ignore[no-untyped-call]
        finally:
            self.stream.close()

    def abandon(self) -> None:
        """Close a file that cannot be written; its contents stay readable."""
        with contextlib.suppress(OSError, ValueError):
            self.stream.close()


def newest_file(folder: Path) -> Path:
    """Return the newest file of recordings in a folder. Raises ValueError when it has none, and OSError."""
    return max(folder.glob("*.mcap"), key=lambda path: path.stat().st_mtime_ns)
