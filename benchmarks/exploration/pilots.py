"""Pilots: the planner itself, and the simple rules that it is compared with."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Final, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.exploration.disc import Disc
from benchmarks.exploration.surveyed import SurveyedMap
from hawk.algo.frame import FrameInput
from hawk.algo.ground import COARSE_M, CoarseLayers, Window
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.path_plan.field import InformationField, information_field
from hawk.algo.path_plan.footprint import Swath
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
_REPLAN_S: Final = 3.0  # explore_lite's planner_frequency, 0.33 Hz
_POTENTIAL_SCALE: Final = 3.0  # m-explore's launch file
_GAIN_SCALE: Final = 1.0
_LEAST_STEP_M: Final = 5.0
_LATTICE: Final = 3  # coarse cells between two candidates of gain by distance


class PlannerPilot:
    """The Path Plan App as the flight has it; ``is_disc``: what counts as seen is a disc, and it knows that.
    ``settings`` None: its own. ``ground``: what an operator asked to survey, None without an outline.
    """

    def __init__(
        self, *, is_disc: bool = False, settings: PathPlanSettings | None = None, ground: AskedGround | None = None
    ) -> None:
        self._ground = ground
        self._app = PathPlanApp(settings, footprint=_disc if is_disc else None)
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

    @property
    def next(self) -> int:
        """Number of the waypoint that is next."""
        return self._next

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
    """Inputs of a simple rule: ``unknown`` cells that may be lot and were not seen well, ``frontier`` those of them
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


class Rule(Protocol):
    """Chooses a place; None when nothing is left."""

    def choose(self, scene: Scene, frame: FrameInput) -> Place | None:
        """Return a new place to fly to."""
        ...

    def keeps(self, scene: Scene, place: Place, frame: FrameInput) -> bool:
        """Return True while the chosen place is worth flying to."""
        ...


@dataclass
class RulePilot:
    """Flies to the places that a rule chooses, inside the fence, picture along the flight."""

    rule: Rule
    _place: Place | None = None
    _guard: FenceGuard = field(default_factory=lambda: FenceGuard(None))

    def plan(self, frame: FrameInput, known: SurveyedMap) -> PathPlan:
        """Keep the place for as long as the rule does."""
        if frame.fence != self._guard.fence:
            self._guard = FenceGuard(frame.fence)
        scene = _scene(frame, known, self._guard)
        if self._place is None or not self.rule.keeps(scene, self._place, frame):
            self._place = self.rule.choose(scene, frame)
        if self._place is None:
            return PathPlan(explore=ExploreStatus(done=True))
        if self._guard.contains_line(scene.place, self._place):
            return towards(frame, self._place)
        corner = scene.field.corner_towards(scene.place, self._place)
        return towards(frame, corner if corner is not None else self._place)


class NearestFrontier:
    """Yamauchi's rule: the nearest cell between what is known and what is not."""

    def choose(self, scene: Scene, frame: FrameInput) -> Place | None:  # noqa: ARG002 - a rule's interface
        """Return the nearest frontier cell."""
        cells = np.argwhere(scene.frontier)
        if len(cells) == 0:
            return None
        places = scene.places(cells)
        north, east = places[int(np.argmin(np.hypot(*(places - scene.place).T)))]
        return float(north), float(east)

    def keeps(self, scene: Scene, place: Place, frame: FrameInput) -> bool:  # noqa: ARG002
        """Until it is seen."""
        return scene.is_frontier_near(place) and math.dist(place, scene.place) > ARRIVAL_M


@dataclass
class MExplore:
    """explore_lite: least ``potential_scale * distance - gain_scale * size`` over whole frontiers, chosen every 3 s."""

    _chosen_at: float = -math.inf

    def choose(self, scene: Scene, frame: FrameInput) -> Place | None:
        """Return the middle of the cheapest frontier, or its nearest cell when the drone is there already."""
        self._chosen_at = frame.captured
        count, labels = cv2.connectedComponents(scene.frontier.astype(np.uint8), connectivity=8)
        best, least = None, math.inf
        for label in range(1, count):
            places = scene.places(np.argwhere(labels == label))
            away = np.hypot(*(places - scene.place).T)
            cost = _POTENTIAL_SCALE * float(away.min()) - _GAIN_SCALE * len(places) * COARSE_M
            if cost < least:
                middle = places.mean(0)
                near = math.dist(middle, scene.place) <= 2 * ARRIVAL_M
                at = places[int(np.argmin(np.where(away > 2 * ARRIVAL_M, away, math.inf)))] if near else middle
                best, least = (float(at[0]), float(at[1])), cost
        return best

    def keeps(self, scene: Scene, place: Place, frame: FrameInput) -> bool:
        """Until the next look, or until it is reached."""
        return frame.captured - self._chosen_at < _REPLAN_S and math.dist(place, scene.place) > ARRIVAL_M


@dataclass
class GainByDistance:
    """The place whose picture shows the most new ground for its distance."""

    side: float
    """Of a square as large as a picture on the ground, metres."""
    _gain: float = 0.0

    def choose(self, scene: Scene, frame: FrameInput) -> Place | None:
        """Return the best place of a lattice over where the drone may be."""
        gains = self._gains(scene)
        lattice = np.zeros(gains.shape, np.bool_)
        lattice[::_LATTICE, ::_LATTICE] = True
        cells = np.argwhere(lattice & (scene.field.allowed > 0) & (gains > PathPlanSettings().least_gain_m2))
        places = scene.places(cells)
        away = np.hypot(*(places - scene.place).T)
        cells, places, away = (values[away > _LEAST_STEP_M] for values in (cells, places, away))
        if len(cells) == 0:
            self._gain = 0.0
            return NearestFrontier().choose(scene, frame)
        best = int(np.argmax(gains[cells[:, 0], cells[:, 1]] / away))
        self._gain = float(gains[tuple(cells[best])])
        return float(places[best][0]), float(places[best][1])

    def keeps(self, scene: Scene, place: Place, frame: FrameInput) -> bool:  # noqa: ARG002
        """Return True until it is reached, or half of its promise was seen in flight."""
        if math.dist(place, scene.place) <= ARRIVAL_M:
            return False
        if self._gain == 0.0:
            return scene.is_frontier_near(place)
        column, row = np.round(scene.field.window.cells_of(np.array(place[0]), np.array(place[1]))).astype(int)
        shape = scene.unknown.shape
        if not (0 <= row < shape[0] and 0 <= column < shape[1]):
            return False
        return bool(self._gains(scene)[row, column] > self._gain / 2)

    def _gains(self, scene: Scene) -> NDArray[np.float32]:
        side = round(self.side / COARSE_M)
        summed = cv2.boxFilter(scene.unknown.astype(np.float32), -1, (side, side), normalize=False)
        return np.asarray(summed * COARSE_M**2, dtype=np.float32)


def _disc(swath: Swath) -> Disc:
    return Disc(swath.width, swath.width)


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
