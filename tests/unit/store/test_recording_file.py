"""A recording's file, read by the plain reader of the field, each channel decoded by its own schema."""

from __future__ import annotations

import io
import json
import math
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from google.protobuf.json_format import MessageToDict
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.records import Schema

from hawk.algo.frame import FrameInput
from hawk.daemon.recording_parts import json_schemas
from hawk.model.known_lot import KnownLot, KnownStall
from hawk.model.lot_map import Stall, StallState
from hawk.model.poses import GlobalPose, MapPose, VehiclePose
from hawk.store.frame_codec import FRAME_INPUT, MapStalls, Words, to_json
from hawk.store.recording_file import RecordingFile, start_metadata
from hawk.store.replay import RecordingError, read_frames, read_metadata, read_recording
from hawk.store.ring_buffer import Item
from tests.unit.ddc.fakes import Rig
from tests.unit.store.test_frame_codec import FRAME

START = datetime(2026, 5, 1, 12, 0, 0, tzinfo=UTC)
S = 1_000_000_000
DATUM = GlobalPose(48.0, 11.0, 500.0)
STALLS = {
    7: Stall(7, 10.0, 20.0, 0.0, 2.5, 5.0, 0.9, StallState.TAKEN, 0.95, 4, 12.0, 1),
    9: Stall(9, 10.0, 23.0, 0.0, 2.5, 5.0, 0.1, StallState.FREE, 0.95, 4, 12.0, 1),
}
POSE = VehiclePose(
    12.0, GlobalPose(48.1, 11.1, 530.0), 30.0, None, MapPose(3.0, 4.0, 30.0, 0.0, 0.0, math.pi / 2), (0.0, 0.0, 0.0),
    0.0, 0.0, math.pi / 2,
)  # fmt: skip


def view(value: Any, seconds: float = 12.0) -> Item:
    return Item("", value, "view", round(seconds * S), 1)


def record(topic: str, payload: Any, seconds: float = 12.0) -> Item:
    return Item(topic, payload, "json", round(seconds * S), 1)


def frame(number: int, seconds: float = 12.0) -> Item:
    return Item(FRAME_INPUT, replace(FRAME, sequence=number, captured=seconds - 0.1), "frame", round(seconds * S), 1)


def write(path: Path, items: list[Item], **metadata: str) -> Path:
    head = {**start_metadata({"version": "0.1.0"}, START, 10.0), **metadata}
    file = RecordingFile(path.open("wb"), head, json_schemas)
    for item in items:
        file.write(item)
    file.close()
    return path


def decoded(schema: Schema, data: bytes) -> Any:
    """Decode a message by its schema alone, as a viewer does."""
    if schema.encoding == "jsonschema":
        payload = json.loads(data)
        jsonschema.validate(payload, json.loads(schema.data))
        return payload
    files = descriptor_pb2.FileDescriptorSet.FromString(schema.data)
    pool = descriptor_pool.DescriptorPool()
    for file in files.file:
        pool.Add(file)
    message = message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name))()
    message.ParseFromString(data)
    return MessageToDict(message, preserving_proto_field_name=True)


def messages(path: Path) -> list[tuple[str, str, int, Any]]:
    """Return topic, name of the schema, time (seconds) and content of every message."""
    found = []
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages(log_time_order=False):
            assert schema is not None
            found.append((channel.topic, schema.name, message.log_time, decoded(schema, message.data)))
    return found


def by_topic(path: Path) -> dict[str, Any]:
    return {topic: content for topic, _, _, content in messages(path)}


@pytest.mark.nightly
def test_each_channel_is_decoded_by_its_own_schema(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.manager.process()
    records = [record(kind, json.loads(to_json(payload))) for kind, payload in rig.records]
    items = [*records, frame(1), view(POSE), view(Words("warning", "Wind.", "12 m/s")), view(MapStalls(DATUM, STALLS))]
    path = write(tmp_path / "flight.mcap", items)
    found = {topic: name for topic, name, _, _ in messages(path)}
    assert {topic: name for topic, name in found.items() if name.startswith("foxglove.")} == {
        "camera": "foxglove.CompressedImage",
        "camera_calibration": "foxglove.CameraCalibration",
        "location": "foxglove.LocationFix",
        "pose": "foxglove.PoseInFrame",
        "log": "foxglove.Log",
        "stalls_on_earth": "foxglove.GeoJSON",
        "stalls": "foxglove.SceneUpdate",
    }
    assert {"tick", "memory", FRAME_INPUT} <= found.keys()
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == len(messages(path))
    assert {channel.topic for channel in summary.channels.values()} == found.keys()


def test_viewers_see_what_was_there(tmp_path: Path) -> None:
    items = [frame(1), view(POSE), view(Words("warning", "Wind.", "12 m/s")), view(MapStalls(DATUM, STALLS))]
    shown = by_topic(write(tmp_path / "flight.mcap", items))
    assert shown["camera"]["format"] == "jpeg"
    assert shown["camera"]["timestamp"] == "2026-05-01T12:00:01.900Z"
    assert shown["camera_calibration"]["width"] == FRAME.camera.width
    assert shown["camera_calibration"]["K"][0] == FRAME.camera.fx
    assert shown["camera_calibration"]["D"] == [0.1, -0.2, 0.0, 0.0, 0.0]
    assert shown["location"] == {
        "timestamp": "2026-05-01T12:00:02Z", "frame_id": "drone", "latitude": 48.1, "longitude": 11.1, "altitude": 530.0
    }  # fmt: skip
    assert shown["pose"]["pose"]["position"] == {"x": 4.0, "y": 3.0, "z": 30.0}
    assert shown["pose"]["pose"]["orientation"] == {"w": 1.0}  # eastwards is along x
    assert (shown["log"]["level"], shown["log"]["message"]) == ("WARNING", "Wind.\n12 m/s")
    features = json.loads(shown["stalls_on_earth"]["geojson"])["features"]
    assert [(one["id"], one["properties"]["state"]) for one in features] == [(7, "taken"), (9, "free")]
    (entity,) = shown["stalls"]["entities"]
    (lines,) = entity["lines"]
    assert (entity["frame_id"], lines["type"], len(lines["points"])) == ("map", "LINE_LIST", 16)
    corners = {(point.get("x", 0.0), point.get("y", 0.0)) for point in lines["points"][:8]}
    assert corners == {(18.75, 7.5), (18.75, 12.5), (21.25, 7.5), (21.25, 12.5)}


@given(st.floats(-3, 3), st.floats(-1.5, 1.5), st.floats(-3, 3))
def test_the_nose_of_a_pose_points_where_yaw_and_pitch_say(roll: float, pitch: float, yaw: float) -> None:
    from hawk.store.views import _quaternion

    x, y, z, w = _quaternion(roll, -pitch, math.pi / 2 - yaw)
    nose = (1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w))
    east, north = math.sin(yaw) * math.cos(pitch), math.cos(yaw) * math.cos(pitch)
    assert nose == pytest.approx((east, north, math.sin(pitch)), abs=1e-9)


def test_an_empty_map_takes_the_stalls_away(tmp_path: Path) -> None:
    shown = by_topic(write(tmp_path / "flight.mcap", [view(MapStalls(DATUM, {}))]))
    assert shown["stalls"]["deletions"][0]["type"] == "ALL"


def test_a_picture_is_stored_once(tmp_path: Path) -> None:
    jpeg = bytes(range(256)) * 400
    item = Item(FRAME_INPUT, replace(FRAME, jpeg=jpeg), "frame", 12 * S, 1)
    path = write(tmp_path / "flight.mcap", [item])
    assert path.read_bytes().count(jpeg) == 1
    assert next(read_frames(path, FrameInput)).jpeg == jpeg


@pytest.mark.slow
def test_the_plan_of_a_known_lot_is_stored_once(tmp_path: Path) -> None:
    stall = KnownStall("a uuid", 1.0, 2.0, 0.1, 2.5, 5.0, True, "A 1")
    ground = ((((0.0, 1.0), (1.0, 1.0), (1.0, 0.0)),),)
    lots = [KnownLot(f"lot {n}", (stall,), ground) for n in range(2)]
    one, both = (lots[0],), (lots[0], lots[1])
    flown: list[tuple[KnownLot, ...]] = [(), one, one, both, one]
    frames = [replace(FRAME, sequence=n, known=known) for n, known in enumerate(flown)]
    items = [Item(FRAME_INPUT, each, "frame", (12 + n) * S, 1) for n, each in enumerate(frames)]
    path = write(tmp_path / "flight.mcap", items)
    assert list(read_frames(path, FrameInput)) == frames
    written = [content["lots"] for topic, _, _, content in messages(path) if topic == "known_lot"]
    assert [[lot["id"] for lot in plans] for plans in written] == [["lot 0"], ["lot 0", "lot 1"], ["lot 0"]]


@pytest.mark.slow
def test_times_are_utc_in_the_file_and_the_clock_for_its_reader(tmp_path: Path) -> None:
    path = write(tmp_path / "flight.mcap", [record("tick", {"number": 1, "facts": {}}, 12.5)])
    assert messages(path)[0][2] == (int(START.timestamp()) * S) + 2_500_000_000
    assert [one.time for one in read_recording(path)] == [12.5]


def test_a_wall_clock_that_was_never_set_leaves_the_clock_as_it_is(tmp_path: Path) -> None:
    head = start_metadata({}, datetime.fromtimestamp(30, UTC), 7000.0)
    assert head["epoch_ns"] == "0"
    path = write(tmp_path / "flight.mcap", [record("tick", {}, 6941.0)], **head)
    assert [one.time for one in read_recording(path)] == [6941.0]


@pytest.mark.nightly
@pytest.mark.parametrize("jumps_to", [5.0, 1e9])
def test_a_clock_that_jumps_is_read_in_the_order_of_the_file(jumps_to: float, tmp_path: Path) -> None:
    times = [12.0, 13.0, jumps_to, jumps_to + 0.1]
    items = [frame(number, at) for number, at in enumerate(times)]
    path = write(tmp_path / "flight.mcap", items)
    assert [one.time for one in read_recording(path) if one.topic == FRAME_INPUT] == times
    assert [one.sequence for one in read_frames(path, FrameInput)] == [0, 1, 2, 3]
    assert len(messages(path)) >= 8


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    items = [item for number in range(4) for item in (frame(number, 12.0 + number), record("request", {"n": number}))]
    return write(tmp_path_factory.mktemp("whole") / "flight.mcap", [*items, view(POSE)]).read_bytes()


@pytest.mark.slow
def test_a_recording_cut_at_any_byte_is_read_up_to_the_cut(whole: bytes, tmp_path: Path) -> None:
    path = tmp_path / "cut.mcap"
    most = 0
    for length in range(9, len(whole), 23):
        path.write_bytes(whole[:length])
        frames = list(read_frames(path, FrameInput))
        assert [one.sequence for one in frames] == list(range(len(frames)))
        assert len(frames) >= most
        most = len(frames)
    assert most == 4


@given(st.integers(0, 2**31), st.integers(1, 255))
def test_a_damaged_byte_gives_messages_or_a_clear_error(
    whole: bytes, scratch: Path, place: int, difference: int
) -> None:
    changed = bytearray(whole)
    changed[place % len(whole)] ^= difference
    scratch.write_bytes(bytes(changed))
    words = ""
    try:
        assert len(list(read_recording(scratch))) <= 18
    except RecordingError as error:
        words = str(error)
    assert not words or str(scratch) in words


@pytest.fixture(scope="module")
def scratch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("scratch") / "damaged.mcap"


def test_a_recording_of_a_newer_version_is_refused_with_the_remedy(tmp_path: Path) -> None:
    path = write(tmp_path / "flight.mcap", [frame(1)], format="3", version="9.1.0")
    with pytest.raises(RecordingError, match=r"newer version \(9.1.0, format 3\).*reads up to format 2: use that vers"):
        list(read_recording(path))
    assert read_metadata(path)["version"] == "9.1.0"


def test_a_recording_of_the_first_format_is_read(tmp_path: Path) -> None:
    from mcap.writer import CompressionType, Writer

    from hawk.store.frame_codec import encode_frame

    stream = io.BytesIO()
    writer = Writer(stream, compression=CompressionType.NONE, use_chunking=False)
    writer.start(profile="hawk", library="hawk-drone")
    writer.add_metadata("hawk", {"version": "0.1.0", "clock": "10.0"})
    ticks = writer.register_channel("tick", "json", schema_id=0)
    frames = writer.register_channel(FRAME_INPUT, "hawk-frame", schema_id=0)
    writer.add_message(ticks, 11 * S, b'{"facts":{}}', 11 * S)
    writer.add_message(frames, 12 * S, encode_frame(FRAME), 12 * S)
    writer.finish()  # type: ignore[no-untyped-call]
    path = tmp_path / "old.mcap"
    path.write_bytes(stream.getvalue())
    assert [(one.topic, one.time) for one in read_recording(path)] == [("tick", 11.0), (FRAME_INPUT, 12.0)]
    assert list(read_frames(path, FrameInput)) == [FRAME]
