"""Lots for the tests of registration: rows of stalls, and what a flight makes of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from hawk.algo.registration.likelihood import Placement, StallMap
from hawk.algo.rows.fit import Indices, Rectangles
from hawk.algo.vision.detection import FloatArray

PITCH_M = 2.6
DEPTH_M = 5.2
_AROUND_M = 12.0


def rows(lengths: Sequence[int], begins: Sequence[float] = (), pitch: float = PITCH_M) -> Rectangles:
    """Return rows of these lengths, 15 m apart to the north, each from its own beginning in the east."""
    starts = [*begins, *[0.0] * (len(lengths) - len(begins))]
    centres = np.array([(15.0 * r, starts[r] + pitch * k) for r, count in enumerate(lengths) for k in range(count)])
    return rectangles(centres)


def rectangles(centres: FloatArray, angle: float = 0.0) -> Rectangles:
    """Return stalls of the usual size at centres (N, 2)."""
    count = len(centres)
    return Rectangles(centres, np.full(count, angle), np.full(count, PITCH_M), np.full(count, DEPTH_M))


def ground_about(stalls: Rectangles, metres: float = _AROUND_M) -> shapely.Polygon:
    """Return the ground about stalls."""
    hull = shapely.MultiPoint(stalls.centres).convex_hull.buffer(metres)
    assert isinstance(hull, shapely.Polygon)
    return hull


def map_of(stalls: Rectangles) -> StallMap:
    """Return a map that saw stalls and all ground about them."""
    return StallMap(stalls, ground_about(stalls))


def flown_again(
    known: StallMap,
    placement: Placement,
    rng: np.random.Generator,
    *,
    missed: float = 0.04,
    deviation: float = 0.15,
) -> tuple[StallMap, Indices]:
    """Return what a later flight maps, in a frame that ``placement`` brings onto the known one; and which known stall
    each of its stalls is.
    """
    stalls = known.stalls
    which = np.flatnonzero(rng.random(len(stalls)) >= missed)
    centres = placement.back(stalls.centres[which]) + rng.normal(0, deviation, (len(which), 2))
    some = stalls[which]
    found = Rectangles(centres, some.angle - placement.turn, some.width, some.length)
    seen = shapely.transform(known.seen, placement.back)
    return StallMap(found, seen), np.asarray(which, np.intp)
