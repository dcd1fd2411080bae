"""Arrivals at a desk: what a drone or a program has sent, and what became of it. Nothing here needs a database."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Literal

from pydantic import Field

from hawk.lots.answers import Part, Shown, Utc
from hawk.lots.plan.values import Id

OutcomeName = Literal["taken", "known", "older", "waits", "refused"]


class ArrivalKind(StrEnum):
    """Kind of what came."""

    SURVEY = "survey"
    LOT = "lot"
    FILE = "file"
    """A picture or film for the inbox."""
    RECORDING = "recording"
    """A recording of a survey, whole."""
    OTHER = "other"
    """A request for an address that no drone's token opens."""


class Outcome(StrEnum):
    """Outcome of an arrival."""

    TAKEN = "taken"
    KNOWN = "known"
    """The same is here already."""
    OLDER = "older"
    """A newer state is here: nothing changes."""
    WAITS = "waits"
    """The plan of a lot waits for a person; a survey that came with it is stored."""
    REFUSED = "refused"


@dataclass(frozen=True, slots=True)
class Arrival:
    """An arrival. ``sender``: name of the token; "": it had none. ``name``: id of the lot, or of the survey, of a
    recording too; name of the file; method and path of a request. ``state``: of the document. ``reason``: of a refusal,
    in words. ``times``: with those that were refused unread before it.
    """

    sender: str
    kind: ArrivalKind
    name: str
    outcome: Outcome
    lot: str | None = None
    state: int | None = None
    reason: str = ""
    times: int = 1


class ListedArrival(Shown):
    """Arrival from a drone or a program. `name`: id of the lot, or of the survey, of a recording too; name of the file;
    method and path of another request; empty for what was erased.
    """

    seq: Annotated[int, Field(description="number in the order of arrival")]
    at: Utc
    sender: Annotated[str, Field(description="name of the drone's token; empty: no token that is known")]
    kind: Literal["survey", "lot", "file", "recording", "other"]
    name: str
    lot: Id | None
    state: Annotated[int | None, Field(description="of the document; null: it was not read")]
    outcome: Annotated[
        OutcomeName,
        Field(
            description="known: the same was here; older: a newer state was here; waits: the plan waits for a person, "
            "its survey is stored"
        ),
    ]
    reason: Annotated[str, Field(description="why it was refused")]
    times: Annotated[int, Field(ge=1, description="refusals in a row that were alike; `at` is the last one")]


class ArrivalList(Part):
    """Part of the list of arrivals."""

    items: list[ListedArrival]
