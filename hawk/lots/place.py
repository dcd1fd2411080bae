"""Which lot is it? By place alone: the outline of a survey against the outlines of the known lots.

All is judged in metres about the survey, so that neither latitude nor the date line matters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import numpy as np
import pymap3d
from numpy.typing import NDArray
from shapely import BufferCapStyle, Polygon, intersection, make_valid, transform, union_all
from shapely.geometry.base import BaseGeometry

from hawk.model.plans import Outline

SAME_SHARE: Final = 0.30
"""Overlap from which a lot is meant, of the smaller of both areas: half of a lot is that lot."""
NEAR_M: Final = 300.0
"""A lot nearer than this may be meant although nothing overlaps: GNSS and outlines err."""
_FAR_M: Final = 20_000.0
"""Ground farther off than this is left out: a tangent plane folds the other side of the Earth onto this one."""
_LEAST_M2: Final = 1.0
_GRID_M: Final = 1e-3
"""Without a grid GEOS 3.14.1 returns, for some areas that touch, the whole of one of them."""


@dataclass(frozen=True, slots=True)
class LotPlace:
    """A known lot and its outline, WGS-84."""

    id: str
    outline: Outline


@dataclass(frozen=True, slots=True)
class Candidate:
    """A lot that may be meant: ``overlap`` of the smaller area, 0 to 1, and ``distance`` between both, metres."""

    lot: str
    overlap: float
    distance: float


class Answer(StrEnum):
    """Answer to "which lot is it?"."""

    KNOWN = "known"
    NEW = "new"
    ASK = "ask"
    NOTHING = "nothing"
    """The survey has no ground that could be anywhere."""


@dataclass(frozen=True, slots=True)
class Decision:
    """``candidates``, the best first: the lot for KNOWN, those to choose from for ASK, else none."""

    answer: Answer
    candidates: tuple[Candidate, ...] = ()

    @property
    def lot(self) -> str | None:
        """The known lot."""
        return self.candidates[0].lot if self.answer is Answer.KNOWN else None


def which_lot(outline: Outline, lots: Sequence[LotPlace]) -> Decision:
    """Return the lot that a survey's outline means.

    One lot that overlaps by `SAME_SHARE` is it; two are a question. Without one, a lot within `NEAR_M` is a question,
    and else the lot is a new one.
    """
    corners = [corner for ring in outline.polygons for corner in ring]
    centre = corners[0] if corners else (0.0, 0.0)
    ground = ground_about(centre, outline)
    if ground.area < _LEAST_M2:
        return Decision(Answer.NOTHING)
    near = sorted(
        (found for lot in lots if (found := _candidate(centre, ground, lot)) is not None),
        key=lambda found: (-found.overlap, found.distance, found.lot),
    )
    same = tuple(found for found in near if found.overlap >= SAME_SHARE)
    if len(same) == 1:
        return Decision(Answer.KNOWN, same)
    if candidates := same or tuple(near):
        return Decision(Answer.ASK, candidates)
    return Decision(Answer.NEW)


def _candidate(centre: tuple[float, float], ground: BaseGeometry, lot: LotPlace) -> Candidate | None:
    """Return how near a lot is; None beyond `NEAR_M`."""
    other = ground_about(centre, lot.outline)
    if other.is_empty:
        return None
    distance = float(ground.distance(other))
    if distance >= NEAR_M:
        return None
    smaller = max(min(ground.area, other.area), _LEAST_M2)
    return Candidate(lot.id, min(1.0, shared_area(ground, other) / smaller), distance)


def shared_area(ground: BaseGeometry, other: BaseGeometry) -> float:
    """Return the area that both have, m2."""
    return float(intersection(ground, other, grid_size=_GRID_M).area)


def ground_about(centre: tuple[float, float], outline: Outline) -> BaseGeometry:
    """Return an outline in metres (north, east) about a place (latitude, longitude); empty when it is far off.

    Rings that cross themselves are made valid; holes are cut out.
    """
    pieces = [polygon for ring in outline.polygons if (polygon := _polygon(centre, ring)) is not None]
    holes = [polygon for ring in outline.holes if (polygon := _polygon(centre, ring)) is not None]
    return union_all(pieces).difference(union_all(holes))


def about(centre: tuple[float, float], corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return WGS-84 corners (N, 2) of (latitude, longitude) as (north, east, down) metres about a place, (N, 3)."""
    return np.column_stack(pymap3d.geodetic2ned(corners[:, 0], corners[:, 1], 0.0, centre[0], centre[1], 0.0))


def _polygon(centre: tuple[float, float], ring: Sequence[tuple[float, float]]) -> BaseGeometry | None:
    if len(ring) < 3:
        return None
    points = about(centre, np.asarray(ring, float))
    if not np.isfinite(points).all() or np.abs(points).max() > _FAR_M:
        return None
    return make_valid(Polygon(points[:, :2]))


def joined(outlines: Sequence[Outline]) -> Outline:
    """Return one outline of the ground of several, WGS-84. Parts that touch become one."""
    corners = [corner for outline in outlines for ring in outline.polygons for corner in ring]
    if not corners:
        return Outline()
    centre = corners[0]
    return _outline(centre, union_all([ground_about(centre, outline) for outline in outlines]))


def without(outline: Outline, part: Outline) -> Outline:
    """Return an outline without the ground of another one, WGS-84."""
    corners = [corner for ring in outline.polygons for corner in ring]
    if not corners:
        return Outline()
    centre = corners[0]
    return _outline(centre, ground_about(centre, outline).difference(ground_about(centre, part)))


def _outline(centre: tuple[float, float], ground: BaseGeometry) -> Outline:
    tidy = ground.buffer(0.0, cap_style=BufferCapStyle.flat)

    def to_globe(points: NDArray[np.float64]) -> NDArray[np.float64]:
        latitude, longitude, _ = pymap3d.ned2geodetic(points[:, 0], points[:, 1], 0.0, centre[0], centre[1], 0.0)
        return np.column_stack((latitude, longitude))

    parts = [part for part in getattr(transform(tidy, to_globe), "geoms", [transform(tidy, to_globe)]) if part.area > 0]
    rings = [tuple((float(a), float(b)) for a, b in part.exterior.coords[:-1]) for part in parts]
    holes = [tuple((float(a), float(b)) for a, b in ring.coords[:-1]) for part in parts for ring in part.interiors]
    return Outline(tuple(rings), tuple(holes))
