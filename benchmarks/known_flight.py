"""Flights over known lots without pictures: the planner, the simulated body, and the ground that pictures show.

What lies in a picture without its edge is seen; the plan of a lot comes onto the map after some frames, moved by an
error of the receiver.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import cv2
import numpy as np
import shapely

from benchmarks.kinematic_drone import STEP_S, Drone, goal_of
from hawk.algo.frame import FrameInput
from hawk.algo.ground import Bools, CoarseLayers, Floats, Window
from hawk.algo.known_lot import plan_rectangles, tour_rectangles
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.path_plan.known_tour import boxes_of, corners_of
from hawk.algo.vision.rectify import ground_footprint
from hawk.model.known_lot import KnownLot, LotTour
from hawk.model.lot_map import Stall
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import Fence, HeightParameters, Inbound, PathPlan
from hawk.model.poses import MapPoint, MapPose

_FINE_M: Final = 0.4
FRAME_S: Final = 0.25
_AROUND_M: Final = 200.0
_EDGE_M: Final = 0.6
"""Edge of a picture that shows nothing to the mapper."""
_PLACED_AFTER: Final = 6
"""Frames after which a plan has its place."""


class SeenMap:
    """Knows which ground pictures have shown; plans come onto it after some frames, moved by ``off``."""

    def __init__(
        self, known: Sequence[KnownLot], camera: CameraModel, off: tuple[float, float] = (0.0, 0.0),
        new: tuple[Stall, ...] = (),
    ) -> None:  # fmt: skip
        """``new`` are stalls that no plan has."""
        plans = [plan_rectangles(lot) for lot in known]
        looked = [tour_rectangles(lot) for lot in known]
        places = np.concatenate([each.centres for each in looked])
        self.window = Window.around(np.stack([places.min(0), places.max(0)]), _FINE_M, _AROUND_M).aligned(4)
        self.seen = np.zeros(self.window.shape, np.float32)
        self.frames = 0
        self.new = new
        self._camera = camera
        self._values = {
            lot.id: np.column_stack([plan.centres + off, plan.angle, plan.width, plan.length])
            for lot, plan in zip(known, plans, strict=True)
        }
        self._corners = {
            lot.id: corners_of(boxes_of(each)) + np.array(off) for lot, each in zip(known, looked, strict=True)
        }
        self.whole_of: dict[str, Bools] = {
            lot.id: np.zeros(len(each), np.bool_) for lot, each in zip(known, looked, strict=True)
        }
        """Stalls, then places of sections (N,), of each lot that one picture has shown whole."""
        self.shown: set[int] = set()

    @property
    def whole(self) -> Bools:
        """Stalls of all lots that one picture has shown whole."""
        return np.concatenate(list(self.whole_of.values()))

    def look(self, pose: MapPose) -> None:
        """Take a picture."""
        corners = [(point.north, point.east) for point in ground_footprint(self._camera, pose)]
        picture = shapely.Polygon(corners).buffer(-_EDGE_M)
        outer = np.array(picture.exterior.coords)
        cells = self.window.cells_of(outer[:, 0], outer[:, 1])
        cv2.fillConvexPoly(self.seen, np.round(cells * 16).astype(np.int32), (1.0,), shift=4)
        for lot, stalls in self._corners.items():
            self.whole_of[lot] |= shapely.contains_xy(picture, stalls[..., 0], stalls[..., 1]).all(1)
        self.shown |= {stall.id for stall in self.new if picture.covers(shapely.Polygon(stall.corners()))}
        self.frames += 1

    def coarse(self, window: Window) -> CoarseLayers:
        """Return the ground that was seen, as every layer."""
        step = round(window.cell_m / _FINE_M)
        size = (self.window.columns // step, self.window.rows // step)
        small = np.asarray(cv2.resize(self.seen, size, interpolation=cv2.INTER_AREA), np.float32)
        top, left = window.row - self.window.row // step, window.column - self.window.column // step
        part = small[top : top + window.rows, left : left + window.columns]
        return CoarseLayers(window, part, part, part, part)

    def known_extent(self) -> Floats | None:
        """Nothing is explored here."""
        return None

    def lot_area_m2(self) -> float:
        """Nothing is explored here."""
        return 0.0

    def inbound(self, north: float, east: float) -> Inbound:  # noqa: ARG002 - the mapper's interface
        """No place is asked for in these flights."""
        return Inbound.UNKNOWN

    def unclear_stalls(self) -> Mapping[int, Stall]:
        """Nothing is flown to for a second look."""
        return {}

    def plan_places(self, lot: str) -> Floats | None:
        """Return the stalls of a plan, moved."""
        return self._values[lot] if self.frames > _PLACED_AFTER else None

    def stalls_near(self, north: float, east: float, radius: float) -> list[Stall]:
        """Return new stalls that a picture has shown."""
        return [s for s in self.new if s.id in self.shown and np.hypot(s.north - north, s.east - east) < radius]


@dataclass
class KnownFlight:
    """One flight over known lots, without wind and errors of position."""

    known: tuple[KnownLot, ...]
    tours: tuple[LotTour, ...]
    lot_map: SeenMap
    fence: Fence
    camera: CameraModel
    heights: HeightParameters = field(default_factory=HeightParameters)
    app: PathPlanApp = field(default_factory=PathPlanApp)
    distance_m: float = 0.0
    seconds: float = 0.0
    places: list[tuple[float, float]] = field(default_factory=list)
    plans: list[PathPlan] = field(default_factory=list)

    @property
    def last(self) -> PathPlan:
        """The newest plan."""
        return self.plans[-1]

    def fly(self, start: tuple[float, float] = (0.0, 0.0), most_s: float = 240.0) -> None:
        """Fly until the planner is done."""
        height = self.heights.bounded(self.heights.desired)
        drone = Drone(MapPose(*start, height, 0.0, 0.0, 0.0), self.fence, np.random.default_rng(0), 0.0)
        goal, plan = None, PathPlan()
        while drone.seconds < most_s and not plan.explore.done:
            pose = replace(drone.true, roll=0.0, pitch=0.0)
            goal = goal_of(plan, pose, goal)
            self.lot_map.look(pose)
            plan = self.app.plan(self._frame(pose, drone.speed), self.lot_map).path
            self.places.append((pose.north, pose.east))
            self.plans.append(plan)
            for _ in range(round(FRAME_S / STEP_S)):
                drone.step(goal)
        self.distance_m, self.seconds = drone.distance_m, drone.seconds

    def _frame(self, pose: MapPose, speed: float) -> FrameInput:
        number = len(self.places)
        return FrameInput(
            number, number * FRAME_S, b"", self.camera, pose, speed, StateName.AUTONOMOUS_EXPLORE, None, self.heights,
            self.fence, MapPoint(0.0, 0.0), known=self.known, tours=self.tours,
        )  # fmt: skip
