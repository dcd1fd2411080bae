"""The journal's file format: an append-only list of key and value, each record told whole by its checksum.

A record is ``magic, length of key (u16), length of value (u32), CRC-32 of lengths, key and value, key, value``, little
endian. What is torn (a crash while writing) or damaged is passed over: reading goes on at the next whole record.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass

MAX_KEY = 1000
"""Bytes of the longest key."""
MAX_VALUE = 64_000_000
"""Bytes of the largest value."""

_MAGIC = b"\xa5HJ1"
_LENGTHS = struct.Struct("<HI")
_CRC = struct.Struct("<I")
_HEAD = len(_MAGIC) + _LENGTHS.size + _CRC.size


@dataclass(frozen=True, slots=True)
class Record:
    """One entry; an empty value means that the key is gone."""

    key: str
    value: bytes


class Records:
    """Reads the whole records of a segment; ``lost`` counts the bytes that belong to none."""

    def __init__(self, data: bytes | memoryview) -> None:
        self._data = bytes(data)
        self.lost = 0

    def __iter__(self) -> Iterator[Record]:
        """Give every whole record in order."""
        position = 0
        while position < len(self._data):
            found = _record_at(self._data, position)
            if found is None:
                after = self._data.find(_MAGIC, position + 1)
                after = len(self._data) if after < 0 else after
                self.lost += after - position
                position = after
                continue
            record, position = found
            yield record


def check(key: str, value: bytes) -> None:
    """Raise ValueError when key or value is too long."""
    if not 0 < len(key.encode()) <= MAX_KEY:
        raise ValueError(f"journal key {key[:40]!r}: must have 1 to {MAX_KEY} bytes")
    if len(value) > MAX_VALUE:
        raise ValueError(f"journal value of {key!r} has {len(value)} bytes, at most {MAX_VALUE} can be kept")


def pack(key: str, value: bytes) -> bytes:
    """Return a record's bytes. Raises ValueError when key or value is too long."""
    check(key, value)
    name = key.encode()
    lengths = _LENGTHS.pack(len(name), len(value))
    return b"".join((_MAGIC, lengths, _CRC.pack(_checksum(lengths, name, value)), name, value))


def _record_at(data: bytes, start: int) -> tuple[Record, int] | None:
    if not data.startswith(_MAGIC, start) or start + _HEAD > len(data):
        return None
    lengths = data[start + len(_MAGIC) : start + len(_MAGIC) + _LENGTHS.size]
    key_length, value_length = _LENGTHS.unpack(lengths)
    key_end = start + _HEAD + key_length
    end = key_end + value_length
    if not 0 < key_length <= MAX_KEY or value_length > MAX_VALUE or end > len(data):
        return None
    name, value = data[start + _HEAD : key_end], data[key_end:end]
    (checksum,) = _CRC.unpack_from(data, start + len(_MAGIC) + _LENGTHS.size)
    if checksum != _checksum(lengths, name, value):
        return None
    try:
        return Record(name.decode(), value), end
    except UnicodeDecodeError:
        return None


def _checksum(lengths: bytes, name: bytes, value: bytes) -> int:
    return zlib.crc32(value, zlib.crc32(name, zlib.crc32(lengths)))
