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

from hawk.model.pictures import CameraModel
from hawk.worlds.scene.canvas import Bytes, Floats, as_bytes, as_floats
from hawk.worlds.scene.facets import FacetSet, draw_layers, ground_projection, with_rim
from hawk.worlds.world import World

_LOWEST_M = 0.15
_FINE_PER_METRE = 17.0  # pixels; about 54 m high with a 70 degree lens 1280 pixels wide
_SKY = (214, 200, 190, 255)


@dataclass(frozen=True, slots=True)
class Lens:
    """Faults of the lens: blur (sigma, pixels), noise (deviation, grey levels), loss of light in corners (0..1)."""

    blur: float = 0.6
    noise: float = 2.2
    vignette: float = 0.14


class WorldCamera:
    """Draws a downward camera's view of a world. Not safe to use from two threads at once."""

    def __init__(self, world: World, intrinsics: CameraModel, lens: Lens | None = None) -> None:
        self._intrinsics = intrinsics
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
        """Return the frame (BGR uint8) from a place (metres in the world's frame, height above the ground; radians)."""
        projection = self.projection(x_east, y_south, height, roll, pitch, yaw)
        size = (self._intrinsics.width, self._intrinsics.height)
        frame = self._backdrop.draw(projection[:, [0, 1, 3]], size, max(height, _LOWEST_M) / self._intrinsics.fx)
        draw_layers(frame, self._facets, projection, fine_from=_FINE_PER_METRE)
        self._cover_sky(frame, projection)
        return self._exposed(as_bytes(cv2.cvtColor(frame, cv2.COLOR_BGRA2BGR)), rng)

    def projection(
        self, x_east: float, y_south: float, height: float, roll: float, pitch: float, yaw: float
    ) -> NDArray[np.float64]:
        """Return 3 x 4: world metres (x east, y south, z up) to pixels, both homogeneous; depth is positive ahead."""
        k = self._intrinsics
        lens = np.array([[k.fx, 0, k.cx], [0, k.fy, k.cy], [0, 0, 1.0]])
        to_camera = _ned_to_camera(roll, pitch, yaw) @ _WORLD_TO_NED
        place = np.array([x_east, y_south, max(height, _LOWEST_M)])
        return np.asarray(lens @ np.column_stack([to_camera, -to_camera @ place]))

    def _cover_sky(self, frame: Bytes, projection: NDArray[np.float64]) -> None:
        """Paint the sky above the horizon: only a drone that falls over sees it."""
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
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    body_to_ned = np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
    return np.asarray(_BODY_TO_CAMERA @ body_to_ned.T)


def _vignette(intrinsics: CameraModel, loss: float) -> Bytes | None:
    if loss <= 0:
        return None
    rows, columns = np.mgrid[0 : intrinsics.height, 0 : intrinsics.width].astype(np.float32)
    corner = math.hypot(intrinsics.width / 2, intrinsics.height / 2)
    radius = np.hypot(columns - intrinsics.cx, rows - intrinsics.cy) / corner
    gain = (255 * (1 - loss * np.clip(radius, 0, 1) ** 2)).astype(np.uint8)
    return as_bytes(np.dstack([gain] * 3))


def _grain(intrinsics: CameraModel, deviation: float) -> tuple[Bytes, ...]:
    """Return noise somewhat larger than a frame: its positive and its negative half, to cut each frame's from."""
    if deviation <= 0:
        return ()
    shape = (intrinsics.height + 97, intrinsics.width + 131, 3)
    noise = np.random.default_rng(20240229).standard_normal(shape, np.float32) * np.float32(deviation)
    return as_bytes(np.round(np.clip(noise, 0, 255))), as_bytes(np.round(np.clip(-noise, 0, 255)))


BORDER_M = 80.0
"""Width of the mirrored ground beyond a world's edge; farther out its last pixels repeat."""

_BORDER_SCALE = 0.25
_BLUR_NEAR_M, _BLUR_FAR_M = 0.7, 4.0
_COARSEST_M = 0.45


class Backdrop:
    """The ground at several resolutions, with a blurred mirror image of the world around it."""

    def __init__(self, world: World) -> None:
        self._levels = _levels(world)
        self._border, self._border_scale = _border(world)

    def draw(self, homography: NDArray[np.float64], size: tuple[int, int], metres_per_pixel: float) -> Bytes:
        """Return a picture (BGRA) of the ground.

        ``homography`` is 3 x 3: world metres to pixels; ``size`` is (width, height); ``metres_per_pixel`` selects
        the resolution of the ground.
        """
        picture, scale = self._levels[0]
        for finer, finer_scale in self._levels[1:]:
            if finer_scale > 1.15 * metres_per_pixel:
                break
            picture, scale = finer, finer_scale
        inverse = np.asarray(np.linalg.inv(homography), np.float64)
        rows, columns = picture.shape[0] - 2, picture.shape[1] - 2
        drawn = _warp(picture, inverse, scale, (-scale, -scale), size, cv2.BORDER_CONSTANT)
        if self._inside(inverse, size, columns * scale, rows * scale):
            return drawn
        # the border is blurred: a picture a quarter the size loses nothing
        small = (max(1, size[0] // 4), max(1, size[1] // 4))
        sx, sy = size[0] / small[0], size[1] / small[1]
        shrunk = inverse @ np.array([[sx, 0, (sx - 1) / 2], [0, sy, (sy - 1) / 2], [0, 0, 1.0]])
        around = _warp(self._border, shrunk, self._border_scale, (-BORDER_M, -BORDER_M), small, cv2.BORDER_REPLICATE)
        around = as_bytes(cv2.resize(around, size, interpolation=cv2.INTER_LINEAR))
        opaque = cv2.threshold(cv2.extractChannel(drawn, 3), 127, 255, cv2.THRESH_BINARY)[1]
        cv2.copyTo(drawn, opaque, around)
        return around

    @staticmethod
    def _inside(inverse: NDArray[np.float64], size: tuple[int, int], width: float, height: float) -> bool:
        corners = np.array([[0, 0, 1], [size[0], 0, 1], [size[0], size[1], 1], [0, size[1], 1]]) @ inverse.T
        if not (corners[:, 2] > 0).all() and not (corners[:, 2] < 0).all():
            return False
        ground = corners[:, :2] / corners[:, 2:]
        return bool((ground >= 0.1).all() and (ground <= np.array([width, height]) - 0.1).all())


def _warp(
    picture: Bytes,
    inverse: NDArray[np.float64],
    scale: float,
    origin: tuple[float, float],
    size: tuple[int, int],
    border: int,
) -> Bytes:
    to_texel = np.array(
        [[1 / scale, 0, -origin[0] / scale - 0.5], [0, 1 / scale, -origin[1] / scale - 0.5], [0, 0, 1.0]]
    )
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return as_bytes(cv2.warpPerspective(picture, to_texel @ inverse, size, flags=flags, borderMode=border))


def _levels(world: World) -> list[tuple[Bytes, float]]:
    """Return the ground and halvings of it; in four channels, because OpenCV warps four faster than three."""
    picture, scale = as_bytes(cv2.cvtColor(world.ground, cv2.COLOR_BGR2BGRA)), world.metres_per_pixel
    levels = [(picture, scale)]
    while scale * 2 <= _COARSEST_M and min(picture.shape[:2]) >= 64:
        # an even size keeps the halved pixels exactly twice as large
        rows, columns = picture.shape[0] // 2 * 2, picture.shape[1] // 2 * 2
        half = cv2.resize(picture[:rows, :columns], (columns // 2, rows // 2), interpolation=cv2.INTER_AREA)
        picture, scale = as_bytes(half), scale * 2
        levels.append((picture, scale))
    return [(with_rim(level), its_scale) for level, its_scale in levels]


def _border(world: World) -> tuple[Bytes, float]:
    """Return the world with its blurred mirror image around it (coarse, four channels) and its metres per pixel."""
    width, height = world.size_m
    columns, rows = max(8, round(width / _BORDER_SCALE)), max(8, round(height / _BORDER_SCALE))
    inner = as_bytes(cv2.resize(world.ground, (columns, rows), interpolation=cv2.INTER_AREA))
    inner = as_bytes(cv2.cvtColor(inner, cv2.COLOR_BGR2BGRA))
    draw_layers(inner, FacetSet(world.layers), ground_projection((0.0, 0.0), _BORDER_SCALE))
    reach = round(BORDER_M / _BORDER_SCALE)
    mirrored = as_floats(cv2.copyMakeBorder(inner, reach, reach, reach, reach, cv2.BORDER_REFLECT).astype(np.float32))
    near = cv2.GaussianBlur(mirrored, (0, 0), _BLUR_NEAR_M / _BORDER_SCALE)
    far = cv2.GaussianBlur(mirrored, (0, 0), _BLUR_FAR_M / _BORDER_SCALE)
    share = np.clip(_distance(mirrored.shape[:2], reach) / (25 / _BORDER_SCALE), 0, 1)[..., None]
    blended = np.round(np.clip(near * (1 - share) + far * share, 0, 255))
    return as_bytes(blended), _BORDER_SCALE


def _distance(shape: tuple[int, ...], reach: int) -> Floats:
    """Return each pixel's distance (pixels) from the world in the middle."""
    rows, columns = np.arange(shape[0]), np.arange(shape[1])
    down = np.maximum(np.maximum(reach - rows, rows - (shape[0] - 1 - reach)), 0)
    right = np.maximum(np.maximum(reach - columns, columns - (shape[1] - 1 - reach)), 0)
    return as_floats(np.hypot(down[:, None], right[None, :]))
