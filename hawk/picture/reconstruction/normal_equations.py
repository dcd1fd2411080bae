"""Normal equations of a bundle, from which the points are eliminated.

Each sight is of one photograph and one point, so that all is blocks: 9 x 9 of a photograph, 3 x 3 of a point, 9 x 3 of
a sight. What is left are the photographs, each with those alone that show common points, bordered by the lens, which
all share (Triggs, McLauchlan, Hartley and Fitzgibbon 2000, 6.1 and 6.3). Time and memory grow with the photographs.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_matrix
from scipy.sparse.linalg import splu

FloatArray = NDArray[np.float64]
_LEAST: Final = 1e-9


@dataclass(frozen=True, slots=True)
class Slopes:
    """Derivatives of the errors of the sights of a run of photographs, with the errors (M, 2), all weighed: by pose
    (M, 2, A), lens (M, 2, B) and point (M, 2, 3). ``first``: number of the first sight.
    """

    first: int
    errors: FloatArray
    pose: FloatArray
    lens: FloatArray
    point: FloatArray


@dataclass(slots=True)
class Normal:
    """Sums over the sights of N photographs and P points. The sights are in the order of ``ends`` (N + 1,): those of
    photograph n are from ``ends[n]`` to ``ends[n + 1]``; ``at`` (M,) are their points.
    """

    ends: NDArray[np.intp]
    at: NDArray[np.intp]
    points: int
    poses: FloatArray = field(init=False)
    """(N, A, A)"""
    borders: FloatArray = field(init=False)
    """(N, A, B) of photographs with the lens."""
    lens: FloatArray = field(init=False)
    """(B, B)"""
    own: FloatArray = field(init=False)
    """(P, 3, 3) of points."""
    cross: FloatArray = field(init=False)
    """(M, A, 3) of photographs with points, by sight."""
    lens_cross: FloatArray = field(init=False)
    """(P, B, 3) of the lens with points."""
    to_pose: FloatArray = field(init=False)
    to_lens: FloatArray = field(init=False)
    to_point: FloatArray = field(init=False)
    """Gradients (N, A), (B,) and (P, 3)."""

    def add(self, runs: Iterator[Slopes], pose: int, lens: int) -> None:
        """Sum over all sights. ``pose``, ``lens``: numbers of values A and B."""
        count = len(self.ends) - 1
        self.poses, self.borders = np.zeros((count, pose, pose)), np.zeros((count, pose, lens))
        self.lens, self.own = np.zeros((lens, lens)), np.zeros((self.points, 3, 3))
        self.cross, self.lens_cross = np.empty((len(self.at), pose, 3)), np.zeros((self.points, lens, 3))
        self.to_pose, self.to_lens, self.to_point = np.zeros((count, pose)), np.zeros(lens), np.zeros((self.points, 3))
        for run in runs:
            self._add(run)

    def _add(self, run: Slopes) -> None:
        last = run.first + len(run.errors)
        at = self.at[run.first : last]
        self.cross[run.first : last] = np.einsum("mki,mkj->mij", run.pose, run.point)
        _sum_into(self.lens_cross, at, np.einsum("mki,mkj->mij", run.lens, run.point))
        _sum_into(self.own, at, np.einsum("mki,mkj->mij", run.point, run.point))
        _sum_into(self.to_point, at, np.einsum("mki,mk->mi", run.point, run.errors))
        begin, end = np.searchsorted(self.ends, run.first, side="right") - 1, np.searchsorted(self.ends, last)
        for number in range(int(begin), int(end)):
            part = slice(int(self.ends[number]) - run.first, int(self.ends[number + 1]) - run.first)
            own = run.pose[part].reshape(-1, self.poses.shape[1])
            lens, errors = run.lens[part].reshape(-1, len(self.lens)), run.errors[part].ravel()
            self.poses[number] = own.T @ own
            self.borders[number] = own.T @ lens
            self.lens += lens.T @ lens
            self.to_pose[number] = own.T @ errors
            self.to_lens += lens.T @ errors

    def damp(self, damping: float) -> None:
        """Add Levenberg's share of the diagonals."""
        for blocks in (self.poses, self.lens[None], self.own):
            axis = np.arange(blocks.shape[-1])
            blocks[:, axis, axis] *= 1 + damping

    def solve(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the step (N, A), (B,) and (P, 3) against the gradients."""
        inverse: FloatArray = np.asarray(np.linalg.inv(self.own + _LEAST * np.eye(3)), np.float64)
        count, pose, lens = self.borders.shape
        through = self.cross @ inverse[self.at]
        lens_through = self.lens_cross @ inverse
        left = self.lens - np.einsum("pij,pkj->ik", lens_through, self.lens_cross)
        to_lens = self.to_lens - np.einsum("pij,pj->i", lens_through, self.to_point)
        border, to_pose = self.borders.copy(), self.to_pose.copy()
        for number in range(count):
            part = slice(int(self.ends[number]), int(self.ends[number + 1]))
            at = self.at[part]
            border[number] -= np.tensordot(through[part], self.lens_cross[at], axes=([0, 2], [0, 2]))
            to_pose[number] -= np.tensordot(through[part], self.to_point[at], axes=([0, 2], [0, 1]))
        known = np.column_stack([border.reshape(-1, lens), to_pose.ravel()])
        solved = self._factor(through).solve(known).reshape(count, pose, lens + 1)
        own = left - np.tensordot(border, solved[..., :lens], axes=([0, 1], [0, 1]))
        lens_step = np.linalg.solve(own, np.tensordot(border, solved[..., lens], axes=([0, 1], [0, 1])) - to_lens)
        pose_step = -(solved[..., lens] + solved[..., :lens] @ lens_step)
        return pose_step, lens_step, self._back(inverse, pose_step, lens_step)

    def _factor(self, through: FloatArray) -> Any:
        count, pose, _ = self.borders.shape
        shape = (pose * count, 3 * self.points)
        one, other = (bsr_matrix((blocks, self.at, self.ends), shape=shape) for blocks in (through, self.cross))
        shared = one @ other.T
        del one, other
        own = bsr_matrix((self.poses, np.arange(count), np.arange(count + 1)), shape=(pose * count,) * 2)
        return splu(
            (own - shared).tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )

    def _back(self, inverse: FloatArray, pose_step: FloatArray, lens_step: FloatArray) -> FloatArray:
        """Return the step of the points that follows from the others."""
        shot = np.repeat(np.arange(len(self.ends) - 1), np.diff(self.ends))
        wanted = -self.to_point - np.einsum("pij,i->pj", self.lens_cross, lens_step)
        _sum_into(wanted, self.at, -np.einsum("mij,mi->mj", self.cross, pose_step[shot]))
        return np.asarray(np.einsum("pij,pj->pi", inverse, wanted))


def _sum_into(sums: FloatArray, at: NDArray[np.intp], values: FloatArray) -> None:
    """Add values (M, ...) to sums (P, ...) at numbers (M,)."""
    flat, added = sums.reshape(len(sums), -1), values.reshape(len(values), -1)
    for column in range(flat.shape[1]):
        flat[:, column] += np.bincount(at, added[:, column], len(sums))
