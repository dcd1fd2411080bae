"""Vehicles of a flight: what single frames find, put together over its looks.

A vehicle is looked at again where it stood; one that drives is not there at the next look, and is forgotten. None is
followed from place to place, nor kept longer than its survey.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import Floats
from hawk.algo.mapper.evidence import transform_points
from hawk.algo.mapper.spatial_index import InPicture, SpatialIndex, nearest_pairs, whole_in
from hawk.algo.vision import quads
from hawk.algo.vision.detection import Vehicle
from hawk.model.vehicles import MapVehicle, VehicleKind

SHOWN: Final = 0.5
"""Probability from which a vehicle is part of the map."""
_SAME_M: Final = 1.5
_SAME_ANGLE: Final = 0.5
_SOLID: Final = 6.0
"""Looks of which place, size and kind are the mean."""
_LEAST, _MOST = -4.0, 6.0
"""Log-odds that any number of looks may add up to: a car that leaves must be believed to leave."""
_FRAME: Final = 2.5
"""Log-odds that one look may claim."""
_MISSED: Final = -1.5
"""Log-odds that a look at its whole place adds when it shows none: 13 of 100 are missed, some at every look."""
_FORGOTTEN: Final = -2.0
_LONGEST_S: Final = 900.0
"""Seconds between two looks that count: the clock of another run of the program begins elsewhere."""
_WHOLE: Final = 0.9
"""Visible share from which a look shows the whole size."""


@dataclass(frozen=True, slots=True)
class TrackedVehicle:
    """A vehicle over its looks, metres and radians; ``odds``: log-odds that it stands there. ``weight``: independent
    looks so far; ``kinds``: their sum by kind. ``stood_s``: seconds between its looks. ``born_m``: metres flown at the
    first look; ``time``: seconds of the last one.
    """

    id: int
    north: float
    east: float
    angle: float
    width: float
    length: float
    odds: float
    weight: float
    looks: int
    kinds: tuple[float, ...]
    stood_s: float
    born_m: float
    time: float
    version: int

    @property
    def probability(self) -> float:
        """Probability that it is a vehicle and stands there."""
        return 1 / (1 + math.exp(-self.odds))

    @property
    def is_shown(self) -> bool:
        """True when it is part of the map."""
        return self.probability >= SHOWN

    def on_map(self) -> MapVehicle:
        """Return it as published."""
        kind = tuple(VehicleKind)[int(np.argmax(self.kinds))]
        return MapVehicle(
            id=self.id,
            kind=kind,
            north=round(self.north, 3),
            east=round(self.east, 3),
            angle=round(self.angle, 4),
            width=round(self.width, 2),
            length=round(self.length, 2),
            probability=round(self.probability, 3),
            looks=self.looks,
            stood_s=round(self.stood_s, 1),
            last_seen=round(self.time, 3),
            version=self.version,
        )

    def to_bytes(self) -> bytes:
        """Return it as JSON."""
        return json.dumps(asdict(self)).encode()

    @classmethod
    def from_bytes(cls, data: bytes) -> TrackedVehicle:
        """Return the vehicle. Raises ValueError when it is none."""
        try:
            fields = json.loads(data)
            read = cls(**{**fields, "kinds": tuple(map(float, fields["kinds"]))})
            numbers = (read.north, read.east, read.angle, read.width, read.length, read.odds, read.weight, read.time)
            is_sound = all(map(math.isfinite, (*numbers, read.stood_s, read.born_m, *read.kinds)))
        except (AttributeError, KeyError, TypeError, UnicodeDecodeError) as error:
            raise ValueError(f"not a vehicle: {error!r}") from error
        if not is_sound or len(read.kinds) != len(VehicleKind):
            raise ValueError("not a vehicle: a number is not finite, or a kind is missing")
        return read


@dataclass(frozen=True, slots=True)
class VehicleLook:
    """One look: its finds, where the picture shows the ground, its weight as news, metres flown, time, version."""

    found: Sequence[Vehicle]
    in_picture: InPicture
    weight: float
    flown_m: float
    time: float
    version: int


class VehicleTracker(SpatialIndex[TrackedVehicle]):
    """The vehicles of a flight."""

    def look(self, sight: VehicleLook, middle: tuple[float, float], reach: float, next_id: int) -> int:
        """Take in one look at the ground within reach (metres) of a place; return the next free id."""
        here = self.about(*middle, reach)
        pairs, fresh = _pairs(here, sight.found)
        for one, found in pairs:
            self.put(_looked(one, found, sight))
        for found in fresh:
            self.put(_begun(next_id, found, sight))
            next_id += 1
        seen = {one.id for one, _ in pairs}
        for one in _missed([one for one in here if one.id not in seen], sight):
            odds = max(one.odds + sight.weight * _MISSED, _LEAST)
            if odds < _FORGOTTEN:
                self.remove(one.id, sight.version)
            else:
                self.put(replace(one, odds=odds, version=sight.version))
        return next_id

    def restore(self, vehicle: TrackedVehicle, version: int) -> None:
        """Restore one of an earlier run of the same survey."""
        self.put(replace(vehicle, born_m=0.0, version=version))

    def shown(self, since: int) -> Iterator[tuple[int, MapVehicle | None]]:
        """Yield those that changed after a version as published, None for those that are no part of the map."""
        for number, one in self.changed_since(since):
            yield number, one.on_map() if one is not None and one.is_shown else None


def moved_vehicles(found: Sequence[Vehicle], correction: Floats) -> tuple[Vehicle, ...]:
    """Return vehicles at their places after a (2, 3) correction of the map plane."""
    if not found:
        return ()
    places = transform_points(correction, np.array([(one.north, one.east) for one in found]))
    turn = math.atan2(correction[1, 0], correction[0, 0])
    return tuple(
        replace(one, north=north, east=east, angle=(one.angle + turn) % math.pi)
        for one, (north, east) in zip(found, places.tolist(), strict=True)
    )


def _places(those: Sequence[TrackedVehicle] | Sequence[Vehicle]) -> Floats:
    return np.array([(one.north, one.east) for one in those], np.float64).reshape(-1, 2)


def _pairs(
    known: list[TrackedVehicle], found: Sequence[Vehicle]
) -> tuple[list[tuple[TrackedVehicle, Vehicle]], list[Vehicle]]:
    """Return the known vehicles with the finds that are theirs, nearest first, and the other finds."""
    angles = np.array([one.angle for one in known], np.float64), np.array([one.angle for one in found], np.float64)
    pairs = nearest_pairs(_places(known), _places(found), angles, _SAME_M, _SAME_ANGLE)
    given = set(pairs.values())
    fresh = [find for k, find in enumerate(found) if k not in given]
    return [(known[one], found[find]) for one, find in pairs.items()], fresh


def _claim(found: Vehicle) -> float:
    odds = math.log(max(found.probability, 1e-6) / max(1 - found.probability, 1e-6))
    return min(max(odds, -_FRAME), _FRAME)


def _kinds(found: Vehicle) -> NDArray[np.float64]:
    return np.array([float(kind == found.kind) for kind in VehicleKind])


def _begun(number: int, found: Vehicle, sight: VehicleLook) -> TrackedVehicle:
    return TrackedVehicle(
        id=number,
        north=found.north,
        east=found.east,
        angle=found.angle,
        width=found.width,
        length=found.length,
        odds=_claim(found),
        weight=1.0,
        looks=1,
        kinds=tuple(_kinds(found).tolist()),
        stood_s=0.0,
        born_m=sight.flown_m,
        time=sight.time,
        version=sight.version,
    )


def _looked(one: TrackedVehicle, found: Vehicle, sight: VehicleLook) -> TrackedVehicle:
    """Return the vehicle after another look: the mean of its looks; a cut one shows little of place and size."""
    shown = sight.weight * (1.0 if found.visible >= _WHOLE else 0.1)
    share = shown / min(one.weight + shown, _SOLID)
    turn = (found.angle - one.angle + math.pi / 2) % math.pi - math.pi / 2
    kinds = np.array(one.kinds) + sight.weight * _kinds(found)
    gap = sight.time - one.time
    return replace(
        one,
        north=one.north + (found.north - one.north) * share,
        east=one.east + (found.east - one.east) * share,
        angle=(one.angle + turn * share) % math.pi,
        width=one.width + (found.width - one.width) * share,
        length=one.length + (found.length - one.length) * share,
        odds=min(max(one.odds + sight.weight * _claim(found), _LEAST), _MOST),
        weight=min(one.weight + shown, _SOLID),
        looks=one.looks + 1,
        kinds=tuple(kinds.tolist()),
        stood_s=one.stood_s + (gap if 0 < gap <= _LONGEST_S else 0.0),
        time=sight.time,
        version=sight.version,
    )


def _missed(those: list[TrackedVehicle], sight: VehicleLook) -> list[TrackedVehicle]:
    """Return the vehicles whose whole places the picture shows."""
    if not those:
        return []
    shape = np.array([(one.north, one.east, one.angle, one.width, one.length) for one in those]).T
    corners = quads.corners(*shape)
    return [those[k] for k in np.flatnonzero(whole_in(sight.in_picture, corners)).tolist()]
