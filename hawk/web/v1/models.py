"""Answers that the web room makes itself: refusals, and the recordings on the drone's disk."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from hawk.lots.answers import Count, Next, Shown, Utc
from hawk.lots.plan.values import Id


class Problem(Shown):
    """Refusal of a request (RFC 9457): `detail` says what is wrong and the remedy, `field` names the value."""

    type: str
    title: str
    status: int
    detail: str
    field: str = ""
    who: Annotated[str, Field(description="person who edits the plan")] = ""
    since: Annotated[Utc | None, Field(description="beginning of that edit")] = None


class RecordedLot(Shown):
    """Lot of a recorded flight."""

    id: Id
    name: str


class Recording(Shown):
    """A recording on the drone's disk. `keep`: it is never removed for room."""

    name: str
    bytes: Count
    began: Utc | None
    seconds: float | None
    survey: str | None
    lot: RecordedLot | None
    keep: bool
    under_way: bool


class RecordingList(Shown):
    """Part of the list of recordings."""

    items: list[Recording]
    next: Next
