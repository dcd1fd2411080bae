"""Limits of a flight: heights, fence, and the ground that an outline asks for."""

from __future__ import annotations

from dataclasses import dataclass

from hawk.model.poses import Ring


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
class Outline:
    """Area that an operator asks to survey: what lies in a polygon and in no hole.

    Rings are WGS-84 corners (latitude, longitude) in degrees, in order, not closed. Without polygons there is no
    outline.
    """

    polygons: tuple[Ring, ...] = ()
    holes: tuple[Ring, ...] = ()


@dataclass(frozen=True, slots=True)
class AskedGround:
    """The part of an outline that lies inside the fence, map frame.

    ``pieces`` do not overlap; each is its outer ring, then its holes, rings as in `Fence`. ``area`` is theirs,
    ``outside`` that of the outline outside the fence, square metres.
    """

    pieces: tuple[tuple[Ring, ...], ...]
    area: float
    outside: float = 0.0
