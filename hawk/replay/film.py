"""A recorded flight as the page plays it: what a film says, declared once (as `hawk.lots.answers`)."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Final, Literal, Self

from pydantic import Field

from hawk.lots.answers import Degrees, Metres, Shown, SpokenSentence, Utc

READER: Final = "hawk.replay.timeline:packed_film"
"""Function that makes the film of a recording, for `hawk.formats.box`."""
_HEAD: Final = struct.Struct("<III")
_PIECE: Final = struct.Struct("<?QI")
Seconds = Annotated[float, Field(ge=0, description="seconds of the film")]
Row = list[float | None]


class FilmMessage(Shown):
    """A line of the flight's messages."""

    at: Seconds
    level: Literal["info", "ok", "warning", "error"]
    text: str
    details: str
    sentences: list[SpokenSentence]


class FilmPhase(Shown):
    """A state of the drone, from `at` to the next one."""

    at: Seconds
    state: str


class FilmFence(Shown):
    """The fence from `at` on: its ring, and the zones that the drone keeps out of."""

    at: Seconds
    ring: list[Metres]
    zones: list[list[Metres]]


class FilmStall(Shown):
    """A stall of the plan that was flown over; `angle` in radians clockwise from north."""

    north: float
    east: float
    angle: float
    width: float
    length: float
    label: str


class Film(Shown):
    """A recorded flight by time: `at` is in seconds of the film, places in metres north and east of `datum`."""

    name: str
    program: Annotated[str, Field(description="program and network that flew")]
    began: Annotated[Utc | None, Field(description="moment of the first second, by the clock of the surveys")]
    seconds: float
    clock: Annotated[list[Row], Field(description="at; seconds by which the clock is ahead of the film from there on")]
    problem: Annotated[str, Field(description="why the end is missing; else empty")]
    datum: Degrees | None
    phases: list[FilmPhase]
    messages: list[FilmMessage]
    track: Annotated[list[Row], Field(description="at, north, east, height in metres, heading in degrees")]
    battery: Annotated[list[Row], Field(description="at, per cent, seconds until it must return; null: not known")]
    counts: Annotated[list[Row], Field(description="at, free, taken, unclear stalls")]
    homes: Annotated[list[Row], Field(description="at, north, east")]
    footprints: Annotated[list[Row], Field(description="at, north and east of each corner of what the camera sees")]
    fences: list[FilmFence]
    plan: list[FilmStall]
    pictures: Annotated[list[float], Field(description="at of each picture, in order of their numbers from 0")]
    maps: Annotated[list[float], Field(description="at of each map, in order of their numbers from 0")]


@dataclass(frozen=True, slots=True)
class Piece:
    """A picture or a map: bytes of the recording, or of the file beside it where the recording is packed."""

    is_beside: bool
    offset: int
    length: int


@dataclass(frozen=True, slots=True)
class PackedFilm:
    """A film, and where its pictures and maps stand, as bytes: one process makes them, another one looks up a piece."""

    data: bytes = field(repr=False)

    @classmethod
    def of(cls, film: Film, pictures: Sequence[Piece], maps: Sequence[Piece]) -> Self:
        """Return a film with its pieces."""
        text = film.model_dump_json().encode()
        places = [_PIECE.pack(piece.is_beside, piece.offset, piece.length) for piece in (*pictures, *maps)]
        return cls(b"".join((_HEAD.pack(len(text), len(pictures), len(maps)), text, *places)))

    @property
    def text(self) -> str:
        """The film as JSON."""
        return self.data[_HEAD.size : _HEAD.size + self._counts[0]].decode()

    @property
    def _counts(self) -> tuple[int, int, int]:
        length, pictures, maps = _HEAD.unpack_from(self.data)
        return length, pictures, maps

    def picture(self, number: int) -> Piece | None:
        """Return where a picture stands; None without one of this number."""
        return self._piece(number, self._counts[1], 0)

    def map(self, number: int) -> Piece | None:
        """Return where a map stands; None without one of this number."""
        _, pictures, maps = self._counts
        return self._piece(number, maps, pictures)

    def _piece(self, number: int, count: int, before: int) -> Piece | None:
        if not 0 <= number < count:
            return None
        at = _HEAD.size + self._counts[0] + (before + number) * _PIECE.size
        return Piece(*_PIECE.unpack_from(self.data, at))
