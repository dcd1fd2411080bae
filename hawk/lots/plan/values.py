"""Values of a plan: stalls and areas as a layout version has them, and the draft of a change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, ClassVar, Final, Literal, Protocol

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field, WithJsonSchema

from hawk.lots.plan.kinds import Kind
from hawk.model.poses import Ring

Floats = NDArray[np.float64]
ID: Final = "^[0-9a-f-]{36}$"
Id = Annotated[str, WithJsonSchema({"pattern": ID, "type": "string"})]
"""Id of an answer: the store made it, and nobody checks it again."""
ANSWER: Final = ConfigDict(extra="forbid", allow_inf_nan=False)
"""Rules for a value that is an answer of the API."""

SHAPE: Final = ("north", "east", "angle", "width", "length")
LASTING: Final = ("label", *SHAPE, "kind", "is_confirmed", "is_named")
"""Columns of a stall that each layout version may have otherwise."""
NO_STALLS: Final = "no_stalls"
"""Kind of a zone that has no stall."""
PRIVATE: Final = "private_ground"
"""Kind of a zone that nobody may look at: it has no stall either, and no picture shows it."""
BARE: Final = (NO_STALLS, PRIVATE)
"""Kinds of zones that have no stall."""
BareKind = Literal["no_stalls", "private_ground"]
SectionKind = Literal["parallel", "across", ""]
NEW: Final = 0
"""Key of a stall that is not in the store yet."""


class Shaped(Protocol):
    """A rectangle on the ground."""

    @property
    def shape(self) -> tuple[float, float, float, float, float]:
        """North, east (its middle), angle of its length, width, length; metres, radians."""


@dataclass(frozen=True, slots=True)
class PlanStall:
    """A stall of a plan: its middle, and the direction of its length, radians clockwise from north.

    ``id`` (UUID) is never another stall's, ``label`` none's of the same layout. Metres in the lot's frame.
    """

    __pydantic_config__: ClassVar = ANSWER

    id: Id
    label: str
    north: float
    east: float
    angle: float
    width: float
    length: float
    kind: Annotated[Kind, Field(description="as OpenStreetMap's parking_space; empty for a normal stall")]
    is_confirmed: bool
    is_named: Annotated[bool, Field(description="a person gave or confirmed the label; else it is hawk's guess")]

    @property
    def shape(self) -> tuple[float, float, float, float, float]:
        """North, east, angle, width, length."""
        return self.north, self.east, self.angle, self.width, self.length


@dataclass(frozen=True, slots=True)
class LayoutStall(PlanStall):
    """A stall of a plan in the store, by its ``key``; ``begins``: first version of the layout that has it."""

    key: int = NEW
    begins: int = 1

    def at(self, shape: Sequence[float]) -> LayoutStall:
        """Return the stall with another shape."""
        north, east, angle, width, length = shape
        return replace(self, north=north, east=east, angle=angle, width=width, length=length)


@dataclass(frozen=True, slots=True)
class PlanZone:
    """An area of a plan: a zone whose stalls statistics count together, or one without stalls."""

    __pydantic_config__: ClassVar = ANSWER

    id: Id
    name: str
    outline: Annotated[Ring, Field(description="north and east, metres")] = field(repr=False)
    kind: Kind | BareKind


@dataclass(frozen=True, slots=True)
class PlanSection:
    """A section of a plan: a strip along a kerb, or an area, whose parked vehicles are counted against a capacity.

    Its ``id`` (UUID) stays when it changes, ``name`` is no other section's of the plan.
    """

    __pydantic_config__: ClassVar = ANSWER

    id: Id
    name: str
    outline: Annotated[Ring, Field(description="north and east, metres")] = field(repr=False)
    kind: Annotated[
        SectionKind, Field(description="how vehicles stand at the kerb; empty for an area where that does not matter")
    ]
    length_m: Annotated[float, Field(description="length along the kerb")]
    capacity: Annotated[int | None, Field(description="places; null: not known, vehicles are counted alone")]
    is_capacity_given: Annotated[bool, Field(description="a person gave the capacity; else it follows from the length")]
    note: Annotated[str, Field(description="words of a person: permit, loading, disabled")]


@dataclass(frozen=True, slots=True)
class LayoutSection(PlanSection):
    """A section in the store, by the ``key`` of its row."""

    key: int = NEW


@dataclass(frozen=True, slots=True)
class Draft:
    """A change of a plan that was not checked yet.

    ``changed``: stalls as they are and as they are to be; ``added``: in the order of a row. A stall without label gets
    one of ours. ``field``: the field of the operation that says where stalls stand, or their labels. ``rows``: names of
    rows that stalls get as a whole: a row of ours that has such a name gives it up. ``forbidden``, ``allowed``: areas
    without stalls that begin, end; ``drawn``, ``erased``: named zones that do; ``begun_sections``, ``ended_sections``:
    sections that do: one that changes does both.
    """

    changed: tuple[tuple[LayoutStall, LayoutStall], ...] = ()
    ended: tuple[LayoutStall, ...] = ()
    added: tuple[LayoutStall, ...] = ()
    forbidden: tuple[PlanZone, ...] = ()
    allowed: tuple[PlanZone, ...] = ()
    drawn: tuple[PlanZone, ...] = ()
    erased: tuple[PlanZone, ...] = ()
    begun_sections: tuple[LayoutSection, ...] = ()
    ended_sections: tuple[LayoutSection, ...] = ()
    field: str = "stalls"
    rows: frozenset[str] = frozenset()

    @property
    def is_empty(self) -> bool:
        """True when nothing changes."""
        stalls, zones = self.changed or self.ended or self.added, self.begun_zones or self.ended_zones
        return not (stalls or zones or self.begun_sections or self.ended_sections)

    @property
    def begun_zones(self) -> tuple[PlanZone, ...]:
        """Areas that become part of the plan."""
        return (*self.forbidden, *self.drawn)

    @property
    def ended_zones(self) -> tuple[PlanZone, ...]:
        """Areas that are no part of the plan any more."""
        return (*self.allowed, *self.erased)

    @property
    def placed(self) -> tuple[LayoutStall, ...]:
        """Stalls that stand elsewhere than before."""
        return (*self.added, *(new for old, new in self.changed if old.shape != new.shape))

    @property
    def given(self) -> tuple[tuple[str, LayoutStall], ...]:
        """Stalls with a label that a person gives them, each behind its former label, "" of a new one."""
        added = (("", stall) for stall in self.added)
        changed = ((old.label, new) for old, new in self.changed if old.label != new.label)
        return tuple((former, stall) for former, stall in (*added, *changed) if stall.label)

    @property
    def nameless(self) -> tuple[LayoutStall, ...]:
        """Stalls that get a label of ours: the new ones first."""
        return tuple(stall for stall in (*self.added, *(new for _, new in self.changed)) if not stall.label)

    @property
    def touched(self) -> frozenset[int]:
        """Keys of the stalls that end or change."""
        return frozenset((*(stall.key for stall in self.ended), *(old.key for old, _ in self.changed)))

    def naming(self, labels: Mapping[str, str]) -> Draft:
        """Return the draft with other labels of some stalls, by their ids. A label that is taken away is ours."""

        def named(stall: LayoutStall) -> LayoutStall:
            return replace(stall, label=labels[stall.id], is_named=False) if stall.id in labels else stall

        changed = tuple((old, named(new)) for old, new in self.changed)
        return replace(self, added=tuple(map(named, self.added)), changed=changed)


def shapes_of(stalls: Sequence[Shaped]) -> Floats:
    """Return the shapes of stalls, (N, 5): north, east, angle, width, length."""
    return np.array([stall.shape for stall in stalls], np.float64).reshape(-1, 5)
