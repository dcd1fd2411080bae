"""Stalls as rectangles, their neighbours, and the rows that labels form."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
SAME_DIRECTION = math.radians(20)
"""Greatest difference of direction of two stalls of one row."""
STEP, ASIDE = (0.6, 1.5), 0.4
"""Neighbours lie one stall on along the row, in stalls, and at most this share of a stall aside of it."""
BEYOND = 2.6
"""A find lies beyond the end of a row within N stalls of the last label's middle."""


@dataclass(frozen=True, slots=True)
class Boxes:
    """Smallest rectangles around quads: ``centre`` (N, 2), unit vectors ``across`` and ``along`` (N, 2) of the short
    and the long side, ``width`` and ``length`` (N,), metres.
    """

    centre: Floats
    across: Floats
    along: Floats
    width: Floats
    length: Floats

    @classmethod
    def of(cls, stalls: Floats) -> Boxes:
        """Return the rectangles of quads (N, 4, 2)."""
        if not len(stalls):
            none = np.zeros((0, 2))
            return cls(none, none, none, np.zeros(0), np.zeros(0))
        around = shapely.minimum_rotated_rectangle(shapely.convex_hull(shapely.polygons(stalls)))
        corners = shapely.get_coordinates(around).reshape(-1, 5, 2)
        first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 1]
        long_first = np.hypot(*first.T) > np.hypot(*second.T)
        along = np.where(long_first[:, None], first, second)
        across = np.where(long_first[:, None], second, first)
        length, width = (np.maximum(np.hypot(*side.T), 1e-6) for side in (along, across))
        return cls(corners[:, :4].mean(axis=1), across / width[:, None], along / length[:, None], width, length)

    def __len__(self) -> int:
        return len(self.width)

    def offsets(self, points: Floats) -> Floats:
        """Return (N, M, 2): how far each point (M, 2) lies from each middle, in widths across and lengths along."""
        apart = points[None] - self.centre[:, None]
        across = np.einsum("nmk,nk->nm", apart, self.across) / self.width[:, None]
        along = np.einsum("nmk,nk->nm", apart, self.along) / self.length[:, None]
        return np.stack([across, along], axis=-1)

    def turned(self, other: Boxes) -> Floats:
        """Return (N, M): angle between the long sides, 0 to a quarter turn, radians."""
        return np.asarray(np.arccos(np.clip(np.abs(self.along @ other.along.T), 0, 1)))

    def patch(self, number: int, across: tuple[float, float], along: tuple[float, float]) -> Floats:
        """Return a part of a rectangle as a quad (4, 2); the parts are in metres from its middle."""
        corners = [(across[0], along[0]), (across[1], along[0]), (across[1], along[1]), (across[0], along[1])]
        axes = np.stack([self.across[number], self.along[number]])
        return np.asarray(self.centre[number] + np.array(corners) @ axes)


def neighbours(boxes: Boxes, others: Boxes) -> NDArray[np.int_]:
    """Return (N, M): on which side of a stall each other one lies next to it.

    1 and -1: beside it, on the side of ``across`` or against it; 2 and -2: at its head or foot, on the side of
    ``along`` or against it; 0: no neighbour.
    """
    offset = boxes.offsets(others.centre)
    size = np.abs(offset)
    level = boxes.turned(others) < SAME_DIRECTION
    sides = np.zeros(level.shape, np.int_)
    for axis in (1, 0):
        step, aside = size[..., axis], size[..., 1 - axis]
        near = level & (step > STEP[0]) & (step < STEP[1]) & (aside < ASIDE)
        sides[near] = np.sign(offset[..., axis][near]).astype(int) * (axis + 1)
    return sides


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows of labels. ``axis`` (N,): 0 where stalls lie side by side, 1 where they lie head to foot, -1 for a label
    alone. ``open_side`` (N,): 1 or -1, the side on which the row ends, 0 within a row.
    """

    boxes: Boxes
    axis: NDArray[np.int_]
    open_side: NDArray[np.int_]

    @classmethod
    def of(cls, stalls: Floats) -> Rows:
        """Return the rows of labels (N, 4, 2). Head to foot counts only where no label lies beside."""
        boxes = Boxes.of(stalls)
        sides = neighbours(boxes, boxes)
        has = {side: (sides == side).any(axis=1) for side in (1, -1, 2, -2)}
        beside, in_line = has[1] | has[-1], has[2] | has[-2]
        axis = np.where(beside, 0, np.where(in_line, 1, -1))
        before, after = np.where(axis == 1, has[-2], has[-1]), np.where(axis == 1, has[2], has[1])
        open_side = np.where(axis < 0, 0, np.where(before & ~after, 1, np.where(after & ~before, -1, 0)))
        return cls(boxes, axis, open_side)

    @property
    def is_end(self) -> Mask:
        """Labels (N,) at the end of a row."""
        return np.asarray(self.open_side != 0)

    def at_end(self, finds: Boxes) -> Mask:
        """Return finds (M,) at the last label of a row or up to `BEYOND` stalls beyond it."""
        if not len(finds) or not self.is_end.any():
            return np.zeros(len(finds), np.bool_)
        step, aside = self._in_row(finds.centre)
        onward = step * self.open_side[:, None]
        near = self.is_end[:, None] & (onward > -0.5) & (onward < BEYOND) & (np.abs(aside) < 0.6)
        return np.asarray(near.any(axis=0))

    def half_off(self, finds: Boxes) -> Mask:
        """Return (N, M): finds that lie half a stall off a label along its row, turned as the label is."""
        if not len(finds) or not len(self.boxes):
            return np.zeros((len(self.boxes), len(finds)), np.bool_)
        step, aside = self._in_row(finds.centre)
        size = finds.width[None] / self.boxes.width[:, None]
        alike = (self.boxes.turned(finds) < SAME_DIRECTION) & (size > 0.6) & (size < 1.6)
        return np.asarray(alike & (np.abs(step) > 0.3) & (np.abs(step) < 0.7) & (np.abs(aside) < 0.3))

    def _in_row(self, points: Floats) -> tuple[Floats, Floats]:
        """Return (N, M) each: offsets along the row and aside of it, in stalls."""
        offset = self.boxes.offsets(points)
        lengthwise = (self.axis == 1)[:, None]
        return (
            np.where(lengthwise, offset[..., 1], offset[..., 0]),
            np.where(lengthwise, offset[..., 0], offset[..., 1]),
        )


def spanning(long: Floats, short: Floats, share: float) -> Mask:
    """Return (N, M): whether each quad of the first covers ``share`` of two or more of the second, and those."""
    covered = np.zeros((len(long), len(short)), np.bool_)
    if not len(long) or not len(short):
        return covered
    first, second = (shapely.convex_hull(shapely.polygons(quads)) for quads in (long, short))
    i, j = shapely.STRtree(second).query(first, predicate="intersects")
    shared = shapely.area(shapely.intersection(first[i], second[j], grid_size=1e-6))
    covered[i, j] = shared >= share * shapely.area(second[j])
    covered[covered.sum(axis=1) < 2] = False
    return covered
