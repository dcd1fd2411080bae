"""A photograph on the ground: north up, for the network and the map."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.vision.detection import CameraView, GroundImage
from hawk.algo.vision.rectify import GROUND_M, MAXIMUM_OFF_NADIR
from hawk.picture.reconstruction.camera_pose import CameraPose, FloatArray

LARGEST_M: Final = 150.0
"""Side of the ground that is taken of one photograph, about the point below its camera: a network's memory grows with
it, and what lies farther off is seen from the side.
"""
FLATTEST: Final = min(MAXIMUM_OFF_NADIR, 0.7)
"""Rays farther than this off straight down, radians, are left out: there cars hide stalls behind them."""
_FINE: Final = 2
_BLOCK: Final = 16
_EDGE: Final = 32


def orthorectify(image: NDArray[np.uint8], posed: CameraPose) -> GroundImage | None:
    """Return a photograph (H, W, 3), BGR, on the ground, north up at `GROUND_M` a pixel; None where it shows none.

    The picture is sampled once, at `GROUND_M` / 2 where it is that fine; that one is the result's view.
    """
    half = np.full(2, LARGEST_M / 2)
    border = posed.ground(border_of(posed.camera.width, posed.camera.height)) - (posed.north, posed.east)
    low, high = np.maximum(border.min(axis=0), -half), np.minimum(border.max(axis=0), half)
    rows, columns = np.floor((high - low) / GROUND_M).astype(int).tolist()
    if min(rows, columns) < _EDGE:
        return None
    height = posed.pose.height
    fine = _FINE if GROUND_M * posed.camera.fx / height >= _FINE else 1
    side = GROUND_M / fine
    first = np.array([posed.north + high[0] - side / 2, posed.east + low[1] + side / 2])
    seen = seen_by(posed, first, (rows * fine, columns * fine), side)
    shrink = max(1, int(side * posed.camera.fx / height))
    small = cv2.resize(image, None, fx=1 / shrink, fy=1 / shrink, interpolation=cv2.INTER_AREA) if shrink > 1 else image
    scale = np.array([small.shape[1] / image.shape[1], small.shape[0] / image.shape[0]])
    at = np.asarray((seen + 0.5) * scale - 0.5, np.float32)
    view = np.asarray(cv2.remap(small, at[..., 0], at[..., 1], cv2.INTER_LINEAR), np.uint8)
    valid = ((seen >= 0) & (seen <= (posed.camera.width - 1, posed.camera.height - 1))).all(axis=-1)
    valid &= _well_seen(posed, first, valid.shape, side)
    values = (
        view if fine == 1 else np.asarray(cv2.resize(view, (columns, rows), interpolation=cv2.INTER_AREA), np.uint8)
    )
    whole = np.asarray(valid.reshape(rows, fine, columns, fine).all(axis=(1, 3)), np.bool_)
    to_map = np.array(
        [[0.0, -GROUND_M, posed.north + high[0] - GROUND_M / 2], [GROUND_M, 0.0, posed.east + low[1] + GROUND_M / 2]]
    )
    from_map = np.linalg.inv(np.array([[0.0, -side, first[0]], [side, 0.0, first[1]], [0.0, 0.0, 1.0]]))
    values = values * whole[..., None].astype(np.uint8)
    return GroundImage(values, to_map, whole, CameraView(view, from_map))


def seen_by(posed: CameraPose, first: FloatArray, size: tuple[int, int], side: float) -> NDArray[np.float32]:
    """Return the pixels (H, W, 2) of a raster on the ground, north up.

    One of `_BLOCK` pixels a side is projected: the projection is smooth.

    Args:
        posed: The photograph.
        first: Middle of the raster's first pixel, metres north and east of the survey's origin.
        size: Its rows and columns.
        side: Metres a pixel.
    """
    blocks = [number // _BLOCK + 3 for number in size]
    down, across = ((np.arange(n) - 0.5) * _BLOCK - 0.5 for n in blocks)
    north, east = np.meshgrid(first[0] - down * side, first[1] + across * side, indexing="ij")
    coarse = posed.pixels(np.column_stack([north.ravel(), east.ravel()])).reshape(*blocks, 2).astype(np.float32)
    fine = cv2.resize(coarse, None, fx=_BLOCK, fy=_BLOCK, interpolation=cv2.INTER_LINEAR)
    return np.array(fine[_BLOCK : _BLOCK + size[0], _BLOCK : _BLOCK + size[1]], dtype=np.float32)


def _well_seen(posed: CameraPose, first: FloatArray, shape: tuple[int, ...], side: float) -> NDArray[np.bool_]:
    """Return where (H, W) the ground is not seen too flat: a disc below the camera."""
    north = first[0] - np.arange(shape[0]) * side - posed.north
    east = first[1] + np.arange(shape[1]) * side - posed.east
    reach = posed.pose.height * np.tan(FLATTEST)
    return np.asarray(north[:, None] ** 2 + east[None] ** 2 <= reach**2)


def border_of(width: int, height: int) -> FloatArray:
    """Return points (N, 2), pixels, on the border of a picture of this size, by which its ground is bounded."""
    share = np.linspace(0, 1, _EDGE)
    x, y = share * (width - 1), share * (height - 1)
    sides = [(x, 0 * x), (x, 0 * x + height - 1), (0 * y, y), (0 * y + width - 1, y)]
    return np.concatenate([np.column_stack(side) for side in sides])
