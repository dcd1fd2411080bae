"""Recordings that another program packed again are read; one that would become more than it can hold is refused."""

from __future__ import annotations

import io
import struct
from pathlib import Path

import pytest
from mcap.writer import CompressionType, Writer

from hawk.store import mcap_records
from hawk.store.replay import METADATA, RecordingError, read_metadata, read_recording

PACKED = [CompressionType.LZ4, CompressionType.ZSTD, CompressionType.NONE]


def packed(messages: list[bytes], kind: CompressionType, chunk: int = 1 << 20) -> bytes:
    made = io.BytesIO()
    writer = Writer(made, compression=kind, chunk_size=chunk)
    writer.start()
    writer.add_metadata(METADATA, {"format": "2", "epoch_ns": "0"})
    channel = writer.register_channel("tick", "json", writer.register_schema("x", "jsonschema", b"{}"))
    for number, data in enumerate(messages):
        writer.add_message(channel, number * 10**9, data, number * 10**9)
    writer.finish()  # type: ignore[no-untyped-call]
    return made.getvalue()


@pytest.mark.parametrize("kind", PACKED)
def test_a_recording_that_was_packed_again_has_the_same_messages(tmp_path: Path, kind: CompressionType) -> None:
    path = tmp_path / "a.mcap"
    messages = [b'{"n": %d}' % number for number in range(300)]
    path.write_bytes(packed(messages, kind, 1000))
    assert [each.data for each in read_recording(path)] == messages
    assert read_metadata(path)["format"] == "2"


@pytest.mark.parametrize("kind", PACKED[:2])
@pytest.mark.parametrize("lies", [False, True])
def test_a_chunk_never_becomes_more_than_it_says(
    tmp_path: Path, kind: CompressionType, lies: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mcap_records, "MOST_CHUNK_BYTES", 1_000_000)
    data = packed([bytes(5_000_000)], kind)
    if lies:
        data = said_size(data, 1000)
    path = tmp_path / "bomb.mcap"
    path.write_bytes(data)
    assert len(data) < 100_000
    with pytest.raises(RecordingError, match=r"bomb\.mcap: a chunk becomes .* mcap decompress"):
        list(read_recording(path))


def said_size(data: bytes, size: int) -> bytes:
    """Return a file whose first chunk says another size."""
    is_size = (k for k in range(len(data)) if 5_000_000 <= int.from_bytes(data[k : k + 8], "little") < 5_001_000)
    at = next(is_size)
    return data[:at] + size.to_bytes(8, "little") + data[at + 8 :]


def test_all_chunks_together_are_added_up_before_the_first_is_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mcap_records, "LEAST_UNPACKED_BYTES", 1_000_000)
    path = tmp_path / "many.mcap"
    path.write_bytes(packed([bytes(100_000)] * 40, CompressionType.ZSTD, 100_000))
    with pytest.raises(RecordingError, match=r"its chunks become 4 MB, \d+ times the file: name the recording"):
        list(read_recording(path))


def test_a_length_that_the_file_cannot_have_takes_no_memory(tmp_path: Path) -> None:
    data = packed([b"{}"], CompressionType.NONE)
    path = tmp_path / "long.mcap"
    path.write_bytes(data[:8] + b"\x01" + (1 << 27).to_bytes(8, "little") + data[17:])
    with pytest.raises(RecordingError, match="has no metadata"):
        read_metadata(path)


def test_a_summary_of_gigabytes_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "r.mcap"
    with path.open("wb") as file:
        file.write(b"\x89MCAP0\r\n")
        file.seek(3_000_000_000)  # a hole: no byte of it is on the disk
        file.write(struct.pack("<BQQQI", 2, 20, 8, 0, 0) + b"\x89MCAP0\r\n")
    with pytest.raises(mcap_records.TooLargeError, match="its summary has 3,000 MB"):
        mcap_records.statistics_of(path)
