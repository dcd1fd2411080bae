"""Worlds of places, the lots of a world as a map has them, and the planner's own flight over those."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from benchmarks.exploration import setups
from benchmarks.exploration.flight import Flown, fly
from benchmarks.exploration.lots import Lot
from benchmarks.exploration.pilots import PlannerPilot
from hawk.worlds.world import World, picture_world

Ring = NDArray[np.float64]


def north_east(points: Ring, middle: tuple[float, float]) -> Ring:
    """Return points (..., 2) of a world (x east, y south) as (north, east) of a place of it, metres."""
    return np.stack([middle[1] - points[..., 1], points[..., 0] - middle[0]], axis=-1)


def place_world(truth: Path) -> World:
    """Return the picture of a place as a world: PLACE.jpg beside its labels PLACE.json."""
    scale = json.loads(truth.read_text())["metres_per_pixel"]
    return picture_world(truth.with_suffix(".jpg"), scale, truth)


def rings_about(lots: Iterable[Ring], middle: tuple[float, float]) -> list[Ring]:
    """Return lots' outlines (N, 2) as (north, east) of a place of the world."""
    return [north_east(lot, middle) for lot in lots]


def joined(rings: Iterable[Ring]) -> shapely.Geometry:
    """Return outlines as one shape."""
    return shapely.union_all([shapely.Polygon(ring).buffer(0) for ring in rings])


def kinematic_flight(lot: Lot) -> Flown:
    """Return the planner's own flight over a lot, to its own end."""
    cv2.setNumThreads(1)
    return fly(lot, setups.flown(), PlannerPilot())
