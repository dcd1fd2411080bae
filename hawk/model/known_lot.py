"""A lot as earlier surveys and persons know it, for a flight over it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from hawk.model.plans import Outline
from hawk.model.poses import MapPoint, Ring

AGAIN_M: Final = 300.0
"""Distance of the drone from a lot up to which it may survey it again, metres."""


@dataclass(frozen=True, slots=True)
class KnownStall:
    """A stall of a lot's plan: metres (north, east) as the receiver's position places the plan on the map.

    ``id`` is the UUID that lasts, ``label`` the name for people; ``angle`` (radians), ``width`` and ``length`` (metres)
    as in `hawk.model.lot_map.Stall`. ``is_confirmed``: a person says that it is there.
    """

    id: str
    north: float
    east: float
    angle: float
    width: float
    length: float
    is_confirmed: bool = False
    label: str = ""


@dataclass(frozen=True, slots=True)
class KnownLot:
    """The plan of a lot. ``section_places`` cover the ground of its sections, each as large as a stall.

    ``ground`` is the ground whose stalls are known: pieces of an outer ring and its holes, metres (north, east). Where
    the lot really lies on the map is found in flight: a receiver errs by metres, a compass by degrees.
    """

    id: str
    stalls: tuple[KnownStall, ...] = field(repr=False)
    ground: tuple[tuple[Ring, ...], ...] = field(repr=False)
    section_places: tuple[KnownStall, ...] = field(default=(), repr=False)

    @property
    def has_plan(self) -> bool:
        """True for a lot with ground to look at."""
        return bool(self.stalls or self.section_places)


@dataclass(frozen=True, slots=True)
class FlownSection:
    """A section of the known lot on the map of a flight, with its vehicles as they are counted so far.

    ``outline``: (north, east), metres. ``capacity``: None where nobody gives one. ``count``: None while next to nothing
    of it was seen.
    """

    id: str
    name: str
    outline: Ring = field(repr=False)
    capacity: int | None
    count: FlownCount | None = None


@dataclass(frozen=True, slots=True)
class FlownCount:
    """Count of a section: ``parked`` vehicles, ``least`` to ``most`` in nine of ten.

    ``room`` for further ones: None where too much is hidden. ``seen_share`` and ``hidden_share`` of its ground.
    """

    parked: int
    least: int
    most: int
    room: int | None
    seen_share: float
    hidden_share: float


@dataclass(frozen=True, slots=True)
class LotTour:
    """The part of a round that looks at every stall and section of one known lot once more, planned before the start.

    ``points`` are waypoints from the drone's place, or from the end of the lot before, on; ``distance_m`` is the length
    along them. ``missed`` stalls cannot be looked at from inside the fence.
    """

    lot: str
    points: tuple[MapPoint, ...] = field(repr=False)
    distance_m: float
    missed: int = 0


@dataclass(frozen=True, slots=True)
class LotAhead:
    """A lot of the store, as a drone may survey it again: ``stalls`` and ``sections`` of its plan, ``away_m`` from the
    drone, metres.

    ``outline`` is empty for a lot that is too far away. ``is_due``: the settings' schedule wants a survey of it now.
    """

    id: str
    name: str
    stalls: int
    away_m: float
    outline: Outline = field(default=Outline(), repr=False)
    is_due: bool = False
    sections: int = 0

    @property
    def has_plan(self) -> bool:
        """True for a lot with ground to look at."""
        return self.stalls > 0 or self.sections > 0


@dataclass(frozen=True, slots=True)
class PlanOffer:
    """The plan of the lot that is flown over, as somebody changed it since the motors are on.

    The flight goes on with the plan that it began with until who has control takes this one by its ``id``. ``by`` is
    the name that the change is signed with, "" where it has none: anybody may sign so. ``stalls`` are those of this
    plan, ``before`` those of the one flown.
    """

    id: str
    lot: str
    by: str
    stalls: int
    before: int


@dataclass(frozen=True, slots=True)
class LotsAhead:
    """The lots of the store, and why it cannot be read, else "".

    ``tour_m`` is the length of the flight over the lots that are surveyed again, metres; None while it is not planned.
    ``missed`` of their stalls no place inside the fence shows. ``offer`` is a changed plan that waits for an answer.
    """

    lots: tuple[LotAhead, ...] = ()
    problem: str = ""
    tour_m: float | None = None
    missed: int = 0
    offer: PlanOffer | None = None
