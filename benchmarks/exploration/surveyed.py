"""The planner's knowledge of a lot: the mapper's coarse layers, with the mapper's kind of errors.

The secret is the error model. Cells are judged from looks whose noise is smooth over some metres; a look weighs by
the distance flown since the last one, as in the mapper. A road or a drive looks like lot, but no stalls are near it.
The lot's border is off by a metre or two, and trees hide parts. Everything lies where the drone believes to be.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from benchmarks.exploration.lots import Lot
from benchmarks.exploration.setups import GOOD_SHARE, Setup
from hawk.algo.ground import COARSE_M, CoarseLayers, Slices, Window
from hawk.algo.mapper.core import MapperSettings
from hawk.algo.mapper.evidence import Novelty
from hawk.model.lot_map import TILE_M, Stall
from hawk.model.plans import Inbound
from hawk.model.poses import MapPose

FINE_M: Final = COARSE_M / 2
_AROUND_M: Final = 95.0
_BORDER_OFF_M: Final = 1.0
_SMOOTH_M: Final = 3.0
_LOOK_NOISE: Final = 0.5
_CLAMP: Final = 4.0
_PIECE_M2: Final = 100.0
_TREES_PER_HA: Final = 6.0
_ROAD_M: Final = 7.0

Grid = NDArray[np.float32]
Mask = NDArray[np.uint8]


class SurveyedMap:
    """Implements `hawk.algo.ground.LotMap` over one lot; ``errors`` False sees exactly."""

    def __init__(self, lot: Lot, setup: Setup, rng: np.random.Generator, *, errors: bool = True) -> None:
        low, high = np.array(lot.shape.bounds[:2]), np.array(lot.shape.bounds[2:])
        self.window = Window.around(np.array([low, high]), FINE_M, _AROUND_M).aligned(2)
        self._setup = setup
        self._rng = rng
        self._errors = errors
        truth = drawn(lot.shape, self.window)
        self._lot, self._likely = _believed(lot, truth, self.window, rng) if errors else (truth, truth)
        self._evidence: Grid = np.zeros(self.window.shape, np.float32)
        self._looks: Grid = np.zeros(self.window.shape, np.float32)
        self._well: Mask = np.zeros(self.window.shape, np.uint8)
        rows, columns = self.window.rows // 2, self.window.columns // 2
        self._layers: dict[str, Grid] = {
            name: np.zeros((rows, columns), np.float32) for name in ("lot", "seen", "well", "likely")
        }
        self._tiles: NDArray[np.float64] | None = None
        settings = MapperSettings()
        self._novelty = Novelty(settings.look_m, settings.still_weight)

    def look(self, true: MapPose, believed: MapPose) -> None:
        """Take one picture from the true place; it is projected to the place where the drone believes to be."""
        whole = self.window.cells_of(*self._setup.outline(believed, 1.0).T)
        part = _slices(whole, self.window)
        origin = np.array([part[1].start, part[0].start])
        seen = within(whole - origin, part)
        good = self.window.cells_of(*self._setup.outline(believed, GOOD_SHARE).T)
        self._well[part] |= within(good - origin, part)
        error = self.window.cells_of(np.array(true.north), np.array(true.east))
        error = np.round(error - self.window.cells_of(np.array(believed.north), np.array(believed.east))).astype(int)
        self._fuse(part, seen, (int(error[1]), int(error[0])), self._novelty.of(believed))
        self._summarise(part, (int(error[1]), int(error[0])))
        self._remember(whole)

    def coarse(self, window: Window) -> CoarseLayers:
        """Return the coarse layers over a window, 0 outside what is kept."""
        top, left = window.row - self.window.row // 2, window.column - self.window.column // 2
        size = (self.window.rows // 2, self.window.columns // 2)
        rows = slice(max(top, 0), min(top + window.rows, size[0]))
        columns = slice(max(left, 0), min(left + window.columns, size[1]))
        there = (slice(rows.start - top, rows.stop - top), slice(columns.start - left, columns.stop - left))
        layers = {}
        for name, layer in self._layers.items():
            layers[name] = np.zeros(window.shape, np.float32)
            layers[name][there] = layer[rows, columns]
        return CoarseLayers(window, layers["lot"], layers["seen"], layers["well"], layers["likely"])

    def known_extent(self) -> NDArray[np.float64] | None:
        """Return two corners around all tiles that were looked at, as the mapper does."""
        return self._tiles

    def lot_area_m2(self) -> float:
        """Return how much lot is known."""
        return float(self._layers["lot"].sum()) * COARSE_M**2

    def inbound(self, north: float, east: float) -> Inbound:  # noqa: ARG002 - the mapper's interface
        """No place is asked for in these flights."""
        return Inbound.UNKNOWN

    def unclear_stalls(self) -> Mapping[int, Stall]:
        """There are no stalls here: nothing is flown to for a second look."""
        return {}

    def _fuse(self, part: Slices, seen: Mask, shift: tuple[int, int], weight: float) -> None:
        signal = 2 * _shifted(self._likely, part, shift) - 1
        if self._errors:
            signal = signal + _LOOK_NOISE * _noise(self._rng, seen.shape)
        looks = self._looks[part]
        w = np.clip(1 - looks, np.float32(weight), 1) * seen
        self._evidence[part] = np.clip(self._evidence[part] + w * signal, -_CLAMP, _CLAMP)
        self._looks[part] = looks + w

    def _summarise(self, part: Slices, shift: tuple[int, int]) -> None:
        """Bring the coarse layers up to date: shares of two by two cells."""
        known = (self._looks[part] >= 0.5).astype(np.float32)
        likely = (self._evidence[part] > 0) * known
        near_stalls = _shifted(self._lot, part, shift)
        values = {"lot": likely * near_stalls, "seen": known, "well": self._well[part] * known, "likely": likely}
        there = tuple(slice(s.start // 2, s.stop // 2) for s in part)
        for name, layer in values.items():
            self._layers[name][there[0], there[1]] = _coarse(layer)

    def _remember(self, whole: NDArray[np.float64]) -> None:
        cells = (whole + 0.5 + (self.window.column, self.window.row)) * FINE_M / TILE_M
        left, top = np.floor(cells.min(0)) * TILE_M
        right, bottom = np.ceil(cells.max(0)) * TILE_M
        corners = np.array([[-bottom, left], [-top, right]])
        if self._tiles is not None:
            corners = np.stack([np.minimum(corners[0], self._tiles[0]), np.maximum(corners[1], self._tiles[1])])
        self._tiles = corners


class KnownLotMap(SurveyedMap):
    """A map on which the lot is known before the flight: it has only to be seen."""

    def __init__(self, lot: Lot, setup: Setup, rng: np.random.Generator, *, errors: bool = False) -> None:
        super().__init__(lot, setup, rng, errors=errors)
        self._known_lot = _coarse(self._lot)
        self._area = lot.area
        rows, columns = np.nonzero(self._lot)
        self._remember(np.array([[columns.min(), rows.min()], [columns.max(), rows.max()]]))
        self._reveal()

    def look(self, true: MapPose, believed: MapPose) -> None:
        """Take one picture."""
        super().look(true, believed)
        self._reveal()

    def lot_area_m2(self) -> float:
        """Return how large the lot is."""
        return self._area

    def _reveal(self) -> None:
        """Mark everything outside the lot as seen, so that nothing is expected there."""
        for name in ("lot", "likely"):
            self._layers[name][:] = self._known_lot
        seen = self._layers["seen"]
        np.maximum(seen, 1 - self._known_lot, out=seen)


class Coverage:
    """The share of a lot that was really seen, by the true pose."""

    def __init__(self, lot: Lot, setup: Setup) -> None:
        low, high = np.array(lot.shape.bounds[:2]), np.array(lot.shape.bounds[2:])
        self._window = Window.around(np.array([low, high]), FINE_M, _AROUND_M).aligned(2)
        self._setup = setup
        self._left = drawn(lot.shape, self._window).astype(np.uint8)
        self._total = int(self._left.sum())
        self._seen = 0

    def look(self, pose: MapPose) -> None:
        """Take one picture from the true pose."""
        cells = self._window.cells_of(*self._setup.outline(pose, GOOD_SHARE).T)
        part = _slices(cells, self._window)
        new = within(cells - (part[1].start, part[0].start), part) & self._left[part]
        self._seen += int(np.count_nonzero(new))
        self._left[part] -= new

    @property
    def share(self) -> float:
        """Share of the lot that was seen, 0..1."""
        return self._seen / self._total


def _coarse(layer: Grid) -> Grid:
    """Return the mean of two by two cells each."""
    means = layer.reshape(layer.shape[0] // 2, 2, layer.shape[1] // 2, 2).mean((1, 3))
    return np.asarray(means, dtype=np.float32)


def drawn(shape: shapely.Geometry, window: Window) -> Grid:
    """Return 1 where cells of the window lie in the shape, 0 elsewhere."""
    image = np.zeros(window.shape, np.uint8)
    parts = shapely.get_parts(shape)
    rings = [(1, part.exterior) for part in parts] + [(0, ring) for part in parts for ring in part.interiors]
    for value, ring in rings:
        corners = np.array(ring.coords)
        cells = window.cells_of(corners[:, 0], corners[:, 1])
        cv2.fillPoly(image, [np.round(cells * 16).astype(np.int32)], (value,), shift=4)
    return image.astype(np.float32)


def _believed(lot: Lot, truth: Grid, window: Window, rng: np.random.Generator) -> tuple[Grid, Grid]:
    """Return where stalls make a lot, and what looks like one: border off, trees, a road with a drive to it."""
    inside = cv2.distanceTransform(truth.astype(np.uint8), cv2.DIST_L2, 5)
    outside = cv2.distanceTransform((1 - truth).astype(np.uint8), cv2.DIST_L2, 5)
    off = _BORDER_OFF_M / FINE_M * _noise(rng, truth.shape)
    believed = ((inside - outside + off) > 0).astype(np.uint8)
    for _ in range(rng.poisson(_TREES_PER_HA * lot.area / 1e4)):
        cells = np.argwhere(truth > 0)
        row, column = cells[int(rng.integers(len(cells)))]
        cv2.circle(believed, (int(column), int(row)), round(rng.uniform(2, 4) / FINE_M), (0,), cv2.FILLED)
    road = drawn(_road(lot, rng), window).astype(np.uint8)
    believed = _without_specks(believed)
    return believed.astype(np.float32), (believed | road).astype(np.float32)


def _road(lot: Lot, rng: np.random.Generator) -> shapely.Geometry:
    """A straight road beside the lot, and a drive from the lot to it."""
    angle, away = rng.uniform(0, math.tau), rng.uniform(4, 12) + _ROAD_M / 2
    along = np.array([-math.sin(angle), math.cos(angle)])
    outward = np.array([math.cos(angle), math.sin(angle)])
    corners = np.array(lot.shape.convex_hull.exterior.coords)
    rim = corners[int(np.argmax(corners @ outward))]
    middle = rim + outward * away
    road = shapely.LineString([middle - 400 * along, middle + 400 * along]).buffer(_ROAD_M / 2)
    return shapely.union(road, shapely.LineString([rim - outward * 3, middle]).buffer(_ROAD_M / 2))


def _without_specks(mask: Mask) -> Mask:
    """Drop pieces and fill holes that the mapper's outline would not show."""
    most = _PIECE_M2 / FINE_M**2
    for value in (1, 0):
        _, labels, stats, _ = cv2.connectedComponentsWithStats((mask == value).astype(np.uint8), connectivity=4)
        small = stats[:, cv2.CC_STAT_AREA] < most
        small[0] = False
        mask = np.where(small[labels], 1 - value, mask).astype(np.uint8)
    return mask


def _noise(rng: np.random.Generator, shape: tuple[int, ...]) -> Grid:
    """Return noise of standard deviation 1 (about) that is smooth over `_SMOOTH_M`."""
    step = _SMOOTH_M / FINE_M
    small = rng.standard_normal((math.ceil(shape[0] / step) + 1, math.ceil(shape[1] / step) + 1)).astype(np.float32)
    wide = cv2.resize(small * 1.4, (shape[1], shape[0]), interpolation=cv2.INTER_CUBIC)
    return np.asarray(wide, dtype=np.float32)


def _slices(cells: NDArray[np.float64], window: Window) -> Slices:
    """Return the part of the window around the cells, on whole coarse cells."""
    low = np.floor(cells.min(0) / 2).astype(int) * 2
    high = (np.floor(cells.max(0) / 2).astype(int) + 1) * 2
    left, top = np.clip(low, 0, (window.columns - 2, window.rows - 2)).tolist()
    right, bottom = np.clip(high, (left + 2, top + 2), (window.columns, window.rows)).tolist()
    return slice(top, bottom), slice(left, right)


def within(corners: NDArray[np.float64], part: Slices) -> Mask:
    """Return 1 where a cell's middle lies in a convex outline of (column, row), in either direction."""
    rows = np.arange(part[0].stop - part[0].start)[:, None]
    columns = np.arange(part[1].stop - part[1].start)[None]
    following = np.roll(corners, -1, axis=0)
    area = (corners[:, 0] * following[:, 1] - following[:, 0] * corners[:, 1]).sum()
    sides = math.copysign(1.0, area) * (following - corners)
    inside = np.ones((rows.shape[0], columns.shape[1]), np.bool_)
    for (x, y), (along_x, along_y) in zip(corners.tolist(), sides.tolist(), strict=True):
        inside &= along_x * (rows - y) >= along_y * (columns - x)
    return inside.view(np.uint8)


def _shifted(layer: Grid, part: Slices, shift: tuple[int, int]) -> Grid:
    """Return a part of the layer as it looks from ``shift`` (rows, columns) farther, 0 beyond its edge."""
    rows = np.clip(np.arange(part[0].start, part[0].stop) + shift[0], 0, layer.shape[0] - 1)
    columns = np.clip(np.arange(part[1].start, part[1].stop) + shift[1], 0, layer.shape[1] - 1)
    return layer[np.ix_(rows, columns)]
