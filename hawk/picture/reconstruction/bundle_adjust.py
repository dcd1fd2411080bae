"""Bundle adjustment: poses of all photographs, one lens, and the tied places, by the least squares of what they show.

Every tied place is a point of its own, so that crowns and roofs do not bend the ground. Points are eliminated from the
normal equations (Triggs, McLauchlan, Hartley and Fitzgibbon 2000, Bundle adjustment: a modern synthesis). Steps are
Levenberg's. Residuals weigh as Cauchy's distribution has it (3.2 there), since some ties are wrong.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.model.pictures import CAMERA_TO_BODY, CameraModel, rotations
from hawk.picture.reconstruction.camera_pose import CameraPose, FloatArray
from hawk.picture.reconstruction.normal_equations import Normal, Slopes

PIXEL: Final = 1.0
"""Standard deviation of a tie, pixels of a picture of `hawk.picture.reconstruction.features.SIDE` pixels."""
POSE: Final = 9
"""Values of a pose: north, east, height; roll, pitch, yaw; turning about x, y, z."""
LENS: Final = 5
"""Values of the lens: logarithm of the focal length, principal point by the width, k1, k2."""
SHARED: Final = LENS + 1
"""Values that all photographs share: those of the lens, and by how much all are higher above the ground than said."""
LEVEL_SIGMA_M: Final = 15.0
"""Ground may lie so far above or below its mean."""
_MOST_STEPS: Final = 40
_STOP: Final = 1e-4
_POSE_STEPS: Final = np.array([1e-3] * 3 + [1e-6] * 3 + [1e-5] * 3)
_SHARED_STEPS: Final = np.array([1e-6, 1e-6, 1e-6, 1e-5, 1e-5, 1e-3])
_POINT_STEP: Final = 1e-3
_AT_ONCE: Final = 50_000
"""Projections whose slopes are in memory at once."""
_ALL: Final = slice(None)


@dataclass(frozen=True, slots=True)
class Priors:
    """Standard deviations of what the files say. ``place`` (N, 3) metres north, east and up; ``attitude`` (N, 3) and
    ``turning`` (N, 3) radians, also a second; ``lens`` (5,) as `LENS`; ``lift_m`` of how high all are above the ground.
    """

    place: FloatArray = field(repr=False)
    attitude: FloatArray = field(repr=False)
    turning: FloatArray = field(repr=False)
    lens: FloatArray = field(repr=False)
    lift_m: float


@dataclass(frozen=True, slots=True)
class Projections:
    """Pixels (M, 2) at which photograph ``shot`` (M,) shows place ``point`` (M,) of ``points``."""

    shot: NDArray[np.intp] = field(repr=False)
    point: NDArray[np.intp] = field(repr=False)
    pixels: FloatArray = field(repr=False)
    points: int


@dataclass(frozen=True, slots=True)
class BundleSolution:
    """Poses after the adjustment, the places (P, 3) north, east, up of the ties, and how far each sight is from where
    its place should show (M,), pixels of the photograph. ``shared``: as `SHARED`.
    """

    posed: tuple[CameraPose, ...]
    shared: FloatArray
    points: FloatArray = field(repr=False)
    off: FloatArray = field(repr=False)


def bundle_adjust(
    said: Sequence[CameraPose], sights: Projections, trust: Priors, pixel: float, begin: BundleSolution | None = None
) -> BundleSolution:
    """Return the poses that explain the sights best.

    Args:
        said: The poses as the files say them.
        sights: Ties.
        trust: How far the files are believed.
        pixel: Standard deviation of a sight, its own pixels.
        begin: Outcome with other sights of the same photographs, to begin with.
    """
    problem = _Problem(said, sights, trust, pixel)
    values = problem.start(begin)
    errors = problem.errors(values)
    cost, damping = problem.cost(values, errors), 1e-3
    for _ in range(_MOST_STEPS):
        step = problem.step(values, errors, damping)
        tried = values + step
        found = problem.errors(tried)
        after = problem.cost(tried, found)
        if after < cost:
            gain = (cost - after) / cost
            values, errors, cost, damping = tried, found, after, max(damping / 4, 1e-9)
            if gain < _STOP:
                break
        else:
            damping *= 8
            if damping > 1e6:
                break
    return problem.settled(values, errors)


class _Problem:
    """Values are one vector: the poses, what they share, the points."""

    def __init__(self, posed: Sequence[CameraPose], sights: Projections, trust: Priors, pixel: float) -> None:
        self._order = np.argsort(sights.shot, kind="stable")
        sights = Projections(
            sights.shot[self._order], sights.point[self._order], sights.pixels[self._order], sights.points
        )
        self._posed, self._sights, self._pixel = tuple(posed), sights, pixel
        self._ends = np.searchsorted(sights.shot, np.arange(len(posed) + 1))
        self._camera = posed[0].camera
        self._base = np.array([_values(one) for one in posed])
        sigma = np.hstack([trust.place, trust.attitude, trust.turning])
        self._weights = np.concatenate([1 / sigma.ravel(), 1 / trust.lens, [1 / trust.lift_m]])
        self._poses = POSE * len(posed)
        line_s = np.array([one.line_s for one in posed])[sights.shot]
        self._seconds = (sights.pixels[:, 1] - self._camera.height / 2) * line_s
        self._velocity = np.array([one.velocity for one in posed])[sights.shot]

    def start(self, begin: BundleSolution | None) -> FloatArray:
        """Return the values to begin with; points lie where their sights show level ground, in the middle."""
        shown = np.zeros((len(self._sights.pixels), 2))
        front = np.zeros(self._poses + SHARED)
        if begin is not None:
            poses = np.array([_values(one) for one in begin.posed]) - self._base
            poses[:, 2] -= begin.shared[LENS]
            front[: self._poses] = poses.ravel()
            front[self._poses :] = begin.shared
        posed = self._posed if begin is None else begin.posed
        for number, one in enumerate(posed):
            own = slice(int(self._ends[number]), int(self._ends[number + 1]))
            shown[own] = one.ground(self._sights.pixels[own])
        count = np.bincount(self._sights.point, minlength=self._sights.points)
        middle = [np.bincount(self._sights.point, v, self._sights.points) / np.maximum(count, 1) for v in shown.T]
        points = np.column_stack([*middle, np.zeros(self._sights.points)])
        return np.concatenate([front, points.ravel()])

    def errors(self, values: FloatArray) -> FloatArray:
        """Return how far the places show from their sights (M, 2), standard deviations."""
        poses, shared, points = self._parts(values)
        shown = self._shown(poses[self._sights.shot], shared, points[self._sights.point], _ALL)
        return (shown - self._sights.pixels) / self._pixel

    def cost(self, values: FloatArray, errors: FloatArray) -> float:
        """Return the sum that is made small: Cauchy's of the sights, squares of what was trusted."""
        known = values[: self._poses + SHARED] * self._weights
        level = values[self._poses + SHARED :].reshape(-1, 3)[:, 2] / LEVEL_SIGMA_M
        return float(np.log1p((errors**2).sum(axis=1)).sum() + (known**2).sum() + (level**2).sum())

    def step(self, values: FloatArray, errors: FloatArray, damping: float) -> FloatArray:
        """Return Levenberg's step by the normal equations without the points."""
        normal = Normal(self._ends, self._sights.point, self._sights.points)
        normal.add(self._runs(values, errors), POSE, SHARED)
        known = values[: self._poses + SHARED]
        trusted, pull = self._weights**2, known * self._weights**2
        axis, shared = np.arange(POSE), np.arange(SHARED)
        normal.poses[:, axis, axis] += trusted[: self._poses].reshape(-1, POSE)
        normal.lens[shared, shared] += trusted[self._poses :]
        normal.own[:, 2, 2] += 1 / LEVEL_SIGMA_M**2
        normal.to_pose += pull[: self._poses].reshape(-1, POSE)
        normal.to_lens += pull[self._poses :]
        normal.to_point[:, 2] += values[self._poses + SHARED :].reshape(-1, 3)[:, 2] / LEVEL_SIGMA_M**2
        normal.damp(damping)
        return np.concatenate([part.ravel() for part in normal.solve()])

    def _runs(self, values: FloatArray, errors: FloatArray) -> Iterator[Slopes]:
        """Yield the slopes of the sights of some photographs at a time."""
        begin = 0
        while begin < len(self._posed):
            end = max(begin + 1, int(np.searchsorted(self._ends, self._ends[begin] + _AT_ONCE)))
            part = slice(int(self._ends[begin]), int(self._ends[min(end, len(self._posed))]))
            begin = end
            if part.stop > part.start:
                weight = np.sqrt(1 / (1 + (errors[part] ** 2).sum(axis=1)))[:, None]
                slopes = (each * weight[..., None] for each in self._slopes(values, errors[part], part))
                yield Slopes(part.start, errors[part] * weight, *slopes)

    def settled(self, values: FloatArray, errors: FloatArray) -> BundleSolution:
        """Return the outcome."""
        poses, shared, points = self._parts(values)
        camera = _with_lens(self._camera, shared)
        posed = tuple(
            replace(
                one, camera=camera, north=float(p[0]), east=float(p[1]), height=float(p[2] + shared[LENS]),
                attitude=(float(p[3]), float(p[4]), float(p[5])), turning=(float(p[6]), float(p[7]), float(p[8])),
            )
            for one, p in zip(self._posed, poses, strict=True)
        )  # fmt: skip
        off = np.empty(len(errors))
        off[self._order] = np.hypot(*errors.T) * self._pixel
        return BundleSolution(posed, shared.copy(), points.copy(), off)

    def _parts(self, values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        poses = self._base + values[: self._poses].reshape(-1, POSE)
        return poses, values[self._poses : self._poses + SHARED], values[self._poses + SHARED :].reshape(-1, 3)

    def _shown(self, poses: FloatArray, shared: FloatArray, points: FloatArray, part: slice) -> FloatArray:
        """Return the pixels (M, 2) of points (M, 3) by poses (M, 9), for a part of the sights."""
        seconds = self._seconds[part]
        moved = poses[:, :2] + seconds[:, None] * self._velocity[part]
        offset = np.column_stack([points[:, :2] - moved, poses[:, 2] + shared[LENS] - points[:, 2]])
        rays = np.einsum("mij,mi->mj", rotations(poses[:, 3:6]), offset) @ CAMERA_TO_BODY
        if seconds.any():
            rays = rays - np.cross(seconds[:, None] * poses[:, 6:], rays)
        x, y = (rays[:, :2] / np.maximum(rays[:, 2:], 1e-3)).T
        camera = _with_lens(self._camera, shared)
        k1, k2, p1, p2, k3 = (*camera.distortion, *[0.0] * 5)[:5]
        square = np.minimum(x * x + y * y, 4.0)
        radial = 1 + square * (k1 + square * (k2 + square * k3))
        across = x * radial + 2 * p1 * x * y + p2 * (square + 2 * x * x)
        down = y * radial + p1 * (square + 2 * y * y) + 2 * p2 * x * y
        return np.column_stack([camera.fx * across + camera.cx, camera.fy * down + camera.cy])

    def _slopes(self, values: FloatArray, errors: FloatArray, part: slice) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the derivatives of some errors: by pose (M, 2, 9), by `SHARED` (M, 2, 6), by point (M, 2, 3)."""
        poses, shared, points = self._parts(values)
        poses, points = poses[self._sights.shot[part]], points[self._sights.point[part]]
        base = errors * self._pixel + self._sights.pixels[part]

        def slope(p: FloatArray, at: FloatArray, q: FloatArray, by: float) -> FloatArray:
            return np.asarray((self._shown(p, at, q, part) - base) / by / self._pixel)

        at_pose = [slope(poses + row, shared, points, by) for row, by in _steps(_POSE_STEPS)]
        at_shared = [slope(poses, shared + row, points, by) for row, by in _steps(_SHARED_STEPS)]
        at_point = [slope(poses, shared, points + row, by) for row, by in _steps(np.full(3, _POINT_STEP))]
        return np.stack(at_pose, axis=-1), np.stack(at_shared, axis=-1), np.stack(at_point, axis=-1)


def _steps(sizes: FloatArray) -> list[tuple[FloatArray, float]]:
    return [(row, float(size)) for row, size in zip(np.diag(sizes), sizes, strict=True)]


def _values(posed: CameraPose) -> FloatArray:
    return np.array([posed.north, posed.east, posed.height, *posed.attitude, *posed.turning])


def _with_lens(camera: CameraModel, shared: FloatArray) -> CameraModel:
    """Return the camera with the lens's values added."""
    scale, across, down, k1, k2 = (float(value) for value in shared[:LENS])
    known = (*camera.distortion, *[0.0] * 5)[: max(5, len(camera.distortion))]
    return replace(
        camera,
        fx=camera.fx * float(np.exp(scale)),
        fy=camera.fy * float(np.exp(scale)),
        cx=camera.cx + across * camera.width,
        cy=camera.cy + down * camera.width,
        distortion=(known[0] + k1, known[1] + k2, *known[2:]),
    )
