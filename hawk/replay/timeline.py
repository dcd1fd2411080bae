"""A recorded flight for the page: its time line, with pictures and maps in a file beside it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import IO, Any, Final

from hawk.ddc.recorder import COMMAND, DECISION, TICK
from hawk.replay.flight import Played, RecordedFlight, ReplayError
from hawk.replay.process import STALLS_ON_EARTH
from hawk.store.frame_codec import FRAME_INPUT, FrameFormatError, picture_of
from hawk.store.replay import Recorded, RecordingError, text_of_geojson

STEP_S: Final = 0.2
"""Least time between two points of the track, seconds."""
_QUIET: Final = frozenset({"SendTarget", "Ask", "Record", "Log", "ShowUserError"})
"""Acts that are no event: those of every tick, and those whose words are messages."""
_LOG: Final = "Log"
_STATE: Final = "EnterState"


@dataclass(frozen=True, slots=True)
class Event:
    """An event of the time line. ``at``: seconds of the replay. ``kind``: message, state, command or decision."""

    at: float
    kind: str
    text: str
    level: str = "info"


@dataclass(slots=True)
class Piece:
    """A picture or a map: when it is shown, and where it stands in the file beside."""

    at: float
    offset: int
    length: int


@dataclass(slots=True)
class Shown:
    """The time line. ``track``: [seconds, latitude, longitude, height above the arm place in metres]."""

    seconds: float = 0.0
    events: list[Event] = field(default_factory=list)
    track: list[tuple[float, float, float, float]] = field(default_factory=list)
    pictures: list[Piece] = field(default_factory=list)
    maps: list[Piece] = field(default_factory=list)
    damage: str = ""


def read_shown(flight: RecordedFlight, beside: IO[bytes]) -> Shown:
    """Read a recording up to its damage; pictures and maps are written to a file, which must be empty.

    Raises ReplayError for a recording of which nothing can be read.
    """
    shown = Shown()
    for played in flight.played():
        shown.seconds = played.at
        try:
            _take(shown, played, beside)
        except (ReplayError, RecordingError, FrameFormatError, LookupError, TypeError, ValueError) as error:
            if not shown.events and not shown.pictures:
                raise ReplayError(f"{flight.path}: {error}; use {flight.maker}, which recorded it") from error
            shown.damage = f"at {played.at:.1f} s: {error}"
            break
    shown.damage = shown.damage or flight.damage
    beside.flush()
    return shown


def _take(shown: Shown, played: Played, beside: IO[bytes]) -> None:
    message = played.message
    if message.topic == FRAME_INPUT:
        shown.pictures.append(_kept(played.at, picture_of(message.data), beside))
    elif message.topic == STALLS_ON_EARTH:
        shown.maps.append(_kept(played.at, text_of_geojson(message.data).encode(), beside))
    elif message.topic == TICK:
        _place(shown, played)
    elif message.topic in (DECISION, COMMAND):
        shown.events += _events(played.at, message)


def _kept(at: float, data: bytes, beside: IO[bytes]) -> Piece:
    piece = Piece(at, beside.tell(), len(data))
    beside.write(data)
    return piece


def _place(shown: Shown, played: Played) -> None:
    if shown.track and played.at - shown.track[-1][0] < STEP_S - 1e-6:
        return
    position = played.message.payload()["facts"].get("position") or {}
    pose = position.get("pose")
    if pose is None:
        return
    place = [float(pose["global_"][name]) for name in ("latitude", "longitude")]
    known = pose["relative_altitude"]
    height = math.nan if known is None else float(known)
    if all(map(math.isfinite, (*place, height))):
        shown.track.append((played.at, place[0], place[1], height))


def _events(at: float, message: Recorded) -> Iterator[Event]:
    content = message.payload()
    if message.topic == COMMAND:
        yield Event(at, "command", str(content["Type"]))
        return
    if content.get("fault"):
        yield Event(at, "decision", str(content["fault"]), "error")
    for act in content["acts"]:
        yield from _act(at, act)


def _act(at: float, act: dict[str, Any]) -> Iterator[Event]:
    name = str(act["act"])
    if name == _STATE:
        yield Event(at, "state", str(act["name"]))
    elif name == _LOG:
        yield Event(at, "message", str(act["text"]), str(act["level"]))
    elif name not in _QUIET:
        yield Event(at, "decision", name)
