"""One file of a recording: MCAP (https://mcap.dev) whose messages are written as they come, not in chunks.

Own topics hold JSON with a JSON Schema, those of `hawk.store.views` Foxglove's messages. A picture is stored once, on
the topic ``camera``, and the plans of known lots on ``known_lot``; the other fields of a frame are JSON on
``frame_input``, which names the times of both. The summary at the end, with schemas, channels and counts, is written
when the file is closed; readers do without it.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable, Mapping
from datetime import datetime
from typing import IO, Any, Final

from foxglove import Schema
from mcap.writer import CompressionType, IndexType, Writer

from hawk.model.pictures import CameraModel
from hawk.store.frame_codec import parts_of, to_json
from hawk.store.replay import CAMERA, FORMAT, KNOWN, KNOWN_LOT, LOTS, METADATA
from hawk.store.ring_buffer import Item
from hawk.store.views import calibration_message, picture_message, schema_of, views_of

PICTURE: Final = "picture"
"""Field of a frame: topic and time of its picture."""
_CALIBRATION_S: Final = 1.0
JsonSchemas = Callable[[], Mapping[str, Mapping[str, Any]]]
"""Returns the JSON Schema of each topic that has one of its own."""


def start_metadata(metadata: Mapping[str, str], utc: datetime, clock: float) -> dict[str, str]:
    """Return the metadata of a file that begins now.

    ``epoch_ns`` is added to the clock, in nanoseconds, for the times of the file: UTC, as the computer's clock was at
    the start. A clock that jumps in flight leaves no mark in the times.
    """
    epoch_ns = max(0, round(utc.timestamp() * 1e9) - round(clock * 1e9))
    times = {"utc": utc.isoformat(), "clock": repr(clock), "epoch_ns": str(epoch_ns)}
    return {**metadata, "format": str(FORMAT), **times}


class RecordingFile:
    """Makes a channel for each topic with its first message."""

    def __init__(self, stream: IO[bytes], metadata: Mapping[str, str], json_schemas: JsonSchemas) -> None:
        """Write the head. ``metadata``: that of `start_metadata`. Raises OSError; the stream is closed then."""
        self.stream = stream
        self._epoch_ns = int(metadata["epoch_ns"])
        self._json_schemas = json_schemas
        self._channels: dict[str, int] = {}
        self._camera: CameraModel | None = None
        self._camera_at = 0
        self._known: object = None
        self._known_at = 0
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

    def write(self, item: Item) -> None:
        """Write a message. Raises TypeError, ValueError for one that cannot be kept, and OSError."""
        time_ns = item.time_ns + self._epoch_ns
        if item.kind == "frame":
            self._write_frame(item, time_ns)
        elif item.kind == "view":
            for topic, data in views_of(item.payload, time_ns):
                self._view(topic, time_ns, data)
        else:
            self._json(item.topic, time_ns, item.payload)

    def close(self) -> None:
        """Write the summary and close. Raises OSError."""
        try:
            self._writer.finish()  # type: ignore[no-untyped-call]
        finally:
            self.stream.close()

    def abandon(self) -> None:
        """Close a file that cannot be written; its contents stay readable."""
        with contextlib.suppress(OSError, ValueError):
            self.stream.close()

    def _write_frame(self, item: Item, time_ns: int) -> None:
        values, jpeg = parts_of(item.payload)
        if values.get(KNOWN):
            values[KNOWN] = self._known_lots(values[KNOWN], time_ns)
        header = to_json({**values, PICTURE: {"topic": CAMERA, "log_time": time_ns}}).encode()
        camera, captured = values.get("camera"), values.get("captured")
        if isinstance(camera, CameraModel) and (
            camera != self._camera or time_ns - self._camera_at >= _CALIBRATION_S * 1e9
        ):
            self._camera, self._camera_at = camera, time_ns
            self._view(*_timed(calibration_message(camera, time_ns), time_ns))
        exposed = time_ns if captured is None else max(0, round(captured * 1e9) + self._epoch_ns)
        self._view(*_timed(picture_message(jpeg, exposed), time_ns))
        self._add(self._json_channel(item.topic), time_ns, header)

    def _known_lots(self, known: object, time_ns: int) -> dict[str, object]:
        """Return the name of the known lots' message, which is written once: each frame of a flight has the same."""
        if known is not self._known:
            self._known, self._known_at = known, time_ns
            self._json(KNOWN_LOT, time_ns, {LOTS: known})
        return {"topic": KNOWN_LOT, "log_time": self._known_at}

    def _json(self, topic: str, time_ns: int, payload: Any) -> None:
        data = to_json(payload).encode()
        self._add(self._json_channel(topic), time_ns, data)

    def _json_channel(self, topic: str) -> int:
        if topic not in self._channels:
            schema = {"title": f"hawk.{topic}", "type": "object", **self._json_schemas().get(topic, {})}
            self._register(topic, "json", Schema(name=f"hawk.{topic}", encoding="jsonschema", data=_bytes(schema)))
        return self._channels[topic]

    def _view(self, topic: str, time_ns: int, data: bytes) -> None:
        if topic not in self._channels:
            self._register(topic, "protobuf", schema_of(topic))
        self._add(self._channels[topic], time_ns, data)

    def _register(self, topic: str, encoding: str, schema: Schema) -> None:
        number = self._writer.register_schema(schema.name, schema.encoding, schema.data)
        self._channels[topic] = self._writer.register_channel(topic, encoding, schema_id=number)

    def _add(self, channel: int, time_ns: int, data: bytes) -> None:
        self._writer.add_message(channel, time_ns, data, time_ns)


def _timed(coded: tuple[str, bytes], time_ns: int) -> tuple[str, int, bytes]:
    topic, data = coded
    return topic, time_ns, data


def _bytes(schema: Mapping[str, Any]) -> bytes:
    return json.dumps(schema, separators=(",", ":")).encode()
