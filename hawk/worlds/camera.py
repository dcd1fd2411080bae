"""The downward camera of a drone over a world.

Body axes are front, right, down (FRD); the attitude is NED's (yaw clockwise from north, then pitch, roll; radians).
The camera looks straight down in the body's frame, the top of its picture towards the nose. Pixel centres are whole
numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.model import CameraModel
from hawk.worlds.backdrop import Backdrop
from hawk.worlds.canvas import Bytes, Points, as_bytes
from hawk.worlds.facets import FacetSet, lay_all
from hawk.worlds.world import World

_LOWEST_M = 0.15
_FARTHEST_M = 400.0
_FINE_PER_METRE = 17.0  # pixels; about 54 m high with a 70 degree lens 1280 pixels wide
_SKY = (214, 200, 190, 255)


@dataclass(frozen=True, slots=True)
class Lens:
    """What the camera adds: blur (sigma, pixels), noise (deviation, grey levels), loss of light in corners (0..1)."""

    blur: float = 0.6
    noise: float = 2.2
    vignette: float = 0.14


class WorldCamera:
    """Draws what a downward camera sees of a world. Not safe to use from two threads at once."""

    def __init__(self, world: World, intrinsics: CameraModel, lens: Lens | None = None) -> None:
        self.world = world
        self.intrinsics = intrinsics
        self._lens = lens or Lens()
        self._backdrop = Backdrop(world)
        self._facets = FacetSet(world.layers)
        self._gain = _vignette(intrinsics, self._lens.vignette)
        self._grain = _grain(intrinsics, self._lens.noise)

    def render(
        self,
        x_east: float,
        y_south: float,
        height: float,
        roll: float,
        pitch: float,
        yaw: float,
        *,
        rng: np.random.Generator,
    ) -> Bytes:
        """Return the frame (BGR uint8) seen from a place (metres in the world's frame, height above the ground)."""
        projection = self.projection(x_east, y_south, height, roll, pitch, yaw)
        size = (self.intrinsics.width, self.intrinsics.height)
        frame = self._backdrop.draw(projection[:, [0, 1, 3]], size, max(height, _LOWEST_M) / self.intrinsics.fx)
        lay_all(frame, self._facets, projection, fine_from=_FINE_PER_METRE)
        self._cover_sky(frame, projection)
        return self._exposed(as_bytes(cv2.cvtColor(frame, cv2.COLOR_BGRA2BGR)), rng)

    def projection(
        self, x_east: float, y_south: float, height: float, roll: float, pitch: float, yaw: float
    ) -> NDArray[np.float64]:
        """Return 3 x 4: world metres (x east, y south, z up) to pixels, both homogeneous; depth is positive ahead."""
        k = self.intrinsics
        lens = np.array([[k.fx, 0, k.cx], [0, k.fy, k.cy], [0, 0, 1.0]])
        to_camera = _ned_to_camera(roll, pitch, yaw) @ _WORLD_TO_NED
        place = np.array([x_east, y_south, max(height, _LOWEST_M)])
        return np.asarray(lens @ np.column_stack([to_camera, -to_camera @ place]))

    def ground_from_pixel(
        self, pixels: Points, x_east: float, y_south: float, height: float, roll: float, pitch: float, yaw: float
    ) -> Points:
        """Return where pixels (N, 2) see the ground: (N, 2) metres; NaN for those that look above the horizon."""
        homography = self.projection(x_east, y_south, height, roll, pitch, yaw)[:, [0, 1, 3]]
        rays = np.column_stack([pixels, np.ones(len(pixels))]) @ np.linalg.inv(homography).T
        # a ray that has to be turned round to meet the ground lies above the horizon
        ahead = rays[:, 2] * np.linalg.det(homography) > 0
        scale = np.where(ahead & (np.abs(rays[:, 2]) > 1e-9), rays[:, 2], np.nan)
        return np.asarray(rays[:, :2] / scale[:, None])

    def footprint(self, x_east: float, y_south: float, height: float, roll: float, pitch: float, yaw: float) -> Points:
        """Return the corners (4, 2) of the ground in the picture, from its upper left corner clockwise, metres.

        What lies farther than 400 m is brought to that distance.
        """
        k = self.intrinsics
        edges = np.array([[0, 0], [k.width, 0], [k.width, k.height], [0, k.height]]) - 0.5
        rays = np.column_stack([(edges - (k.cx, k.cy)) / (k.fx, k.fy), np.ones(4)])
        north, east, down = (rays @ _ned_to_camera(roll, pitch, yaw)).T
        distance = np.hypot(north, east) + 1e-12
        height = max(height, _LOWEST_M)
        reach = np.where(down > 1e-6, distance * height / np.maximum(down, 1e-6), np.inf)
        reach = np.minimum(reach, _FARTHEST_M) / distance
        return np.column_stack([x_east + east * reach, y_south - north * reach])

    def _cover_sky(self, frame: Bytes, projection: NDArray[np.float64]) -> None:
        """Paint what lies above the horizon: only a drone that falls over sees it."""
        inverse = np.linalg.inv(projection[:, [0, 1, 3]])
        # along the horizon the ground's third homogeneous component is zero
        a, b, c = inverse[2] * math.copysign(1.0, float(np.linalg.det(projection[:, [0, 1, 3]])))
        height, width = frame.shape[:2]
        corners = [a * x + b * y + c for x in (0, width) for y in (0, height)]
        if min(corners) > 0:
            return
        rows, columns = np.mgrid[0:height, 0:width]
        frame[a * columns + b * rows + c <= 0] = _SKY

    def _exposed(self, frame: Bytes, rng: np.random.Generator) -> Bytes:
        if self._lens.blur > 0:
            frame = as_bytes(cv2.GaussianBlur(frame, (3, 3), self._lens.blur))
        if self._gain is not None:
            frame = as_bytes(cv2.multiply(frame, self._gain, scale=1 / 255))
        for k, grain in enumerate(self._grain):
            row = int(rng.integers(grain.shape[0] - frame.shape[0] + 1))
            column = int(rng.integers(grain.shape[1] - frame.shape[1] + 1))
            part = grain[row : row + frame.shape[0], column : column + frame.shape[1]]
            frame = as_bytes(cv2.subtract(frame, part) if k else cv2.add(frame, part))
        return frame


_WORLD_TO_NED = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
_BODY_TO_CAMERA = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def _ned_to_camera(roll: float, pitch: float, yaw: float) -> NDArray[np.float64]:
    """Return the rotation from NED to the camera's axes (right, down in the picture, ahead)."""
    cr, sr, cp, sp, cy, sy = *_turn(roll), *_turn(pitch), *_turn(yaw)
    body_to_ned = np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
    return np.asarray(_BODY_TO_CAMERA @ body_to_ned.T)


def _turn(angle: float) -> tuple[float, float]:
    return math.cos(angle), math.sin(angle)


def _vignette(intrinsics: CameraModel, loss: float) -> Bytes | None:
    if loss <= 0:
        return None
    rows, columns = np.mgrid[0 : intrinsics.height, 0 : intrinsics.width].astype(np.float32)
    corner = math.hypot(intrinsics.width / 2, intrinsics.height / 2)
    radius = np.hypot(columns - intrinsics.cx, rows - intrinsics.cy) / corner
    gain = (255 * (1 - loss * np.clip(radius, 0, 1) ** 2)).astype(np.uint8)
    return as_bytes(np.dstack([gain] * 3))


def _grain(intrinsics: CameraModel, deviation: float) -> tuple[Bytes, ...]:
    """Return noise somewhat larger than a frame: its positive and its negative half, cut anew for every frame."""
    if deviation <= 0:
        return ()
    shape = (intrinsics.height + 97, intrinsics.width + 131, 3)
    noise = np.random.default_rng(20240229).standard_normal(shape, np.float32) * np.float32(deviation)
    return as_bytes(np.round(np.clip(noise, 0, 255))), as_bytes(np.round(np.clip(-noise, 0, 255)))
