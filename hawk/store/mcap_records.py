"""Records of an MCAP file, one after the other: no length in it is believed beyond what the file can hold.

Our own files have no chunks; those that another program packed again (``mcap compress``) do. A small chunk may say, or
hold, any number of bytes: the sizes of all are added up before the first is opened, and none becomes more than it says.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, Final, cast

import lz4.frame
import zstandard
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.records import Chunk, Footer, Statistics
from mcap.stream_reader import StreamReader

MOST_CHUNK_BYTES: Final = 64_000_000
"""Of an unpacked chunk: programs that write MCAP make chunks of 1 to 8 MB."""
MOST_RECORD_BYTES: Final = 256_000_000
LEAST_UNPACKED_BYTES: Final = 256_000_000
MOST_GROWTH: Final = 40
"""Times that all chunks together may be larger than a file of more: JSON of a flight is packed to a tenth."""
MOST_SUMMARY_BYTES: Final = 16_000_000
"""Of the section at the end: hawk's has a kilobyte for a topic."""
_WINDOW_BYTES: Final = 1 << 26
_MAGIC: Final = b"\x89MCAP0\r\n"
_HEAD: Final = struct.Struct("<BQ")
"""Of a record: its kind and length."""
_CHUNK_HEAD: Final = struct.Struct("<QQQ")
"""Of a chunk: its first and last time, and its size unpacked (mcap.dev/spec, op=0x06)."""


_FOOTER_BYTES: Final = _HEAD.size + 20 + len(_MAGIC)
"""Of the footer and the magic behind it (mcap.dev/spec, op=0x02)."""


class TooLargeError(McapError):
    """A file would become more than its bytes can be; the text has the remedy."""


def records_of(path: Path) -> Iterator[tuple[Any, int | None]]:
    """Yield the records of a file, those of chunks in their place; EndOfFile where it is torn.

    With each comes the byte of the file behind it; None for one that a chunk holds. Raises OSError, McapError,
    ValueError and struct.error for one that is damaged.
    """
    size, is_checked = path.stat().st_size, False
    with path.open("rb") as stream:
        reads = _WholeReads(stream, size)
        reader = StreamReader(cast("IO[bytes]", reads), emit_chunks=True, record_size_limit=MOST_RECORD_BYTES)
        for record in reader.records:
            if isinstance(record, Chunk):
                if not is_checked:
                    _check_growth(path, size)
                    is_checked = True
                yield from ((each, None) for each in _of_chunk(record))
            else:
                yield record, size - reads.left


def statistics_of(path: Path) -> Statistics | None:
    """Return the counts at the end of a file; None where it has none. No chunk is opened.

    Raises OSError, McapError, ValueError and struct.error for one that is damaged, or has a larger summary than any.
    """
    size = path.stat().st_size
    with path.open("rb") as stream:
        stream.seek(max(0, size - _FOOTER_BYTES))
        footer = next(_plain_records(stream.read()), None)
        if not isinstance(footer, Footer) or footer.summary_start == 0:
            return None
        length = size - _FOOTER_BYTES - footer.summary_start
        if not 0 <= length <= MOST_SUMMARY_BYTES:
            raise TooLargeError(f"its summary has {length / 1e6:,.0f} MB, {MOST_SUMMARY_BYTES / 1e6:.0f} are the most")
        stream.seek(footer.summary_start)
        records = _plain_records(stream.read(length))
    return next((each for each in records if isinstance(each, Statistics)), None)


def _plain_records(data: bytes) -> Iterator[Any]:
    """Yield the records of a piece of a file; chunks stay packed."""
    reads = _WholeReads(io.BytesIO(data), len(data))
    try:
        yield from StreamReader(cast("IO[bytes]", reads), skip_magic=True, emit_chunks=True).records
    except EndOfFile:
        return


def _check_growth(path: Path, size: int) -> None:
    """Add up what the chunks of a file say that they become. Raises TooLargeError."""
    at, unpacked = len(_MAGIC), 0
    with path.open("rb") as stream:
        while at + _HEAD.size <= size:
            stream.seek(at)
            kind, length = _HEAD.unpack(stream.read(_HEAD.size))
            if kind == Opcode.CHUNK and at + _HEAD.size + _CHUNK_HEAD.size <= size:
                unpacked += _CHUNK_HEAD.unpack(stream.read(_CHUNK_HEAD.size))[2]
            if kind in (Opcode.DATA_END, Opcode.FOOTER):
                break
            at += _HEAD.size + length
    if unpacked > max(LEAST_UNPACKED_BYTES, MOST_GROWTH * size):
        raise TooLargeError(
            f"its chunks become {unpacked / 1e6:,.0f} MB, {unpacked / size:,.0f} times the file: {_REMEDY}"
        )


_REMEDY: Final = "name the recording as hawk-drone wrote it, or one that mcap decompress has unpacked"


def _of_chunk(chunk: Chunk) -> Iterator[Any]:
    yield from (record for record in _plain_records(_unpacked(chunk)) if not isinstance(record, Chunk))


def _unpacked(chunk: Chunk) -> bytes:
    """Return the records of a chunk. Raises TooLargeError for one that becomes more than it says, or too much."""
    said = chunk.uncompressed_size
    if said > MOST_CHUNK_BYTES:
        raise TooLargeError(
            f"a chunk becomes {said / 1e6:,.0f} MB, {MOST_CHUNK_BYTES / 1e6:.0f} are the most: {_REMEDY}"
        )
    try:
        if chunk.compression == "zstd":
            packed = zstandard.ZstdDecompressor(max_window_size=_WINDOW_BYTES).stream_reader(io.BytesIO(chunk.data))
            data = packed.read(said + 1)
        elif chunk.compression == "lz4":
            data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=said + 1)
        elif chunk.compression:
            raise McapError(f"a chunk is packed by {chunk.compression[:20]!r}, not by lz4 or zstd")
        else:
            data = chunk.data
    except (zstandard.ZstdError, RuntimeError) as error:
        raise McapError(f"a chunk cannot be unpacked ({error})") from error
    if len(data) > said:
        raise TooLargeError(f"a chunk becomes more than the {said} bytes that it says: {_REMEDY}")
    return bytes(data)


class _WholeReads:
    """A stream whose reads are whole or end the file, so a torn last message is not read as a short one."""

    def __init__(self, stream: IO[bytes], size: int) -> None:
        self._stream = stream
        self.left = size

    def read(self, length: int) -> bytes:
        if length > self.left:  # asks for no memory that the file cannot fill
            raise EndOfFile
        data = self._stream.read(length)
        self.left -= len(data)
        if len(data) < length:
            raise EndOfFile
        return data
