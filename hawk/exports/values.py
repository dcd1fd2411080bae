"""Values of an export: one survey of a lot with everything that a reader must know of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from hawk.lots.survey.source import PictureSource
from hawk.lots.values import UTC_NAME
from hawk.model.plans import Outline

if TYPE_CHECKING:
    from hawk.lots.answers import SectionLook
    from hawk.lots.plan.values import PlanSection

LatLon = tuple[float, float]
"""Degrees, WGS-84: latitude, longitude."""
UNSEEN: Final = "unknown"
"""State of a stall at which a survey did not look, or that it could not determine."""


@dataclass(frozen=True, slots=True)
class Observation:
    """A stall of the layout with the survey's look at it.

    ``corners`` (4) run counter-clockwise as seen from above; ``place`` is their middle. ``taken_probability``: that
    a car stands there, None where the survey did not look. ``looked_at``: time of the last look, UTC, Unix seconds.
    ``picture_count``: number of looks. ``kind`` is one of OpenStreetMap's ``parking_space``, "" for a normal stall.
    ``width`` and ``length`` in metres, ``direction`` of the long side in degrees clockwise from north, below 180.
    ``score``: probability of being a stall at all, None for one of a layout. ``is_named``: a person gave or confirmed
    the label.
    """

    id: str
    label: str
    kind: str
    state: str
    taken_probability: float | None
    looked_at: float | None
    picture_count: int
    place: LatLon
    corners: tuple[LatLon, ...]
    width: float
    length: float
    direction: float
    is_confirmed: bool
    score: float | None = None
    is_named: bool = False


@dataclass(frozen=True, slots=True)
class SeenSection:
    """A section of the lot's plan with a survey's look at it; ``ring``: corners on Earth, (latitude, longitude)."""

    section: PlanSection
    look: SectionLook
    ring: tuple[LatLon, ...] = field(repr=False)


@dataclass(frozen=True, slots=True)
class ExportRecord:
    """One survey of a lot.

    ``began``, ``ended``: UTC, Unix seconds; not ``time_is_sure`` while neither a time server nor GNSS had set the
    clock. ``accuracy``: standard deviation of the lot's place on Earth, metres; a person's pin has none. ``outline``:
    that of the lot. ``doubt``: why the survey is not registered: its stalls are as it found them then, without ids and
    labels of the lot. ``software``: the program and its network. ``origin``: the lot's datum. ``blurred``: number of
    its stalls that only blurred pictures showed; None: not measured. ``pictures``: its source, None for one that hawk
    flew. ``time_zone``: name of the lot's. ``sections``: those of the present plan that it looked at.
    """

    lot: str
    lot_id: str
    survey: str
    began: float
    ended: float
    time_is_sure: bool
    layout: int | None
    software: str
    is_simulated: bool
    accuracy: float | None
    is_pinned: bool
    origin: LatLon
    outline: Outline = field(repr=False)
    stalls: tuple[Observation, ...] = field(repr=False)
    doubt: str = ""
    blurred: int | None = None
    pictures: PictureSource | None = None
    time_zone: str = UTC_NAME
    sections: tuple[SeenSection, ...] = ()

    def count(self, state: str) -> int:
        """Return the number of stalls in a state."""
        return sum(stall.state == state for stall in self.stalls)
