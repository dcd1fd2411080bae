"""Damage to files: cut, flipped, spliced, lengths that lie, numbers at their limits; and files made to harm."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

SOUND: Final = 0
"""Number of the file that every reader must take: a fuzz of files that none takes would show nothing."""
_EXTREMES: Final = (b"\0", b"\xff", b"\x7f", b"\x80", b"\x01")
_NUMBER: Final = re.compile(rb"-?\d+(?:\.\d+)?")
_NUMBERS: Final = (
    b"0", b"-1", b"1e308", b"-1e309", b"nan", b"NaN", b"Infinity", b"99999999999999999999", b"1e-320", b"null",
    b"[]", b'""', b"2147483648", b"0x10", b"",
)  # fmt: skip
_MOST_FLIPS: Final = 8
_DEEP: Final = 200_000


@dataclass(frozen=True, slots=True)
class Base:
    """A sound file: what its name ends in, and its bytes."""

    suffix: str
    data: bytes


class Damage:
    """Draws files from sound ones and from hostile ones. ``at(number)`` depends on seed and number only."""

    def __init__(self, seed: int, bases: Sequence[Base], hostile: Sequence[Base]) -> None:
        self._seed = seed
        self._bases = bases
        self._hostile = (*hostile, *_DEEP_FILES)
        self._kinds: tuple[Callable[[random.Random, bytes], bytes], ...] = (
            _cut, _flipped, _flipped, self._spliced, _overwritten, _overwritten, _repeated, _renumbered, _renumbered,
        )  # fmt: skip

    def at(self, number: int) -> Base:
        """Return a file: a sound one (0), each hostile one, then damaged ones."""
        if number == SOUND:
            return self._bases[0]
        if number <= len(self._hostile):
            return self._hostile[number - 1]
        rng = random.Random(f"{self._seed}:{number}")
        base = rng.choice(self._bases)
        data = base.data
        for _ in range(rng.choice((1, 1, 1, 2, 3))):
            data = rng.choice(self._kinds)(rng, data)
        suffix = base.suffix if rng.random() < 0.9 else rng.choice(self._bases).suffix
        return Base(suffix, data)

    def _spliced(self, rng: random.Random, data: bytes) -> bytes:
        other = rng.choice(self._bases).data
        return data[: _place(rng, data)] + other[_place(rng, other) :]


def _place(rng: random.Random, data: bytes) -> int:
    """Return a place: heads of files decide more than their middles."""
    return rng.randint(0, min(len(data), 512) if rng.random() < 0.4 else len(data))


def _cut(rng: random.Random, data: bytes) -> bytes:
    return data[: _place(rng, data)]


def _flipped(rng: random.Random, data: bytes) -> bytes:
    changed = bytearray(data)
    for _ in range(rng.randint(1, _MOST_FLIPS) if data else 0):
        changed[min(_place(rng, data), len(data) - 1)] ^= 1 << rng.randrange(8)
    return bytes(changed)


def _overwritten(rng: random.Random, data: bytes) -> bytes:
    """A field of 1 to 8 bytes at its limits: lengths and offsets that lead nowhere, or far."""
    at, width = _place(rng, data), rng.choice((1, 2, 4, 8))
    field = rng.choice(_EXTREMES) * width if rng.random() < 0.6 else rng.randbytes(width)
    return data[:at] + field + data[at + width :]


def _repeated(rng: random.Random, data: bytes) -> bytes:
    begin = _place(rng, data)
    part = data[begin : begin + rng.randint(1, 2000)]
    return data[:begin] + part * rng.choice((0, 2, 3, 50)) + data[begin + len(part) :]


def _renumbered(rng: random.Random, data: bytes) -> bytes:
    """A number of a text at its limits; binary files have digits as well."""
    found = list(_NUMBER.finditer(data[:200_000]))
    if not found:
        return _overwritten(rng, data)
    at = rng.choice(found)
    return data[: at.start()] + rng.choice(_NUMBERS) + data[at.end() :]


_DEEP_FILES: Final = tuple(
    Base(suffix, data)
    for suffix, data in (
        (".geojson", b"[" * _DEEP),
        (".geojson", b'{"type":"GeometryCollection","geometries":[' * 20_000),
        (".geojson", b'{"type":"Polygon","coordinates":' + b"[" * 900 + b"]" * 900 + b"}"),
        (".kml", b"<kml>" + b"<Folder>" * _DEEP),
        (".osm", b'<!DOCTYPE osm [<!ENTITY a "aaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]><osm>&b;</osm>'),
        (".vrt", b"<VRTDataset>" * _DEEP),
        (".toml", b"a = " + b"[" * 50_000),
        (".yaml", b"a: &a [x, x]\nb: &b [*a, *a, *a]\nc: [*b, *b, *b]\n" + b"- " * 5000),
        (".srt", b"1\n00:00:00,000 --> 99999999999:59:59,999\n[latitude: 1e999]\n"),
    )
)
"""Files that a reader of text would descend into, or let grow."""
