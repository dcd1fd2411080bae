"""Reads recordings, also those that a crash left without their end."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, TypeVar, cast

from mcap.exceptions import EndOfFile, McapError
from mcap.records import Channel, DataEnd, Message, Metadata
from mcap.stream_reader import StreamReader

from hawk.store.recording import FRAME_INPUT, METADATA, decode_frame

T = TypeVar("T")


class RecordingError(Exception):
    """A file that is no recording, or is damaged; the text names it."""


@dataclass(frozen=True, slots=True)
class Recorded:
    """One recorded message. ``time`` in seconds of that run's clock; ``data`` as it was written."""

    topic: str
    time: float
    data: bytes = field(repr=False)

    def payload(self) -> dict[str, Any]:
        """Return the payload given to `Recording.record`, as JSON keeps it. Raises RecordingError for frames."""
        try:
            value = json.loads(self.data)
        except ValueError as error:
            raise RecordingError(f"{self.topic}: not JSON: {error}") from error
        if not isinstance(value, dict):
            raise RecordingError(f"{self.topic}: not an object")
        return value

    def frame(self, kind: type[T]) -> T:
        """Return the frame given to `Recording.record_frame`. Raises FrameFormatError."""
        return decode_frame(self.data, kind)


def read_recording(path: Path) -> Iterator[Recorded]:
    """Yield the messages in the order they were recorded. A torn end is skipped. Raises RecordingError."""
    channels: dict[int, str] = {}
    for record in _records(path):
        if isinstance(record, Channel):
            channels[record.id] = record.topic
        elif isinstance(record, Message):
            yield Recorded(channels[record.channel_id], record.log_time / 1e9, record.data)


def read_metadata(path: Path) -> dict[str, str]:
    """Return seed, configuration, version and start of a recording. Raises RecordingError when it has none."""
    for record in _records(path):
        if isinstance(record, Metadata) and record.name == METADATA:
            return dict(record.metadata)
    raise RecordingError(f"{path}: has no metadata {METADATA!r}")


def read_frames(path: Path, kind: type[T]) -> Iterator[T]:
    """Yield the frames of the algorithms, equal to the recorded ones. Raises RecordingError."""
    for recorded in read_recording(path):
        if recorded.topic == FRAME_INPUT:
            yield recorded.frame(kind)


class _WholeReads:
    """A stream whose reads are whole or end the file, so a torn last message is not read as a short one."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream

    def read(self, length: int) -> bytes:
        data = self._stream.read(length)
        if len(data) < length:
            raise EndOfFile
        return data


def _records(path: Path) -> Iterator[Any]:
    try:
        with path.open("rb") as stream:
            for record in StreamReader(cast("IO[bytes]", _WholeReads(stream))).records:
                if isinstance(record, DataEnd):
                    return
                yield record
    except EndOfFile:
        return
    except McapError as error:
        raise RecordingError(f"{path}: is no recording, or damaged: {error}") from error
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror or error}") from error
