"""A drone that flies what the planner says over a lot of known shape; what a picture's middle shows is seen exactly."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
import shapely
import shapely.affinity
import shapely.ops
from numpy.typing import NDArray

from benchmarks.kinematic_drone import STEP_S, Drone, goal_of
from hawk.algo.ground import CoarseLayers, Window
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.topic_interface import AlgorithmTopicInterface
from hawk.model.lot_map import Stall
from hawk.model.plans import AskedGround, Fence, Inbound, PathPlan
from hawk.model.poses import MapPose
from tests.unit.algo.synthetic import CAMERA, frame_at, ground_affine

_FINE_M = 0.8
_FRAME_S = 0.25
_NO_FENCE = Fence(((-999.0, -999.0), (-999.0, 999.0), (999.0, 999.0), (999.0, -999.0)), (), 97.0, 100.0)


class KnownMap:
    """The part of a lot that was seen so far, on a 0.8 m grid about the origin."""

    def __init__(self, lot: shapely.Geometry, reach: float) -> None:
        self.window = Window.around(np.array([[-reach, -reach], [reach, reach]]), _FINE_M).aligned(2)
        self.lot = self._drawn(lot)
        self.seen = np.zeros_like(self.lot)
        self.well = np.zeros_like(self.lot)

    def look(self, pose: MapPose) -> None:
        for layer, share in ((self.seen, 1.0), (self.well, 0.85)):
            corners = footprint(pose, share)
            cells = self.window.cells_of(corners[:, 0], corners[:, 1])
            cv2.fillConvexPoly(layer, np.round(cells * 16).astype(np.int32), (1.0,), shift=4)

    def coverage(self) -> float:
        return float((self.lot * self.well).sum() / self.lot.sum())

    def coarse(self, window: Window) -> CoarseLayers:
        lot, seen, well = (self._coarse(layer, window) for layer in (self.lot * self.seen, self.seen, self.well))
        return CoarseLayers(window, lot, seen, well, lot)

    def known_extent(self) -> NDArray[np.float64] | None:
        rows, columns = np.nonzero(self.seen)
        north = -(self.window.row + np.array([rows.max(), rows.min()])) * _FINE_M
        east = (self.window.column + np.array([columns.min(), columns.max()])) * _FINE_M
        return np.stack([north, east], -1)

    def lot_area_m2(self) -> float:
        return float((self.lot * self.seen).sum()) * _FINE_M**2

    def inbound(self, north: float, east: float) -> Inbound:
        return Inbound.UNKNOWN

    def unclear_stalls(self) -> Mapping[int, Stall]:
        return {}

    def _coarse(self, layer: NDArray[np.float32], window: Window) -> NDArray[np.float32]:
        step = round(window.cell_m / _FINE_M)
        size = (self.window.columns // step, self.window.rows // step)
        small = cv2.resize(layer, size, interpolation=cv2.INTER_AREA)
        top, left = window.row - self.window.row // step, window.column - self.window.column // step
        result = np.zeros(window.shape, np.float32)
        rows, columns = np.arange(window.rows) + top, np.arange(window.columns) + left
        r, c = (rows >= 0) & (rows < size[1]), (columns >= 0) & (columns < size[0])
        result[np.ix_(r, c)] = small[np.ix_(rows[r], columns[c])]
        return result

    def _drawn(self, lot: shapely.Geometry) -> NDArray[np.float32]:
        image = np.zeros(self.window.shape, np.float32)
        for part in shapely.get_parts(lot):
            corners = np.array(part.exterior.coords)
            cells = self.window.cells_of(corners[:, 0], corners[:, 1])
            cv2.fillPoly(image, [np.round(cells * 16).astype(np.int32)], (1.0,), shift=4)
        return image


@dataclass
class Flight:
    """A flight: metres flown, seconds, share of the lot seen well, and every place."""

    distance_m: float = 0.0
    seconds: float = 0.0
    coverage: float = 0.0
    done: bool = False
    places: list[tuple[float, float]] = field(default_factory=list)
    plans: list[PathPlan] = field(default_factory=list)


def footprint(pose: MapPose, share: float) -> NDArray[np.float64]:
    """Return the corners of the middle ``share`` of the level picture."""
    width, depth = (pose.height * n / CAMERA.fx * share for n in (CAMERA.width, CAMERA.height))
    affine = ground_affine(pose, (2, 2), 1.0)
    box = np.array([[-width, -depth], [width, -depth], [width, depth], [-width, depth]]) / 2 + 0.5
    return np.asarray(box @ affine[:, :2].T + affine[:, 2])


LEVEL = PathPlanSettings(lean_deg=0.0, stop_lean_deg=0.0)
"""The drone that is flown here stays level."""


def fly(
    lot: shapely.Geometry,
    start: tuple[float, float],
    fence: Fence,
    app: PathPlanApp | None = None,
    most_s: float = 900,
    known: KnownMap | None = None,
    ground: AskedGround | None = None,
) -> Flight:
    """Fly hawk-sim's body, with a camera that is kept level, until the planner is done. Nothing but the planner keeps
    it inside the fence.

    ``known`` is what an earlier flight saw, ``ground`` what an operator asked to survey.
    """
    known = known or KnownMap(lot, max(map(abs, lot.bounds)) + 80)
    interface = AlgorithmTopicInterface()
    app = app or PathPlanApp(LEVEL)
    app.init(known, interface)
    drone = Drone(MapPose(*start, 35.0, 0.0, 0.0, 0.0), _NO_FENCE, np.random.default_rng(0), 0.0)
    flight, goal, waiting = Flight(), None, PathPlan()
    while drone.seconds < most_s and not flight.done:
        pose = replace(drone.true, roll=0.0, pitch=0.0)
        goal = goal_of(waiting, pose, goal)
        known.look(pose)
        frame = frame_at(pose, len(flight.plans), fence=fence, interval=_FRAME_S)
        interface.begin(replace(frame, speed=drone.speed, asked_ground=ground))
        app.process()
        waiting = app.get_local_pose()
        flight.plans.append(waiting)
        flight.places.append((pose.north, pose.east))
        flight.done = waiting.explore.done
        for _ in range(round(_FRAME_S / STEP_S)):
            drone.step(goal)
    flight.seconds, flight.distance_m, flight.coverage = drone.seconds, drone.distance_m, known.coverage()
    return flight


def lower_bound(lot: shapely.Polygon) -> float:
    """Return the length of the shortest path that can show the lot: all that one picture does not show, swept."""
    width, depth = (35.0 * n / CAMERA.fx * 0.85 for n in (CAMERA.width, CAMERA.height))
    return float((lot.area - width * depth) / width)


def random_lot(seed: int) -> tuple[shapely.Polygon, tuple[float, float]]:
    """Return a lot of one or two joined rectangles, turned about the origin, and a start just inside its border."""
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(50, 110), rng.uniform(40, 80)
    lot = shapely.box(-b / 2, -a / 2, b / 2, a / 2)
    if rng.random() < 0.6:
        c, d = rng.uniform(30, 50), rng.uniform(30, 60)
        at = rng.uniform(-a / 2, a / 2 - c)
        lot = shapely.union(lot, shapely.box(b / 2 - 5, at, b / 2 + d, at + c))
    lot = shapely.affinity.rotate(lot, rng.uniform(0, 180), origin=(0, 0))
    edge = np.array(lot.exterior.coords)
    i = int(rng.integers(len(edge) - 1))
    middle = shapely.Point((edge[i] + edge[i + 1]) / 2)
    inner = lot.buffer(-2.0)
    inside = shapely.ops.nearest_points(inner, middle)[0]
    return lot, (inside.x, inside.y)


def fence_around(lot: shapely.Polygon, margin: float) -> Fence:
    """Return a fence so far around the lot."""
    polygon = tuple(map(tuple, lot.buffer(margin, join_style="mitre").exterior.coords[:-1]))
    return Fence(polygon, polygon, 60.0, 63.0)
