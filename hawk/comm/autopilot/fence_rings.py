"""The autopilot's fence in degrees: what is uploaded, and the comparison with what is read back."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from hawk.comm.autopilot.vehicle import AutopilotError
from hawk.model.frames import place_at
from hawk.model.limits import Fence
from hawk.model.poses import GlobalPose
from hawk.model.sentences import say

LEAST_CORNERS = 3
TOLERANCE_DEG = 1e-6
"""A decimetre; the mission protocol carries 1e-7 degrees."""
STORAGE_BYTES = 560
"""Memory for a fence of an ArduCopter board with 16 kB for parameters (ArduPilot, libraries/StorageManager)."""
_HEAD_BYTES, _RING_BYTES, _CORNER_BYTES = 5, 2, 8

Corners = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class FenceRings:
    """An inclusion polygon and exclusion polygons: (latitude, longitude) corners in degrees, in order, not closed."""

    inclusion: Corners
    exclusions: tuple[Corners, ...] = ()

    def __iter__(self) -> Iterator[Corners]:
        """Yield the inclusion polygon, then the exclusion polygons."""
        yield self.inclusion
        yield from self.exclusions


def rings_of(fence: Fence, origin: GlobalPose | None) -> FenceRings:
    """Return the autopilot's limits of a fence whose metres are about ``origin``.

    Raises:
        AutopilotError: The origin is not known, a ring is none, or the autopilot cannot store the fence.
    """
    if origin is None:
        raise AutopilotError(say("The drone does not know where it is yet: the fence cannot be placed"))
    rings = FenceRings(
        _corners(fence.autopilot_polygon, origin), tuple(_corners(zone, origin) for zone in fence.autopilot_zones)
    )
    if len(rings.inclusion) < LEAST_CORNERS:
        raise AutopilotError(say("A fence needs at least {least} corners", least=LEAST_CORNERS))
    if any(len(ring) < LEAST_CORNERS for ring in rings.exclusions):
        raise AutopilotError(say("An exclusion zone needs at least {least} corners", least=LEAST_CORNERS))
    needed = _HEAD_BYTES + sum(_RING_BYTES + _CORNER_BYTES * len(ring) for ring in rings)
    if needed > STORAGE_BYTES:  # ArduCopter ends its program over a fence that fills its memory to the last byte
        raise AutopilotError(
            say(
                "The fence needs {needed} bytes, the autopilot has {most}: leave out corners",
                needed=needed,
                most=STORAGE_BYTES,
            )
        )
    if not all(math.isfinite(value) for ring in rings for corner in ring for value in corner):
        raise AutopilotError(say("A corner of the fence is not finite: not sent"))
    return rings


def difference(ours: FenceRings, found: FenceRings) -> str:
    """Return how the fence that was read differs from ours, in words; empty when it does not.

    Rings and corners are compared in their order.
    """
    if len(ours.exclusions) != len(found.exclusions):
        return say(
            "it has {held} exclusion zones, ours has {ours}", held=len(found.exclusions), ours=len(ours.exclusions)
        )
    for number, (ring, read) in enumerate(zip(ours, found, strict=True)):
        if not _is_same(ring, read):
            zone = say("its zone {number} is another one", number=number)
            return zone if number else say("its polygon is another one")
    return ""


def _corners(ring: Corners, origin: GlobalPose) -> Corners:
    places = [place_at(north, east, origin) for north, east in ring]
    return tuple((place.latitude, place.longitude) for place in places)


def _is_same(ring: Corners, read: Corners) -> bool:
    return len(ring) == len(read) and all(
        math.isclose(ours, theirs, rel_tol=0.0, abs_tol=TOLERANCE_DEG)
        for corner, other in zip(ring, read, strict=True)
        for ours, theirs in zip(corner, other, strict=True)
    )
