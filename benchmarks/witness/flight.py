"""A drawn flight: hawk-sim's body and estimate under wind, a camera over a drawn world, and the steps that it sees."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.kinematic_drone import STEP_S, Drone
from hawk.algo.frame import FrameInput
from hawk.algo.vision.odometry import Odometry
from hawk.ddc.motion import Goal
from hawk.model.operation import StateName
from hawk.model.pictures import CameraModel, GroundStep
from hawk.model.plans import Fence, HeightParameters
from hawk.model.poses import MapPose
from hawk.sim.vehicle import Wind
from hawk.worlds.camera import Lens, WorldCamera
from hawk.worlds.world import World

WIDTH, HEIGHT = 320, 180
"""Pixels of a picture: as large as the odometry compares."""
FIELD_OF_VIEW: Final = math.radians(70.0)
FRAME_TICKS: Final = 8
"""Ticks of the drone from picture to picture, unless a setting says otherwise: 2.5 a second."""
FENCE_M: Final = 400.0
NEAR_M: Final = 1.5
"""A place is reached within this distance, metres."""
GNSS_SIGMA_M: Final = 0.2
"""Slow error of the estimate besides the receiver's, metres."""
TRUCK_M: Final = (9.0, 2.6, 3.0)
"""Length, width and height of a truck that passes, metres."""

Flat = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Wander:
    """Error of an honest receiver: Gauss-Markov with a standard deviation (metres, each axis) and a time (seconds)."""

    sigma_m: float = 0.0
    time_s: float = 600.0


@dataclass(frozen=True, slots=True)
class Leg:
    """Hold for ``hold_s`` seconds at the place (north, east; metres from the start), which is flown to first."""

    place: Flat
    hold_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Setting:
    """Settings that a flight is drawn from.

    ``offset`` is the start from the lot's middle (north, east), metres. ``walk`` of GNSS begins at ``walk_at`` seconds.
    ``height_factor`` and ``compass`` (radians) are errors of the reported pose, ``late_s`` of the pictures' times.
    ``truck_s`` is the usual time between two trucks that pass; 0: none. ``blind``: every such comparison is missing.
    """

    seed: int
    legs: tuple[Leg, ...]
    height_m: float = 25.0
    offset: Flat = (0.0, 0.0)
    wind_m_s: float = 0.0
    wander: Wander = field(default_factory=Wander)
    walk: Flat = (0.0, 0.0)
    walk_at: float = math.inf
    height_factor: float = 1.0
    compass: float = 0.0
    late_s: float = 0.0
    truck_s: float = 0.0
    blind: int = 0
    limit_s: float = 600.0
    frame_ticks: int = FRAME_TICKS


@dataclass(frozen=True, slots=True)
class Glance:
    """One picture's comparison, or None; ``gone``: metres by which the drone left its place since the walk began."""

    time: float
    step: GroundStep | None
    gone: float


def camera() -> CameraModel:
    """Return the camera that is flown."""
    focal = WIDTH / 2 / math.tan(FIELD_OF_VIEW / 2)
    return CameraModel(WIDTH, HEIGHT, focal, focal, (WIDTH - 1) / 2, (HEIGHT - 1) / 2)


def poor(world: World) -> World:
    """Return the world with little texture: nothing stands on it, and its ground has two fifths of its contrast."""
    ground = cv2.GaussianBlur(world.ground, (0, 0), 0.12 / world.metres_per_pixel).astype(np.float32)
    pale = 110.0 + 0.4 * (ground - ground.mean())
    return replace(world, ground=np.clip(pale, 0, 255).astype(np.uint8), layers=())


class Flight:
    """Flies a setting over a world, picture by picture."""

    def __init__(self, world: World, setting: Setting) -> None:
        self._world, self._setting = world, setting
        self._eye = WorldCamera(world, camera(), Lens(blur=0.0, noise=1.5))
        self._rng = np.random.default_rng((setting.seed, 11))
        middle = np.mean([stall.corners.mean(0) for stall in world.stalls], 0)
        self._origin = (float(middle[0]) + setting.offset[1], float(middle[1]) - setting.offset[0])
        ring = tuple((n * FENCE_M, e * FENCE_M) for n, e in ((1, 1), (1, -1), (-1, -1), (-1, 1)))
        start = MapPose(*setting.legs[0].place, setting.height_m, 0.0, 0.0, float(self._rng.uniform(-math.pi, math.pi)))
        wind = Wind(setting.wind_m_s, float(self._rng.uniform(0, math.tau)), np.random.default_rng((setting.seed, 12)))
        rng = np.random.default_rng((setting.seed, 13))
        self._drone = Drone(start, Fence(ring, ring, 97.0, 100.0), rng, GNSS_SIGMA_M, wind)
        self._yaw = start.yaw
        self._odometry = Odometry()
        self._error = self._rng.normal(0.0, 1.0, 2) * setting.wander.sigma_m
        self._right: Flat | None = None
        self._trucks = _Trucks(setting, np.random.default_rng((setting.seed, 14)))
        self._late: deque[MapPose] = deque(maxlen=1 + round(setting.late_s / STEP_S))
        self._count = 0

    def glances(self) -> Iterator[Glance]:
        """Yield the flight's comparisons, until its last leg is flown or its time is over."""
        for leg in self._setting.legs:
            goal = Goal(*leg.place, self._setting.height_m, self._yaw)
            yield from self._until_there(goal)
            until = self._drone.seconds + leg.hold_s
            while self._drone.seconds < min(until, self._setting.limit_s):
                yield self._glance(goal)

    def _until_there(self, goal: Goal) -> Iterator[Glance]:
        while self._drone.seconds < self._setting.limit_s:
            here = self._drone.believed
            if math.hypot(goal.north - here.north, goal.east - here.east) <= NEAR_M:
                return
            yield self._glance(goal)

    def _glance(self, goal: Goal) -> Glance:
        for _ in range(self._setting.frame_ticks):
            self._err()
            self._drone.step(goal)
            self._late.append(self._drone.true)
        self._count += 1
        believed, setting = self._drone.believed, self._setting
        reported = replace(believed, height=believed.height * setting.height_factor, yaw=believed.yaw + setting.compass)
        picture = self._picture(self._late[0])
        if setting.blind and self._count % setting.blind == 0:
            picture = np.full_like(picture, 90)
        step = self._odometry.look(_frame(self._count, self._drone, reported), picture)
        return Glance(self._drone.seconds, step, self._gone())

    def _gone(self) -> float:
        """Return how far the estimate has gone wrong since the walk began, metres."""
        true, believed = self._drone.true, self._drone.believed
        error = believed.north - true.north, believed.east - true.east
        if self._drone.seconds < self._setting.walk_at:
            self._right = error
        return 0.0 if self._right is None else math.dist(error, self._right)

    def _err(self) -> None:
        """Let the receiver wander and walk for a tick."""
        setting, keep = self._setting, math.exp(-STEP_S / self._setting.wander.time_s)
        fresh = setting.wander.sigma_m * math.sqrt(1.0 - keep * keep)
        error = self._error * keep + fresh * self._rng.standard_normal(2)
        rate, self._error = (error - self._error) / STEP_S, error
        walks = self._drone.seconds >= setting.walk_at
        north, east = setting.walk if walks else (0.0, 0.0)
        self._drone.receiver.walk = (float(rate[0]) + north, float(rate[1]) + east)

    def _picture(self, true: MapPose) -> NDArray[np.uint8]:
        x, y = self._origin[0] + true.east, self._origin[1] - true.north
        pose = (x, y, true.height, true.roll, true.pitch, true.yaw)
        picture = self._eye.render(*pose, rng=self._rng)
        self._trucks.draw(picture, self._eye.projection(*pose), self._drone.seconds, (x, y))
        return picture


class _Trucks:
    """Trucks that pass below, one after the other."""

    def __init__(self, setting: Setting, rng: np.random.Generator) -> None:
        self._setting, self._rng = setting, rng
        self._skin = rng.integers(60, 230, (12, 40, 3), np.uint8).repeat(4, 0).repeat(4, 1)
        self._next = float(rng.exponential(setting.truck_s)) if setting.truck_s else math.inf
        self._from: NDArray[np.float64] | None = None
        self._velocity, self._began = np.zeros(2), 0.0

    def draw(self, picture: NDArray[np.uint8], projection: NDArray[np.float64], now: float, below: Flat) -> None:
        """Draw the truck of this moment onto the picture."""
        if now >= self._next:
            heading = float(self._rng.uniform(0, math.tau))
            along = np.array([math.cos(heading), math.sin(heading)])
            aside = np.array([-along[1], along[0]]) * float(self._rng.uniform(-6.0, 6.0))
            self._velocity, self._began = along * float(self._rng.uniform(2.0, 9.0)), now
            self._from = np.array(below) - along * 30.0 + aside
            self._next = (
                now + 60.0 / float(np.hypot(*self._velocity)) + float(self._rng.exponential(self._setting.truck_s))
            )
        if self._from is None:
            return
        along = self._velocity / np.hypot(*self._velocity)
        side = np.array([-along[1], along[0]])
        at = self._from + self._velocity * (now - self._began)
        length, width, tall = TRUCK_M
        corners = np.array([at + a * length / 2 * along + b * width / 2 * side for a, b in _CORNERS])
        points = np.column_stack([corners, np.full(4, tall), np.ones(4)]) @ projection.T
        if (points[:, 2] <= 0).any():
            return
        target = (points[:, :2] / points[:, 2:]).astype(np.float32)
        rows, columns = self._skin.shape[:2]
        source = np.array([[0, 0], [columns, 0], [columns, rows], [0, rows]], np.float32)
        size = (picture.shape[1], picture.shape[0])
        warp = cv2.getPerspectiveTransform(source, target)
        skin = cv2.warpPerspective(self._skin, warp, size)
        mask = cv2.warpPerspective(np.full((rows, columns), 255, np.uint8), warp, size)
        cv2.copyTo(skin, mask, picture)


_CORNERS: Final = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def lanes(width: float, length: float, apart: float) -> Sequence[Leg]:
    """Return the legs of a survey in lanes about the start, metres."""
    legs, forth = [], True
    for k in range(math.floor(width / apart) + 1):
        east = -width / 2 + k * apart
        ends = (-length / 2, length / 2) if forth else (length / 2, -length / 2)
        legs += [Leg((end, east)) for end in ends]
        forth = not forth
    return legs


def _frame(number: int, drone: Drone, reported: MapPose) -> FrameInput:
    return FrameInput(
        sequence=number,
        captured=drone.seconds,
        jpeg=b"",
        camera=camera(),
        pose=reported,
        speed=drone.speed,
        state=StateName.HOVER,
        desired=None,
        heights=HeightParameters(),
        fence=None,
        home=None,
    )
