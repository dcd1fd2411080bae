"""Projects a camera frame onto the ground plane: from here on everything is in metres.

Frames: body FRD; the camera looks straight down with the picture's top towards the nose, so that picture x is body
right, picture y is body back and the optical axis is body down. The mount turns the camera by Rz(yaw) Ry(pitch)
Rx(roll) in the body frame, the attitude turns the body into NED in the same order (z-y-x, as in aerospace).
"""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.detection import CameraView, FloatArray, GroundImage
from hawk.model.pictures import CAMERA_TO_BODY, CameraModel, rotation
from hawk.model.poses import MapPoint, MapPose

GROUND_M = 0.10
"""Side of a pixel of the rectified picture, metres."""
MAXIMUM_PIXELS = (960, 640)
"""Largest rectified picture (width, height): ground farther from below the drone is left out. Bounds the cost."""
MAXIMUM_OFF_NADIR = math.radians(58.0)
"""Rays that meet the ground flatter than this are left out: a pixel then covers more than three times its size."""
_FLATTEST = math.cos(math.radians(75))  # rays of the footprint that meet the ground flatter than this are cut there
_BORDER_STEPS = 12
_SMALLEST = 32
_FINEST = 1e3


class RectifyError(ValueError):
    """The picture cannot be projected onto the ground; the text gives the reason."""


def camera_to_ned(camera: CameraModel, pose: MapPose) -> FloatArray:
    """Return (3, 3): turns vectors of the camera (x right, y down in the picture, z ahead) into NED."""
    mount = rotation(camera.mount_roll, camera.mount_pitch, camera.mount_yaw)
    return np.asarray(rotation(pose.roll, pose.pitch, pose.yaw) @ mount @ CAMERA_TO_BODY)


def intrinsics(camera: CameraModel) -> FloatArray:
    """Return the pinhole matrix (3, 3), pixels; whole numbers are pixel centres."""
    return np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])


def ground_homography(camera: CameraModel, pose: MapPose) -> FloatArray:
    """Return (3, 3) from ground (north, east, 1), metres of the map, to undistorted picture coordinates (homogeneous).

    The third coordinate is the distance along the optical axis: positive in front of the camera.
    """
    ned_to_camera = camera_to_ned(camera, pose).T
    ground = np.array([[1.0, 0.0, -pose.north], [0.0, 1.0, -pose.east], [0.0, 0.0, pose.height]])
    return np.asarray(intrinsics(camera) @ ned_to_camera @ ground)


def project(points: FloatArray, camera: CameraModel, pose: MapPose) -> FloatArray:
    """Return (..., 2) picture coordinates (distorted, as the camera sees) of ground points (..., 2) (north, east).

    NaN where a point lies behind the camera.
    """
    flat = np.asarray(points, float).reshape(-1, 2)
    offset = np.column_stack([flat - (pose.north, pose.east), np.full(len(flat), pose.height)])
    rays = offset @ camera_to_ned(camera, pose)
    with np.errstate(divide="ignore", invalid="ignore"):
        rays = np.where(rays[:, 2:] > 1e-6, rays / rays[:, 2:], np.nan)
    x, y = _distort(rays[:, 0], rays[:, 1], camera.distortion)
    pixels = np.column_stack([camera.fx * x + camera.cx, camera.fy * y + camera.cy])
    return pixels.reshape(*np.shape(points)[:-1], 2)


def ground_footprint(camera: CameraModel, pose: MapPose) -> tuple[MapPoint, ...]:
    """Return the four corners of the picture on the ground (map frame), from its upper left one clockwise.

    Lens distortion is left out. Empty when the pose is not finite or on the ground.
    """
    if not pose.is_finite() or pose.height <= 0:
        return ()
    columns = np.array([0.0, camera.width, camera.width, 0.0]) - 0.5
    rows = np.array([0.0, 0.0, camera.height, camera.height]) - 0.5
    rays = np.stack([(columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy, np.ones(4)])
    north, east, down = camera_to_ned(camera, pose) @ (rays / np.linalg.norm(rays, axis=0))
    reach = pose.height / np.maximum(down, _FLATTEST)
    return tuple(
        MapPoint(round(pose.north + float(n), 3), round(pose.east + float(e), 3))
        for n, e in zip(north * reach, east * reach, strict=True)
    )


class Rectifier:
    """Rectifies the frames of a camera; keeps the lens correction between frames."""

    def __init__(self) -> None:
        self._lens: tuple[CameraModel, tuple[NDArray[Any], NDArray[Any]], NDArray[np.uint8]] | None = None

    def rectify(self, image: NDArray[np.uint8], camera: CameraModel, pose: MapPose) -> GroundImage:
        """Return the picture on the ground plane, turned to the camera's heading, clipped to the well seen ground.

        ``image`` is uint8 BGR (H, W, 3). A picture of another size than the camera's is taken as a scaled one.
        Raises RectifyError when the pose is not finite, the height is not positive or no ground is in view.
        """
        _check(image, pose)
        camera = scaled_camera(camera, image.shape[1], image.shape[0])
        seen = np.full(image.shape[:2], 255, np.uint8)
        if any(camera.distortion):
            maps, seen = self._undistortion(camera)
            image = np.asarray(cv2.remap(image, maps[0], maps[1], cv2.INTER_LINEAR), np.uint8)
        width, height, to_map = _layout(camera, pose)
        from_ground = ground_homography(camera, pose)
        to_image = from_ground @ np.vstack([to_map, [0.0, 0.0, 1.0]])
        shrunk, shrink, step = _shrink(image, to_image, width, height)
        values = cv2.warpPerspective(
            _softened(shrunk, step), shrink @ to_image, (width, height), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        )
        flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
        mask = cv2.warpPerspective(seen, to_image, (width, height), flags=flags, borderValue=(0,))
        valid = (mask > 0) & _well_seen(to_map, pose, width, height)
        values[~valid] = 0
        view = CameraView(shrunk, shrink @ from_ground)
        return GroundImage(np.asarray(values, np.uint8), to_map, valid, view)

    def _undistortion(self, camera: CameraModel) -> tuple[tuple[NDArray[Any], NDArray[Any]], NDArray[np.uint8]]:
        if self._lens is None or self._lens[0] != camera:
            matrix, size = intrinsics(camera), (camera.width, camera.height)
            maps = cv2.initUndistortRectifyMap(
                matrix, np.array(camera.distortion), np.eye(3), matrix, size, cv2.CV_16SC2
            )
            whole = np.full((camera.height, camera.width), 255, np.uint8)
            seen = cv2.remap(whole, maps[0], maps[1], cv2.INTER_NEAREST, borderValue=(0,))
            self._lens = camera, (maps[0], maps[1]), np.asarray(seen, np.uint8)
        return self._lens[1], self._lens[2]


def scaled_camera(camera: CameraModel, width: int, height: int) -> CameraModel:
    """Return the camera for a picture of another resolution of the same view."""
    if (camera.width, camera.height) == (width, height):
        return camera
    sx, sy = width / camera.width, height / camera.height
    return CameraModel(
        width=width,
        height=height,
        fx=camera.fx * sx,
        fy=camera.fy * sy,
        cx=(camera.cx + 0.5) * sx - 0.5,
        cy=(camera.cy + 0.5) * sy - 0.5,
        distortion=camera.distortion,
        mount_roll=camera.mount_roll,
        mount_pitch=camera.mount_pitch,
        mount_yaw=camera.mount_yaw,
    )


def _check(image: NDArray[np.uint8], pose: MapPose) -> None:
    if image.ndim != 3 or image.shape[2] != 3:
        raise RectifyError(f"the picture must be BGR (H, W, 3), not {image.shape}")
    if not pose.is_finite():
        raise RectifyError("the pose of the frame is not finite")
    if pose.height <= 0:
        raise RectifyError(f"the frame was taken {pose.height:.1f} m above the arm place; it must be above the ground")


def _distort(x: FloatArray, y: FloatArray, coefficients: tuple[float, ...]) -> tuple[FloatArray, FloatArray]:
    """Radial-tangential model of OpenCV (Brown-Conrady): k1, k2, p1, p2, k3."""
    k1, k2, p1, p2, k3 = (*coefficients, 0.0, 0.0, 0.0, 0.0, 0.0)[:5]
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    return (
        x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
        y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
    )


def _layout(camera: CameraModel, pose: MapPose) -> tuple[int, int, FloatArray]:
    """Return width, height and `to_map` of the smallest raster in the camera's heading with all visible ground."""
    turn = camera_to_ned(camera, pose)
    ahead = turn @ (0.0, -1.0, 0.0) if abs(turn[2, 1]) < 0.9 else turn @ (0.0, 0.0, 1.0)
    heading = math.atan2(ahead[1], ahead[0])
    right = np.array([-math.sin(heading), math.cos(heading)])
    back = np.array([-math.cos(heading), -math.sin(heading)])
    below = _border_on_ground(camera, turn, pose.height)
    half = np.array(MAXIMUM_PIXELS) * GROUND_M / 2
    corners = np.column_stack([below @ right, below @ back])
    low = np.maximum(corners.min(axis=0), -half)
    high = np.minimum(corners.max(axis=0), half)
    size = np.floor((high - low) / GROUND_M).astype(int)
    if (size < 32).any():
        raise RectifyError("no ground is in view: the drone is too low or the camera looks too far aside")
    first = low + GROUND_M / 2
    origin = np.array([pose.north, pose.east]) + first[0] * right + first[1] * back
    return int(size[0]), int(size[1]), np.column_stack([right * GROUND_M, back * GROUND_M, origin])


def _border_on_ground(camera: CameraModel, turn: FloatArray, height: float) -> FloatArray:
    """Return (N, 2) (north, east) metres from below the drone where the picture's border meets the ground.

    Rays that are too flat are pulled in to the limit.
    """
    across = np.linspace(-0.5, camera.width - 0.5, _BORDER_STEPS + 1)
    down = np.linspace(-0.5, camera.height - 0.5, _BORDER_STEPS + 1)
    grid = np.stack(np.meshgrid(across, down), axis=-1).reshape(-1, 2)
    rays = np.column_stack([(grid - (camera.cx, camera.cy)) / (camera.fx, camera.fy), np.ones(len(grid))]) @ turn.T
    flat = np.hypot(rays[:, 0], rays[:, 1])
    reach = height * np.minimum(
        np.where(rays[:, 2] > 1e-6, flat / np.maximum(rays[:, 2], 1e-6), np.inf), math.tan(MAXIMUM_OFF_NADIR)
    )
    if (rays[:, 2] <= 1e-6).all():
        raise RectifyError("no ground is in view: the camera looks above the horizon")
    return np.asarray(rays[:, :2] / np.maximum(flat, 1e-12)[:, None] * reach[:, None])


def _shrink(
    image: NDArray[np.uint8], to_image: FloatArray, width: int, height: int
) -> tuple[NDArray[np.uint8], FloatArray, float]:
    """Halve a picture while it is twice as fine as the ground raster.

    Halving is far quicker than averaging down by any other factor. Returns the picture, the (3, 3) scaling from full to
    shrunk picture coordinates, and the pixels of the shrunk one along a pixel of the raster.
    """
    centre = np.array([(width - 1) / 2, (height - 1) / 2])
    ends = centre + np.array([(0, 0), (1, 0), (0, 1)])
    seen = np.column_stack([ends, np.ones(3)]) @ to_image.T
    pixels = seen[:, :2] / seen[:, 2:]
    step = min(np.hypot(*(pixels[1] - pixels[0])), np.hypot(*(pixels[2] - pixels[0])))
    scale = np.eye(3)
    while 2 <= step < _FINEST and min(image.shape[:2]) >= 2 * _SMALLEST:
        size = (image.shape[1] // 2, image.shape[0] // 2)
        sx, sy = size[0] / image.shape[1], size[1] / image.shape[0]
        image = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)
        scale = np.array([[sx, 0.0, (sx - 1) / 2], [0.0, sy, (sy - 1) / 2], [0.0, 0.0, 1.0]]) @ scale
        step /= 2
    return image, scale, float(step)


def _softened(image: NDArray[np.uint8], step: float) -> NDArray[np.uint8]:
    """Return a picture of ``step`` pixels along a pixel of the raster, so soft that the warp does not alias."""
    if not 1.3 < step < _FINEST:
        return image
    return np.asarray(cv2.GaussianBlur(image, (3, 3), 0.45 * math.sqrt(step**2 - 1)), np.uint8)


def _well_seen(to_map: FloatArray, pose: MapPose, width: int, height: int) -> NDArray[np.bool_]:
    """Return (height, width): where the ground is seen no flatter than the limit (a disc below the drone)."""
    centre = np.linalg.solve(to_map[:, :2], np.array([pose.north, pose.east]) - to_map[:, 2])
    radius = pose.height * math.tan(MAXIMUM_OFF_NADIR) / float(np.hypot(to_map[0, 0], to_map[1, 0]))
    far = np.hypot(max(abs(centre[0]), abs(width - 1 - centre[0])), max(abs(centre[1]), abs(height - 1 - centre[1])))
    if far <= radius:
        return np.ones((height, width), np.bool_)
    columns = (np.arange(width) - centre[0]) ** 2
    rows = (np.arange(height) - centre[1]) ** 2
    return np.asarray(rows[:, None] + columns[None, :] <= radius**2)
