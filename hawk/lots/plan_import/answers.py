"""Answers about the import of a plan, as `hawk.lots.answers` has those about lots."""

from __future__ import annotations

from typing import Literal

from hawk.lots.answers import Count, Degrees, Shown
from hawk.lots.plan.values import Id, SectionKind
from hawk.model.poses import Ring


class PlanPlace(Shown):
    """Place of a file's plan on the lot: by what it was found, on what; a shift, metres, a turn, degrees."""

    by: str
    on: str
    is_certain: bool
    doubt: str
    north: float
    east: float
    turn: float
    residual: float
    accuracy: float | None


class PlanShape(Shown):
    """A stall in the lot's frame, metres and radians."""

    north: float
    east: float
    angle: float
    width: float
    length: float
    label: str


class BeginningShape(PlanShape):
    """A stall that the plan would have besides."""

    kind: str


class StayingShape(BeginningShape):
    """A stall of the plan as the file has it; `former`: its label."""

    id: Id
    former: str


class EndingShape(PlanShape):
    """A stall that the plan would have no more."""

    id: Id


class SectionShape(Shown):
    """A section that the plan would have besides, otherwise (`stay`), or no more: metres in the frame of the lot.

    `former`: its name in the plan, empty where it begins.
    """

    change: Literal["begin", "stay", "end"]
    name: str
    former: str
    outline: Ring
    kind: SectionKind
    length_m: float
    capacity: int | None
    is_capacity_given: bool
    note: str


class LeftOutFeature(Shown):
    """A feature of the file that is left out, or that clashes, and why."""

    name: str
    reason: str


class Renamed(Shown):
    """A label of the file that another stall keeps, or a name that another section keeps, and the one in its place."""

    label: str
    to: str


class PlanLayer(Shown):
    """A layer of a drawing."""

    name: str
    outlines: Count


class PlanPreview(Shown):
    """Effect of an import, which its `token` takes within minutes; nothing is written before. `same` and
    `same_sections`: stalls and sections that the plan has as the file does.
    """

    token: str
    lot: Id | None
    file: str
    format: str
    crs: str
    datum: Degrees
    placed: PlanPlace
    begin: list[BeginningShape]
    stay: list[StayingShape]
    same: int
    end: list[EndingShape]
    sections: list[SectionShape]
    same_sections: Count
    left_out: list[LeftOutFeature]
    left_out_count: Count
    notes: list[str]
    clashes: list[LeftOutFeature]
    clash_count: Count
    renamed: list[Renamed]
    layers: list[PlanLayer]
