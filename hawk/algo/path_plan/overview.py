"""What a plan knows of a large map without looking at all of it again: dense near the drone, coarse far away.

The secret is what is kept of the ground that no frame can have changed: of every tile (`hawk.model.TILE_M`) where the
drone may be, what is wanted there in a few lumps, and how much of it is lot and was seen well. The tiles near the drone
are made anew with every frame; the others are made once, a block of them a frame, before anything is said of the
whole.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.algo.mapper.grid import COARSE_M
from hawk.algo.mapper.window import Slices, Window
from hawk.algo.path_plan.field import Grid, InformationField, Place
from hawk.algo.path_plan.footprint import Bools, Floats
from hawk.algo.path_plan.route import way_over
from hawk.algo.path_plan.tour import Wanted
from hawk.algo.path_plan.wanted import gathered
from hawk.model import TILE_M

NEAR_M: Final = 110.0
"""At least so far from the drone the ground is looked at with every frame."""
AROUND_TILES: Final = 2
"""Tiles about everything seen that belong to the ground looked at."""
BLOCK: Final = 8
"""Tiles a side of the block that is made in one frame."""
MOST_LUMPS: Final = 400
"""Far lumps that a tour takes into account, the nearest first."""

_CELLS: Final = round(TILE_M / COARSE_M)
_LUMP: Final = 8  # cells a side
_MARGIN: Final = 25  # cells: what lies farther off changes nothing


@dataclass(frozen=True, slots=True)
class Part:
    """A part of the ground: ``tiles`` are meant (cells of `TILE_M`), ``field`` holds a margin about them too."""

    tiles: Window
    field: InformationField

    @property
    def inner(self) -> Slices:
        """Where the tiles lie in the field."""
        return self.field.window.part(cells_of_tiles(self.tiles))


def cells_of_tiles(tiles: Window) -> Window:
    """Return the window of coarse cells that covers a window of tiles."""
    top, left = tiles.row * _CELLS, tiles.column * _CELLS
    return Window(top, left, tiles.rows * _CELLS, tiles.columns * _CELLS, COARSE_M)


def with_margin(tiles: Window) -> Window:
    """Return the window of coarse cells from which a part's field is to be made."""
    return cells_of_tiles(tiles).grown(_MARGIN)


def near_tiles(whole: Window, place: Place) -> Window:
    """Return the tiles of a whole that are looked at with every frame; next to the whole for a place beyond it."""
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
        self._sums = np.zeros((3, 0, 0))
        """Square metres a tile: lot, well seen, and lot that was seen well."""
        self._lumps = np.zeros((3, 0, 0))
        """Of each lump: square metres wanted, and their moments north and east."""
        self._allowed: NDArray[np.uint8] = np.zeros((0, 0), np.uint8)

    @property
    def is_complete(self) -> bool:
        """Whether every tile was made."""
        return self._made.size > 0 and bool(self._made.all())

    @property
    def lot_m2(self) -> float:
        """Square metres of known lot."""
        return float(self._sums[0].sum())

    @property
    def well_m2(self) -> float:
        """Square metres that were seen well."""
        return float(self._sums[1].sum())

    @property
    def seen_share(self) -> float:
        """Share (0..1) of the known lot that was seen well, 0 when none is known."""
        return float(self._sums[2].sum()) / self.lot_m2 if self.lot_m2 > 0 else 0.0

    def whole(self, extent: Floats) -> Window:
        """Return the tiles of the ground: about everything seen, two corners (2, 2), and never fewer than before."""
        tiles = Window.around(extent, TILE_M).grown(AROUND_TILES)
        self._grow(tiles)
        return self._whole

    def missing(self, place: Place, near: Window) -> Window | None:
        """Return the block of tiles to be made next, that nearest to a place; None when there is none beyond the near
        ones."""
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
        """Have every tile made anew: what is wanted is told otherwise from now on."""
        self._made[:] = False

    def take(self, part: Part, share: Grid) -> None:
        """Make the tiles of a part. ``share`` (0..1) is what is wanted of the field's cells."""
        field, inner, there = part.field, part.inner, self._whole.part(part.tiles)
        area = field.window.cell_m**2
        lot, well = field.lot[inner], field.well[inner]
        for index, layer in enumerate((lot, well, np.minimum(lot, well))):
            self._sums[index][there] = _blocks(layer, _CELLS) * area
        self._lumps[(slice(None), *_scaled(there, _CELLS // _LUMP))] = _lumps_of(part, share[inner] * area)
        self._allowed[_scaled(there, _CELLS)] = field.allowed[inner]
        self._made[there] = True

    def wanted(self, part: Part, share: Grid, spare: float) -> Wanted:
        """Return what is to be shown: the near part's in detail, the nearest lumps of the rest."""
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
        """Return for places (T, 2) of (north, east) whether the drone may be there, as far as is known."""
        window = cells_of_tiles(self._whole)
        cells = np.round(window.cells_of(places[:, 0], places[:, 1])).astype(np.intp)
        within = (cells >= 0) & (cells < (window.columns, window.rows))
        inside = within[:, 0] & within[:, 1]
        column, row = np.where(inside[:, None], cells, 0).T
        return np.asarray(inside & (self._allowed[row, column] > 0)) if self._allowed.size else inside

    def way_round(self, place: Place, end: Place) -> Place | None:
        """Return the farthest place on the shortest way that is reached straight on, None when there is none."""
        return way_over(self._allowed, cells_of_tiles(self._whole), place, end)

    def _grow(self, tiles: Window) -> None:
        old = self._whole
        if old.rows == 0:
            whole = tiles
        else:
            top, left = min(old.row, tiles.row), min(old.column, tiles.column)
            bottom = max(old.row + old.rows, tiles.row + tiles.rows)
            right = max(old.column + old.columns, tiles.column + tiles.columns)
            whole = Window(top, left, bottom - top, right - left, TILE_M)
        if whole == old:
            return
        made, sums, lumps, allowed = self._made, self._sums, self._lumps, self._allowed
        self._whole = whole
        per = _CELLS // _LUMP
        self._made = np.zeros(whole.shape, np.bool_)
        self._sums = np.zeros((3, *whole.shape))
        self._lumps = np.zeros((3, whole.rows * per, whole.columns * per))
        self._allowed = np.zeros((whole.rows * _CELLS, whole.columns * _CELLS), np.uint8)
        if old.rows:
            there = self._whole.part(old)
            self._made[there] = made
            self._sums[(slice(None), *there)] = sums
            self._lumps[(slice(None), *_scaled(there, per))] = lumps
            self._allowed[_scaled(there, _CELLS)] = allowed


def _blocks(layer: Grid, size: int) -> Grid:
    """Return the sums over blocks of so many cells a side."""
    rows, columns = layer.shape
    return np.asarray(layer.reshape(rows // size, size, columns // size, size).sum((1, 3)))


def _lumps_of(part: Part, weights: Grid) -> Floats:
    """Return (3, rows, columns) of lumps: weight, and its moments north and east."""
    window = cells_of_tiles(part.tiles)
    north = -(window.row + np.arange(window.rows) + 0.5)[:, None] * window.cell_m
    east = (window.column + np.arange(window.columns) + 0.5)[None] * window.cell_m
    return np.stack([_blocks(layer, _LUMP) for layer in (weights, weights * north, weights * east)]).astype(np.float64)


def _scaled(part: Slices, by: int) -> Slices:
    rows, columns = part
    return slice(rows.start * by, rows.stop * by), slice(columns.start * by, columns.stop * by)
