"""Oriented rectangles on the ground, vectorised: corners, distances in their own axes, overlap."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def quads(north: Floats, east: Floats, angle: Floats, width: Floats, length: Floats) -> Floats:
    """Return corners (N, 4, 2) of (north, east) metres, in the order of `hawk.model.Stall.corners`."""
    along = np.stack([np.cos(angle), np.sin(angle)], -1) * (length / 2)[:, None]
    across = np.stack([-np.sin(angle), np.cos(angle)], -1) * (width / 2)[:, None]
    centre = np.stack([north, east], -1)
    corners = [centre - along - across, centre - along + across, centre + along + across, centre + along - across]
    return np.asarray(np.stack(corners, 1))


def angle_difference(a: Floats, b: Floats) -> Floats:
    """Return the unsigned difference of two directions modulo pi, in [0, pi/2]."""
    return np.abs((a - b + np.pi / 2) % np.pi - np.pi / 2)


def rotated_iou(first: Floats, second: Floats) -> Floats:
    """Return the intersection over union of quads (N, 4, 2) with quads (N, 4, 2), pair by pair."""
    if len(first) == 0:
        return np.zeros(0)
    a, b = shapely.polygons(first), shapely.polygons(second)
    both = shapely.area(shapely.intersection(a, b))
    either = shapely.area(a) + shapely.area(b) - both
    return np.asarray(both / np.maximum(either, 1e-9), dtype=np.float64)


def transform_points(affine: Floats, points: Floats) -> Floats:
    """Apply a (2, 3) affine to points (..., 2)."""
    return np.asarray(points @ affine[:, :2].T + affine[:, 2])


def invert_affine(affine: Floats) -> Floats:
    """Return the inverse of a (2, 3) affine. Raises numpy.linalg.LinAlgError when it has none."""
    inverse = np.linalg.inv(affine[:, :2])
    return np.column_stack([inverse, -inverse @ affine[:, 2]])
