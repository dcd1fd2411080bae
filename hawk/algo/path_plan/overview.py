"""A large map as one plan sees it, dense near the drone and coarse far away, so that no plan looks at all of it again.

Ground that no frame can have changed is kept by tiles (`hawk.model.lot_map.TILE_M`): the wanted ground in a few lumps,
and the area of lot and of ground seen well. Tiles near the drone are made again with every frame; the others are made
once, a block of them a frame, before the plan speaks of the whole. A plan is made from this and the drone's pose.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import COARSE_M, Bools, Floats, Grid, Mask, Place, Slices, Window
from hawk.algo.path_plan.field import InformationField, gathered
from hawk.algo.path_plan.footprint import Footprint
from hawk.algo.path_plan.grid_search import farthest_in_sight
from hawk.algo.path_plan.lot_ground import FenceGuard
from hawk.algo.path_plan.tour import Wanted
from hawk.model.lot_map import TILE_M
from hawk.model.plans import LeftOut

NEAR_M: Final = 110.0  # within it the ground is looked at with every frame
AROUND_TILES: Final = 2  # tiles about everything seen that belong to the whole
BLOCK: Final = 8  # tiles a side of the block that is made in one frame
MOST_LUMPS: Final = 400  # far lumps in a tour, the nearest first
_CELLS: Final = round(TILE_M / COARSE_M)
_LUMP: Final = 8  # cells a side
_MARGIN: Final = 25  # cells: ground farther off changes nothing
_LEAST_STEP: Final = 2  # cells a routing cell
_MOST_STEPS: Final = 128  # routing cells a side


@dataclass(frozen=True, slots=True)
class GroundPart:
    """A part of the ground: ``tiles`` (cells of `TILE_M`), and the ``field`` of them with a margin about them."""

    tiles: Window
    field: InformationField

    @property
    def inner(self) -> Slices:
        """The tiles' part of the field."""
        return self.field.window.part(cells_of_tiles(self.tiles))


def cells_of_tiles(tiles: Window) -> Window:
    """Return the window of coarse cells that covers a window of tiles."""
    top, left = tiles.row * _CELLS, tiles.column * _CELLS
    return Window(top, left, tiles.rows * _CELLS, tiles.columns * _CELLS, COARSE_M)


def with_margin(tiles: Window) -> Window:
    """Return the window of coarse cells from which a part's field is to be made."""
    return cells_of_tiles(tiles).grown(_MARGIN)


def near_tiles(whole: Window, place: Place) -> Window:
    """Return the tiles of a whole that are looked at with every frame; those at its edge for a place beyond it."""
    row, column = -place[0] / TILE_M, place[1] / TILE_M
    row = min(max(row, whole.row), whole.row + whole.rows)
    column = min(max(column, whole.column), whole.column + whole.columns)
    reach = NEAR_M / TILE_M
    top, left = max(math.floor(row - reach), whole.row), max(math.floor(column - reach), whole.column)
    bottom = min(math.ceil(row + reach), whole.row + whole.rows)
    right = min(math.ceil(column + reach), whole.column + whole.columns)
    return Window(top, left, bottom - top, right - left, TILE_M)


class Overview:
    """All of the ground of one exploration."""

    def __init__(self) -> None:
        self._whole = Window(0, 0, 0, 0, TILE_M)
        self._made = np.zeros((0, 0), np.bool_)
        self._sums = np.zeros((5, 0, 0))
        """Square metres a tile: lot, well seen, lot that was seen well, wanted that does not lie beyond the lot, and
        ground of the survey beyond the lot that was not looked at.
        """
        self._left_out = np.zeros((4, 0, 0))
        """Square metres a tile that were not looked at, in the order of `hawk.model.plans.LeftOut`."""
        self._lumps = np.zeros((3, 0, 0))
        """Of each lump: square metres wanted, and their moments north and east."""
        self._allowed: Mask = np.zeros((0, 0), np.uint8)

    @property
    def is_complete(self) -> bool:
        """True when every tile was made."""
        return self._made.size > 0 and bool(self._made.all())

    @property
    def lot_m2(self) -> float:
        """Area of known lot, square metres."""
        return float(self._sums[0].sum())

    @property
    def well_m2(self) -> float:
        """Area that was seen well, square metres."""
        return float(self._sums[1].sum())

    @property
    def wanted_lot_m2(self) -> float:
        """Wanted area without what lies beyond the lot's border, square metres: some of it alone may be left out."""
        return float(self._sums[3].sum())

    @property
    def unlooked_m2(self) -> float:
        """Ground of the survey beyond the lot's border that was not looked at and may hold a row, square metres."""
        return float(self._sums[4].sum())

    @property
    def left_out(self) -> LeftOut:
        """Area that was not looked at, by its reason."""
        return LeftOut(*(round(float(area), 1) for area in self._left_out.sum((1, 2))))

    @property
    def found_share(self) -> float:
        """Share (0..1) of known lot in it and that ground: the higher, the closer the fence was drawn about the lot."""
        return self.lot_m2 / (self.lot_m2 + self.unlooked_m2) if self.lot_m2 > 0 else 0.0

    @property
    def seen_share(self) -> float:
        """Share (0..1) of the known lot that was seen well, 0 when none is known."""
        return float(self._sums[2].sum()) / self.lot_m2 if self.lot_m2 > 0 else 0.0

    def whole(self, extent: Floats) -> Window:
        """Return the tiles of the ground: about everything seen, two corners (2, 2), and never fewer than before."""
        tiles = Window.around(extent, TILE_M).grown(AROUND_TILES)
        self._grow(self._whole.joined(tiles) if self._whole.rows else tiles)
        return self._whole

    def missing(self, place: Place, near: Window) -> Window | None:
        """Return the block of tiles to be made next, the nearest to a place; None when only near ones are missing."""
        made = self._made.copy()
        made[self._whole.part(near)] = True
        left = np.argwhere(~made)
        if len(left) == 0:
            return None
        away = np.hypot(
            left[:, 0] + self._whole.row + 0.5 + place[0] / TILE_M,
            left[:, 1] + self._whole.column + 0.5 - place[1] / TILE_M,
        )
        row, column = left[int(np.argmin(away))] // BLOCK * BLOCK
        rows, columns = min(BLOCK, self._whole.rows - int(row)), min(BLOCK, self._whole.columns - int(column))
        return Window(self._whole.row + int(row), self._whole.column + int(column), rows, columns, TILE_M)

    def forget(self) -> None:
        """Have every tile made again: other ground is wanted from now on."""
        self._made[:] = False

    def take(self, part: GroundPart, share: Grid, left_out: Floats | None = None) -> None:
        """Make the tiles of a part.

        ``share`` (0..1) is the wanted share of the field's cells, ``left_out`` (4, H, W) their area that was not looked
        at, square metres; None: not asked.
        """
        field, inner, there = part.field, part.inner, self._whole.part(part.tiles)
        area = field.window.cell_m**2
        lot, well = field.lot[inner], field.well[inner]
        wanted, unlooked = share[inner], np.zeros_like(lot)
        if field.beyond is not None:
            wanted, unlooked = wanted * (1 - field.beyond.near[inner]), field.beyond.all[inner].astype(np.float32)
        for index, layer in enumerate((lot, well, np.minimum(lot, well), wanted, unlooked)):
            self._sums[index][there] = _blocks(layer, _CELLS) * area
        if left_out is not None:
            for index, layer in enumerate(left_out):
                self._left_out[index][there] = _blocks(layer[inner], _CELLS)
        self._lumps[(slice(None), *_scaled(there, _CELLS // _LUMP))] = _lumps_of(part, share[inner] * area)
        self._allowed[_scaled(there, _CELLS)] = field.allowed[inner]
        self._made[there] = True

    def wanted(self, part: GroundPart, share: Grid, spare: float) -> Wanted:
        """Return the ground to be shown: the near part's cells by their share (0..1), the nearest lumps of the rest."""
        rows, columns = part.inner
        cells, weights = gathered(share[rows, columns], cells_of_tiles(part.tiles))
        lumps = self._lumps.copy()
        lumps[(slice(None), *_scaled(self._whole.part(part.tiles), _CELLS // _LUMP))] = 0.0
        found = lumps[:, lumps[0] > 0]
        if found.shape[1] == 0:
            return Wanted(cells, weights, spare)
        places = (found[1:] / found[0]).T
        north, east = part.tiles.middle
        nearest = np.argsort(np.hypot(places[:, 0] - north, places[:, 1] - east), kind="stable")[:MOST_LUMPS]
        return Wanted(
            np.concatenate([cells, places[nearest].astype(np.float32)]),
            np.concatenate([weights, found[0, nearest].astype(np.float32)]),
            spare,
        )

    def are_allowed(self, places: Floats) -> Bools:
        """Return True for those of places (T, 2) of (north, east) where the drone may be, as far as is known."""
        rows, columns, inside = cells_of_tiles(self._whole).cells_at(places)
        return np.asarray(inside & (self._allowed[rows, columns] > 0)) if self._allowed.size else inside

    def corner_towards(self, place: Place, end: Place) -> Place | None:
        """Return the farthest place on the shortest path to ``end`` that a straight line reaches, None without a path.

        The larger the map, the coarser the path.
        """
        shape = self._allowed.shape
        step = max(_LEAST_STEP, -(-max(shape) // _MOST_STEPS))
        rows, columns = (size // step for size in shape)
        free = self._allowed[: rows * step, : columns * step].reshape(rows, step, columns, step).min((1, 3))
        return farthest_in_sight(free, cells_of_tiles(self._whole), step, place, end)

    def _grow(self, whole: Window) -> None:
        """Make room for a larger whole."""
        if whole == self._whole:
            return
        there = whole.part(self._whole)
        self._whole = whole
        self._made, self._sums = _enlarged(self._made, whole, there, 1), _enlarged(self._sums, whole, there, 1)
        self._left_out = _enlarged(self._left_out, whole, there, 1)
        self._lumps = _enlarged(self._lumps, whole, there, _CELLS // _LUMP)
        self._allowed = _enlarged(self._allowed, whole, there, _CELLS)


@dataclass(frozen=True, slots=True)
class ExploreScene:
    """Everything that one plan of an exploration is made from.

    ``near`` is the ground about the drone, ``rest`` another part that the ``overview`` does not know yet. ``place`` is
    the drone's, ``heading`` the picture's (radians), ``speed`` over ground, m/s. ``unclear`` are stalls with unknown
    state, by id. ``scouting`` is the field for looking around, None when the lot is large enough to be the whole.
    ``share`` is the wanted share (0..1) of the near field's cells, once it is known. ``lot_known`` is False while
    ground that looks like lot stands in for one.
    """

    near: GroundPart
    rest: GroundPart | None
    overview: Overview
    place: Place
    heading: float
    speed: float
    footprint: Footprint
    fence: FenceGuard
    unclear: dict[int, Place]
    scouting: InformationField | None = None
    share: Grid | None = None
    lot_known: bool = True
    is_outlined: bool = False
    """True when an operator gave an outline: see `hawk.algo.path_plan.lot_ground`."""

    @property
    def field(self) -> InformationField:
        """Field about the drone."""
        return self.near.field

    def with_field(self, field: InformationField, share: Grid | None = None) -> ExploreScene:
        """Return the same with another field about the drone."""
        return replace(self, near=replace(self.near, field=field), share=share)

    def are_allowed(self, places: Floats) -> Bools:
        """Return True for those of places (T, 2) of (north, east) where the drone may be."""
        window = self.field.window
        cells = window.cells_of(places[:, 0], places[:, 1])
        is_near = ((cells >= 0) & (cells <= (window.columns - 1, window.rows - 1))).all(1)
        return np.where(is_near, self.field.are_allowed(places), self.overview.are_allowed(places))

    def target_towards(self, end: Place, least_m: float) -> Place | None:
        """Return a waypoint, or the corner to fly to first; None without a path.

        A corner nearer to the drone than ``least_m`` metres is none.
        """
        if not self.fence.contains(*self.place):
            return end
        is_allowed = self.are_allowed(np.array([self.place]))[0]
        if (not is_allowed or self._is_clear(end)) and self.fence.contains_line(self.place, end):
            return end
        corner = self.field.corner_towards(self.place, end) if self.field.window.holds(end) else None
        corner = corner or self.overview.corner_towards(self.place, end)
        if corner is None or math.dist(corner, self.place) <= least_m:
            return None
        return corner if self.fence.contains_line(self.place, corner) else None

    def _is_clear(self, end: Place) -> bool:
        """Return True when the straight line is free; ground beyond the field will be looked at from nearer."""
        steps = max(2, math.ceil(math.dist(self.place, end) / self.field.window.cell_m * 2))
        rows, columns, inside = self.field.window.cells_at(np.linspace(self.place, end, steps))
        return bool(self.field.passable[rows[inside], columns[inside]].all())


def _blocks(layer: NDArray[np.floating], size: int) -> NDArray[np.floating]:
    """Return the sums over blocks of ``size`` x ``size`` cells."""
    rows, columns = layer.shape
    return np.asarray(layer.reshape(rows // size, size, columns // size, size).sum((1, 3)))


def _lumps_of(part: GroundPart, weights: Grid) -> Floats:
    """Return (3, rows, columns) of lumps: weight, and its moments north and east."""
    window = cells_of_tiles(part.tiles)
    north, east = window.centres(np.arange(window.rows)[:, None], np.arange(window.columns)[None])
    return np.stack([_blocks(layer, _LUMP) for layer in (weights, weights * north, weights * east)]).astype(np.float64)


def _scaled(part: Slices, by: int) -> Slices:
    rows, columns = part
    return slice(rows.start * by, rows.stop * by), slice(columns.start * by, columns.stop * by)


def _enlarged(old: NDArray[Any], whole: Window, there: Slices, cells: int) -> NDArray[Any]:
    """Return an array of ``cells`` a tile for a larger whole, of which the old one covers the tiles ``there``."""
    new = np.zeros((*old.shape[:-2], whole.rows * cells, whole.columns * cells), old.dtype)
    new[(..., *_scaled(there, cells))] = old
    return new
