"""Limits of a flight, and plans: what the Path Plan App receives, and its target, route and verdict."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from typing import Final

from hawk.model.poses import MapPoint, Ring


@dataclass(frozen=True, slots=True)
class HeightParameters:
    """Travel heights above the arm place, metres: 0 < minimum <= desired <= maximum <= ceiling."""

    minimum: float = 15.0
    desired: float = 35.0
    maximum: float = 60.0

    def bounded(self, height: float) -> float:
        """Return the height, metres, or the nearest one between minimum and maximum."""
        return min(max(height, self.minimum), self.maximum)


@dataclass(frozen=True, slots=True)
class Fence:
    """Limits of the flight, map frame. ``polygon`` is our own limit: it lies inside the autopilot's by the margin.

    ``autopilot_zones`` are the exclusion zones as they were drawn, ``zones`` our own limit: the same zones grown by the
    margin, so that they may cross each other and ``polygon``. Rings are (north, east) vertices in order, not closed.
    Heights are metres above the arm place.
    """

    polygon: tuple[tuple[float, float], ...]
    autopilot_polygon: tuple[tuple[float, float], ...]
    ceiling: float
    autopilot_ceiling: float
    zones: tuple[tuple[tuple[float, float], ...], ...] = ()
    autopilot_zones: tuple[tuple[tuple[float, float], ...], ...] = ()


@dataclass(frozen=True, slots=True)
class RoundLot:
    """A known lot of a round: a flight that surveys lots again, one or several.

    ``polygons`` and ``holes`` are the numbers of its rings in the outline of the round. ``is_first``: it is flown
    before the others. ``is_over``: the round has looked at it.
    """

    id: str
    name: str
    polygons: int = 1
    holes: int = 0
    is_first: bool = False
    is_over: bool = False


@dataclass(frozen=True, slots=True)
class Outline:
    """Area that an operator asks to survey: what lies in a polygon and in no hole.

    Rings are WGS-84 corners (latitude, longitude) in degrees, in order, not closed. Without polygons there is no
    outline. ``lots`` are those that are surveyed again, whose ground it is, in the order of their rings; empty for any
    other area.
    """

    polygons: tuple[Ring, ...] = ()
    holes: tuple[Ring, ...] = ()
    lots: tuple[RoundLot, ...] = ()

    def grounds(self) -> tuple[tuple[RoundLot, Outline], ...]:
        """Return each lot of the round with its own ground."""
        found, ring, hole = [], 0, 0
        for lot in self.lots:
            rings, holes = self.polygons[ring : ring + lot.polygons], self.holes[hole : hole + lot.holes]
            found.append((lot, Outline(rings, holes)))
            ring, hole = ring + lot.polygons, hole + lot.holes
        return tuple(found)


@dataclass(frozen=True, slots=True)
class AskedGround:
    """The part of an outline that lies inside the fence, map frame.

    ``pieces`` do not overlap; each is its outer ring, then its holes, rings as in `Fence`. ``area`` is theirs,
    ``outside`` that of the outline outside the fence, square metres.
    """

    pieces: tuple[tuple[Ring, ...], ...]
    area: float
    outside: float = 0.0


class Inbound(StrEnum):
    """Verdict on a place: inside the lot, outside it, or not seen yet."""

    INSIDE = "inside"
    OUTSIDE = "outside"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class DesiredPose:
    """The operator's place for the drone, numbered, so that a verdict belongs to one of them."""

    number: int
    north: float
    east: float


@dataclass(frozen=True, slots=True)
class Route:
    """A route over known lot, map frame: ``points`` from the drone's place to the requested one.

    ``turns`` has a number for each point: metres before and behind it within which its corner may be cut (0: the drone
    stops there). ``refused`` is the reason for no route; it is empty when there is one, and when none was requested.
    """

    points: tuple[MapPoint, ...] = ()
    turns: tuple[float, ...] = ()
    refused: str = ""

    @property
    def length_m(self) -> float:
        """Metres from the first point to the last."""
        return sum(a.distance(b) for a, b in pairwise(self.points))


@dataclass(frozen=True, slots=True)
class Verdict:
    """Path Plan App's answer on the desired pose of that number; ``route`` leads there when it lies inside the lot."""

    number: int
    inbound: Inbound
    route: Route = Route()


WHOLE_SHARE: Final = 0.95
"""Share of the lot found that was seen well, from which on an exploration that is done has seen it whole: planner and
mapper leave out patches smaller than a stall, and ground at the border that no picture shows well."""


@dataclass(frozen=True, slots=True)
class LeftOut:
    """Ground that an exploration did not look at, and why, square metres.

    Lot found that was not seen well: ``outside_m2`` lies outside the fence as it was drawn, ``hidden_m2`` inside, but
    no picture from inside our limit shows it, ``given_up_m2`` was flown to and showed nothing new. ``beside_m2`` is
    other ground inside the fence and near the lot, where the lot may go on: a flight there costs more than it promises.
    """

    outside_m2: float = 0.0
    hidden_m2: float = 0.0
    given_up_m2: float = 0.0
    beside_m2: float = 0.0


@dataclass(frozen=True, slots=True)
class LotLook:
    """Looks of a flight at a known lot: the share ``seen`` (0..1) of its stalls; ``is_over``: nothing is left to do."""

    lot: str
    seen: float
    is_over: bool = False


@dataclass(frozen=True, slots=True)
class ExploreStatus:
    """Progress of the exploration: ``seen`` is the share (0..1) of the known lot that has been seen well.

    ``lot_known`` is False while it still searches around something that looks like a lot. With an outline it is the
    lot: ``asked_m2`` is its area inside the fence, ``unseen_m2`` what was not looked at when it is done, square metres.
    """

    done: bool = False
    seen: float = 0.0
    remaining_m: float | None = None
    reason: str = ""
    lot_known: bool = True
    asked_m2: float | None = None
    unseen_m2: float | None = None
    unreached: bool = False
    """True when places that were worth seeing were given up: they could not be reached, or showed nothing."""
    left_out: LeftOut | None = None
    """Ground that was not looked at, once it is done; None before, and with an outline."""
    lots: tuple[LotLook, ...] = ()
    """Lots that are surveyed again, in the order of the flight; empty for any other exploration."""
    path_m: float = 0.0
    """Length of the rest of the path to the next lot; 0 over a lot."""
    is_spent: bool = False
    """True while another exploration in this flight would look at nothing more: no lot was found since this one."""

    @property
    def seen_share(self) -> float:
        """Share (0..1) of what is to be surveyed that was looked at: of the outline's whole area once it is done."""
        if not self.asked_m2 or self.unseen_m2 is None:
            return self.seen
        return max(1 - self.unseen_m2 / self.asked_m2, 0.0)

    @property
    def is_whole(self) -> bool:
        """True when the exploration is done and has seen the lot found, or the outline, whole."""
        return self.done and self.lot_known and self.seen_share >= WHOLE_SHARE


@dataclass(frozen=True, slots=True)
class PathPlan:
    """Next target in the map frame, with its yaw and height, and the route from there for display."""

    target: MapPoint | None = None
    height: float | None = None
    yaw: float | None = None
    route: tuple[MapPoint, ...] = ()
    explore: ExploreStatus = ExploreStatus()
    verdict: Verdict | None = None
    asked: Verdict | None = None
    """Verdict on a place for which only the route was requested."""
    speed: float | None = None
    """Greatest speed at which vision can read the ground, m/s; None: no limit but the travel speed."""
