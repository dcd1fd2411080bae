"""What a picture shows while the drone flies along straight legs, and while it turns.

A level picture is a rectangle about the drone, wide across the heading. Between two legs the drone turns it: about a
way point it shows what a disc would, and more than the two rectangles together. Turned half round on the spot, its
corners sweep a disc that is wider still.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Bools = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Turns:
    """How far about the ends of K legs the picture shows the ground by turning there, metres: ``at_begin`` and
    ``at_end`` (K,), or one radius for all; 0: it does not turn."""

    at_begin: Floats | float = 0.0
    at_end: Floats | float = 0.0


@dataclass(frozen=True, slots=True)
class Footprint:
    """Ground that a picture shows: ``width`` across and ``depth`` along its heading, metres.

    ``turned`` is the radius about a way point that the picture shows by turning to the next leg, ``spun`` the radius
    about a place where it turns half round; 0: turns are not counted on.
    """

    width: float
    depth: float
    turned: float = 0.0
    spun: float = 0.0

    @property
    def reach(self) -> float:
        """Metres from the middle of the picture to a corner: what no turn can show lies beyond."""
        return math.hypot(self.width, self.depth) / 2

    def shown(self, cells: Singles, begins: Floats, ends: Floats, turns: Turns | None = None) -> Bools:
        """Return (K, N): which of N cells (N, 2) each of K straight legs shows."""
        along, across, half = legs_about(cells, begins, ends)
        shown = (np.abs(across) <= self.width / 2) & (np.abs(along) <= half + self.depth / 2)
        if turns is None:
            return np.asarray(shown)
        aside = across * across
        for sign, radii in ((1, turns.at_begin), (-1, turns.at_end)):
            if np.any(radii):
                near = along + sign * half
                shown |= near * near + aside < np.reshape(np.float32(radii) ** 2, (-1, 1))
        return np.asarray(shown)

    def swept(self, cells: Singles, place: Floats, heading: float, headings: Floats) -> Bools:
        """Return (K, N): which cells the picture shows while it turns on the spot from one heading to each of K
        others, the short way round (radians)."""
        off = cells - place.astype(np.float32)
        away = np.hypot(off[:, 0], off[:, 1])
        result = np.zeros((len(headings), len(cells)), np.bool_)
        near = np.flatnonzero(away <= self.spun)
        if len(near) == 0:
            return result
        turns = np.array([math.remainder(value - heading, math.tau) for value in headings.tolist()])
        left, right = self.turns_until_shown(off[near], heading)
        result[:, near] = np.where(turns[:, None] >= 0, right <= turns[:, None], left <= -turns[:, None])
        return result

    def turns_until_shown(self, off: Singles, heading: float) -> tuple[Floats, Floats]:
        """Return how far a picture must turn to the left, and to the right, until it shows cells that lie ``off``
        (N, 2) the drone and no farther than ``reach``: radians, 0 what it shows now."""
        away = np.maximum(np.hypot(off[:, 0], off[:, 1]), 1e-6)
        # a cell is shown while its bearing lies between these angles to the picture's wide axis, on either side of it
        least = np.arccos(np.minimum(self.width / 2 / away, 1.0))
        most = np.maximum(np.arcsin(np.minimum(self.depth / 2 / away, 1.0)), least)
        aside = (np.arctan2(off[:, 1], off[:, 0]) - heading - math.pi / 2) % math.pi
        from_axis = np.minimum(aside, math.pi - aside)
        is_shown = (from_axis >= least) & (from_axis <= most)
        right = np.minimum((aside - most) % math.pi, (aside + least) % math.pi)
        left = np.minimum((least - aside) % math.pi, (-most - aside) % math.pi)
        return np.where(is_shown, 0.0, left), np.where(is_shown, 0.0, right)


def legs_about(cells: Singles, begins: Floats, ends: Floats) -> tuple[Singles, Singles, Singles]:
    """Return how far along from each leg's middle and across it the cells lie, (K, N), and half of each leg's length,
    (K, 1)."""
    leg = ends - begins
    length = np.hypot(leg[:, 0], leg[:, 1])
    unit = leg / np.maximum(length, 1e-9)[:, None]
    unit[length < 1e-9] = (1.0, 0.0)
    # one product of matrices gives both coordinates of every cell about every leg
    turn = np.concatenate([unit, np.column_stack([-unit[:, 1], unit[:, 0]])])
    middle = (begins + ends) / 2
    origin = np.concatenate([(middle * unit).sum(1), middle[:, 1] * unit[:, 0] - middle[:, 0] * unit[:, 1]])
    turned = turn.astype(np.float32) @ cells.T - origin[:, None].astype(np.float32)
    half = (length / 2).astype(np.float32)[:, None]
    return turned[: len(leg)], turned[len(leg) :], half
