"""Values of a request for the recordings of a survey, as `hawk.store.recording_requests` keeps it and answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

ASKED: Final = "Hawk-Recordings"
"""Header by which a desk names surveys, by their ids, whose recordings it asks the drone of the token for."""
MOST_ASKED: Final = 16
MOST_RECORDINGS: Final = 100
"""Recordings of one survey: its landings, between which batteries are changed."""
Answer = Literal["", "never", "gone"]
"""Answer of a drone: it gives them, its settings forbid that, it has none."""
State = Literal["none", "asked", "coming", "here", "never", "gone"]
Cause = Literal["unasked", "other", "place", "wrong", "full"]
"""Causes of a refusal: nobody asked for it, another drone was asked, another part comes next, it is not what it says
it is, there is no room."""


class PartRefusedError(Exception):
    """Refusal of what a drone sent of a recording; the text says why, with the remedy."""

    def __init__(self, cause: Cause, named: str, reason: str) -> None:
        super().__init__(f"{named}: {reason}")
        self.cause = cause
        self.named = named
        self.reason = reason


@dataclass(frozen=True, slots=True)
class OfferedRecording:
    """A recording on a drone: ``name`` of the file there, and its ``bytes``."""

    name: str
    bytes: int


@dataclass(frozen=True, slots=True)
class ComingRecording:
    """A recording that is to come. ``digest``: SHA-256 as hex, "" before its first part."""

    name: str
    bytes: int
    digest: str = ""


@dataclass(frozen=True, slots=True)
class WholeRecording:
    """A recording that is here. ``name``: on the drone; ``file``: its name here.

    A name is given again once its file was deleted: the recording is known by its ``bytes``, ``digest`` (SHA-256 as
    hex) and ``changed_ns``, the time of its last change, Unix nanoseconds.
    """

    name: str
    file: str
    bytes: int
    digest: str
    changed_ns: int


@dataclass(frozen=True, slots=True)
class RecordingRequest:
    """A request. ``survey``: id; ``drone``: name of the token that sent it; ``journal``: name that its recordings have
    of the survey; ``asked_at``: UTC, Unix seconds. ``coming`` is None before the drone has said what it has.
    ``problem``: why nothing comes now, in words.
    """

    survey: str
    drone: str
    journal: str
    asked_at: float
    answer: Answer = ""
    coming: tuple[ComingRecording, ...] | None = None
    whole: tuple[WholeRecording, ...] = ()
    problem: str = ""

    @property
    def is_waiting(self) -> bool:
        """True while the drone has something to send, or has not answered."""
        return not self.answer and self.coming != ()

    def missing(self) -> int:
        """Return the bytes of the recordings that are not whole here."""
        return sum(each.bytes for each in self.coming or ()) if self.is_waiting else 0


@dataclass(frozen=True, slots=True)
class RequestProgress:
    """Progress of a request: ``received`` of ``bytes`` are here. ``bytes`` is None before the drone has said it."""

    state: State
    received: int = 0
    bytes: int | None = None
    problem: str = ""


@dataclass(frozen=True, slots=True)
class Part:
    """Bytes of a recording: from ``start`` up to before ``end``, of ``size``. ``digest``: SHA-256 of the whole, hex."""

    start: int
    end: int
    size: int
    digest: str


NOTHING: Final = RequestProgress("none")
