"""A recorded flight: what it says of itself, and its messages by time, up to the place where the file is damaged."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any, Final

from hawk.config.sections import Config, ConfigError
from hawk.ddc.recorder import TICK
from hawk.model.poses import GlobalPose
from hawk.store.replay import NO_END, ZERO_UTC, Recorded, RecordingError, is_whole, read_metadata, read_recording

LONGEST_GAP_S: Final = 5.0
"""A longer time without a message is played in this, seconds: a clock that leapt stops no player."""
_SECTIONS: Final = ("camera", "flight", "vision")
"""Settings that vision, mapper and planner have; those of other rooms may be of any version."""
_FURTHER: Final = re.compile(r"For further information visit \S+")
_DATUM: Final = b'"datum":{'


class ReplayError(Exception):
    """A recording, or a file beside it, that cannot be used; the text says why, and the remedy."""


@dataclass(frozen=True, slots=True)
class Maker:
    """Program and network that made a map. ``network``: the name of its file, empty where it was not noted."""

    version: str
    network: str

    def __str__(self) -> str:
        return f"hawk-drone {self.version}, network {self.network or 'not noted'}"


@dataclass(frozen=True, slots=True)
class Played:
    """A message, and when it is played: seconds from the first one, which never fall."""

    at: float
    message: Recorded = field(repr=False)


class RecordedFlight:
    """A recording on the disk. What was read of it stays valid when the rest is damaged."""

    def __init__(self, path: Path) -> None:
        """Read what the file says of itself. Raises ReplayError when it is no recording, or holds nothing."""
        self.path = path
        self.damage = ""
        """Why messages are missing at the end, known once all have been read; else empty."""
        self.seconds = 0.0
        """Length of what was read, seconds of the flight."""
        try:
            self._metadata = read_metadata(path)
        except RecordingError as error:
            raise ReplayError(f"{error}; name a recording of STORE/recordings") from error

    @property
    def maker(self) -> Maker:
        """Program and network of the flight."""
        return Maker(self._metadata.get("version", "unknown"), self._metadata.get("network", ""))

    @property
    def utc(self) -> str:
        """When the file began (ISO 8601), by the clock of its computer; empty where it was not noted."""
        return self._metadata.get("utc", "")

    def moment(self, time: float) -> datetime | None:
        """Return UTC at a time of the recording's clock, seconds; None where the file does not say it.

        It is that of the surveys: by the autopilot's GNSS, which a simulation draws, else by the computer.
        """
        try:
            if ZERO_UTC in self._metadata:
                return datetime.fromisoformat(self._metadata[ZERO_UTC]) + timedelta(seconds=time)
            began, clock = datetime.fromisoformat(self.utc), float(self._metadata["clock"])
            return began + timedelta(seconds=time - clock)
        except (LookupError, ValueError, OverflowError, TypeError):
            return None

    @property
    def survey(self) -> str:
        """Name of the survey that was flown; empty where it was not noted."""
        return self._metadata.get("survey", "")

    def settings(self) -> Config:
        """Return the flight's settings of camera, flight and vision; the others are defaults.

        Raises ReplayError when this version cannot read them.
        """
        try:
            values = json.loads(self._metadata.get("configuration", ""))
            return Config.model_validate({name: values[name] for name in _SECTIONS if name in values})
        except (ValueError, TypeError, ConfigError) as error:  # of JSON and of pydantic
            words = f"{self.path}: its settings cannot be used by this version: {in_a_line(error)}"
            raise ReplayError(f"{words}; use {self.maker}, which recorded it") from error

    def messages(self) -> Iterator[Recorded]:
        """Give the messages in their order, up to the damage. Raises ReplayError when the first cannot be read."""
        first: float | None = None
        self.damage = "" if is_whole(self.path) else NO_END
        try:
            for message in read_recording(self.path):
                first = message.time if first is None else first
                self.seconds = max(self.seconds, message.time - first)
                yield message
        except RecordingError as error:
            if first is None:
                raise ReplayError(f"{error}; name another recording") from error
            self.damage = str(error)

    def follow(self, take: Callable[[Recorded], bool]) -> None:
        """Hand each message to ``take``, which returns True for one that it uses, up to the damage.

        What it cannot read (it raises ReplayError, RecordingError) is damage, too. Raises ReplayError when that is the
        first that it would use.
        """
        used, damage = False, ""
        for message in self.messages():
            try:
                used = take(message) or used
            except (ReplayError, RecordingError) as error:
                if not used:
                    raise ReplayError(f"{self.path}: {error}; use {self.maker}, which recorded it") from error
                damage = str(error)
                break
        self.damage = damage or self.damage

    def played(self) -> Iterator[Played]:
        """Give the messages and when each is played: as they came, with leaps of the clock cut to `LONGEST_GAP_S`."""
        return play(self.messages())


def play(messages: Iterable[Recorded]) -> Iterator[Played]:
    """Give messages with the seconds at which each is played; see `RecordedFlight.played`."""
    at, before = 0.0, None
    for message in messages:
        if before is not None:
            at += min(max(0.0, message.time - before), LONGEST_GAP_S)
        before = message.time
        yield Played(at, message)


def in_a_line(error: Exception) -> str:
    """Return an error's words in one line, without pydantic's address for more."""
    return " ".join(_FURTHER.sub("", str(error)).split())


class Origin:
    """Follows the map's origin, and the altitude of the arm place, in the facts of the ticks."""

    def __init__(self) -> None:
        self.datum: GlobalPose | None = None
        """WGS-84 place of the map's origin; None before it is known."""
        self.arm_altitude = 0.0
        """Metres above mean sea level by which heights above the arm place become altitudes."""

    def look(self, message: Recorded) -> None:
        """Take a message; those that say nothing of the origin are ignored. Raises ReplayError."""
        if message.topic != TICK or _DATUM not in message.data:
            return
        try:
            position = message.payload()["facts"]["position"]
            if position.get("datum") is not None:
                self.datum = GlobalPose(*(float(position["datum"][name]) for name in GlobalPose.__slots__))
            self._look_at_pose(position.get("pose"))
        except (RecordingError, LookupError, TypeError, ValueError, AttributeError) as error:
            raise ReplayError(f"the position at {message.time:.2f} s cannot be read: {error!r}") from error

    def _look_at_pose(self, pose: Any) -> None:
        if pose is not None and pose.get("map") is not None:
            self.arm_altitude = float(pose["global_"]["altitude"]) - float(pose["map"]["height"])
