"""The outline of a survey: what an operator asks to be seen, checked, and cut off at the fence.

An outline says what is worth seeing. It never widens the fence, and no target is judged by it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from hawk.comm.protocol.commands import SetOutline
from hawk.comm.protocol.heartbeat import FenceCorner
from hawk.ddc.fence import geometry
from hawk.model.plans import AskedGround, Fence, Outline, RoundLot
from hawk.model.poses import GlobalPose
from hawk.model.sentences import say

LEAST_OUTLINE_M2 = 50.0
"""Some four stalls: a smaller polygon is a slip of the hand, m²."""


class OutlineError(geometry.FenceError):
    """An outline that cannot be used; the text names the polygon, what is wrong and the remedy."""


@dataclass(frozen=True, slots=True)
class OutlineFacts:
    """Size of the outline in force: inside the fence, and what the fence leaves out, m²."""

    area: float
    outside: float
    lots: tuple[RoundLot, ...] = ()
    """Known lots that are surveyed again, whose ground it is; empty for any other area."""


def outline_of(command: SetOutline) -> Outline:
    """Return the outline of a command."""
    return Outline(_rings(command.polygons), _rings(command.holes))


def check_rings(outline: Outline) -> float:
    """Check an outline as far as it does not depend on a fence; return its area, m².

    Raises:
        OutlineError: Names the polygon or hole, the fault and the remedy.
    """
    origin = GlobalPose(*outline.polygons[0][0], 0.0)
    rings = geometry.converted((*outline.polygons, *outline.holes), lambda ring: geometry.ring_to_map(origin, ring))
    names = [say("Polygon {number}", number=number) for number, _ in enumerate(outline.polygons, 1)]
    names += [say("Hole {number}", number=number) for number, _ in enumerate(outline.holes, 1)]
    for name, ring in zip(names, rings, strict=True):
        _check(name, _polygon(np.round(ring, 2)), ring)
    polygons = [_polygon(np.array(ring)) for ring in rings]
    _check_extent(polygons)
    whole = shapely.union_all(polygons[: len(outline.polygons)])
    for number, hole in enumerate(polygons[len(outline.polygons) :], 1):
        if not whole.intersects(hole):
            raise OutlineError(
                say("Hole {number}: lies outside every polygon: draw it inside one, or leave it out.", number=number)
            )
    area = float(_shape(outline, origin).area)
    if area < LEAST_OUTLINE_M2:
        raise OutlineError(say("Holes: they leave {area:.0f} m² of the outline: draw them smaller.", area=area))
    return area


@lru_cache(maxsize=4)
def ground_of(outline: Outline, datum: GlobalPose, fence: Fence) -> AskedGround:
    """Return the part of an outline inside the fence as drawn, on the map of a datum.

    The drone itself stays inside our own limit, by the margin within; from there its pictures show ground beyond.
    """
    whole = _shape(outline, datum)
    inside = shapely.intersection(whole, geometry.shape(geometry.autopilot_fence(fence)))
    parts = [part for part in shapely.get_parts(inside) if isinstance(part, Polygon) and not part.is_empty]
    pieces = tuple(tuple(_open(ring) for ring in (part.exterior, *part.interiors)) for part in parts)
    area = float(sum(part.area for part in parts))
    return AskedGround(pieces, area, max(0.0, float(whole.area) - area))


def is_left(lot: RoundLot, lots: Sequence[RoundLot]) -> bool:
    """Return True for a lot that a round with these lots did not finish, or that an earlier one did not."""
    return not lot.is_over and (lot.is_first or any(each.is_over for each in lots))


def overlap(outlines: Sequence[Outline]) -> tuple[int, int, float] | None:
    """Return the numbers of two outlines that share `LEAST_OUTLINE_M2` or more, and that area, m²; None without.

    Raises:
        OutlineError: Together they are wider than an outline may be.
    """
    origin = GlobalPose(*outlines[0].polygons[0][0], 0.0)
    owners = [number for number, outline in enumerate(outlines) for _ in outline.polygons]
    rings = geometry.converted([ring for outline in outlines for ring in outline.polygons],
                               lambda ring: geometry.ring_to_map(origin, ring))  # fmt: skip
    polygons = [_polygon(np.array(ring)) for ring in rings]
    _check_extent(polygons)
    touching = shapely.STRtree(polygons).query(polygons, predicate="intersects").T.tolist()
    for one, other in sorted({(owners[a], owners[b]) for a, b in touching if owners[a] < owners[b]}):
        area = float(shapely.intersection(_shape(outlines[one], origin), _shape(outlines[other], origin)).area)
        if area >= LEAST_OUTLINE_M2:
            return one, other, area
    return None


def size_words(area: float, outside: float = 0.0) -> str:
    """Return the size of an outline in words, and what of it the fence leaves out."""
    words = area_words(area)
    if outside < 1.0:
        return words
    return say("{size}; {outside} outside the fence are left out", size=words, outside=area_words(outside))


def corners_of(rings: Sequence[geometry.Ring]) -> list[list[FenceCorner]]:
    """Return rings as the messages have them."""
    return [[FenceCorner(latitude=latitude, longitude=longitude) for latitude, longitude in ring] for ring in rings]


def area_words(area: float) -> str:
    """Return an area in m², from a hectare on in hectares."""
    return say("{area:.1f} ha", area=area / 1e4) if area >= 1e4 else say("{area:.0f} m²", area=area)


def _check(name: str, polygon: Polygon, ring: geometry.Ring) -> None:
    if not polygon.is_valid:
        raise OutlineError(
            say(
                "{name}: {crossing}: move a corner so that no side crosses another.",
                name=name,
                crossing=geometry.crossing(ring),
            )
        )
    if name.startswith("Polygon") and polygon.area < LEAST_OUTLINE_M2:
        raise OutlineError(
            say(
                "{name}: holds {area:.0f} m²: draw {least:.0f} m² at least.",
                name=name,
                area=polygon.area,
                least=LEAST_OUTLINE_M2,
            )
        )


def _check_extent(polygons: Sequence[Polygon]) -> None:
    south, west, north, east = shapely.total_bounds(polygons)
    widest = max(north - south, east - west)
    if widest > geometry.MOST_EXTENT_M:
        raise OutlineError(
            say(
                "Polygons: the outline is {widest:.0f} m wide: draw it at most {most:.0f} m wide.",
                widest=widest,
                most=geometry.MOST_EXTENT_M,
            )
        )


def _polygon(ring: NDArray[np.float64]) -> Polygon:
    """Return corners (N, 2) as a polygon, twenty times as fast as the class of shapely makes one of tuples."""
    polygon: Polygon = shapely.polygons(ring)
    return polygon


def _shape(outline: Outline, datum: GlobalPose) -> shapely.Geometry:
    rings = geometry.converted((*outline.polygons, *outline.holes), lambda ring: geometry.ring_to_map(datum, ring))
    polygons = [_polygon(np.array(ring)) for ring in rings]
    count = len(outline.polygons)
    return shapely.difference(shapely.union_all(polygons[:count]), shapely.union_all(polygons[count:]))


def _rings(rings: Sequence[Sequence[FenceCorner]]) -> tuple[geometry.Ring, ...]:
    return tuple(tuple((each.latitude, each.longitude) for each in ring) for ring in rings)


def _open(ring: shapely.LinearRing) -> geometry.Ring:
    return tuple((float(north), float(east)) for north, east in ring.coords[:-1])
