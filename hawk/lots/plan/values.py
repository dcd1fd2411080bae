"""Values of a plan: stalls and areas as a layout version has them, and the draft of a change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SHAPE: Final = ("north", "east", "angle", "width", "length")
LASTING: Final = ("label", *SHAPE, "kind", "is_confirmed")
"""Columns of a stall that each layout version may have otherwise."""
NO_STALLS: Final = "no_stalls"
"""Kind of a zone that has no stall."""
NEW: Final = 0
"""Key of a stall that is not in the store yet."""


class Shaped(Protocol):
    """A rectangle on the ground."""

    @property
    def shape(self) -> tuple[float, float, float, float, float]:
        """North, east (its middle), angle of its length, width, length; metres, radians."""


@dataclass(frozen=True, slots=True)
class PlanStall:
    """A stall of the plan; ``id`` (UUID) and ``label`` are never another stall's.

    ``north``, ``east``: middle, metres in the lot's frame; ``angle`` of its length, radians; ``kind`` of
    `hawk.lots.plan.kinds`. ``key``: in the store; ``begins``: first version of the layout that has it.
    """

    id: str
    label: str
    north: float
    east: float
    angle: float
    width: float
    length: float
    kind: str = ""
    is_confirmed: bool = False
    key: int = 0
    begins: int = 1

    @property
    def shape(self) -> tuple[float, float, float, float, float]:
        """North, east, angle, width, length."""
        return self.north, self.east, self.angle, self.width, self.length

    def at(self, shape: Sequence[float]) -> PlanStall:
        """Return the stall with another shape."""
        north, east, angle, width, length = shape
        return replace(self, north=north, east=east, angle=angle, width=width, length=length)


@dataclass(frozen=True, slots=True)
class Zone:
    """An area; ``outline``: corners (north, east), metres in the lot's frame.

    ``kind``: `NO_STALLS`, or one of `hawk.lots.plan.kinds` of a named zone, whose stalls statistics count together.
    """

    id: str
    name: str
    outline: tuple[tuple[float, float], ...] = field(repr=False)
    kind: str = NO_STALLS


@dataclass(frozen=True, slots=True)
class Draft:
    """A change of a plan that was not checked yet.

    ``changed``: stalls as they are and as they are to be; ``added``: without label, in the order of a row; ``field``:
    the field of the operation that says where stalls stand. ``forbidden``, ``allowed``: areas without stalls that
    begin, end; ``drawn``, ``erased``: named zones that do.
    """

    changed: tuple[tuple[PlanStall, PlanStall], ...] = ()
    ended: tuple[PlanStall, ...] = ()
    added: tuple[PlanStall, ...] = ()
    forbidden: tuple[Zone, ...] = ()
    allowed: tuple[Zone, ...] = ()
    drawn: tuple[Zone, ...] = ()
    erased: tuple[Zone, ...] = ()
    field: str = "stalls"

    @property
    def is_empty(self) -> bool:
        """True when nothing changes."""
        return not (self.changed or self.ended or self.added or self.begun_zones or self.ended_zones)

    @property
    def begun_zones(self) -> tuple[Zone, ...]:
        """Areas that become part of the plan."""
        return (*self.forbidden, *self.drawn)

    @property
    def ended_zones(self) -> tuple[Zone, ...]:
        """Areas that are no part of the plan any more."""
        return (*self.allowed, *self.erased)

    @property
    def placed(self) -> tuple[PlanStall, ...]:
        """Stalls that stand elsewhere than before."""
        return (*self.added, *(new for old, new in self.changed if old.shape != new.shape))

    @property
    def given_labels(self) -> tuple[PlanStall, ...]:
        """Stalls with a label that a person gives them."""
        added = (stall for stall in self.added if stall.label)
        return (*added, *(new for old, new in self.changed if old.label != new.label))


def shapes_of(stalls: Sequence[Shaped]) -> Floats:
    """Return the shapes of stalls, (N, 5): north, east, angle, width, length."""
    return np.array([stall.shape for stall in stalls], np.float64).reshape(-1, 5)
