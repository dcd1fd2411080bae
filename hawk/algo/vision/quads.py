"""Oriented rectangles as arrays, and how much they overlap.

A rectangle is (x, y, angle, width, length) with the direction of the long side (cos angle, sin angle) in (x, y); its
corners run along one short end, then along the other. It works in pixels (col, row) and on the map (north, east) alike.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from hawk.algo.vision.detection import FloatArray

IntArray = NDArray[np.intp]


def corners(x: FloatArray, y: FloatArray, angle: FloatArray, width: FloatArray, length: FloatArray) -> FloatArray:
    """Return the corners, (N, 4, 2)."""
    along = np.stack([np.cos(angle), np.sin(angle)], -1) * (np.asarray(length) / 2)[..., None]
    across = np.stack([-np.sin(angle), np.cos(angle)], -1) * (np.asarray(width) / 2)[..., None]
    centre = np.stack([x, y], -1)
    return np.stack(
        [centre - along - across, centre - along + across, centre + along + across, centre + along - across], axis=-2
    )


def angle_between(a: Any, b: Any) -> FloatArray:
    """Return the angle between two undirected directions, 0..pi/2 (radians)."""
    return np.asarray(np.abs((np.asarray(a) - b + math.pi / 2) % math.pi - math.pi / 2))


def cross(angle: FloatArray, vector: FloatArray) -> FloatArray:
    """Return how far ``vector`` (..., 2) leads to the side of the direction ``angle`` (...), signed."""
    return np.asarray(vector[..., 1] * np.cos(angle) - vector[..., 0] * np.sin(angle))


def overlaps(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the intersection over union of pairs of convex quads, both (N, 4, 2), as (N,).

    Not by GEOS: its intersection of two rectangles whose common edge differs by rounding only can be a whole one of
    them (seen with 3.14), which is just what neighbours in a row are.
    """
    if not len(first):
        return np.zeros(0)
    first, second = _anticlockwise(first), _anticlockwise(second)
    shared = _area_of_points(*_meeting_points(first, second))
    union = _signed_area(first) + _signed_area(second) - shared
    return np.asarray(shared / np.maximum(union, 1e-12))


def overlap_more(first: FloatArray, second: FloatArray, limit: float) -> NDArray[np.bool_]:
    """Return which pairs of convex quads, both (N, 4, 2), have an intersection over union above ``limit``, (N,).

    Boxes about both along the first one's sides bound the common part: most neighbours need no closer look.
    """
    more = np.zeros(len(first), np.bool_)
    if not len(first):
        return more
    along = first[:, 2] + first[:, 3] - first[:, 0] - first[:, 1]
    along = along / np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-12)[:, None]
    shared = np.ones(len(first))
    for axis in (along, np.column_stack([-along[:, 1], along[:, 0]])):
        a, b = (quads[..., 0] * axis[:, :1] + quads[..., 1] * axis[:, 1:] for quads in (first, second))
        shared *= np.maximum(np.minimum(a.max(1), b.max(1)) - np.maximum(a.min(1), b.min(1)), 0)
    both = np.abs(_signed_area(first)) + np.abs(_signed_area(second))
    close = np.flatnonzero(shared * (1 + limit) >= limit * both * (1 - 1e-9))
    more[close] = overlaps(first[close], second[close]) > limit
    return more


def near_pairs(first: FloatArray, second: FloatArray, reach: float) -> tuple[IntArray, IntArray]:
    """Return the indices (i, j) of points (N, 2) and (M, 2) that are within ``reach`` of each other."""
    if not len(first) or not len(second):
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    near = cKDTree(first).sparse_distance_matrix(cKDTree(second), reach, output_type="ndarray")
    return near["i"].astype(np.intp), near["j"].astype(np.intp)


def suppress(quads: FloatArray, score: FloatArray, limit: float) -> NDArray[np.bool_]:
    """Return which of the quads (N, 4, 2) stay when of two that overlap more than ``limit`` the better one wins.

    Greedy non-maximum suppression, best first. Ties go to the first one.
    """
    keep = np.ones(len(quads), np.bool_)
    if len(quads) < 2:
        return keep
    reach = float(np.hypot(*(quads[:, 0] - quads[:, 2]).T).max())
    centres = quads.mean(axis=1)
    pairs = cKDTree(centres).query_pairs(reach, output_type="ndarray")
    pairs = pairs[overlap_more(quads[pairs[:, 0]], quads[pairs[:, 1]], limit)]
    rank = np.empty(len(quads), np.intp)
    rank[np.argsort(-score, kind="stable")] = np.arange(len(quads))
    ordered = np.where((rank[pairs[:, 0]] < rank[pairs[:, 1]])[:, None], pairs, pairs[:, ::-1])
    for winner, loser in ordered[np.argsort(rank[ordered[:, 0]], kind="stable")]:
        if keep[winner]:
            keep[loser] = False
    return keep


def _signed_area(quads: FloatArray) -> FloatArray:
    x, y = quads[..., 0], quads[..., 1]
    return np.asarray((x * np.roll(y, -1, -1) - y * np.roll(x, -1, -1)).sum(axis=-1) / 2)


def _anticlockwise(quads: FloatArray) -> FloatArray:
    return np.where((_signed_area(quads) < 0)[:, None, None], quads[:, ::-1], quads)


def _meeting_points(first: FloatArray, second: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the points (N, 24, 2) that may be corners of the common part, and which are (N, 24).

    Those are the corners of each quad within the other, and the crossings of their sides.
    """
    r, s = np.roll(first, -1, axis=1) - first, np.roll(second, -1, axis=1) - second
    between = second[:, None, :, :] - first[:, :, None, :]
    denominator = _turn(r[:, :, None], s[:, None])
    parallel = np.abs(denominator) < 1e-12
    denominator = np.where(parallel, 1.0, denominator)
    t, u = _turn(between, s[:, None]) / denominator, _turn(between, r[:, :, None]) / denominator
    crossing = ~parallel & (t >= 0) & (t <= 1) & (u >= 0) & (u <= 1)
    at = first[:, :, None] + np.where(crossing, t, 0.0)[..., None] * r[:, :, None]
    inner_first = (_turn(s[:, None], first[:, :, None] - second[:, None]) >= 0).all(axis=2)
    inner_second = (_turn(r[:, None], second[:, :, None] - first[:, None]) >= 0).all(axis=2)
    points = np.concatenate([first, second, at.reshape(len(first), 16, 2)], axis=1)
    return points, np.concatenate([inner_first, inner_second, crossing.reshape(-1, 16)], axis=1)


def _area_of_points(points: FloatArray, used: NDArray[np.bool_]) -> FloatArray:
    """Return the area (N,) of the convex polygons with the used corners, in any order and with repetitions."""
    count = np.maximum(used.sum(axis=1), 1)
    middle = (points * used[..., None]).sum(axis=1) / count[:, None]
    offset = np.where(used[..., None], points - middle[:, None], 0.0)
    angle = np.where(used, np.arctan2(offset[..., 1], offset[..., 0]), np.inf)
    order = np.argsort(angle, axis=1)
    ring = np.take_along_axis(offset, order[..., None], axis=1)
    ring = np.where((np.arange(points.shape[1]) < count[:, None])[..., None], ring, ring[:, :1])
    return np.abs(_signed_area(ring))


def _turn(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the cross product of vectors (..., 2)."""
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])
