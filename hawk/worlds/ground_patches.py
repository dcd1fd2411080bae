"""Ground of stalls in a picture of a real lot: which ground is bare, and how it is copied from stall to stall."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.worlds.scene.canvas import Floats, Points, as_floats
from hawk.worlds.world import TrueStall

TURN_DEG: Final = 4.0
"""Greatest turn between two stalls: shade keeps its direction within it."""
_SIZE_SHARE: Final = 0.12
_CORE_M: Final = 0.6
"""Lines and the shade of cars beside a stall lie within this distance of its long sides."""
_SUNLIT: Final = 0.8
"""Ground darker than this share of the usual one is in shade."""
_GREEN: Final = 7.0
"""Excess of green over red and blue from which a pixel is a plant ..."""
_YELLOW: Final = (35.0, 14.0)
"""... or over blue, while red exceeds green by less than the second: leaves in autumn, and no yellow paint."""
_MOST_GREEN: Final = 0.02
_MOST_TINT: Final = 24.0
_MOST_SPREAD: Final = 13.0
_NEAR_USUAL: Final = 0.13
_STRAIGHT_DEG: Final = 1.5
"""Smaller turns are left out, so that the picture stays as sharp as it is."""


Rims = tuple[float, float, float, float]
"""Pixels beyond the first and the second short end, and beyond the left and the right long side."""
_EDGES: Final = ((0, 1), (2, 3), (3, 0), (1, 2))


def _rim(border: int, reach: float) -> Rims:
    first, second, left, right = (reach if k == border else 0.0 for k in range(4))
    return first, second, left, right


@dataclass(frozen=True, slots=True, eq=False)
class Spot:
    """A stall in a picture: its ``corners`` (4, 2) in pixels, short ends first and third."""

    stall: TrueStall
    corners: Points

    @property
    def centre(self) -> Points:
        """Its middle, pixels."""
        return np.asarray(self.corners.mean(0))

    @property
    def angle(self) -> float:
        """Direction of its long sides, degrees; that of its other end is 180 more."""
        ahead = self.corners[3] + self.corners[2] - self.corners[0] - self.corners[1]
        return math.degrees(math.atan2(ahead[1], ahead[0]))

    @property
    def size(self) -> Points:
        """Length of the short and of the long sides, pixels."""
        sides = np.linalg.norm(np.roll(self.corners, -1, axis=0) - self.corners, axis=1)
        return np.array([sides[0] + sides[2], sides[1] + sides[3]]) / 2

    def turn_to(self, other: Spot) -> float:
        """Return the turn, degrees in -90..90, that makes it parallel to another."""
        return math.remainder(other.angle - self.angle, 180.0)

    def is_opposed(self, other: Spot) -> bool:
        """Return True where its first short end corresponds to the other one's second."""
        return abs(math.remainder(other.angle - self.angle, 360.0)) > 90.0

    def fits(self, other: Spot) -> bool:
        """Return True where a car of it may stand on another: of like size and nearly the same direction."""
        return abs(self.turn_to(other)) <= TURN_DEG and bool((abs(self.size / other.size - 1) <= _SIZE_SHARE).all())

    def grown(self, rims: Rims) -> Points:
        """Return its corners (4, 2), moved outwards by some pixels at each end and side."""
        along = (self.corners[[3, 2, 2, 3]] - self.corners[[0, 1, 1, 0]]) / self.size[1]
        across = (self.corners[[1, 1, 2, 2]] - self.corners[[0, 0, 3, 3]]) / self.size[0]
        first, second, left, right = rims
        ends, sides = np.array([-first, -first, second, second]), np.array([-left, right, right, -left])
        return np.asarray(self.corners + along * ends[:, None] + across * sides[:, None])

    def beyond(self, border: int, reach: float, start: float = 0.0) -> Points:
        """Return the strip (4, 2) from ``start`` to ``reach`` pixels beyond a border, numbered as `Rims` are."""
        first, second = _EDGES[border]
        inner, outer = self.grown(_rim(border, start)), self.grown(_rim(border, reach))
        return np.array([inner[first], inner[second], outer[second], outer[first]])


@dataclass(frozen=True, slots=True)
class Window:
    """A part of a picture: its rows and columns."""

    rows: slice
    columns: slice

    def mask(self, corners: Points, feather_px: float = 0.0) -> Floats:
        """Return an area (N, 2), pixels, as a mask 0..1 of the window's size, with a soft edge."""
        mask = np.zeros((self.rows.stop - self.rows.start, self.columns.stop - self.columns.start), np.uint8)
        inside = np.round((corners - (self.columns.start, self.rows.start)) * 16).astype(np.int32)
        cv2.fillConvexPoly(mask, inside, 255, cv2.LINE_AA, 4)
        values = as_floats(mask.astype(np.float32) / 255)
        return as_floats(cv2.GaussianBlur(values, (0, 0), feather_px)) if feather_px else values

    def of(self, picture: NDArray[Any]) -> Floats:
        """Return the part of a picture; what is written to it is written to the picture."""
        return picture[self.rows, self.columns]


class Ground:
    """A picture (BGR float32, 0..255) whose ground is judged; ``scale`` is metres per pixel.

    ``free`` are stalls without cars: most of them show the usual ground.
    """

    def __init__(self, picture: Floats, scale: float, free: Sequence[Spot]) -> None:
        self.picture = picture
        self.scale = scale
        self._smooth = as_floats(cv2.GaussianBlur(picture, (0, 0), 1.0))
        blue, green, red = cv2.split(self._smooth)
        is_yellow = (green - blue > _YELLOW[0]) & (red - green < _YELLOW[1])
        self._plants = (green - np.maximum(blue, red) > _GREEN) | is_yellow
        medians = [np.median(self._inside(self._smooth, spot, _CORE_M), axis=0) for spot in free]
        self._usual = as_floats(np.median(medians, axis=0)) if medians else np.ones(3, np.float32)

    @property
    def usual(self) -> float:
        """Brightness of the usual ground, 0..255."""
        return float(self._usual.mean())

    def window(self, spot: Spot, margin_m: float) -> Window:
        """Return the window about a spot."""
        low = np.floor(spot.corners.min(0) - margin_m / self.scale).astype(int)
        high = np.ceil(spot.corners.max(0) + margin_m / self.scale).astype(int) + 1
        rows, columns = self.picture.shape[:2]
        x0, y0, x1, y1 = max(0, low[0]), max(0, low[1]), min(columns, high[0]), min(rows, high[1])
        return Window(slice(int(y0), int(y1)), slice(int(x0), int(x1)))

    def has_plants(self, spot: Spot, rims: Rims) -> bool:
        """Return True where leaves hide part of a spot and of some pixels about it."""
        window = self.window(spot, 3.0)
        plants = window.of(self._plants)[window.mask(spot.grown(rims)) > 0.5]
        return bool(plants.mean() > _MOST_GREEN)

    def is_bare(self, spot: Spot, side_m: float) -> bool:
        """Return True for even ground of the usual colour, but for ``side_m`` metres beside each long side."""
        pixels = self._inside(self._smooth, spot, side_m)
        values, tint = pixels.mean(1), pixels - self._usual
        return (
            abs(float(np.median(values)) / self.usual - 1) < _NEAR_USUAL
            and float(values.std()) < _MOST_SPREAD
            and float(np.percentile(np.ptp(tint, axis=1), 95)) < _MOST_TINT
        )

    def is_sunlit(self, spot: Spot) -> bool:
        """Return True for a stall on whose ground nothing is dark, up to its lines."""
        values = self._inside(self._smooth, spot, 0.0).mean(1)
        return float(np.percentile(values, 1)) > _SUNLIT * self.usual

    def is_plain(self, spot: Spot, area: Points) -> bool:
        """Return True for even ground of the usual colour in an area (N, 2), pixels, near a spot."""
        window = self.window(spot, 3.0)
        pixels = window.of(self._smooth)[window.mask(area) > 0.5]
        if not len(pixels):
            return False
        tint = np.ptp(pixels - self._usual, axis=1)
        is_like = abs(float(np.median(pixels.mean(1))) / self.usual - 1) < _NEAR_USUAL
        return is_like and float(np.percentile(tint, 90)) < _MOST_TINT

    def _inside(self, picture: Floats, spot: Spot, side_m: float) -> Floats:
        window, side = self.window(spot, 1.0), -side_m / self.scale
        return as_floats(window.of(picture)[window.mask(spot.grown((0.0, 0.0, side, side))) > 0.5])


def moved(picture: Floats, source: Spot, target: Spot, window: Window) -> Floats:
    """Return the part of a picture that comes to lie in a window when a spot is moved and turned onto a target."""
    turn = source.turn_to(target)
    middle = (float(source.centre[0]), float(source.centre[1]))
    matrix = np.asarray(cv2.getRotationMatrix2D(middle, -turn, 1.0), np.float64)
    shift = target.centre - source.centre
    if abs(turn) < _STRAIGHT_DEG:
        matrix, shift = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), np.round(shift)
    matrix[:, 2] += shift - (window.columns.start, window.rows.start)
    size = (window.columns.stop - window.columns.start, window.rows.stop - window.rows.start)
    return as_floats(cv2.warpAffine(picture, matrix, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE))
