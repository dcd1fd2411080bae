"""One exploration: camera, vision, mapper and planner, flown by a point whose pose is as wrong as a real drone's."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from hawk.algo.frame import FrameInput, FrameOutput
from hawk.algo.manager import AlgorithmManagerApp
from hawk.algo.mapper.app import MapperApp
from hawk.algo.path_plan.app import PathPlanApp
from hawk.algo.topic_interface import AlgorithmTopicInterface, FrameCamera
from hawk.algo.vision.app import VisionApp
from hawk.algo.vision.seen import Seen
from hawk.algo.vision.settings import VisionSettings
from hawk.model import CameraModel, Fence, HeightParameters, MapPoint, MapPose, PathPlan, StateName
from hawk.sim.gps import Estimator
from hawk.sim.vehicle import Body
from hawk.survey.truth import Truth
from hawk.worlds.camera import WorldCamera
from hawk.worlds.world import World

FRAMES_PER_S = 5.0
SPEED_M_S = 4.0
ACCELERATION = 2.5
YAW_RATE = math.radians(60)
HEIGHT_M = 35.0
FENCE_M = 10.0
TIMEOUT_S = 900.0
PIXELS = (1280, 720)
FIELD_OF_VIEW = math.radians(70)
SHAKE = math.radians(0.7)
JPEG_QUALITY = (cv2.IMWRITE_JPEG_QUALITY, 85)


@dataclass(frozen=True, slots=True)
class Errors:
    """What is wrong with the pose: standard deviation of the slow error of GNSS (metres, as hawk-sim draws it, with
    those of barometer, attitude and compass), the height it tells by the true one, and a constant error of the compass
    (radians)."""

    gnss_m: float = 1.0
    height: float = 1.0
    compass: float = 0.0


@dataclass(frozen=True, slots=True)
class Glance:
    """One frame: what vision saw in it, and how far (metres north and east) the pose it was laid by is off."""

    seen: Seen
    off: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Flown:
    """``frame_ms`` and ``mapper_ms`` are milliseconds of every frame; ``way`` metres."""

    output: FrameOutput
    way: float
    seconds: float
    frame_ms: NDArray[np.float64]
    mapper_ms: NDArray[np.float64]
    finished: bool


@dataclass(slots=True)
class Drone:
    """A point that flies to targets with limited speed, acceleration and turn rate. Metres, map frame.

    It is told where it should be in the words of an estimate that is ``off`` (north, east, yaw) from the truth.
    """

    north: float = 0.0
    east: float = 0.0
    yaw: float = 0.0
    speed_north: float = 0.0
    speed_east: float = 0.0
    way: float = 0.0

    def step(self, plan: PathPlan, dt: float, off: tuple[float, float, float]) -> None:
        """Fly towards the plan's target for ``dt`` seconds."""
        wanted = np.zeros(2)
        if plan.target is not None:
            target = plan.target.north - off[0], plan.target.east - off[1]
            offset = np.array([target[0] - self.north, target[1] - self.east])
            distance = float(np.hypot(*offset))
            if distance > 0.05:
                speed = min(SPEED_M_S, math.sqrt(2 * ACCELERATION * 0.7 * distance))
                wanted = offset / distance * speed
        change = wanted - (self.speed_north, self.speed_east)
        size = float(np.hypot(*change))
        if size > ACCELERATION * dt:
            change *= ACCELERATION * dt / size
        self.speed_north += float(change[0])
        self.speed_east += float(change[1])
        self.north += self.speed_north * dt
        self.east += self.speed_east * dt
        self.way += math.hypot(self.speed_north, self.speed_east) * dt
        if plan.yaw is not None:
            turn = math.remainder(plan.yaw - off[2] - self.yaw, math.tau)
            self.yaw += max(-YAW_RATE * dt, min(YAW_RATE * dt, turn))

    def body(self, roll: float, pitch: float) -> Body:
        """Return the true state as the simulator's sensors take it."""
        velocity = (self.speed_north, self.speed_east, 0.0)
        return Body((self.north, self.east, -HEIGHT_M), velocity, roll, pitch, self.yaw, on_ground=False)


def fly(
    world: World,
    truth: Truth,
    vision: VisionApp | None = None,
    errors: Errors | None = None,
    seed: int = 0,
    watch: Callable[[Glance], None] = lambda _: None,
) -> Flown:
    """Fly one exploration; ``watch`` is given every frame that was laid on the ground."""
    errors = errors or Errors()
    vision = vision or VisionApp(VisionSettings())
    manager, camera_model = _manager(vision), camera()
    eye = WorldCamera(world, camera_model)
    rng = np.random.default_rng(seed)
    estimator = Estimator(errors.gnss_m, 0.0, np.random.default_rng((seed, 1)))
    estimator.exact = errors.gnss_m == 0.0
    x0, y0 = world.start()
    drone, fence = Drone(), _fence(truth, x0, y0)
    costs: list[tuple[float, float]] = []
    dt, finished = 1 / FRAMES_PER_S, False
    for sequence in range(int(TIMEOUT_S * FRAMES_PER_S)):
        roll, pitch = rng.normal(0, SHAKE, 2).tolist()
        picture = eye.render(x0 + drone.east, y0 - drone.north, HEIGHT_M, roll, pitch, drone.yaw, rng=rng)
        told = estimator.step(drone.body(roll, pitch), dt)
        north, east, down = told.position
        pose = MapPose(north, east, -down * errors.height, told.roll, told.pitch, told.yaw + errors.compass)
        output = manager.run(_frame(sequence, dt, picture, camera_model, pose, drone, fence))
        timings = dict(output.timings)
        costs.append((timings["all"], timings["mapper"]))
        off = north - drone.north, east - drone.east
        if vision.seen is not None:
            watch(Glance(vision.seen, off))
        finished = output.path_plan.explore.done
        if finished:
            break
        drone.step(output.path_plan, dt, (*off, pose.yaw - drone.yaw))
    frame_ms, mapper_ms = np.array(costs).T
    return Flown(output, drone.way, len(costs) * dt, frame_ms, mapper_ms, finished)


def camera() -> CameraModel:
    """Return the camera that is flown."""
    width, height = PIXELS
    focal = width / 2 / math.tan(FIELD_OF_VIEW / 2)
    return CameraModel(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)


def _manager(vision: VisionApp) -> AlgorithmManagerApp:
    interface, manager = AlgorithmTopicInterface(), AlgorithmManagerApp()
    manager.init(interface, vision, MapperApp(map_id="chain"), PathPlanApp(), FrameCamera(interface))
    return manager


def _frame(
    sequence: int,
    dt: float,
    picture: NDArray[np.uint8],
    model: CameraModel,
    pose: MapPose,
    drone: Drone,
    fence: Fence,
) -> FrameInput:
    return FrameInput(
        sequence=sequence,
        captured=sequence * dt,
        jpeg=cv2.imencode(".jpg", picture, JPEG_QUALITY)[1].tobytes(),
        camera=model,
        pose=pose,
        speed=math.hypot(drone.speed_north, drone.speed_east),
        state=StateName.AUTONOMOUS_EXPLORE,
        desired=None,
        heights=HeightParameters(15, HEIGHT_M, 60),
        fence=fence,
        home=MapPoint(0, 0),
    )


def _fence(truth: Truth, x0: float, y0: float) -> Fence:
    lots = shapely.union_all([shapely.Polygon(lot).buffer(0) for lot in truth.lots])
    area = lots.buffer(FENCE_M)
    outer = area if area.geom_type == "Polygon" else area.convex_hull
    ring = tuple((float(y0 - y), float(x - x0)) for x, y in np.asarray(outer.simplify(0.5).exterior.coords)[:-1])
    return Fence(ring, ring, 97.0, 100.0)
