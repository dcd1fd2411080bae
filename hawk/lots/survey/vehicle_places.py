"""Places of a survey's vehicles, one each: on a stall, in a section, beside the stalls of the lot, on a road, or not.

All is in the lot's frame, metres (north, east).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from hawk.lots.plan import geometry
from hawk.lots.plan.values import Floats
from hawk.model.poses import Ring

ON_STALL: Final = 0.3
"""Share of a stall that a vehicle covers from which it stands on it."""


class Place(StrEnum):
    """Kind of ground that a vehicle stands on. The first that fits counts."""

    STALL = "stall"
    SECTION = "section"
    BESIDE = "beside"
    """On the lot's ground, on no stall and in no section: in an aisle, on hatching, before a gate."""
    ROAD = "road"
    ELSEWHERE = "elsewhere"


@dataclass(frozen=True, slots=True)
class Grounds:
    """Grounds of a lot. ``stalls``: shapes (N, 5). ``sections``: id -> ring; one without corners is passed over."""

    stalls: Floats = field(repr=False)
    sections: dict[str, Ring] = field(repr=False)
    lot: BaseGeometry = field(default_factory=shapely.Polygon, repr=False)
    roads: BaseGeometry = field(default_factory=shapely.Polygon, repr=False)


@dataclass(frozen=True, slots=True)
class PlacedVehicle:
    """Place of a vehicle. ``of``: number of the stall, or id of the section; else ""."""

    place: Place
    of: str = ""


def may_be_seen(shapes: Floats, private: Sequence[Ring]) -> NDArray[np.bool_]:
    """Return which shapes (N, 5) have their middle on ground that one may look at; ``private``: rings of other one."""
    hidden = np.zeros(len(shapes), np.bool_)
    for ring in private:
        hidden |= np.array(geometry.within(ring, shapes[:, :2]), np.bool_)
    return ~hidden


def places_of(vehicles: Floats, grounds: Grounds) -> tuple[PlacedVehicle, ...]:
    """Return the place of each vehicle, shapes (V, 5).

    A vehicle stands on the stall of which it covers most, above `ON_STALL`; else in the section that has its middle,
    the first of several.
    """
    stalls = _stalls_of(vehicles, grounds.stalls)
    middles = vehicles[:, :2]
    sections = np.full(len(vehicles), "", object)
    for section, ring in grounds.sections.items():
        if ring:
            sections[np.array(geometry.within(ring, middles), np.bool_) & (sections == "")] = section
    in_lot, on_road = (shapely.contains_xy(ground, middles) for ground in (grounds.lot, grounds.roads))
    found = []
    for stall, section, is_beside, is_on_road in zip(stalls, sections, in_lot, on_road, strict=True):
        if stall >= 0:
            found.append(PlacedVehicle(Place.STALL, str(stall)))
        elif section:
            found.append(PlacedVehicle(Place.SECTION, section))
        else:
            found.append(PlacedVehicle(Place.BESIDE if is_beside else Place.ROAD if is_on_road else Place.ELSEWHERE))
    return tuple(found)


def _stalls_of(vehicles: Floats, stalls: Floats) -> list[int]:
    """Return the number of the stall that each vehicle stands on; -1 for none."""
    found = [-1] * len(vehicles)
    if not len(vehicles) or not len(stalls):
        return found
    bodies, grounds = geometry.polygons(vehicles), geometry.polygons(stalls)
    body, stall = shapely.STRtree(grounds).query(bodies, predicate="intersects")
    shares = shapely.area(shapely.intersection(bodies[body], grounds[stall])) / shapely.area(grounds[stall])
    for number in np.argsort(shares, kind="stable").tolist():
        if shares[number] > ON_STALL:
            found[body[number]] = int(stall[number])
    return found
