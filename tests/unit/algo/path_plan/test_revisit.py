from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
import pytest
import shapely

from benchmarks.kinematic_drone import STEP_S, Drone, goal_of
from hawk.algo.frame import outcome
from hawk.algo.ground import CoarseLayers, Floats, Window
from hawk.algo.known_lot import plan_rectangles
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.path_plan.known_tour import boxes_of, corners_of, lot_tour
from hawk.algo.vision.rectify import ground_footprint
from hawk.model.known_lot import KnownLot, KnownStall, LotTour
from hawk.model.lot_map import Stall, StallState
from hawk.model.plans import Fence, HeightParameters, Inbound, PathPlan
from hawk.model.poses import MapPose
from tests.unit.algo.path_plan.flight import LEVEL
from tests.unit.algo.synthetic import CAMERA, frame_at

_FINE_M = 0.4
_FRAME_S = 0.25
RING = ((-150.0, -150.0), (-150.0, 150.0), (150.0, 150.0), (150.0, -150.0))
FENCE = Fence(RING, RING, 97.0, 100.0)


class SeenMap:
    """Knows which ground pictures have shown; the plan comes onto it after some frames, moved by ``off``."""

    def __init__(self, known: KnownLot, off: tuple[float, float], new: tuple[Stall, ...]) -> None:
        self.window = Window.around(np.array([[-200.0, -200.0], [200.0, 200.0]]), _FINE_M).aligned(4)
        self.seen = np.zeros(self.window.shape, np.float32)
        self.frames = 0
        self.known, self.new = known, new
        plan = plan_rectangles(known)
        self.values = np.column_stack([plan.centres + off, plan.angle, plan.width, plan.length])
        self.corners = corners_of(boxes_of(plan)) + np.array(off)
        self.whole = np.zeros(len(self.corners), np.bool_)
        self.shown: set[int] = set()

    def look(self, pose: MapPose) -> None:
        """Take a picture; its edge of 0.6 m shows nothing."""
        picture = shapely.Polygon([(p.north, p.east) for p in ground_footprint(CAMERA, pose)]).buffer(-0.6)
        corners = np.array(picture.exterior.coords)
        cells = self.window.cells_of(corners[:, 0], corners[:, 1])
        cv2.fillConvexPoly(self.seen, np.round(cells * 16).astype(np.int32), (1.0,), shift=4)
        self.whole |= shapely.contains_xy(picture, self.corners[..., 0], self.corners[..., 1]).all(1)
        self.shown |= {stall.id for stall in self.new if picture.covers(shapely.Polygon(stall.corners()))}
        self.frames += 1

    def coarse(self, window: Window) -> CoarseLayers:
        step = round(window.cell_m / _FINE_M)
        size = (self.window.columns // step, self.window.rows // step)
        small = np.asarray(cv2.resize(self.seen, size, interpolation=cv2.INTER_AREA), np.float32)
        top, left = window.row - self.window.row // step, window.column - self.window.column // step
        part = small[top : top + window.rows, left : left + window.columns]
        return CoarseLayers(window, part, part, part, part)

    def known_extent(self) -> Floats | None:
        return None

    def lot_area_m2(self) -> float:
        return 0.0

    def inbound(self, north: float, east: float) -> Inbound:
        return Inbound.UNKNOWN

    def unclear_stalls(self) -> Mapping[int, Stall]:
        return {}

    def plan_places(self, lot: str) -> Floats | None:
        return self.values if self.frames > 6 and lot == self.known.id else None

    def stalls_near(self, north: float, east: float, radius: float) -> list[Stall]:
        return [s for s in self.new if s.id in self.shown and np.hypot(s.north - north, s.east - east) < radius]


@dataclass
class Flight:
    known: KnownLot
    tour: LotTour
    lot_map: SeenMap
    fence: Fence
    distance_m: float = 0.0
    places: list[tuple[float, float]] = field(default_factory=list)
    last: PathPlan = field(default_factory=PathPlan)
    app: PathPlanApp = field(default_factory=lambda: PathPlanApp(LEVEL))

    def fly(self, start: tuple[float, float] = (0.0, 0.0), most_s: float = 240.0) -> None:
        """Fly until the planner is done."""
        drone = Drone(MapPose(*start, 35.0, 0.0, 0.0, 0.0), self.fence, np.random.default_rng(0), 0.0)
        goal, plan = None, PathPlan()
        while drone.seconds < most_s and not plan.explore.done:
            pose = replace(drone.true, roll=0.0, pitch=0.0)
            goal = goal_of(plan, pose, goal)
            self.lot_map.look(pose)
            frame = frame_at(pose, len(self.places), fence=self.fence, interval=_FRAME_S)
            plan = self.app.plan(
                replace(frame, speed=drone.speed, known=(self.known,), tours=(self.tour,)), self.lot_map
            ).path
            self.places.append((pose.north, pose.east))
            for _ in range(round(_FRAME_S / STEP_S)):
                drone.step(goal)
        self.distance_m, self.last = drone.distance_m, plan


def lot_of(rows: int = 4, stalls: int = 24) -> KnownLot:
    """Return rows of stalls east and north of the origin."""
    row, number = np.divmod(np.arange(rows * stalls), stalls)
    places = np.column_stack([row * 11.0, number * 2.6]).tolist()
    return KnownLot("a lot", tuple(KnownStall(str(k), at[0], at[1], 0.0, 2.5, 5.0) for k, at in enumerate(places)), ())


def flight(
    known: KnownLot | None = None,
    off: tuple[float, float] = (0.0, 0.0),
    new: tuple[Stall, ...] = (),
    fence: Fence = FENCE,
) -> Flight:
    known = known or lot_of()
    tour = outcome(lot_tour(known, CAMERA, HeightParameters(15.0, 35.0, 60.0), fence, (0.0, 0.0), LEVEL))
    return Flight(known, tour, SeenMap(known, off, new), fence)


@pytest.mark.slow
@pytest.mark.parametrize("off", [(0.0, 0.0), (3.5, -2.5)])
def test_every_stall_is_looked_at_in_little_more_than_the_planned_distance(off: tuple[float, float]) -> None:
    flown = flight(off=off)
    flown.fly()
    assert flown.last.explore.done
    assert flown.last.explore.seen == 1.0
    assert flown.lot_map.whole.all()
    assert flown.distance_m < 1.12 * flown.tour.distance_m + 8.0


class SeenInParts(SeenMap):
    """Pictures have shown all ground from the second frame on, but no stall in one picture."""

    def look(self, pose: MapPose) -> None:
        super().look(pose)
        if self.frames > 1:
            self.seen[:] = 1.0


@pytest.mark.slow
def test_stalls_that_pictures_have_shown_in_parts_alone_are_looked_at() -> None:
    flown = flight(off=(1.5, -1.0))
    flown.lot_map = SeenInParts(flown.known, (1.5, -1.0), ())
    flown.fly()
    assert flown.last.explore.done
    assert flown.lot_map.whole.all()


@pytest.mark.slow
def test_after_a_battery_swap_only_the_rest_is_flown() -> None:
    flown = flight()
    flown.fly(most_s=0.6 * flown.tour.distance_m / 5.0)
    assert not flown.last.explore.done
    left = int((~flown.lot_map.whole).sum())
    planned = flown.tour.distance_m
    again = Flight(flown.known, flown.tour, flown.lot_map, flown.fence)
    again.fly()
    assert left > 0
    assert flown.lot_map.whole.mean() > 0.97  # of the flight before, cells of 1.6 m are known
    assert again.distance_m < planned + 8.0


@pytest.mark.slow
def test_the_drone_stays_inside_the_fence_and_out_of_its_zones_and_says_what_it_missed() -> None:
    zone = ((-20.0, 10.0), (-20.0, 16.0), (30.0, 16.0), (30.0, 10.0))
    ring = ((-25.0, -25.0), (-25.0, 30.0), (60.0, 30.0), (60.0, -25.0))
    flown = flight(fence=Fence(ring, ring, 97.0, 100.0, zones=(zone,), autopilot_zones=(zone,)))
    flown.fly()
    allowed = shapely.Polygon(ring).difference(shapely.Polygon(zone)).buffer(1.5)
    assert shapely.contains_xy(allowed, *np.array(flown.places).T).all()
    assert flown.last.explore.done
    assert flown.last.explore.seen < 1.0
    assert flown.last.explore.unreached


def _new(number: int, north: float, east: float) -> Stall:
    return Stall(number, north, east, 0.0, 2.5, 5.0, 0.1, StallState.FREE, 0.9, 5, 1.0, 1)


@pytest.mark.slow
def test_a_row_that_goes_on_beyond_the_plan_is_followed() -> None:
    new = tuple(_new(k, -11.0, -k * 2.6) for k in range(24))
    flown = flight(new=new)
    flown.fly()
    assert flown.lot_map.whole.all()
    assert len(flown.lot_map.shown) > 15  # of 24: 120 m of flight at most
    assert flown.distance_m < flown.tour.distance_m + 180.0


@pytest.mark.slow
def test_without_the_plan_of_its_lot_a_tour_is_not_flown() -> None:
    flown = flight()
    frame = frame_at(MapPose(0.0, 0.0, 35.0, 0.0, 0.0, 0.0), 0, fence=FENCE)
    plan = flown.app.plan(replace(frame, known=(), tours=(flown.tour,)), flown.lot_map).path
    assert plan.target is None
    assert plan.explore.reason == "nothing is mapped yet"
