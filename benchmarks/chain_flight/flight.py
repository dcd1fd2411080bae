"""One exploration: camera, vision, mapper and planner on hawk-sim's body, with a pose as wrong as a real drone's."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.exploration.lots import Lot
from benchmarks.frames import FIELD_OF_VIEW, PIXELS, camera_model, encoded, frame_of
from benchmarks.kinematic_drone import Drone, goal_of
from benchmarks.world_lots import joined, rings_about
from hawk.algo.frame import FrameOutput
from hawk.algo.manager import AlgorithmManagerApp
from hawk.algo.mapper.app import MapperApp
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.algo.vision.app import VisionApp, VisionSettings
from hawk.algo.vision.detection import FrameGround
from hawk.ddc.motion import Goal
from hawk.model.known_lot import KnownLot, LotTour
from hawk.model.pictures import CameraModel
from hawk.model.plans import Fence, HeightParameters, PathPlan
from hawk.model.poses import MapPoint, MapPose
from hawk.survey.truth import GroundTruth
from hawk.worlds.camera import WorldCamera
from hawk.worlds.world import World

FRAME_TICKS = 4
"""Ticks of the drone from frame to frame: five a second; a plan leads it when the next frame is taken."""
HEIGHT_M = 35.0
FENCE_M = 10.0
TIMEOUT_S = 900.0
HEIGHTS = HeightParameters(15, HEIGHT_M, 60)


@dataclass(frozen=True, slots=True)
class Errors:
    """Errors of the pose: standard deviation of the slow error of GNSS (metres, as hawk-sim draws it, with those of
    barometer, attitude and compass), reported height by true height, and a constant error of the compass (radians).
    """

    gnss_m: float = 1.0
    height: float = 1.0
    compass: float = 0.0

    def reported(self, pose: MapPose) -> MapPose:
        """Return the pose that the algorithms get in place of the autopilot's estimate."""
        return replace(pose, height=pose.height * self.height, yaw=pose.yaw + self.compass)

    def led(self, goal: Goal | None) -> Goal | None:
        """Return the goal that the drone flies to: at its own height, with its own compass."""
        return None if goal is None else replace(goal, height=HEIGHT_M, yaw=goal.yaw - self.compass)


@dataclass(frozen=True, slots=True)
class Glance:
    """One frame: vision's result, and the error of its pose (metres north and east)."""

    seen: FrameGround
    off: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Flown:
    """``frame_ms`` and ``mapper_ms`` are milliseconds of every frame; ``distance_m`` the true path."""

    output: FrameOutput
    distance_m: float
    seconds: float
    frame_ms: NDArray[np.float64]
    mapper_ms: NDArray[np.float64]
    finished: bool


def fly(
    world: World,
    lot: Lot,
    vision: VisionApp | None = None,
    errors: Errors | None = None,
    seed: int = 0,
    watch: Callable[[Glance], None] = lambda _: None,
    known: KnownLot | None = None,
    tour: LotTour | None = None,
) -> Flown:
    """Fly one exploration of a world whose lots are ``lot`` (`lot_of`); ``watch`` gets every frame that was projected
    to the ground. ``known`` is the plan of the lot, ``tour`` that over the known lot.
    """
    errors = errors or Errors()
    vision = vision or VisionApp(VisionSettings())
    manager, model = _manager(vision), camera()
    eye = WorldCamera(world, model)
    rng = np.random.default_rng(seed)
    x0, y0 = world.start()
    start = MapPose(*lot.start, HEIGHT_M, 0.0, 0.0, lot.yaw)
    drone = Drone(start, lot.fence, np.random.default_rng((seed, 1)), errors.gnss_m)
    costs: list[tuple[float, float]] = []
    goal, waiting = None, PathPlan()
    while not waiting.explore.done and drone.seconds < TIMEOUT_S:
        true, pose = drone.true, errors.reported(drone.believed)
        goal = goal_of(waiting, pose, goal)
        picture = eye.render(x0 + true.east, y0 - true.north, true.height, true.roll, true.pitch, true.yaw, rng=rng)
        frame = frame_of(
            len(costs), drone.seconds, model, pose, jpeg=encoded(picture), speed=drone.speed, fence=lot.fence,
            heights=HEIGHTS, home=MapPoint(0, 0), known=known, tour=tour,
        )  # fmt: skip
        output = manager.run(frame)
        timings = dict(output.timings)
        costs.append((timings["all"], timings["mapper"]))
        if vision.seen.ground is not None:
            watch(Glance(vision.seen.ground, (pose.north - true.north, pose.east - true.east)))
        waiting = output.path_plan
        led = errors.led(goal)
        for _ in range(FRAME_TICKS):
            drone.step(led)
    frame_ms, mapper_ms = np.array(costs).T
    return Flown(output, drone.distance_m, drone.seconds, frame_ms, mapper_ms, waiting.explore.done)


def camera() -> CameraModel:
    """Return the camera that is flown."""
    return camera_model(*PIXELS, focal=PIXELS[0] / 2 / math.tan(FIELD_OF_VIEW / 2))


def _manager(vision: VisionApp) -> AlgorithmManagerApp:
    interface, manager = AlgorithmTopicInterface(), AlgorithmManagerApp()
    manager.init(interface, vision, MapperApp(map_id="chain"), PathPlanApp(), FrameCamera(interface))
    return manager


def lot_of(truth: GroundTruth, start: tuple[float, float]) -> Lot:
    """Return the world's lots as one, in the map's frame, with the fence about them; ``start`` is the world's own."""
    lots = joined(rings_about(truth.lots, start))
    area = lots.buffer(FENCE_M)
    outer = area if area.geom_type == "Polygon" else area.convex_hull
    ring = tuple((float(north), float(east)) for north, east in outer.simplify(0.5).exterior.coords[:-1])
    return Lot(0, "world", lots, (0.0, 0.0), 0.0, Fence(ring, ring, 97.0, 100.0))
