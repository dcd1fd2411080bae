"""Blending of a camera's picture into the mosaic: its exposure, its place, and the weights.

Work that covers the whole picture is done on blocks of `BLOCK` pixels a side (0.8 m). Detail is taken from one view at
a time, with a seam of about a metre; brightness and colour change over several metres (the method of Burt and Adelson,
A multiresolution spline with application to image mosaics, 1983, in two bands): views of the same ground from two sides
differ in detail, and a wide band of both shows everything double.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import Slices, Window
from hawk.algo.vision.detection import FloatArray, GroundImage
from hawk.model.lot_map import CELL_M

BLOCK: Final = 8
"""Pixels along one side of a block."""

_BLOCK_M: Final = BLOCK * CELL_M
_HEIGHT: Final = 0.2  # of a view's height counts as distance from straight below
_COARSE_M: Final = 100.0  # a view whose pixels are twice those of the map counts as this much farther
_EDGE_M: Final = 4.0
_EDGE_COST: Final = 0.5  # for each metre that the picture's edge is nearer than that
_BETTER_M: Final = 6.0
_BETTER_BLOCKS: Final = 8
_FRESH: Final = 51  # of 255
_SEAM: Final = 1.2
_WIDE: Final = 4.0
_MOST_CHANGE: Final = 40.0
_GAIN_KEPT: Final = 0.95
_MOST_GAIN: Final = 1.7
_CORNERS_STEP: Final = 0.1
_MOST_CORNERS: Final = 0.9
_CORNERS_NEWS: Final = 0.02
_LEAST_BLOCKS: Final = 60
_DARK, _BRIGHT = 12.0, 240.0
_LENS_UNIT: Final = 128

Floats32 = NDArray[np.float32]
Bools = NDArray[np.bool_]
Bytes = NDArray[np.uint8]


def blocks_of(window: Window) -> Window:
    """Return the blocks of a window whose bounds are multiples of a block."""
    return Window(window.row // BLOCK, window.column // BLOCK, window.rows // BLOCK, window.columns // BLOCK, _BLOCK_M)


def enlarged(layer: NDArray[Any], part: Slices) -> Floats32:
    """Return a part of a layer of blocks for its pixels, linear between the blocks' centres.

    A block about the part must be within the layer: parts beside each other meet without a step.
    """
    rows, columns = part
    around = layer[rows.start - 1 : rows.stop + 1, columns.start - 1 : columns.stop + 1]
    size = (around.shape[1] * BLOCK, around.shape[0] * BLOCK)
    large = cv2.resize(np.ascontiguousarray(around, np.float32), size, interpolation=cv2.INTER_LINEAR)
    return np.ascontiguousarray(large[BLOCK:-BLOCK, BLOCK:-BLOCK], np.float32)


@dataclass(frozen=True, slots=True)
class View:
    """A camera's picture over ground: BGR ``image``, (3, 3) from (north, east, 1) to its (column, row), homogeneous.

    ``pixel_m`` is the side of a pixel on the ground in the picture's middle, metres.
    """

    image: Bytes
    to_image: FloatArray
    pixel_m: float

    def sampled(self, window: Window) -> Bytes:
        """Return the picture on a window's cells."""
        size, flags = (window.columns, window.rows), cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
        matrix = self.to_image @ _to_ground(window)
        found = cv2.warpPerspective(self.image, matrix, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(found, np.uint8)

    def colours(self, blocks: Window) -> Floats32:
        """Return the mean colours (rows, columns, 3) of blocks."""
        height, width = self.image.shape[:2]
        shrink = min(max(1, round(_BLOCK_M / self.pixel_m)), height, width)
        size = (width // shrink, height // shrink)
        exact = self.image[: size[1] * shrink, : size[0] * shrink]  # means over whole pixels are four times as quick
        small = cv2.resize(exact, size, interpolation=cv2.INTER_AREA)
        offset = (1 / shrink - 1) / 2
        scale = np.array([[1 / shrink, 0.0, offset], [0.0, 1 / shrink, offset], [0.0, 0.0, 1.0]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        matrix = scale @ self.to_image @ _to_ground(blocks)
        found = cv2.warpPerspective(
            small, matrix, (blocks.columns, blocks.rows), flags=flags, borderMode=cv2.BORDER_REPLICATE
        )
        return np.asarray(found, np.float32)

    def from_middle(self, blocks: Window) -> Floats32:
        """Return the squared distance of each block from the picture's middle, 1 in its corners."""
        columns, rows = np.meshgrid(np.arange(blocks.columns), np.arange(blocks.rows))
        cells = np.stack([columns, rows, np.ones_like(rows)], -1).reshape(-1, 3).T
        x, y, depth = self.to_image @ _to_ground(blocks) @ cells
        height, width = self.image.shape[:2]
        x, y = x / depth - (width - 1) / 2, y / depth - (height - 1) / 2
        return np.asarray((x * x + y * y) / _corner(self.image), np.float32).reshape(blocks.shape)

    def moved(self, north: float, east: float) -> View:
        """Return the view with the ground's picture moved by metres."""
        back = np.array([[1.0, 0.0, -north], [0.0, 1.0, -east], [0.0, 0.0, 1.0]])
        return replace(self, to_image=self.to_image @ back)


def view_of(picture: GroundImage) -> View:
    """Return the camera's own picture; one on the ground alone is taken for it."""
    if picture.view is None:
        to_image = np.linalg.inv(np.vstack([picture.to_map, (0.0, 0.0, 1.0)]))
        return View(picture.values, to_image, picture.metres_per_pixel)
    to_image, image = picture.view.to_image, picture.view.image
    rows, columns = picture.valid.shape
    middle = np.array([(columns - 1) / 2, (rows - 1) / 2])
    ends = picture.map_points(middle + np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]))
    seen = np.column_stack([ends, np.ones(3)]) @ to_image.T
    pixels = seen[:, :2] / seen[:, 2:]
    step = math.sqrt(math.dist(pixels[0], pixels[1]) * math.dist(pixels[0], pixels[2]))
    return View(image, to_image, picture.metres_per_pixel / max(step, 1e-3))


def view_cost(view: View, blocks: Window, covered: Bytes, below: tuple[float, float], height: float) -> Floats32:
    """Return how bad a view of each block is, metres: infinite where the picture does not show all of it.

    The distance from straight below the camera, with parts for height, coarse pixels and the picture's edge.
    """
    north, east = blocks.centres(np.arange(blocks.rows), np.arange(blocks.columns))
    aside = np.hypot(north[:, None] - below[0], east[None] - below[1])
    whole = (covered == 255).astype(np.uint8)
    from_edge = cv2.distanceTransform(whole, cv2.DIST_L2, 3) * _BLOCK_M
    at_edge = _EDGE_COST * np.maximum(_EDGE_M - from_edge, 0.0)
    coarse = _COARSE_M * max(0.0, view.pixel_m / CELL_M - 1.0)
    cost = aside + at_edge + max(height, 0.0) * _HEIGHT + coarse
    return np.where(whole > 0, cost, np.inf).astype(np.float32)


@dataclass(frozen=True, slots=True)
class Blend:
    """Parts of a picture that go into the mosaic, by blocks: ``weight`` of detail (0..1), True where it is ``used``."""

    weight: Floats32
    used: Bools

    def change(self, shown: Bytes, colour: Floats32, both: Bools) -> Floats32:
        """Return what is added to the picture's colours, (rows, columns, 3), so that they meet those that stay.

        ``shown`` and ``colour`` are the colours of mosaic and picture; only blocks in ``both`` are compared.
        """
        stays = np.where(both, 1.0 - self.weight, 0.0).astype(np.float32)
        apart = np.clip(shown.astype(np.float32) - colour, -_MOST_CHANGE, _MOST_CHANGE) * stays[..., None]
        near, total = _blurred(stays, _WIDE), _blurred(apart, _WIDE)
        share = np.minimum(1.0, 2.0 * near) / np.maximum(near, 1e-3)
        return np.asarray(total * share[..., None], np.float32)


def blend_of(known: NDArray[np.float16], known_covered: Bytes, cost: Floats32, covered: Bytes) -> Blend | None:
    """Return where a picture goes into the mosaic, None where it brings nothing new.

    It brings ground that was not seen, and, once it is better by far somewhere, all that it shows better: the parts of
    two pictures then meet in the middle between their places, and few pictures make up the whole.

    Args:
        known: Cost of the views that are shown, by blocks.
        known_covered: Share of the blocks that was seen, 0..255.
        cost: Cost of this view.
        covered: Share of the blocks that it shows, 0..255.
    """
    whole = covered == 255
    fresh = (covered.astype(np.int16) - known_covered > _FRESH) | (whole & (known_covered < 255))
    with np.errstate(invalid="ignore"):
        gain = np.where(whole, known.astype(np.float32) - cost, -np.inf)
    takes = np.asarray(cv2.dilate(fresh.astype(np.uint8), np.ones((5, 5), np.uint8))) > 0
    seen_gain = np.where(known_covered == 255, gain, -np.inf)
    if np.count_nonzero(seen_gain > _BETTER_M) >= _BETTER_BLOCKS:
        better = cv2.morphologyEx((gain > 0).astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
        takes |= np.asarray(better) > 0
    takes &= whole
    weight = np.clip(2 * _blurred(takes.astype(np.float32), _SEAM) - 1, 0, 1)
    used = fresh | (weight > 0)
    return Blend(weight, used) if used.any() else None


class Exposure:
    """Brings pictures to the brightness of the mosaic: one factor a picture, and the lens's loss of light in corners.

    The factor is a little nearer to 1 than what was measured, so that errors do not add up from picture to picture.
    """

    def __init__(self) -> None:
        self._corners = 0.0
        """Light that the corners lack, as a share of what they have."""
        self._lens: tuple[float, Bytes] | None = None

    def matched(self, view: View, blocks: Window, both: Bools, shown: Bytes) -> tuple[View, Floats32]:
        """Return the view with its light corrected, and its colours by blocks.

        Args:
            view: The camera's picture.
            blocks: The window of blocks about it.
            both: Blocks that mosaic and picture show.
            shown: Colours of the mosaic.
        """
        from_middle, colours = view.from_middle(blocks), view.colours(blocks)
        here = colours.mean(2)
        there = shown.astype(np.float32).mean(2)
        usable = both & (np.minimum(here, there) > _DARK) & (np.maximum(here, there) < _BRIGHT)
        gain = 1.0
        if np.count_nonzero(usable) >= _LEAST_BLOCKS:
            squared = from_middle[usable]
            ratio = np.log(there[usable] / here[usable]) - np.log1p(self._corners * squared)
            middle = float(np.median(ratio))
            self._learn(ratio - middle, squared)
            most = math.log(_MOST_GAIN)
            gain = math.exp(min(max(_GAIN_KEPT * middle, -most), most))
        lit = colours * (gain * (1 + self._corners * from_middle))[..., None]
        return self._applied(view, gain), np.asarray(lit, np.float32)

    def _learn(self, left: Floats32, squared: Floats32) -> None:
        """Learn the loss of light in corners from what is left of the ratios: the lens has the same in all pictures."""
        beside = squared - squared.mean()
        spread = float((beside * beside).sum())
        if spread > 1e-3 * len(squared):
            slope = float((np.clip(left, -0.2, 0.2) * beside).sum()) / spread
            self._corners = min(max(self._corners + _CORNERS_STEP * slope, 0.0), _MOST_CORNERS)

    def _applied(self, view: View, gain: float) -> View:
        lens = self._lens
        if lens is None or lens[1].shape != view.image.shape or abs(lens[0] - self._corners) > _CORNERS_NEWS:
            lens = self._lens = self._corners, _lens_gain(view.image, self._corners)
        image = cv2.multiply(view.image, lens[1], scale=gain / _LENS_UNIT)
        return replace(view, image=np.asarray(image, np.uint8))


def _lens_gain(image: Bytes, corners: float) -> Bytes:
    height, width = image.shape[:2]
    unit = corners * _LENS_UNIT / _corner(image)
    rows = (unit * (np.arange(height) - (height - 1) / 2) ** 2).astype(np.float32)
    columns = (unit * (np.arange(width) - (width - 1) / 2) ** 2).astype(np.float32)
    gain = cv2.convertScaleAbs(rows[:, None] + columns[None], alpha=1.0, beta=_LENS_UNIT)
    return np.asarray(cv2.cvtColor(gain, cv2.COLOR_GRAY2BGR), np.uint8)


def _corner(image: Bytes) -> float:
    """Return the squared distance of a corner from the middle, pixels."""
    height, width = image.shape[:2]
    return float(((height - 1) / 2) ** 2 + ((width - 1) / 2) ** 2)


@dataclass(frozen=True, slots=True)
class Patch:
    """Pixels of the mosaic, BGR on the cells of a window."""

    window: Window
    values: Bytes


class Alignment:
    """Moves pictures by the few decimetres that their poses are off, so that what they show meets what is shown.

    Part of each movement is left out: the mosaic stays where the poses, on average, put it.
    """

    KEPT: Final = 0.5
    LEAST_SHARE: Final = 0.75
    MOST_M: Final = 0.8
    SIDE: Final = 20
    """Blocks along one side of the square that is compared."""
    LEAST_RESPONSE: Final = 0.08

    @staticmethod
    def place(both: Bools, blocks: Window, below: tuple[float, float]) -> Window | None:
        """Return a square of cells that mosaic and picture share, None where there is none.

        It is the one nearest to straight ``below`` the camera (north, east): what stands there leans least.
        """
        side = Alignment.SIDE
        if min(blocks.shape) < side:
            return None
        share = cv2.boxFilter(both.astype(np.float32), -1, (side, side), anchor=(0, 0), borderType=cv2.BORDER_CONSTANT)
        share = share[: blocks.rows - side + 1, : blocks.columns - side + 1]
        half = (side - 1) / 2
        north, east = blocks.centres(np.arange(share.shape[0]) + half, np.arange(share.shape[1]) + half)
        away = np.hypot(north[:, None] - below[0], east[None] - below[1])
        away[share < Alignment.LEAST_SHARE] = np.inf
        row, column = divmod(int(away.argmin()), away.shape[1])
        if not math.isfinite(away[row, column]):
            return None
        cells = side * BLOCK
        return Window((blocks.row + row) * BLOCK, (blocks.column + column) * BLOCK, cells, cells, CELL_M)

    def __init__(self) -> None:
        half = self.SIDE * BLOCK // 2
        self._hann = cv2.createHanningWindow((half, half), cv2.CV_32F)

    def aligned(self, view: View, patch: Patch) -> View:
        """Return the view moved to where it fits best; unmoved where that is not clear."""
        one, other = (self._grey(image) for image in (patch.values, view.sampled(patch.window)))
        (right, down), response = cv2.phaseCorrelate(one, other, self._hann)
        off = 2 * CELL_M * math.hypot(right, down)
        if response < self.LEAST_RESPONSE or off > self.MOST_M:
            return view
        step = 2 * CELL_M * self.KEPT
        return view.moved(down * step, -right * step)

    @staticmethod
    def _grey(image: Bytes) -> Floats32:
        """Return it at half the size, the mean taken off."""
        half = cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        grey = cv2.cvtColor(half, cv2.COLOR_BGR2GRAY).astype(np.float32)
        return np.asarray(grey - grey.mean(), np.float32)


def _to_ground(window: Window) -> FloatArray:
    """Return (3, 3) from a window's (column, row, 1) to (north, east, 1)."""
    side = window.cell_m
    return np.array(
        [[0.0, -side, -(window.row + 0.5) * side], [side, 0.0, (window.column + 0.5) * side], [0.0, 0.0, 1.0]]
    )


def _blurred(layer: Floats32, sigma: float) -> Floats32:
    return np.asarray(cv2.GaussianBlur(layer, (0, 0), sigma, borderType=cv2.BORDER_CONSTANT), np.float32)
