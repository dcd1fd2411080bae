"""Vehicles on the map: objects beside the stalls, each of one survey only."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class VehicleKind(StrEnum):
    """Class of a vehicle. A bus is a lorry, a camper a van, a caravan a trailer."""

    CAR = "car"
    VAN = "van"
    LORRY = "lorry"
    TRAILER = "trailer"


@dataclass(frozen=True, slots=True)
class Vehicle:
    """A vehicle: an oriented rectangle, the body on the ground without its shadow.

    ``north``, ``east``: its middle, metres. ``angle`` is the direction of the long side in [0, pi), clockwise from
    north; ``probability`` that it is a vehicle and stands there still; ``looks``: how many showed it. ``stood_s``:
    seconds of the flight between the first and the last of them: a vehicle that drives is gone at the next.
    """

    id: int
    kind: VehicleKind
    north: float
    east: float
    angle: float
    width: float
    length: float
    probability: float
    looks: int
    stood_s: float


@dataclass(frozen=True, slots=True)
class MapVehicle(Vehicle):
    """A vehicle on the map. ``version`` rises when its shown content changes."""

    last_seen: float
    version: int
