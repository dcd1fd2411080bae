"""Reads recordings, also those that a crash left without their end."""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any, Final, TypeVar

from mcap.exceptions import EndOfFile, McapError
from mcap.records import Channel, DataEnd, Message, Metadata

from hawk.store.frame_codec import FRAME_INPUT, decode_frame, join_frame
from hawk.store.mcap_records import TooLargeError, records_of

T = TypeVar("T")
CAMERA: Final = "camera"
"""Topic of the pictures (`hawk.store.views`)."""
STALLS_ON_EARTH: Final = "stalls_on_earth"
"""Topic of the stalls as GeoJSON (`hawk.store.views`)."""
KNOWN_LOT: Final = "known_lot"
"""Topic of the plans of known lots: the frames after it, whose field `KNOWN` names its time, have them."""
MESSAGE: Final = "message"
"""Topic of the flight's messages as the page has them: level, text, details, and the sentences among them."""
KNOWN: Final = "known"
LOTS: Final = "lots"
"""Field of `KNOWN_LOT` with the plans; before rounds its message was one plan."""
ZERO_UTC: Final = "zero_utc"
"""Metadata: UTC at second 0 of the run's clock by the autopilot's GNSS, as surveys have it; left out where unknown."""
METADATA: Final = "hawk"
"""Name of the metadata record with seed, configuration and version."""
FORMAT: Final = 2
"""The newest format. 1, without a number in the metadata, has no schemas and joins each picture to its frame."""
_MAGIC: Final = b"\x89MCAP0\r\n"
"""Last bytes of an MCAP file that was closed, as its first ones."""
NO_END: Final = "the file has no end: a crash or a copy cut it off"
"""Words for a recording that is not whole."""
_IMAGE_DATA: Final = 2  # field of foxglove.CompressedImage
_GEOJSON_TEXT: Final = 1  # field of foxglove.GeoJson


class RecordingError(Exception):
    """A file that is no recording, or is damaged; the text names it."""


@dataclass(frozen=True, slots=True)
class Recorded:
    """One recorded message. ``time`` in seconds of that run's clock.

    ``data`` is JSON; of a frame its fields and its picture, as `hawk.store.frame_codec` joins them; of a topic of
    `hawk.store.views` protobuf. ``place``: byte of the file at which ``data`` stands; None where it was put together.
    """

    topic: str
    time: float
    data: bytes = field(repr=False)
    place: int | None = None

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
        return decode_frame(self.data, kind, _of_rounds)


def _of_rounds(values: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of a frame; those of a recording before rounds had one lot, or none."""
    known, tour = values.get(KNOWN), values.pop("tour", None)
    plans = known.get(LOTS, [known]) if isinstance(known, dict) else known or []
    return {**values, KNOWN: plans, "tours": values.get("tours", [tour] if tour else [])}


def is_whole(path: Path) -> bool:
    """Return whether a recording was closed: a crash leaves it without its end. Raises RecordingError."""
    try:
        with path.open("rb") as stream:
            stream.seek(-len(_MAGIC), os.SEEK_END)
            return stream.read() == _MAGIC
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror or error}") from error


def read_recording(path: Path) -> Iterator[Recorded]:
    """Yield the messages in the order they were recorded. A torn end is skipped. Raises RecordingError."""
    channels: dict[int, Channel] = {}
    epoch_ns = 0
    last: dict[str, Message] = {}
    for record, end in _records(path):
        if isinstance(record, Channel):
            channels[record.id] = record
        elif isinstance(record, Metadata) and record.name == METADATA:
            epoch_ns = _epoch(path, record.metadata)
        elif isinstance(record, Message):
            channel, data = channels.get(record.channel_id), record.data
            place = None if end is None else end - len(data)
            if channel is None:
                raise RecordingError(f"{path}: is damaged: a message has no channel")
            if channel.topic in (CAMERA, KNOWN_LOT):
                last[channel.topic] = record
            elif channel.topic == FRAME_INPUT and channel.message_encoding == "json":
                data, place = _frame(path, record, last), None
            yield Recorded(channel.topic, (record.log_time - epoch_ns) / 1e9, data, place)


def _frame(path: Path, frame: Message, last: Mapping[str, Message]) -> bytes:
    """Return a frame with its picture, and with the plans of its known lots, as `hawk.store.frame_codec` joins them."""
    picture, known, fields = last.get(CAMERA), last.get(KNOWN_LOT), frame.data
    if picture is None or picture.log_time != frame.log_time:
        raise RecordingError(f"{path}: is damaged: a frame has no picture")
    if known is not None:
        name = f'"{KNOWN}":{{"topic":"{KNOWN_LOT}","log_time":{known.log_time}}}'.encode()
        fields = fields.replace(name, b'"known":' + known.data, 1)
    return join_frame(fields, _image_data(path, picture.data))


def _epoch(path: Path, metadata: Mapping[str, str]) -> int:
    """Return what is added to the clock in a file's times, nanoseconds. Raises RecordingError."""
    try:
        written, epoch_ns = int(metadata.get("format", "1")), int(metadata.get("epoch_ns", "0"))
    except ValueError as error:
        raise RecordingError(f"{path}: its metadata is damaged: {error}") from error
    if written > FORMAT:
        raise RecordingError(
            f"{path}: was recorded by a newer version ({metadata.get('version', 'unknown')}, format {written}); this "
            f"one reads up to format {FORMAT}: use that version, or a newer one"
        )
    return epoch_ns


def span_of(topic: str, message: bytes) -> slice:
    """Return where the picture stands in a message of `CAMERA`, or the text in a foxglove.GeoJson.

    Raises RecordingError.
    """
    try:
        return _span(message, _IMAGE_DATA if topic == CAMERA else _GEOJSON_TEXT)
    except ValueError as error:
        raise RecordingError(f"{topic}: is damaged: {error}") from error


def text_of_geojson(message: bytes) -> str:
    """Return the text of a foxglove.GeoJson. Raises RecordingError."""
    try:
        return message[_span(message, _GEOJSON_TEXT)].decode()
    except ValueError as error:
        raise RecordingError(f"stalls are no foxglove.GeoJson: {error}") from error


def _image_data(path: Path, image: bytes) -> bytes:
    """Return the picture of a foxglove.CompressedImage."""
    try:
        return image[_span(image, _IMAGE_DATA)]
    except ValueError as error:
        raise RecordingError(f"{path}: is damaged: a picture is no foxglove.CompressedImage: {error}") from error


def _span(message: bytes, field_number: int) -> slice:
    """Return where a field of a protobuf message stands whose fields before it have lengths; empty without it.

    https://protobuf.dev/programming-guides/encoding. Raises ValueError.
    """
    place = 0
    try:
        while place < len(message):
            tag, place = _varint(message, place)
            if tag & 7 != 2:
                raise ValueError(f"a field of wire type {tag & 7}")
            length, place = _varint(message, place)
            if tag >> 3 == field_number:
                return slice(place, place + length)
            place += length
    except IndexError as error:
        raise ValueError(str(error)) from error
    return slice(0, 0)


def _varint(data: bytes, place: int) -> tuple[int, int]:
    """Return a number, and the place after it. Raises IndexError."""
    value = shift = 0
    while True:
        byte = data[place]
        value |= (byte & 0x7F) << shift
        place, shift = place + 1, shift + 7
        if byte < 0x80:
            return value, place


def read_metadata(path: Path, most: int | None = None) -> dict[str, str]:
    """Return seed, configuration, version and start of a recording, from its first ``most`` records.

    Raises RecordingError when it has none.
    """
    for record, _ in islice(_records(path), most):
        if isinstance(record, Metadata) and record.name == METADATA:
            return dict(record.metadata)
    raise RecordingError(f"{path}: has no metadata {METADATA!r}")


def read_frames(path: Path, kind: type[T]) -> Iterator[T]:
    """Yield the frames of the algorithms, equal to the recorded ones. Raises RecordingError."""
    for recorded in read_recording(path):
        if recorded.topic == FRAME_INPUT:
            yield recorded.frame(kind)


def _records(path: Path) -> Iterator[tuple[Any, int | None]]:
    try:
        for record, end in records_of(path):
            if isinstance(record, DataEnd):
                return
            yield record, end
    except EndOfFile:
        return
    except TooLargeError as error:
        raise RecordingError(f"{path}: {error}") from error
    except (McapError, ValueError, OverflowError, LookupError, struct.error) as error:
        raise RecordingError(f"{path}: is no recording, or damaged: {error}") from error
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror or error}") from error
