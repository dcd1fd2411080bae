"""The ground below adjusted photographs: one sloping plane for the whole survey, and beside it each one's own level."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from scipy.spatial import cKDTree

from hawk.picture.reconstruction.camera_pose import CameraPose, FloatArray

_LEVEL_M: Final = 0.5
_LEVEL_NEAR: Final = 0.6
_LEAST_LEVEL: Final = 12
_ABOUT_M: Final = 2.0
_STEEPEST: Final = 0.15
_DRAWS: Final = 400


def fit_terrain(posed: Sequence[CameraPose], points: FloatArray) -> tuple[CameraPose, ...]:
    """Return the poses with the level and the slope of the ground below.

    One plane holds for the whole survey, so that a roof that fills a photograph is not taken for ground; about it, most
    of the tied places below a photograph lie on its ground.

    Args:
        posed: Reconstruction poses.
        points: Tied places (N, 3): metres north, east and above the survey's mean ground.
    """
    if len(points) < _LEAST_LEVEL:
        return tuple(posed)
    plane = _plane(points)
    beside = points[:, 2] - _heights(plane, points)
    about = np.abs(beside) < _ABOUT_M
    tree, beside = cKDTree(points[about, :2]), beside[about]
    result = []
    for one in posed:
        here = float(_heights(plane, np.array([(one.north, one.east)]))[0])
        near = tree.query_ball_point((one.north, one.east), _LEVEL_NEAR * one.reach())
        level = here + (_mode(beside[near]) if len(near) >= _LEAST_LEVEL else 0.0)
        result.append(replace(one, level=level, slope=(float(plane[0]), float(plane[1]))))
    return tuple(result)


def _plane(points: FloatArray) -> FloatArray:
    """Return the plane (north's and east's slope, height) near which most points (N, 3) lie, by RANSAC.

    Fischler and Bolles 1981; then the least squares of those that are near.
    """
    rng = np.random.default_rng(len(points))
    best, most = np.array([0.0, 0.0, float(np.median(points[:, 2]))]), -1
    for _ in range(_DRAWS):
        three = points[rng.choice(len(points), 3, replace=False)]
        try:
            solved = np.linalg.solve(np.column_stack([three[:, :2], np.ones(3)]), three[:, 2])
        except np.linalg.LinAlgError:
            continue
        plane = np.asarray(solved, np.float64)
        if np.hypot(*plane[:2]) > _STEEPEST:
            continue
        count = int((np.abs(points[:, 2] - _heights(plane, points)) < _LEVEL_M).sum())
        if count > most:
            best, most = plane, count
    near = np.abs(points[:, 2] - _heights(best, points)) < _LEVEL_M
    if near.sum() < _LEAST_LEVEL:
        return best
    fitted = np.linalg.lstsq(np.column_stack([points[near, :2], np.ones(near.sum())]), points[near, 2])[0]
    return np.asarray(fitted, np.float64)


def _heights(plane: FloatArray, points: FloatArray) -> FloatArray:
    """Return the heights of a plane at points (N, 2) or (N, 3)."""
    return np.asarray(points[:, :2] @ plane[:2] + plane[2])


def _mode(heights: FloatArray) -> float:
    """Return the middle of the half metre with the most heights."""
    ordered = np.sort(heights)
    count = np.searchsorted(ordered, ordered + _LEVEL_M, side="right") - np.arange(len(ordered))
    begin = int(count.argmax())
    return float(np.median(ordered[begin : begin + int(count[begin])]))
