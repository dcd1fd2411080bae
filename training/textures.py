"""Ground, leaves and cars cut from pictures of real ground (`training.ground`).

Textures hold parts of the pictures, so they are never written to a file.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.worlds.scene.canvas import Bytes, Floats, Points, as_bytes, as_floats
from hawk.worlds.scene.cars import SPRITE_M
from training.ground import METRES_PER_PIXEL, Ground, Region
from training.targets import UNKNOWN

Mask = NDArray[np.bool_]

SHEET_PIXELS: Final = 512
_PATCH_PIXELS: Final = 32
_STRIDE: Final = 4
_WOVEN: Final = 40
"""Patches of a sheet: those most alike the first in colour and contrast."""
_FEWEST: Final = 8
"""Patches below which no sheet is woven."""
_PAVINGS, _GREENS = 3, 2
"""Sheets of a region of paving, and of grass and of leaves."""
_TREND_PIXELS: Final = 10.0
"""Brightness that varies over more than this is left to the drawing."""
_PAVING_CONTRAST, _GRASS_CONTRAST, _LEAF_CONTRAST, _WILD_CONTRAST = 0.09, 0.16, 0.35, 0.45
"""Relative deviation at most; that of leaves and of wild ground is above that of grass."""
_PAVING_EDGES, _PLANT_EDGES = 0.35, 0.2
"""Coherence of the gradients of paving and of plants at most: 1 is one straight edge (Bigun and Granlund 1987)."""
_GREEN, _WILD_GREEN, _GRASS_GREEN, _LEAF_GREEN = 0.06, 0.02, 0.08, 0.1
"""(2 green - blue - red) / mean: paving has less, the others have more."""
_LIT, _LIT_PLANTS = 0.7, 0.35
"""Share of a region's lit ground below which a patch, or the ground about a car, and plants are in the shade."""
_LIT_PERCENTILE: Final = 75.0
_STALL_MARGIN, _NEAR_STALLS = 5, 61
"""Pixels about a stall that may show its marks, and within which open ground counts as paving where no lot is known."""

_CAR_LENGTHS, _CAR_WIDTHS = (3.3, 5.4), (1.4, 2.2)
_CAR_FILLS: Final = 0.78
"""Share of the box about a car that the car must fill."""
_CAR_INSET: Final = 0.96
_BESIDE_M: Final = 0.7


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """Real ground that goes on without a seam: its picture over its mean (S, S, 3), and that mean, BGR."""

    variation: NDArray[np.float16] = field(repr=False)
    colour: Floats


@dataclass(frozen=True, slots=True, eq=False)
class CarPicture:
    """A car from above, BGR (rows, columns, 3) at `SPRITE_M`, its length along the columns.

    ``light`` is the direction to the sun, a unit vector along columns and rows; None: not known.
    """

    pixels: Bytes = field(repr=False)
    light: Points | None


@dataclass(frozen=True, slots=True, eq=False)
class Textures:
    """Everything that was cut; painters in other processes get it as a whole. ``wild`` is ground as of gardens."""

    paving: tuple[Sheet, ...]
    grass: tuple[Sheet, ...]
    wild: tuple[Sheet, ...]
    leaves: tuple[Sheet, ...]
    cars: tuple[CarPicture, ...]


def cut_textures(ground: Ground, rng: np.random.Generator) -> Textures:
    """Cut what the regions of real ground show; regions that were left out are not among them."""
    paving: list[Sheet] = []
    grass: list[Sheet] = []
    wild: list[Sheet] = []
    leaves: list[Sheet] = []
    cars: list[CarPicture] = []
    for region in ground.regions:
        look = _Look(region)
        paving += look.sheets(look.paving(), _PAVINGS, rng)
        grass += look.sheets(look.plants(_GRASS_GREEN, 0.0, _GRASS_CONTRAST), _GREENS, rng)
        wild += look.sheets(look.plants(_WILD_GREEN, _GRASS_CONTRAST, _WILD_CONTRAST), _GREENS, rng)
        leaves += look.sheets(look.plants(_LEAF_GREEN, _GRASS_CONTRAST, _LEAF_CONTRAST), _GREENS, rng)
        cars += look.cars()
    return Textures(tuple(paving), tuple(grass), tuple(wild), tuple(leaves), tuple(cars))


class _Look:
    """One region: which of its ground is what."""

    def __init__(self, region: Region) -> None:
        scene = region.scene
        self._scene = scene
        self._picture = scene.image.astype(np.float32)
        size = scene.image.shape[:2]
        stalls, near = np.zeros(size, np.uint8), np.zeros(size, np.uint8)
        for quad in scene.quads:
            cv2.fillConvexPoly(stalls, np.round(quad).astype(np.int32), 1)
        near = as_bytes(cv2.dilate(stalls, np.ones((_NEAR_STALLS, _NEAR_STALLS), np.uint8)))
        stalls = as_bytes(cv2.dilate(stalls, np.ones((2 * _STALL_MARGIN + 1,) * 2, np.uint8)))
        self._lot, self._car = scene.labels[..., 0], scene.labels[..., 1]
        seen = np.ones(size, np.bool_) if scene.seen is None else scene.seen > 0
        self._open = seen & (self._car == 0) & (stalls == 0)
        self._near = near > 0
        self._levels = self._picture.mean(2)
        mean = cv2.blur(self._levels, (_PATCH_PIXELS,) * 2)
        spread = cv2.blur(self._levels**2, (_PATCH_PIXELS,) * 2) - mean**2
        self._mean = as_floats(mean)
        self._contrast = as_floats(np.sqrt(np.maximum(spread, 0)) / np.maximum(mean, 1))
        colour = as_floats(cv2.blur(self._picture, (_PATCH_PIXELS,) * 2))
        self._greenness = (3 * colour[..., 1] - colour.sum(2)) / np.maximum(mean, 1)
        self._edges = _coherence(self._levels)
        paved = self._open & ((self._lot == 1) | ((self._lot == UNKNOWN) & self._near))
        self._lit = float(np.percentile(self._levels[paved], _LIT_PERCENTILE)) if paved.any() else 0.0
        self._paved = paved

    def paving(self) -> Mask:
        """Return the middles of patches of lit paving without cars, marks of stalls or leaves."""
        plain = (self._contrast < _PAVING_CONTRAST) & (self._greenness < _GREEN) & (self._edges < _PAVING_EDGES)
        return _whole(self._paved) & plain & (self._mean > _LIT * self._lit)

    def plants(self, greenness: float, least: float, most: float) -> Mask:
        """Return the middles of patches of plants that are so green and whose contrast lies between two limits."""
        kept = (self._contrast >= least) & (self._contrast < most) & (self._greenness > greenness)
        kept &= (self._edges < _PLANT_EDGES) & (self._mean > _LIT_PLANTS * self._lit)
        return np.asarray(_whole(self._open & (self._lot == 0)) & kept)

    def sheets(self, middles: Mask, count: int, rng: np.random.Generator) -> Iterator[Sheet]:
        """Yield up to ``count`` sheets woven of patches about these middles, each of patches that are alike."""
        grid = np.zeros_like(middles)
        grid[::_STRIDE, ::_STRIDE] = True
        rows, columns = np.nonzero(middles & grid)
        if len(rows) < _FEWEST:
            return
        patches = [self._picture[r - 16 : r + 16, c - 16 : c + 16] for r, c in zip(rows, columns, strict=True)]
        kind = np.stack([self._mean[rows, columns] / self._mean[rows, columns].mean(), self._contrast[rows, columns]])
        hue = np.array([patch.mean((0, 1)) / patch.mean() for patch in patches]).T
        kinds = np.concatenate([kind, hue])
        for first in rng.choice(len(rows), count, replace=False).tolist():
            apart = np.abs(kinds - kinds[:, first : first + 1]).sum(0)
            yield woven([patches[k] for k in np.argsort(apart, kind="stable")[:_WOVEN].tolist()], rng)

    def cars(self) -> Iterator[CarPicture]:
        """Yield the cars of taken stalls that stand in the light."""
        boxes = list(self._car_boxes())
        shadow = np.sum([self._shadow_of(*box) for box in boxes], axis=0) if boxes else np.zeros(2)
        length = float(np.linalg.norm(shadow))
        for centre, along, (long, wide) in boxes:
            ahead = np.array([np.cos(along), np.sin(along)])
            aside = np.array([-ahead[1], ahead[0]])
            sun = None if length == 0 else -np.array([shadow @ ahead, shadow @ aside]) / length
            if self._ground_about(centre, ahead * long, aside * wide) > _LIT * self._lit:
                yield CarPicture(_straightened(self._scene.image, centre, ahead, long, wide), sun)

    def _car_boxes(self) -> Iterator[tuple[Points, float, tuple[float, float]]]:
        """Yield middle (pixels), direction of the length (radians) and length and width (metres) of parked cars."""
        scene = self._scene
        _, parts = cv2.connectedComponents((self._car == 1).astype(np.uint8))
        sure = scene.taken & scene.judged
        if scene.unclear is not None:
            sure &= ~scene.unclear
        for quad in scene.quads[sure]:
            column, row = np.round(quad.mean(0)).astype(int)
            part = parts[row, column]
            if not part:
                continue
            spots = np.argwhere(parts == part)[:, ::-1].astype(np.float32)
            (x, y), sides, degrees = cv2.minAreaRect(spots)
            long, wide = max(sides) * METRES_PER_PIXEL, min(sides) * METRES_PER_PIXEL
            fills = len(spots) / max(sides[0] * sides[1], 1)
            if _within(long, _CAR_LENGTHS) and _within(wide, _CAR_WIDTHS) and fills > _CAR_FILLS:
                along = np.radians(degrees + (0 if sides[0] >= sides[1] else 90))
                yield np.array([x, y]), float(along), (long, wide)

    def _shadow_of(self, centre: Points, along: float, size: tuple[float, float]) -> Points:
        """Return a vector from a car to where the ground about it is darkest, longer the darker it is."""
        ahead = np.array([np.cos(along), np.sin(along)])
        places, levels = self._about(centre, ahead * size[0], np.array([-ahead[1], ahead[0]]) * size[1])
        if len(levels) == 0:
            return np.zeros(2)
        away = (places - centre) / np.linalg.norm(places - centre, axis=1, keepdims=True)
        return np.asarray(((levels.mean() - levels)[:, None] * away).mean(0))

    def _ground_about(self, centre: Points, ahead: Points, aside: Points) -> float:
        levels = self._about(centre, ahead, aside)[1]
        return float(np.percentile(levels, _LIT_PERCENTILE)) if len(levels) else 0.0

    def _about(self, centre: Points, ahead: Points, aside: Points) -> tuple[Points, Floats]:
        """Return places (N, 2) in a ring about a car and the levels (N,) of the ground there, without other cars."""
        angles = np.linspace(0, 2 * np.pi, 48, endpoint=False)[:, None]
        ring = np.cos(angles) * _grown(ahead) + np.sin(angles) * _grown(aside)
        places = centre + ring / METRES_PER_PIXEL
        columns, rows = np.round(places).astype(int).T
        height, width = self._levels.shape
        inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        inside[inside] = self._car[rows[inside], columns[inside]] == 0
        return places[inside], self._levels[rows[inside], columns[inside]]


def _coherence(levels: Floats) -> Floats:
    """Return how much the gradients about each pixel, over a patch, have one direction, 0 to 1."""
    right, down = (cv2.Sobel(levels, cv2.CV_32F, *order) for order in ((1, 0), (0, 1)))
    xx, yy, xy = (cv2.blur(part, (_PATCH_PIXELS,) * 2) for part in (right * right, down * down, right * down))
    return as_floats(np.hypot(xx - yy, 2 * xy) / np.maximum(xx + yy, 1e-3))


def _grown(side: Points) -> Points:
    """Return the half axis (metres) of an ellipse a little outside a car of that length and direction."""
    length = float(np.linalg.norm(side))
    return side * ((length / 2 + _BESIDE_M) / length)


def _within(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] <= value <= limits[1]


def _whole(mask: Mask) -> Mask:
    """Return the middles of the patches that lie wholly in a mask."""
    inner = cv2.erode(mask.astype(np.uint8), np.ones((_PATCH_PIXELS + 1,) * 2, np.uint8), borderValue=0)
    return np.asarray(inner > 0)


def _straightened(image: Bytes, centre: Points, ahead: Points, long: float, wide: float) -> Bytes:
    """Return the box about a car, its length along the columns, at `SPRITE_M`."""
    columns, rows = round(long * _CAR_INSET / SPRITE_M), round(wide * _CAR_INSET / SPRITE_M)
    step = SPRITE_M / METRES_PER_PIXEL
    across, down = ahead * step, np.array([-ahead[1], ahead[0]]) * step
    corner = centre - across * (columns - 1) / 2 - down * (rows - 1) / 2
    move = np.array([[across[0], down[0], corner[0]], [across[1], down[1], corner[1]]])
    flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
    return as_bytes(cv2.warpAffine(image, move, (columns, rows), flags=flags, borderMode=cv2.BORDER_REPLICATE))


def woven(patches: Sequence[NDArray[np.float32]], rng: np.random.Generator) -> Sheet:
    """Weave a sheet of patches (P, P, 3), BGR: they overlap by some half, and the sum deviates as much as each of them
    (weights over the root of the sum of their squares: Heitz and Neyret 2018, doi 10.1145/3233304).
    """
    side, half = patches[0].shape[0], patches[0].shape[0] // 2
    window = np.hanning(side + 2)[1:-1].astype(np.float32)
    weight = (window[:, None] * window)[..., None]
    rough = [_without_trend(patch) for patch in patches]
    total = np.zeros((SHEET_PIXELS, SHEET_PIXELS, 3), np.float32)
    squares = np.zeros((SHEET_PIXELS, SHEET_PIXELS, 1), np.float32)
    lattice = np.stack(np.meshgrid(*[np.arange(0, SHEET_PIXELS, half)] * 2), -1).reshape(-1, 2)
    for row, column in (lattice + rng.integers(-half // 2, half // 2 + 1, lattice.shape)).tolist():
        rows, columns = (np.arange(at, at + side) % SHEET_PIXELS for at in (row, column))
        place = np.ix_(rows, columns)
        total[place] += weight * rough[int(rng.integers(len(rough)))]
        squares[place] += weight**2
    colour = as_floats(np.mean([patch.mean((0, 1)) for patch in patches], axis=0))
    return Sheet((1 + total / np.sqrt(squares)).astype(np.float16), colour)


def _without_trend(patch: NDArray[np.float32]) -> Floats:
    """Return the relative deviations of a patch from its mean, without those that a drawing has itself."""
    relative = patch / np.maximum(patch.mean((0, 1)), 1) - 1
    return as_floats(relative - cv2.GaussianBlur(relative, (0, 0), _TREND_PIXELS, borderType=cv2.BORDER_REFLECT))
