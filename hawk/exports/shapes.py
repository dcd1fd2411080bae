"""Shapes of an export as geometry in WGS-84, (longitude, latitude), rings of RFC 7946."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon

from hawk.exports.values import LatLon, Observation
from hawk.model.plans import Outline


def stall_shape(stall: Observation) -> Polygon:
    """Return a stall; its ring runs counter-clockwise."""
    return Polygon(_swapped(stall.corners))


def stall_shapes(stalls: Sequence[Observation]) -> NDArray[np.object_]:
    """Return many stalls, as `stall_shape` returns one."""
    corners = np.array([stall.corners for stall in stalls], np.float64).reshape(-1, 4, 2)
    found: NDArray[np.object_] = shapely.polygons(corners[..., ::-1])
    return found


def lot_shape(outline: Outline) -> MultiPolygon:
    """Return the ground of a lot: polygons without holes; empty without an outline."""
    ground = shapely.union_all([Polygon(_swapped(ring)).buffer(0) for ring in outline.polygons])
    ground = ground.difference(shapely.union_all([Polygon(_swapped(ring)).buffer(0) for ring in outline.holes]))
    parts = [part for part in shapely.get_parts(ground) if isinstance(part, Polygon) and not part.is_empty]
    return MultiPolygon([shapely.geometry.polygon.orient(part) for part in parts])


def _swapped(ring: tuple[LatLon, ...]) -> list[LatLon]:
    return [(longitude, latitude) for latitude, longitude in ring]
