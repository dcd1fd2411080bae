"""The lots of a world as a map has them, and the planner's own flight over them on the exploration's model."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from benchmarks.exploration import setups
from benchmarks.exploration.flight import Flown, fly
from benchmarks.exploration.lots import Lot
from benchmarks.exploration.pilots import PlannerPilot

Ring = NDArray[np.float64]


def rings_about(lots: Iterable[Ring], middle: tuple[float, float]) -> list[Ring]:
    """Return lots' outlines (N, 2) as (north, east) of a place of the world, metres (x east, y south)."""
    x, y = middle
    return [np.column_stack([y - lot[:, 1], lot[:, 0] - x]) for lot in lots]


def joined(rings: Iterable[Ring]) -> shapely.Geometry:
    """Return outlines as one shape."""
    return shapely.union_all([shapely.Polygon(ring).buffer(0) for ring in rings])


def kinematic_flight(lot: Lot) -> Flown:
    """Return the planner's own flight over a lot, to its own end."""
    cv2.setNumThreads(1)
    return fly(lot, setups.flown(), PlannerPilot())
