"""Geometry of the fence in the map frame (metres north and east): no clock, no autopilot.

*Inside the fence* means inside its polygon and in none of its exclusion zones (`shape`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import chain, islice

import numpy as np
import pymap3d
import shapely
from shapely import LineString, MultiPolygon, Point, Polygon

from hawk.model.frames import offset_ned
from hawk.model.plans import Fence
from hawk.model.poses import GlobalPose, MapPoint, MapPose
from hawk.model.sentences import say

BREACH_TOLERANCE_M = 0.5
"""Position noise and overshoot: a breach begins this far outside our fence, metres."""
RECOVERY_DEPTH_M = 2.0
"""A drone beyond our fence is sent this far inside it, metres."""
CIRCLE_VERTICES = 48
"""Corners of a circular fence; ArduCopter takes up to 69."""
LEAST_SIDE_M = 0.5
"""Corners nearer to each other are one corner set twice, metres."""
LEAST_AREA_M2 = 400.0
"""20 x 20 m: with the margin taken off both sides something is left to fly in."""
MOST_EXTENT_M = 4000.0
"""As wide as the widest circle that can be configured."""
EDGE_MARGIN_M = 0.5
"""A stop before the edge is this far before it, metres."""
POCKET_M2 = 1.0
"""Ground that zones cut off is forbidden without a word up to this area, m²: margins leave such slivers."""
_ARC_SEGMENTS = 16
_ZONE_MITRE = 2.0
"""Corners of a grown zone lie up to this number of margins from the drawn corner; sharper ones are cut there."""
_SHALLOWER = (1.0, 0.5, 0.25, 0.0)
"""Shares of a depth, tried until the straight path to the place that deep inside enters once."""

Ring = tuple[tuple[float, float], ...]


class FenceError(ValueError):
    """A fence that cannot be used; the text names the file or the field, what is wrong and the remedy."""


def to_map(datum: GlobalPose, latitude: float, longitude: float) -> MapPoint:
    """Return a WGS-84 place (degrees) on the tangent plane at the datum."""
    north, east, _ = offset_ned(GlobalPose(latitude, longitude, datum.altitude), datum)
    return MapPoint(north, east)


def ring_to_map(datum: GlobalPose, ring: Ring) -> Ring:
    """Return (latitude, longitude) corners as (north, east) metres on the tangent plane at the datum."""
    latitudes, longitudes = np.array(ring, dtype=float).T
    north, east, _ = pymap3d.geodetic2ned(
        latitudes, longitudes, datum.altitude, datum.latitude, datum.longitude, datum.altitude
    )
    return tuple(zip(north.tolist(), east.tolist(), strict=True))


def ring_from_map(datum: GlobalPose, ring: Ring) -> Ring:
    """Return (north, east) corners on the tangent plane at the datum as (latitude, longitude) degrees."""
    north, east = np.array(ring, dtype=float).T
    latitudes, longitudes, _ = pymap3d.ned2geodetic(
        north, east, np.zeros_like(north), datum.latitude, datum.longitude, datum.altitude
    )
    return tuple(zip(latitudes.tolist(), longitudes.tolist(), strict=True))


def converted(rings: Sequence[Ring], change: Callable[[Ring], Ring]) -> tuple[Ring, ...]:
    """Return the rings changed corner by corner, by one call for all of them: a conversion costs by the call."""
    if not rings:
        return ()
    corners = iter(change(tuple(chain(*rings))))
    return tuple(tuple(islice(corners, len(ring))) for ring in rings)


def check_fence_ring(ring: Ring) -> None:
    """Check a ring of (north, east) metres: sides, extent, no crossing, area. Raises FenceError naming the corners."""
    for number, (here, there) in enumerate(zip(ring, (*ring[1:], ring[0]), strict=True), start=1):
        if math.dist(here, there) < LEAST_SIDE_M:
            raise FenceError(
                say(
                    "Corners: {number} and {other} lie at one place: remove one of them.",
                    number=number,
                    other=number % len(ring) + 1,
                )
            )
    ring = tuple((round(north, 2), round(east, 2)) for north, east in ring)  # sides that touch do so to the centimetre
    shape = Polygon(ring)
    south, west, north, east = shape.bounds
    widest = max(north - south, east - west)
    if widest > MOST_EXTENT_M:
        raise FenceError(
            say(
                "Corners: the fence is {widest:.0f} m wide: draw it at most {most:.0f} m wide.",
                widest=widest,
                most=MOST_EXTENT_M,
            )
        )
    if not shape.is_valid:
        raise FenceError(
            say("Corners: {crossing}: move a corner so that no side crosses another.", crossing=crossing(ring))
        )
    if shape.area < LEAST_AREA_M2:
        raise FenceError(
            say("Corners: the fence holds {area:.0f} m², too little to fly in: draw it wider.", area=shape.area)
        )


def crossing(ring: Ring) -> str:
    """Return in words which two sides cross or touch."""
    sides = shapely.linestrings([(here, there) for here, there in zip(ring, (*ring[1:], ring[0]), strict=True)])
    first, second = np.triu_indices(len(ring), 2)
    apart = (second - first) % len(ring) < len(ring) - 1  # the last side is the first one's neighbour
    first, second = first[apart], second[apart]
    crossed = np.flatnonzero(shapely.intersects(sides[first], sides[second]))
    if not crossed.size:
        return say("a side lies on its neighbour")
    a, b = int(first[crossed[0]]), int(second[crossed[0]])
    return say("the sides {a}-{b} and {c}-{d} cross", a=a + 1, b=a + 2, c=b + 1, d=(b + 1) % len(ring) + 1)


def polygon_fence(
    outer: Sequence[tuple[float, float]],
    margin: float,
    ceiling: float,
    ceiling_margin: float,
    zones: Sequence[Ring] = (),
) -> Fence:
    """Return the fence whose outer limit, the autopilot's, is this (north, east) ring; ours lies inside by the margins.

    Args:
        outer: The autopilot's limit, (north, east) metres.
        margin: Distance of our limit inside the autopilot's, and of our zones around the drawn ones, metres.
        ceiling: The autopilot's ceiling, metres above the arm place.
        ceiling_margin: Distance of our ceiling below the autopilot's, metres.
        zones: Exclusion zones as drawn, (north, east) metres.

    Raises:
        FenceError: Nothing, or more than one piece, is left inside.
    """
    inner = shapely.buffer(Polygon(outer), -margin, join_style="mitre", mitre_limit=5.0)
    if inner.is_empty or not isinstance(inner, Polygon) or inner.interiors:
        raise FenceError(
            say(
                "Corners: the fence is too narrow: nothing whole is left {margin:g} m inside: draw it wider.",
                margin=margin,
            )
        )
    ours = tuple(_grown(zone, margin) for zone in zones)
    _check_whole(_open_ring(inner), ours, margin)
    return Fence(
        polygon=_open_ring(inner),
        autopilot_polygon=_floats(outer),
        ceiling=ceiling - ceiling_margin,
        autopilot_ceiling=ceiling,
        zones=ours,
        autopilot_zones=tuple(_floats(zone) for zone in zones),
    )


def _grown(zone: Ring, margin: float) -> Ring:
    """Return our limit around a zone: nowhere nearer to it than the margin; a yard that it encloses belongs to it."""
    return _open_ring(shapely.buffer(Polygon(zone), margin, join_style="mitre", mitre_limit=_ZONE_MITRE))


def _check_whole(polygon: Ring, zones: Sequence[Ring], margin: float) -> None:
    """Raise FenceError naming the zone with which the inside is no longer one piece."""
    if _is_whole(_pieces(polygon, zones)):
        return
    number = next(count for count, _ in enumerate(zones, 1) if not _is_whole(_pieces(polygon, zones[:count])))
    pieces = _pieces(polygon, zones[:number])
    if not pieces:
        raise FenceError(
            say(
                "Zone {number}: with {margin:g} m around it nothing is left to fly in: draw it smaller.",
                number=number,
                margin=margin,
            )
        )
    raise FenceError(
        say(
            "Zone {number}: with {margin:g} m around it, it cuts {area:.0f} m² off the inside of the fence: "
            "move it, draw it smaller, or draw the fence so that this part lies outside.",
            number=number,
            margin=margin,
            area=pieces[1].area,
        )
    )


def _is_whole(pieces: Sequence[Polygon]) -> bool:
    return bool(pieces) and all(piece.area <= POCKET_M2 for piece in pieces[1:])


def circle(centre: MapPoint, radius: float) -> Ring:
    """Return the corners of a circle, (north, east) metres."""
    steps = (2 * math.pi * k / CIRCLE_VERTICES for k in range(CIRCLE_VERTICES))
    return tuple((centre.north + radius * math.cos(a), centre.east + radius * math.sin(a)) for a in steps)


def contains(fence: Fence, place: MapPoint) -> bool:
    """Return True when the place lies inside our fence or on its edge."""
    return _is_finite(place) and bool(shapely.intersects_xy(shape(fence), place.north, place.east))


def outside_by(fence: Fence, place: MapPoint) -> float:
    """Return how far the place lies outside our fence, metres; 0 inside."""
    if contains(fence, place):
        return 0.0
    return float(shape(fence).distance(Point(place.north, place.east)))


def path_is_inside(fence: Fence, start: MapPoint, end: MapPoint) -> bool:
    """Return True when the straight path lies inside our fence from end to end."""
    if not (_is_finite(start) and _is_finite(end)):
        return False
    if start == end:
        return contains(fence, start)
    return bool(shape(fence).covers(LineString([(start.north, start.east), (end.north, end.east)])))


def leads_inside(fence: Fence, start: MapPoint, end: MapPoint) -> bool:
    """Return True when the straight path ends inside our fence and never leaves it once it is inside.

    From a start inside this is `path_is_inside`; from one outside it is a path back that enters once.
    """
    if path_is_inside(fence, start, end):
        return True
    if not _is_finite(start) or not contains(fence, end) or contains(fence, start):
        return False
    inside = shape(fence).intersection(LineString([(start.north, start.east), (end.north, end.east)]))
    return isinstance(inside, Point | LineString)


def last_inside(fence: Fence, start: MapPoint, end: MapPoint) -> MapPoint:
    """Return the end of a straight path that begins inside and leaves our fence: `EDGE_MARGIN_M` before it leaves."""
    inside = shape(fence).intersection(LineString([(start.north, start.east), (end.north, end.east)]))
    if inside.is_empty:
        return start
    first = min(shapely.get_parts(inside), key=lambda part: part.distance(Point(start.north, start.east)))
    length = max(math.dist((start.north, start.east), corner) for corner in first.coords)
    share = max(length - EDGE_MARGIN_M, 0.0) / max(start.distance(end), 1e-9)
    return start.towards(end, share)


def sees_all(fence: Fence, place: MapPoint) -> bool:
    """Return True when the straight path from everywhere inside our fence to this place stays inside.

    A simple polygon is seen whole from where all its corners are seen. Behind a zone in its middle something always
    remains unseen.
    """
    ground = shape(fence)
    if not contains(fence, place) or ground.interiors:
        return False
    lines = shapely.linestrings([((place.north, place.east), corner) for corner in _open_ring(ground)])
    return bool(np.all(ground.covers(lines)))


def inside_point(fence: Fence, place: MapPoint, depth: float = RECOVERY_DEPTH_M) -> MapPoint:
    """Return the place nearest to this one (within half a percent of the depth) that lies ``depth`` metres inside.

    In a fence too narrow for that depth it is the place farthest from all sides. The straight path from a place outside
    enters once: beside a passage too narrow for the depth, between two zones, the place returned lies less deep.
    """
    ground, point = shape(fence), Point(place.north, place.east)
    if ground.covers(point) and ground.boundary.distance(point) >= depth:
        return place
    best = None
    for share in _SHALLOWER if fence.zones else _SHALLOWER[:1]:
        core = _core(ground, depth * share)
        if core.is_empty:
            continue
        best = _nearest(core, point)
        if contains(fence, place) or leads_inside(fence, place, best):
            return best
    if best is None:
        north, east = shapely.maximum_inscribed_circle(ground).coords[0]
        best = MapPoint(float(north), float(east))
    return best


def _core(ground: Polygon, depth: float) -> Polygon | MultiPolygon:
    """Return the ground that lies this deep inside, metres."""
    # around a corner that points inwards the edge is an arc, drawn by chords that would come too near to the corner
    return shapely.buffer(ground, -depth / math.cos(math.pi / 4 / _ARC_SEGMENTS), quad_segs=_ARC_SEGMENTS)


def _nearest(core: Polygon | MultiPolygon, point: Point) -> MapPoint:
    north, east = shapely.shortest_line(core, point).coords[0]
    return MapPoint(float(north), float(east))


def is_about_same(one: Fence, other: Fence, tolerance: float) -> bool:
    """Return True when the autopilot's limits of two fences differ nowhere by more than the tolerance, metres."""
    ours, theirs = (one.autopilot_polygon, *one.autopilot_zones), (other.autopilot_polygon, *other.autopilot_zones)
    if [len(ring) for ring in ours] != [len(ring) for ring in theirs]:
        return False
    pairs = zip(chain(*ours), chain(*theirs), strict=True)
    near = all(math.dist(here, there) <= tolerance for here, there in pairs)
    return near and abs(one.autopilot_ceiling - other.autopilot_ceiling) <= tolerance


def extent(fence: Fence) -> tuple[float, float]:
    """Return the fence's extent north-south and east-west, metres."""
    south, west, north, east = shape(fence).bounds
    return float(north - south), float(east - west)


def area(fence: Fence) -> float:
    """Return the area inside our fence, m²."""
    return float(shape(fence).area)


def zone_of(fence: Fence, place: MapPoint) -> int | None:
    """Return the number, from 1, of the zone of ours (the drawn one with its margin) that holds the place, or None."""
    if not _is_finite(place):
        return None
    point = Point(place.north, place.east)
    return next((number for number, zone in enumerate(fence.zones, 1) if Polygon(zone).contains(point)), None)


def place_words(fence: Fence, place: MapPoint) -> str:
    """Return in words why a place is not inside our fence."""
    zone = zone_of(fence, place)
    return say("outside the fence") if zone is None else say("in zone {zone} or its margin", zone=zone)


def recovery_words(fence: Fence | None, pose: MapPose | None) -> str:
    """Return in words where a drone is led back to from its place beyond our fence."""
    zone = None if fence is None or pose is None else zone_of(fence, pose.point)
    if zone is None:
        return say("Outside the fence: going back inside.")
    return say("In zone {zone} or its margin: going out of it.", zone=zone)


def path_words(fence: Fence) -> str:
    """Return in words what a path does that is not inside our fence from end to end."""
    return say("leaves the fence or crosses a zone") if fence.zones else say("leaves the fence")


def autopilot_fence(fence: Fence) -> Fence:
    """Return the fence with the autopilot's own limits, without the margins."""
    return replace(fence, polygon=fence.autopilot_polygon, zones=fence.autopilot_zones, ceiling=fence.autopilot_ceiling)


@lru_cache(maxsize=8)
def shape(fence: Fence) -> Polygon:
    """Return the ground inside our fence: its polygon without its zones, as a prepared polygon with holes.

    A zone near the edge is a bay of the edge. Where zones cut something off, the largest piece is the inside. The
    polygon is shared: it must not be changed.
    """
    pieces = _pieces(fence.polygon, fence.zones)
    ground = pieces[0] if pieces else Polygon()
    shapely.prepare(ground)
    return ground


def _pieces(polygon: Ring, zones: Sequence[Ring]) -> list[Polygon]:
    """Return what zones leave of a polygon, the largest piece first."""
    if not zones:
        return [Polygon(polygon)]
    left = Polygon(polygon).difference(shapely.union_all([Polygon(zone) for zone in zones]))
    pieces = [part for part in shapely.get_parts(left) if isinstance(part, Polygon) and not part.is_empty]
    return sorted(pieces, key=lambda piece: piece.area, reverse=True)


def _open_ring(polygon: Polygon) -> Ring:
    return tuple((float(n), float(e)) for n, e in list(polygon.exterior.coords)[:-1])


def _floats(ring: Sequence[tuple[float, float]]) -> Ring:
    return tuple((float(n), float(e)) for n, e in ring)


def _is_finite(place: MapPoint) -> bool:
    return math.isfinite(place.north) and math.isfinite(place.east)
