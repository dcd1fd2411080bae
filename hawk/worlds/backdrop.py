"""The ground of a world as a camera sees it, near and far, and beyond the picture's edge."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.worlds.canvas import Bytes, Floats, as_bytes, as_floats
from hawk.worlds.facets import FacetSet, ground_projection, lay_all, with_rim
from hawk.worlds.world import World

BORDER_M = 80.0
"""How far mirrored ground reaches beyond a world's edge; what lies farther repeats its last pixels."""

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

        ``homography`` is 3 x 3: world metres to pixels; ``size`` is (width, height); ``metres_per_pixel`` tells which
        resolution of the ground to take.
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
    lay_all(inner, FacetSet(world.layers), ground_projection((0.0, 0.0), _BORDER_SCALE))
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
