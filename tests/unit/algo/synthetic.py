"""A lot with known truth, and a vision that sees it: exactly, or with the faults that a test asks for."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.frame import FrameInput
from hawk.algo.vision.detection import Detection, FrameGround, GroundImage, VisionResult
from hawk.model.operation import Health, StateName
from hawk.model.pictures import CameraModel
from hawk.model.plans import DesiredPose, Fence, HeightParameters
from hawk.model.poses import MapPoint, MapPose

CAMERA = CameraModel(width=1280, height=720, fx=914.0, fy=914.0, cx=639.5, cy=359.5)
"""About 70 degrees wide."""
LAYER_M = 0.2
PICTURE_M = 0.1


@dataclass(frozen=True)
class Truth:
    """``lot`` is a polygon (N, 2) of (north, east); ``stalls`` (N, 5): north, east, angle, width, length."""

    lot: NDArray[np.float64]
    stalls: NDArray[np.float64]
    taken: NDArray[np.bool_]


def rows_lot(rows: int = 2, columns: int = 20, turn: float = 0.0, middle: tuple[float, float] = (0.0, 0.0)) -> Truth:
    """Double rows of 2.6 x 5.2 m stalls with 7 m aisles on both sides, turned about the middle; a third is taken."""
    pitch, length, aisle = 2.6, 5.2, 7.0
    across = []
    at = aisle
    for _ in range(rows):
        across += [at + length / 2, at + 1.5 * length]
        at += 2 * length + aisle
    depth, width = at, columns * pitch + 2 * aisle
    along = aisle + (np.arange(columns) + 0.5) * pitch
    east, north = np.meshgrid(along - width / 2, np.array(across) - depth / 2)
    c, s = math.cos(turn), math.sin(turn)
    places = np.stack([north.ravel() * c - east.ravel() * s, north.ravel() * s + east.ravel() * c], -1) + middle
    box = np.array([[-depth, -width], [depth, -width], [depth, width], [-depth, width]]) / 2
    lot = box @ np.array([[c, s], [-s, c]]) + middle
    count = len(places)
    columns_ = [np.full(count, turn % math.pi), np.full(count, pitch), np.full(count, length)]
    return Truth(lot, np.column_stack([places, *columns_]), np.arange(count) % 3 == 0)


@dataclass
class SyntheticVision:
    """Sees the truth through `CAMERA`, level, from the frame's pose plus ``pose_error`` metres.

    ``layers`` False leaves the rasters blank but for the lot, which is faster.
    """

    truth: Truth
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))
    noise_m: float = 0.0
    miss: float = 0.0
    pose_error: tuple[float, float] = (0.0, 0.0)
    state_error: float = 0.0
    false_alarms: list[tuple[float, float]] = field(default_factory=list)
    seen: VisionResult = field(default_factory=VisionResult)
    fault: Exception | None = None
    topic_interface: Any = None
    with_picture: bool = False
    true_height: float | None = None
    """True height of the drone, whatever the pose says: seen ground is projected too large or small by it."""

    def init(self, drone_camera: Any, topic_interface: Any) -> None:
        self.topic_interface = topic_interface

    def see(self, frame: FrameInput) -> VisionResult:
        if self.fault is not None:
            raise self.fault
        image = np.full((720, 1280, 3), 90, np.uint8)
        ground = None if frame.pose is None else self.look(frame.pose, frame.captured)
        self.seen = VisionResult(ground is not None and len(ground.stalls) >= 3, Health(), image, ground)
        return self.seen

    def fail(self, reason: str) -> VisionResult:
        return VisionResult(health=Health.bad(reason), image=self.seen.image)

    def process(self) -> None:
        self.see(self.topic_interface.frame)

    def publish(self) -> None:
        self.topic_interface.park_lot_detected_pub.publish(self.seen.park_lot_detected)
        self.topic_interface.vision_app_health_pub.publish(self.seen.health)

    def look(self, pose: MapPose, captured: float) -> FrameGround:
        """Return the sightings: placed by ``pose``, with the light from the drone's true place."""
        real = replace(pose, north=pose.north + self.pose_error[0], east=pose.east + self.pose_error[1])
        if self.true_height is not None:
            truth = stretched(self.truth, (real.north, real.east), pose.height / self.true_height)
            return replace(self, truth=truth, true_height=None).look(pose, captured)
        lot, corners = self._lot(pose, real)
        stalls = self._stalls(real, lot)
        core = replace(lot, values=self._drawn(lot, corners, 0.74))
        car = replace(lot, values=self._drawn(lot, corners[self.truth.taken], 0.8))
        return FrameGround(tuple(stalls), lot, car, core, car, self._picture(pose), pose, captured)

    def _lot(self, pose: MapPose, real: MapPose) -> tuple[GroundImage, NDArray[np.float64]]:
        shape = (round(pose.height * 720 / 914 / LAYER_M), round(pose.height * 1280 / 914 / LAYER_M))
        blank = GroundImage(np.zeros(shape, np.float32), ground_affine(pose, shape, LAYER_M), np.ones(shape, np.bool_))
        moved = np.array([pose.north - real.north, pose.east - real.east])
        values = blank.values.copy()
        cv2.fillPoly(values, [np.round(blank.pixel_points(self.truth.lot + moved)).astype(np.int32)], [1.0])
        corners = stall_corners(self.truth.stalls) + moved
        return replace(blank, values=np.clip(values, 0.03, 0.97)), corners

    def _drawn(self, image: GroundImage, corners: NDArray[np.float64], share: float) -> NDArray[np.float32]:
        values = np.zeros(image.valid.shape, np.float32)
        centre = corners.mean(1, keepdims=True)
        quads = image.pixel_points(centre + (corners - centre) * share)
        rows, columns = image.valid.shape
        in_sight = (quads.max(1) > -1).all(1) & (quads.min(1) < (columns, rows)).all(1)
        for quad in np.round(quads[in_sight] * 16).astype(np.int32):
            cv2.fillConvexPoly(values, quad, [0.95], shift=4)
        return values

    def _stalls(self, real: MapPose, lot: GroundImage) -> list[Detection]:
        table = self.truth.stalls
        shift = np.array([lot.to_map[0, 2], lot.to_map[1, 2]])
        middle = lot.map_points(np.array([(lot.valid.shape[1] - 1) / 2, (lot.valid.shape[0] - 1) / 2]))
        moved = middle - (real.north, real.east)
        del shift
        centres = table[:, :2] + moved
        corners = stall_corners(table) + moved
        rows, columns = lot.valid.shape
        pixels = lot.pixel_points(corners)
        inside = ((pixels >= 0) & (pixels <= (columns - 1, rows - 1))).all(2).mean(1)
        found = []
        for i in np.flatnonzero(inside >= 0.5):
            if self.rng.random() < self.miss:
                continue
            jitter = self.rng.normal(0, self.noise_m, 2) if self.noise_m else (0.0, 0.0)
            taken = bool(self.truth.taken[i]) != (self.rng.random() < self.state_error)
            found.append(
                Detection(
                    float(centres[i, 0] + jitter[0]),
                    float(centres[i, 1] + jitter[1]),
                    float(table[i, 2]),
                    float(table[i, 3]),
                    float(table[i, 4]),
                    0.9,
                    0.95 if taken else 0.05,
                    float(inside[i]),
                )
            )
        alarms = [Detection(n, e, 0.3, 2.6, 5.2, 0.6, 0.1, 1.0) for n, e in self.false_alarms]
        return found + alarms

    def _picture(self, pose: MapPose) -> GroundImage:
        if not self.with_picture:
            shape = (8, 8)
            affine = ground_affine(pose, shape, PICTURE_M)
            return GroundImage(np.zeros((*shape, 3), np.uint8), affine, np.zeros(shape, np.bool_))
        shape = (round(pose.height * 720 / 914 / PICTURE_M), round(pose.height * 1280 / 914 / PICTURE_M))
        blank = np.full((*shape, 3), 60, np.uint8)
        image = GroundImage(blank, ground_affine(pose, shape, PICTURE_M), np.ones(shape, np.bool_))
        quads = stall_corners(self.truth.stalls)
        cv2.fillPoly(blank, list(np.round(image.pixel_points(quads)).astype(np.int32)), (200, 120, 40))
        return image


def stretched(truth: Truth, about: tuple[float, float], scale: float) -> Truth:
    """Return the lot enlarged about a place."""
    stalls = truth.stalls.copy()
    stalls[:, :2] = about + (stalls[:, :2] - about) * scale
    stalls[:, 3:] *= scale
    return Truth(about + (truth.lot - about) * scale, stalls, truth.taken)


def ground_affine(pose: MapPose, shape: tuple[int, int], pixel_m: float) -> NDArray[np.float64]:
    """Return ``to_map`` of a picture of that shape about the place below, its top in the drone's heading."""
    forward = np.array([math.cos(pose.yaw), math.sin(pose.yaw)])
    right = np.array([-math.sin(pose.yaw), math.cos(pose.yaw)])
    columns, rows = right * pixel_m, -forward * pixel_m
    origin = np.array([pose.north, pose.east]) - columns * (shape[1] - 1) / 2 - rows * (shape[0] - 1) / 2
    return np.column_stack([columns, rows, origin])


def stall_corners(table: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return corners (N, 4, 2) of stalls (N, 5)."""
    places, angle, width, length = table[:, None, :2], table[:, 2], table[:, 3], table[:, 4]
    along = np.stack([np.cos(angle), np.sin(angle)], -1) * length[:, None] / 2
    across = np.stack([-np.sin(angle), np.cos(angle)], -1) * width[:, None] / 2
    return np.asarray(places + np.stack([-along - across, -along + across, along + across, along - across], 1))


def frame_at(
    pose: MapPose | None,
    sequence: int = 1,
    *,
    state: StateName = StateName.AUTONOMOUS_EXPLORE,
    fence: Fence | None = None,
    desired: DesiredPose | None = None,
    jpeg: bytes = b"jpeg",
    interval: float = 0.1,
) -> FrameInput:
    """Return a frame's inputs, ten a second."""
    return FrameInput(
        sequence=sequence,
        captured=sequence * interval,
        jpeg=jpeg,
        camera=CAMERA,
        pose=pose,
        speed=4.0,
        state=state,
        desired=desired,
        heights=HeightParameters(),
        fence=fence,
        home=MapPoint(0.0, 0.0),
    )


def pose_at(north: float, east: float, yaw: float = 0.0, height: float = 35.0) -> MapPose:
    """Return a level pose."""
    return MapPose(north, east, height, 0.0, 0.0, yaw)


def box_fence(lot: NDArray[np.float64], margin: float) -> Fence:
    """Return an axis-parallel fence so far around a lot."""
    top, right = lot.max(0) + margin
    bottom, left = lot.min(0) - margin
    polygon = ((top, left), (top, right), (bottom, right), (bottom, left))
    return Fence(polygon, polygon, 60.0, 63.0)
