"""A recorded flight as a film: its time line, and where its pictures and maps stand in the file.

The file is read once, in a process of its own (`hawk.formats.box`); what is kept of it is bounded, however long it is:
of values that become too many every second one is left out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, Final, Generic, TypeVar

from pydantic import ValidationError

from hawk.ddc.recorder import DECISION, TICK
from hawk.formats.box import RefusedError
from hawk.lots.answers import SpokenSentence
from hawk.model.frames import offset_ned
from hawk.model.poses import GlobalPose
from hawk.replay.film import Film, FilmFence, FilmMessage, FilmPhase, FilmStall, PackedFilm, Piece, Row
from hawk.replay.flight import LONGEST_GAP_S, Played, RecordedFlight, ReplayError
from hawk.store.frame_codec import FRAME_INPUT, FrameFormatError, picture_of
from hawk.store.replay import CAMERA, KNOWN_LOT, LOTS, MESSAGE, STALLS_ON_EARTH, RecordingError, span_of

STEP_S: Final = 0.2
"""Least time between two values of one kind, seconds."""
MOST: Final = 20_000
"""Values of one kind: an hour of them, five a second."""
_LEAST_MOVE_M: Final = 1.5
"""Between two footprints of the camera."""
_LIMITS: Final = b'"limits":'
_MOST_MESSAGES: Final = 5_000
T = TypeVar("T")


@dataclass(slots=True)
class Thinned(Generic[T]):
    """Values by rising time, no nearer than a step, which doubles where they become too many."""

    step: float = STEP_S
    rows: list[tuple[float, T]] = field(default_factory=list)

    def is_due(self, at: float) -> bool:
        """Return whether a value at this time is taken."""
        return not self.rows or at - self.rows[-1][0] >= self.step - 1e-6

    def put(self, at: float, value: T) -> None:
        """Take a value if it is due."""
        if not self.is_due(at):
            return
        self.rows.append((at, value))
        if len(self.rows) > MOST:
            self.rows, self.step = self.rows[::2], 2 * self.step

    def times(self) -> list[float]:
        """Return when each is shown."""
        return [_short(at) for at, _ in self.rows]


class _Steps(Thinned[Row]):
    """Rows of numbers that stay until they change."""

    def put(self, at: float, value: Row) -> None:
        """Take a row that differs from the one before."""
        if not self.rows or self.rows[-1][1] != value:
            super().put(at, value)

    def table(self) -> list[Row]:
        """Return the rows with their times."""
        return [[_short(at), *row] for at, row in self.rows]


def packed_film(_: bytes, asked: Mapping[str, Any]) -> bytes:
    """Return the film of a recording in one piece, for `PackedFilm`: a reader of `hawk.formats.box`.

    Args:
        asked: ``recording``: its path; ``beside``: that of an empty file for pictures and maps of a packed recording.

    Raises:
        RefusedError: Of the recording nothing can be read.
    """
    try:
        flight = RecordedFlight(Path(asked["recording"]))
        with Path(asked["beside"]).open("wb") as beside:
            film, pictures, maps = read_film(flight, beside)
    except ReplayError as error:
        raise RefusedError("recording", str(error)) from error
    return PackedFilm.of(film, pictures, maps).data


def read_film(flight: RecordedFlight, beside: IO[bytes]) -> tuple[Film, list[Piece], list[Piece]]:
    """Return a recording's film up to its damage, and where its pictures and maps stand.

    ``beside``: an empty file. Raises ReplayError for a recording of which nothing can be read.
    """
    made = _Film(flight, beside)
    damage = ""
    for played in flight.played():
        try:
            made.take(played)
        except (
            ReplayError, RecordingError, FrameFormatError, ValidationError, LookupError, TypeError, ValueError,
            AttributeError,
        ) as error:  # fmt: skip
            if made.is_empty:
                raise ReplayError(f"{flight.path}: {error}; use {flight.maker}, which recorded it") from error
            damage = f"at {played.at:.1f} s: {error}"
            break
    return made.film(damage or flight.damage)


class _Film:
    def __init__(self, flight: RecordedFlight, beside: IO[bytes]) -> None:
        self._flight, self._beside = flight, beside
        self._seconds = 0.0
        self._first: float | None = None
        self._before = 0.0
        self._ahead = 0.0
        self._ticked = -math.inf
        self._datum: GlobalPose | None = None
        self._shift = (0.0, 0.0)
        self._leaps: list[Row] = []
        self._phases: list[FilmPhase] = []
        self._messages: list[FilmMessage] = []
        self._acts: list[FilmMessage] = []
        self._fences: list[FilmFence] = []
        self._plan: list[FilmStall] = []
        self._track, self._battery, self._counts, self._homes, self._seen = (_Steps() for _ in range(5))
        self._pictures: Thinned[Piece] = Thinned(0.05)
        self._maps: Thinned[Piece] = Thinned(0.0)

    @property
    def is_empty(self) -> bool:
        return not (self._phases or self._acts or self._messages or self._pictures.rows)

    def take(self, played: Played) -> None:
        """Take a message. Raises the errors of content that cannot be read."""
        message, at = played.message, played.at
        self._first = message.time if self._first is None else self._first
        self._follow_clock(at, message.time)
        self._seconds = at
        if message.topic in (CAMERA, STALLS_ON_EARTH):
            (self._pictures if message.topic == CAMERA else self._maps).put(at, self._piece(played))
        elif message.topic == FRAME_INPUT and message.place is not None:  # an old format: the frame holds its picture
            data = picture_of(message.data)
            self._pictures.put(at, Piece(False, message.place + len(message.data) - len(data), len(data)))
        elif message.topic == TICK:
            if at - self._ticked >= STEP_S - 1e-6 or _LIMITS in message.data:
                self._ticked = at
                self._facts(at, message.payload()["facts"])
        elif message.topic == DECISION:
            self._decision(at, message.payload())
        elif message.topic == MESSAGE:
            self._said(at, message.payload())
        elif message.topic == KNOWN_LOT:
            self._known(message.payload())

    def _follow_clock(self, at: float, time: float) -> None:
        """Note where the film leaves time out."""
        ahead = max(0.0, time - (self._first or 0.0) - at)
        if ahead - self._ahead > LONGEST_GAP_S / 10 and len(self._leaps) < MOST:
            self._ahead = ahead
            self._leaps.append([_short(at), _short(ahead)])

    def _piece(self, played: Played) -> Piece:
        message = played.message
        span = span_of(message.topic, message.data)
        length = span.stop - span.start
        if message.place is not None:
            return Piece(False, message.place + span.start, length)
        kept = Piece(True, self._beside.tell(), length)
        self._beside.write(message.data[span])
        return kept

    def _facts(self, at: float, facts: Mapping[str, Any]) -> None:
        if (position := facts.get("position")) is not None:
            self._position(at, position)
        if (battery := facts.get("battery")) is not None:
            info, reserve = battery.get("info") or {}, battery.get("reserve") or {}
            self._battery.put(at, [_number(info.get("percentage"), 0), _number(reserve.get("time_left"), 0)])
        if self._datum is None:
            return
        if (sight := facts.get("sight")) is not None:
            self._sight(at, sight)
        if (limits := facts.get("limits")) is not None and (fence := limits.get("fence")) is not None:
            self._fence(at, fence)

    def _position(self, at: float, position: Mapping[str, Any]) -> None:
        if position.get("datum") is not None:
            datum = GlobalPose(*(float(position["datum"][name]) for name in GlobalPose.__slots__))
            self._datum = self._datum or datum
            north, east, _ = offset_ned(datum, self._datum)
            self._shift = north, east
        pose = position.get("pose") or {}
        place = pose.get("map")
        if place is None or self._datum is None:
            return
        height = _number(pose.get("relative_altitude"), 1)
        heading = _number(math.degrees(float(place["yaw"])) % 360, 0)
        self._track.put(at, [*self._place(place["north"], place["east"]), height, heading])
        if (home := position.get("home")) is not None:
            self._homes.put(at, self._place(home["north"], home["east"]))

    def _sight(self, at: float, sight: Mapping[str, Any]) -> None:
        counts = sight.get("counts") or {}
        self._counts.put(at, [int(counts.get(name, 0)) for name in ("free", "taken", "unknown")])
        corners: Row = [value for each in sight.get("footprint") or () for value in self._place(**each)]
        last = self._seen.rows[-1][1] if self._seen.rows else []
        if corners and (len(last) != len(corners) or _most_apart(corners, last) > _LEAST_MOVE_M):
            self._seen.put(at, corners)

    def _fence(self, at: float, fence: Mapping[str, Any]) -> None:
        ring = [self._place(*corner) for corner in fence["polygon"]]
        zones = [[self._place(*corner) for corner in zone] for zone in fence.get("zones") or ()]
        made = FilmFence(at=_short(at), ring=ring, zones=zones)
        if not self._fences or (self._fences[-1].ring, self._fences[-1].zones) != (made.ring, made.zones):
            self._fences.append(made)

    def _place(self, north: float, east: float) -> list[Any]:
        return [round(float(north) + self._shift[0], 2), round(float(east) + self._shift[1], 2)]

    def _decision(self, at: float, decision: Mapping[str, Any]) -> None:
        for act in decision["acts"]:
            if act["act"] == "EnterState":
                self._phases.append(FilmPhase(at=_short(at), state=str(act["name"])))
            elif act["act"] == "Log" and len(self._acts) < _MOST_MESSAGES:
                self._acts.append(_message(at, act))

    def _said(self, at: float, message: Mapping[str, Any]) -> None:
        if len(self._messages) < _MOST_MESSAGES:
            self._messages.append(_message(at, message))

    def _known(self, known: Mapping[str, Any]) -> None:
        """The plans of the lots; where they lie on the map is found in flight, a metre or two beside."""
        names = ("north", "east", "angle", "width", "length")
        self._plan = [
            FilmStall(**{name: round(float(stall[name]), 3) for name in names}, label=str(stall.get("label", "")))
            for lot in known.get(LOTS, [known])
            for stall in lot["stalls"]
        ]

    def film(self, damage: str) -> tuple[Film, list[Piece], list[Piece]]:
        """Return what was taken."""
        datum = None if self._datum is None else [self._datum.latitude, self._datum.longitude]
        made = Film(
            name=self._flight.path.name,
            program=str(self._flight.maker),
            began=None if self._first is None else self._flight.moment(self._first),
            seconds=_short(self._seconds),
            clock=self._leaps,
            problem=damage,
            datum=datum,
            phases=self._phases,
            messages=self._messages or self._acts,
            track=self._track.table(),
            battery=self._battery.table(),
            counts=self._counts.table(),
            homes=self._homes.table(),
            footprints=self._seen.table(),
            fences=self._fences,
            plan=self._plan,
            pictures=self._pictures.times(),
            maps=self._maps.times(),
        )
        return made, [piece for _, piece in self._pictures.rows], [piece for _, piece in self._maps.rows]


def _message(at: float, said: Mapping[str, Any]) -> FilmMessage:
    sentences = [SpokenSentence(**each) for each in said.get("sentences") or ()]
    text, details = str(said["text"]), str(said.get("details", ""))
    return FilmMessage(at=_short(at), level=said["level"], text=text, details=details, sentences=sentences)


def _number(value: Any, decimals: int) -> float | None:
    """Return a number that is known; JSON writes those that are none as words."""
    if not isinstance(value, int | float) or not math.isfinite(value):
        return None
    return round(value, decimals) if decimals else round(value)


def _most_apart(one: Row, other: Row) -> float:
    return max(abs((a or 0.0) - (b or 0.0)) for a, b in zip(one, other, strict=True))


def _short(at: float) -> float:
    return round(at, 2)
