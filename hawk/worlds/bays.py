"""Bays added to a lot: the places where there is room for them."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely

from hawk.worlds.plan import Axes, SitePlan
from hawk.worlds.scene.canvas import Points

MOST, LEAST = 6, 3
"""Bays added at once."""
_RIM_M: Final = 1.5
"""Distance from the picture's edge."""
_STEP_M: Final = 1.3
_APART_M: Final = 0.3


@dataclass(frozen=True, slots=True)
class Bay:
    """A kind of bay beside an edge of the lot: ``pitch`` along the edge, ``depth`` across it, metres.

    It lies ``outside`` the edge or inside it, with ``aisle`` metres of free lot before it.
    """

    kind: str
    pitch: float
    depth: float
    aisle: float
    outside: bool


KINDS: Final = (
    Bay("perpendicular", 2.6, 5.2, 5.0, outside=True),
    Bay("parallel", 6.4, 2.4, 4.0, outside=True),
    Bay("parallel", 6.4, 2.4, 5.5, outside=False),
    Bay("perpendicular", 2.6, 5.2, 6.0, outside=False),
)


@dataclass(frozen=True, slots=True)
class Place:
    """Room for ``count`` bays: u of ``axes`` runs along them, v from their open to their closed end."""

    bay: Bay
    axes: Axes
    count: int

    @property
    def outline(self) -> Points:
        """Corners (4, 2) of all bays, metres."""
        return self.axes.rect(0.0, 0.0, self.count * self.bay.pitch, self.bay.depth)

    @property
    def aisle(self) -> Points:
        """Corners (4, 2) of the ground before them, metres."""
        return self.axes.rect(0.0, -self.bay.aisle, self.count * self.bay.pitch, 0.0)

    @property
    def needed(self) -> shapely.Polygon:
        """All of it with a rim, metres."""
        width = self.count * self.bay.pitch + _APART_M
        return shapely.Polygon(self.axes.rect(-_APART_M, -self.bay.aisle - _APART_M, width, self.bay.depth + _APART_M))

    def corners(self, number: int) -> Points:
        """Corners (4, 2) of a bay, the short sides first and third, as of a stall."""
        corners = self.axes.rect(number * self.bay.pitch, 0.0, (number + 1) * self.bay.pitch, self.bay.depth)
        return np.roll(corners, 1, axis=0) if self.bay.kind == "parallel" else corners


class Room:
    """The free ground of a plan; ``size_m`` is width and height of its picture."""

    def __init__(self, plan: SitePlan, size_m: tuple[float, float]) -> None:
        self._lots = [shapely.Polygon(lot).buffer(0) for lot in plan.lots]
        self._lot = shapely.union_all(self._lots).buffer(0.1)
        shapely.prepare(self._lot)
        self._picture = shapely.box(_RIM_M, _RIM_M, size_m[0] - _RIM_M, size_m[1] - _RIM_M)
        solid = [*(b.polygon for b in plan.buildings), *(s.polygon for s in plan.islands)]
        solid += [stall.corners for stall in plan.stalls]
        self._solid = shapely.STRtree([shapely.Polygon(one) for one in solid])
        self._painted = shapely.STRtree([shapely.Polygon(stroke.polygon) for stroke in plan.strokes])
        lots = {id(lot) for lot in plan.lots}
        roads = [s.polygon for s in plan.surfaces if s.material.kind == "asphalt" and id(s.polygon) not in lots]
        self._roads = shapely.STRtree([shapely.Polygon(road) for road in roads])

    def places(self) -> list[Place]:
        """Return the places with room for the most bays, of every kind and edge."""
        found = [place for lot in self._lots for bay in KINDS for place in self._along(lot, bay)]
        most = max((place.count for place in found), default=0)
        return [place for place in found if place.count == most]

    def _along(self, lot: shapely.Polygon, bay: Bay) -> Iterator[Place]:
        corners = np.asarray(shapely.geometry.polygon.orient(lot, 1.0).exterior.coords)
        for start, end in itertools.pairwise(corners):
            length = float(np.linalg.norm(end - start))
            along = (end - start) / max(length, 1e-9)
            # x east, y south: of an outline that is counter-clockwise in numbers, outside is at (y, -x)
            out = (float(along[1]), float(-along[0]))
            edge = Axes((float(start[0]), float(start[1])), (float(along[0]), float(along[1])), out)
            for count in range(MOST, LEAST - 1, -1):
                reach = count * bay.pitch
                found = [
                    place
                    for u in np.arange(0.5, length - reach - 0.5, _STEP_M)
                    if self._is_free(
                        place := Place(bay, edge.moved(float(u), 0.0 if bay.outside else -bay.depth), count)
                    )
                ]
                if found:
                    yield from found
                    break

    def _is_free(self, place: Place) -> bool:
        bays, aisle = shapely.Polygon(place.outline), shapely.Polygon(place.aisle)
        if not self._picture.contains(bays) or not self._lot.contains(aisle):
            return False
        if len(self._solid.query(place.needed, predicate="intersects")):
            return False
        if place.bay.outside:
            return not len(self._roads.query(bays, predicate="intersects"))
        return bool(self._lot.contains(bays)) and not len(self._painted.query(bays, predicate="intersects"))
