"""The planned fence: what the next Arm puts in force, in WGS-84, and what an operator is answered about one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely
from shapely import Polygon

from hawk.comm.protocol.commands import CheckFence, FenceCheck, SetFence
from hawk.comm.protocol.heartbeat import FenceCorner, FenceSetup
from hawk.config.sections import FenceSettings
from hawk.ddc.fence import geometry
from hawk.ddc.settings import DdcSettings
from hawk.ddc.words import metres
from hawk.model.plans import Fence, HeightParameters
from hawk.model.poses import GlobalPose, MapPoint
from hawk.model.sentences import say, words_of

_SAME_M = 0.05
"""A corner that is set on a side may lie beyond it by so much: it is kept in degrees, metres."""
LEAST_ZONE_M2 = 1.0
"""A zone around a mast; a smaller one is a slip of the hand, m²."""


def check_zones(outer: geometry.Ring, zones: Sequence[geometry.Ring]) -> None:
    """Check zones (rings of metres) in the fence ``outer``: sides, area, inside the fence, apart from each other.

    Raises:
        FenceError: Names the zone, the fault and the remedy.
    """
    if not zones:
        return
    fence = Polygon(outer).buffer(_SAME_M)
    shapes = [_checked(say("Zone {number}", number=number), ring) for number, ring in enumerate(zones, 1)]
    for number, shape in enumerate(shapes, 1):
        if not fence.covers(shape):
            where = say("crosses the fence's edge") if fence.intersects(shape) else say("lies outside the fence")
            raise geometry.FenceError(
                say("Zone {number}: {where}: move its corners inside the fence.", number=number, where=where)
            )
    first, second = np.triu_indices(len(shapes), 1)
    places = np.array(shapes, dtype=object)
    crossed = np.flatnonzero(shapely.intersects(shapely.buffer(places, -_SAME_M)[second], places[first]))
    if crossed.size:
        pair = int(second[crossed[0]]) + 1, int(first[crossed[0]]) + 1
        remedy = say("move one of them, or draw one zone around both")
        raise geometry.FenceError(
            say("Zone {one}: it crosses or holds zone {other}: {remedy}.", one=pair[0], other=pair[1], remedy=remedy)
        )


def _checked(name: str, ring: geometry.Ring) -> Polygon:
    """Return a zone's polygon. Raises FenceError when it is no polygon, or too small."""
    for number, (here, there) in enumerate(zip(ring, (*ring[1:], ring[0]), strict=True), start=1):
        if math.dist(here, there) < geometry.LEAST_SIDE_M:
            pair = say("corners {number} and {other}", number=number, other=number % len(ring) + 1)
            raise geometry.FenceError(say("{name}: {pair} lie at one place: remove one of them.", name=name, pair=pair))
    shape = Polygon(tuple((round(north, 2), round(east, 2)) for north, east in ring))
    if not shape.is_valid:
        raise geometry.FenceError(
            say(
                "{name}: {crossing}: move a corner so that no side crosses another.",
                name=name,
                crossing=geometry.crossing(ring),
            )
        )
    if shape.area < LEAST_ZONE_M2:
        raise geometry.FenceError(
            say(
                "{name}: it holds {area:.1f} m², too little to be meant: draw it wider, or remove it.",
                name=name,
                area=shape.area,
            )
        )
    return shape


@dataclass(frozen=True, slots=True)
class FencePlan:
    """The autopilot's limit. ``ring`` has (latitude, longitude) corners, none for a circle around the arm place.

    ``ceiling`` is the autopilot's, metres above the arm place. ``zones`` are exclusion zones inside the ring, corners
    as in it.
    """

    source: Literal["drawn", "file", "circle"]
    ring: geometry.Ring
    ceiling: float
    zones: tuple[geometry.Ring, ...] = ()

    @property
    def origin(self) -> GlobalPose:
        """A datum on the fence. Lengths measured on it hold on any datum near the fence."""
        return GlobalPose(*self.ring[0], 0.0)

    def on_map(self, datum: GlobalPose, settings: FenceSettings) -> Fence:
        """Return the polygon in the map frame with our limit inside it.

        Raises:
            FenceError: Nothing whole is left inside the margin.
        """
        outer, *zones = geometry.converted((self.ring, *self.zones), lambda ring: geometry.ring_to_map(datum, ring))
        return geometry.polygon_fence(outer, settings.margin_m, self.ceiling, settings.ceiling_margin_m, zones)

    def around(self, datum: GlobalPose, place: GlobalPose, settings: FenceSettings) -> Fence:
        """Return the fence in the map frame for a drone that is armed at a place.

        Raises:
            FenceError: Nothing whole is left inside the margin.
        """
        if self.ring:
            return self.on_map(datum, settings)
        outer = geometry.circle(geometry.to_map(datum, place.latitude, place.longitude), settings.radius_m)
        return geometry.polygon_fence(outer, settings.margin_m, self.ceiling, settings.ceiling_margin_m)


@dataclass(frozen=True, slots=True)
class Measures:
    """Size of a planned polygon: our limit (latitude, longitude); extent (m) and area (m²) of the autopilot's.

    ``inner_zones`` are the zones with our margin around them. The area is without zones.
    """

    inner: geometry.Ring
    inner_zones: tuple[geometry.Ring, ...]
    north_south: float
    east_west: float
    area: float


def check_plan(plan: FencePlan, settings: DdcSettings, heights: HeightParameters) -> Measures:
    """Check a drawn fence as far as it does not depend on the drone's place.

    Raises:
        FenceError: Names the field, the fault and the remedy.
    """
    origin = plan.origin
    outer, *zones = geometry.converted((plan.ring, *plan.zones), lambda ring: geometry.ring_to_map(origin, ring))
    geometry.check_fence_ring(outer)
    check_zones(outer, zones)
    _check_ceiling(plan.ceiling, settings, heights)
    fence = plan.on_map(origin, settings.fence)
    inner, *inner_zones = geometry.converted(
        (fence.polygon, *fence.zones), lambda ring: geometry.ring_from_map(origin, ring)
    )
    whole = geometry.autopilot_fence(fence)
    return Measures(inner, tuple(inner_zones), *geometry.extent(whole), geometry.area(whole))


def plan_of(command: SetFence | CheckFence) -> FencePlan:
    """Return the fence of a command."""
    zones = tuple(_ring(zone) for zone in command.zones)
    return FencePlan("drawn", _ring(command.corners), command.ceiling, zones)


def fence_refusal(command: SetFence, settings: DdcSettings, heights: HeightParameters) -> str:
    """Return the reason why the fence of a command cannot be stored; empty when it can."""
    try:
        check_plan(plan_of(command), settings, heights)
    except geometry.FenceError as error:
        return words_of(error)
    return ""


@dataclass(frozen=True, slots=True)
class Standpoint:
    """The drone's place (WGS-84), the datum of the next Arm and the autopilot's return height; None while unknown."""

    place: GlobalPose | None
    datum: GlobalPose | None
    return_height: float | None


def check_answer(
    command: CheckFence, settings: DdcSettings, heights: HeightParameters, standpoint: Standpoint
) -> FenceCheck:
    """Return the faults of a fence, its size, and notes about flying in it from where the drone is."""
    plan = plan_of(command)
    try:
        found = check_plan(plan, settings, heights)
    except geometry.FenceError as error:
        return FenceCheck(
            id=command.id,
            problem=words_of(error),
            notes=[],
            inner=[],
            inner_zones=[],
            north_south=None,
            east_west=None,
            area=None,
        )
    return FenceCheck(
        id=command.id,
        problem="",
        notes=_notes(plan, settings, standpoint),
        inner=corners(found.inner),
        inner_zones=[corners(zone) for zone in found.inner_zones],
        north_south=found.north_south,
        east_west=found.east_west,
        area=found.area,
    )


def fence_setup(plan: FencePlan, settings: DdcSettings, problem: str) -> FenceSetup:
    """Return the planned fence as operators see it."""
    inner: geometry.Ring = ()
    zones: tuple[geometry.Ring, ...] = ()
    if plan.ring:
        with suppress(geometry.FenceError):  # a configured file that is too narrow: the preflight check reports it
            found = check_plan(plan, settings, HeightParameters(0.0, 0.0, 0.0))
            inner, zones = found.inner, found.inner_zones
    return FenceSetup(
        source=plan.source,
        corners=corners(plan.ring),
        zones=[corners(zone) for zone in plan.zones],
        inner=corners(inner),
        inner_zones=[corners(zone) for zone in zones],
        radius=settings.fence.radius_m if plan.source == "circle" else None,
        ceiling=plan.ceiling,
        margin=settings.fence.margin_m,
        ceiling_margin=settings.fence.ceiling_margin_m,
        highest_ceiling=settings.heights.ceiling_m,
        problem=problem,
    )


def corners(ring: geometry.Ring) -> list[FenceCorner]:
    """Return (latitude, longitude) corners as the messages have them."""
    return [FenceCorner(latitude=latitude, longitude=longitude) for latitude, longitude in ring]


def _ring(places: Sequence[FenceCorner]) -> geometry.Ring:
    return tuple((each.latitude, each.longitude) for each in places)


def _notes(plan: FencePlan, settings: DdcSettings, standpoint: Standpoint) -> list[str]:
    place = standpoint.place
    if place is None:
        return [say("Where the drone is, is not known yet.")]
    datum = standpoint.datum or place
    fence = plan.on_map(datum, settings.fence)
    home = geometry.to_map(datum, place.latitude, place.longitude)
    if not geometry.contains(fence, home):
        return [say("The drone stands {where}: it could not be armed there.", where=where_outside(fence, home))]
    notes = [] if geometry.sees_all(fence, home) else [blind_home(fence)]
    altitude = standpoint.return_height
    if altitude is not None and altitude > fence.ceiling:
        high = say(
            "It returns home at {altitude}, above {ceiling}: change the heights first.",
            altitude=metres(altitude),
            ceiling=metres(fence.ceiling),
        )
        notes.insert(0, high)
    return notes


def where_outside(fence: Fence, place: MapPoint) -> str:
    """Return in words where a place outside our fence lies: beyond its edge, or in a zone."""
    away, zone = metres(max(1.0, geometry.outside_by(fence, place))), geometry.zone_of(fence, place)
    if zone is None:
        return say("{away} outside the dotted line", away=away)
    return say("{away} inside the dotted line of zone {zone}", away=away, zone=zone)


def blind_home(fence: Fence) -> str:
    """Return the note about a home that is not seen from everywhere inside."""
    return say(
        "From parts of it the straight path home {crosses}. Our returns stay inside; the autopilot's own failsafes "
        "(lost link, its battery failsafe, a dead companion computer) fly straight.",
        crosses=say("crosses a zone") if fence.zones else say("leaves the fence"),
    )


def _check_ceiling(ceiling: float, settings: DdcSettings, heights: HeightParameters) -> None:
    highest, margin = settings.heights.ceiling_m, settings.fence.ceiling_margin_m
    if ceiling > highest:
        raise geometry.FenceError(
            say(
                "Ceiling: {ceiling} is above the highest allowed, {highest}: lower it.",
                ceiling=metres(ceiling),
                highest=metres(highest),
            )
        )
    needed = heights.maximum + margin
    if ceiling < needed:
        raise geometry.FenceError(
            say(
                "Ceiling: {ceiling} is too low for flying up to {maximum:g} m, which needs {needed:g} m: raise it, or "
                "lower Max first.",
                ceiling=say("{found:g} m", found=ceiling),
                maximum=heights.maximum,
                needed=needed,
            )
        )
