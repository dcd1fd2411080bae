"""Pilots: the planner itself, and the simple rule that it is compared with."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.exploration.surveyed import SurveyedMap
from hawk.algo.frame import FrameInput
from hawk.algo.ground import COARSE_M, CoarseLayers, Window
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.path_plan.field import InformationField, information_field
from hawk.algo.path_plan.lot_ground import FenceGuard
from hawk.algo.path_plan.settings import PathPlanSettings
from hawk.algo.topic_interface import AlgorithmTopicInterface
from hawk.model.plans import AskedGround, ExploreStatus, PathPlan
from hawk.model.poses import MapPoint, MapPose

Place = tuple[float, float]
ARRIVAL_M: Final = 1.5
_FIRST_TURN_RAD: Final = math.radians(125)  # a picture turned so far has shown all that half a turn shows
_TURN_LEAD_RAD: Final = 0.8
_END_M: Final = 0.3  # a tour's last place is reached when the drone stands
_MARGIN_M: Final = 40.0
_LEAST_CELLS: Final = 12  # a smaller frontier is noise


class PlannerPilot:
    """The Path Plan App as the flight has it.

    ``settings`` None: its own. ``ground``: what an operator asked to survey, None without an outline.
    """

    def __init__(self, *, settings: PathPlanSettings | None = None, ground: AskedGround | None = None) -> None:
        self._ground = ground
        self._app = PathPlanApp(settings)
        self._interface = AlgorithmTopicInterface()
        self._known: SurveyedMap | None = None

    def plan(self, frame: FrameInput, known: SurveyedMap) -> PathPlan:
        """Give the app its frame, as the algorithm manager does."""
        if known is not self._known:
            self._known = known
            self._app.init(known, self._interface)
        self._interface.begin(replace(frame, asked_ground=self._ground))
        self._app.process()
        return self._app.get_local_pose()


@dataclass
class TourPilot:
    """Flies a tour of known waypoints, picture along the flight; with ``turns`` it turns on the spot at both ends."""

    tour: list[Place]
    turns: bool = False
    _next: int = 0
    _turned: float = 0.0
    _yaw: float | None = None
    _side: float | None = None

    def plan(self, frame: FrameInput, known: SurveyedMap) -> PathPlan:  # noqa: ARG002 - it knows the lot
        """Return the waypoint that is next."""
        pose = _pose(frame)
        place = pose.north, pose.east
        if self.turns and self.tour and not self._next:
            bearing = math.atan2(self.tour[0][1] - pose.east, self.tour[0][0] - pose.north)
            plan = self._turn(pose, math.remainder(bearing - pose.yaw, math.tau), _FIRST_TURN_RAD)
            if plan is not None:
                return plan
        while self._next < len(self.tour):
            is_last = self._next == len(self.tour) - 1
            if math.dist(self.tour[self._next], place) > (_END_M if is_last else ARRIVAL_M):
                break
            self._next += 1
        if self._next < len(self.tour):
            return towards(frame, self.tour[self._next])
        plan = self._turn(pose, 1.0, _FIRST_TURN_RAD + math.pi) if self.turns else None
        return plan or PathPlan(explore=ExploreStatus(done=True))

    def _turn(self, pose: MapPose, side: float, until: float) -> PathPlan | None:
        """Turn on, None when it turned so far (radians, all turns on the spot together)."""
        if self._yaw is not None and self._turned < until:
            self._turned += abs(math.remainder(pose.yaw - self._yaw, math.tau))
        self._yaw = pose.yaw
        if self._turned >= until:
            self._yaw = self._side = None
            return None
        self._side = math.copysign(_TURN_LEAD_RAD, side) if self._side is None else self._side
        place = MapPoint(pose.north, pose.east)
        return PathPlan(place, pose.height, pose.yaw + self._side, (place,))


@dataclass(frozen=True, slots=True)
class Scene:
    """Inputs of the rule: ``unknown`` cells that may be lot and were not seen well, ``frontier`` those of them
    that touch well-seen lot, and where the drone may fly.
    """

    field: InformationField
    unknown: NDArray[np.bool_]
    frontier: NDArray[np.bool_]
    place: Place

    def places(self, cells: NDArray[np.intp]) -> NDArray[np.float64]:
        """Return (north, east) of cells (N, 2) of (row, column)."""
        window = self.field.window
        return np.column_stack([-(window.row + cells[:, 0] + 0.5), window.column + cells[:, 1] + 0.5]) * window.cell_m

    def is_frontier_near(self, place: Place) -> bool:
        """Return True while the cell of a place, or one beside it, is a frontier."""
        column, row = np.round(self.field.window.cells_of(np.array(place[0]), np.array(place[1]))).astype(int)
        return bool(self.frontier[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2].any())


@dataclass
class FrontierPilot:
    """Yamauchi's rule: flies to the nearest cell between what is known and what is not, inside the fence, picture along
    the flight.
    """

    _place: Place | None = None
    _guard: FenceGuard = field(default_factory=lambda: FenceGuard(None))

    def plan(self, frame: FrameInput, known: SurveyedMap) -> PathPlan:
        """Keep the place until it is reached or seen."""
        if frame.fence != self._guard.fence:
            self._guard = FenceGuard(frame.fence)
        scene = _scene(frame, known, self._guard)
        place = self._place
        if place is None or not scene.is_frontier_near(place) or math.dist(place, scene.place) <= ARRIVAL_M:
            self._place = _nearest(scene)
        if self._place is None:
            return PathPlan(explore=ExploreStatus(done=True))
        if self._guard.contains_line(scene.place, self._place):
            return towards(frame, self._place)
        corner = scene.field.corner_towards(scene.place, self._place)
        return towards(frame, corner if corner is not None else self._place)


def _nearest(scene: Scene) -> Place | None:
    """Return the nearest frontier cell; None when nothing is left."""
    cells = np.argwhere(scene.frontier)
    if len(cells) == 0:
        return None
    places = scene.places(cells)
    north, east = places[int(np.argmin(np.hypot(*(places - scene.place).T)))]
    return float(north), float(east)


def _scene(frame: FrameInput, known: SurveyedMap, guard: FenceGuard) -> Scene:
    pose = _pose(frame)
    extent = known.known_extent()
    assert extent is not None
    window = Window.around(np.vstack([extent, [[pose.north, pose.east]]]), COARSE_M, _MARGIN_M)
    layers = known.coarse(window)
    fenced = guard.mask(window)
    unknown, frontier = _frontier(layers, fenced)
    drivable = information_field(layers, fenced, PathPlanSettings().near_lot_m)
    return Scene(drivable, unknown, frontier, (pose.north, pose.east))


def _frontier(layers: CoarseLayers, fenced: NDArray[np.uint8]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return what may be lot and was not seen well, near known lot, and the part of it that touches seen lot."""
    is_lot = layers.lot > 0.5 * np.maximum(layers.seen, 0.3)
    unseen = layers.seen < 0.5
    near = cv2.dilate(is_lot.astype(np.uint8), np.ones((13, 13), np.uint8)) > 0
    unknown = (layers.well < 0.5) & (is_lot | (unseen & near)) & (fenced > 0)
    seen_lot = (is_lot & (layers.well >= 0.5)).astype(np.uint8)
    touching = (unknown & (cv2.dilate(seen_lot, np.ones((3, 3), np.uint8)) > 0)).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(touching, connectivity=8)
    large = stats[:, cv2.CC_STAT_AREA] >= _LEAST_CELLS
    large[0] = False
    return unknown, np.asarray(large[labels], dtype=np.bool_)


def _pose(frame: FrameInput) -> MapPose:
    assert frame.pose is not None
    return frame.pose


def towards(frame: FrameInput, place: Place) -> PathPlan:
    """Return the plan to fly to a place, picture along the flight."""
    pose = _pose(frame)
    height = frame.heights.bounded(frame.heights.desired)
    yaw = pose.yaw
    if math.dist(place, (pose.north, pose.east)) > 1.0:
        yaw = math.atan2(place[1] - pose.east, place[0] - pose.north)
    return PathPlan(MapPoint(*place), height, yaw, (MapPoint(*place),))
