"""Evidence per cell: what all frames together say of lot, stall core and cars, and how well a place was seen.

The secret is the fusion: log-odds of lot / not lot added frame by frame and clamped, running means of the network's
other layers, everything in tiles that are made as the drone gets there. Cells have `EVIDENCE_M`, the network's own
resolution: finer ones would only repeat it.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.mapper.evidence import EVIDENCE_M, EvidenceLayers, Grid16, Grid32, GridU8
from hawk.algo.mapper.recent import Recent
from hawk.algo.mapper.window import Slices, Window
from hawk.model import TILE_M, Cell, TileKey

COARSE_M = 1.6
"""Side of a cell of the coarse layers for planning, metres: a whole number of evidence cells, and of cells a tile."""

_COARSE_CELLS = round(TILE_M / COARSE_M)
_CLAMP = 4.0  # log-odds, .982: two dozen frames of the opposite can still turn a cell
_FRAME_LIMIT = 2.5  # log-odds that one frame may claim: the network is surer of itself than it should be
_MEAN_LOOKS = 8.0  # running means forget what is older than about as many looks
_LOOKS_LIMIT = 60.0
AWAKE = 64
"""Tiles (4 ha) whose layers are kept as arrays; the others rest as bytes, which the flight journal shares."""


class EvidenceTile:
    """One tile: its layers (`hawk.algo.mapper.evidence`), awake or resting, and shares of them in coarse cells.

    ``version`` is the map version of the last change of any layer.
    """

    def __init__(self, packed: bytes | None = None) -> None:
        """``packed`` are bytes of `to_bytes`. Raises ValueError when they are none."""
        self._layers: EvidenceLayers | None = EvidenceLayers() if packed is None else EvidenceLayers.from_bytes(packed)
        self._packed = packed
        self.version = 0
        self.lot_cells = 0
        coarse = np.zeros((4, _COARSE_CELLS, _COARSE_CELLS), np.float32)
        self.coarse_likely, self.coarse_lot, self.coarse_seen, self.coarse_well = coarse
        if packed is not None:
            self.summarise()

    @property
    def layers(self) -> EvidenceLayers:
        """The layers; a resting tile wakes."""
        if self._layers is None:
            assert self._packed is not None  # noqa: S101 - set by rest()
            self._layers = EvidenceLayers.from_bytes(self._packed)
        return self._layers

    @property
    def lot(self) -> Grid32:
        """Log-odds of lot."""
        return self.layers.lot

    @property
    def looks(self) -> Grid32:
        """Independent looks."""
        return self.layers.looks

    @property
    def core(self) -> Grid16:
        """Mean probability of a stall's inner part."""
        return self.layers.core

    @property
    def car(self) -> Grid16:
        """Mean probability of a car."""
        return self.layers.car

    @property
    def well(self) -> GridU8:
        """1 where it was seen well."""
        return self.layers.well

    @property
    def shown(self) -> GridU8:
        """The `Cell` class without the stalls."""
        return self.layers.shown

    @property
    def is_resting(self) -> bool:
        """Whether only the bytes are kept."""
        return self._layers is None

    def to_bytes(self) -> bytes:
        """Return the layers as bytes; made once for each change."""
        if self._packed is None:
            self._packed = self.layers.to_bytes()
        return self._packed

    def changed(self, version: int) -> None:
        """A layer changed: the bytes are void."""
        self.version = version
        self._packed = None

    def rest(self) -> None:
        """Keep the bytes only, until a layer is asked for."""
        self.to_bytes()
        self._layers = None

    def summarise(self) -> None:
        """Bring the coarse layers up to date: shares of lot, of what looks like it, of seen and of well seen cells."""
        known = (self.shown != Cell.UNKNOWN).astype(np.float32)
        lot = (self.shown == Cell.LOT).astype(np.float32)
        self.coarse_lot = _shares(lot)
        self.coarse_likely = _shares((self.lot > 0).astype(np.float32) * known)
        self.coarse_seen = _shares(known)
        self.coarse_well = _shares(self.well.astype(np.float32))
        self.lot_cells = int(np.count_nonzero(lot))


@dataclass(frozen=True, slots=True)
class CellEvidence:
    """One frame's evidence laid on a window of map cells.

    ``lot`` is the frame's log-odds (limited), ``core`` and ``car`` probabilities, ``mask`` 0 not in the picture, 1 in
    it, 2 in its good part.
    """

    window: Window
    lot: Grid32
    core: Grid32
    car: Grid32
    mask: GridU8


@dataclass(frozen=True, slots=True)
class CoarseLayers:
    """Shares (0..1) over a window of coarse cells: ``lot``, ``seen`` at all, ``well`` seen, and ``likely``: looks like
    lot, whether stalls are near it or not."""

    window: Window
    lot: Grid32
    seen: Grid32
    well: Grid32
    likely: Grid32


class EvidenceGrid:
    """The tiles."""

    def __init__(self) -> None:
        self.tiles: dict[TileKey, EvidenceTile] = {}
        self.recent: Recent[TileKey] = Recent()
        self._lot_cells = 0
        self._bounds: tuple[int, int, int, int] | None = None
        self._used: dict[TileKey, None] = {}
        """Tiles that are awake, the least lately used first."""

    def tile(self, key: TileKey) -> EvidenceTile | None:
        """Return a tile to be read or written, None where nothing was ever seen."""
        tile = self.tiles.get(key)
        if tile is not None:
            self._used.pop(key, None)
            self._used[key] = None
        return tile

    def rest(self, most: int = 1) -> int:
        """Lay to rest what was used longest ago beyond `AWAKE` tiles, at most so many; return how many."""
        beyond = list(itertools.islice(self._used, min(most, max(len(self._used) - AWAKE, 0))))
        for key in beyond:
            del self._used[key]
            self.tiles[key].rest()
        return len(beyond)

    def put(self, key: TileKey, tile: EvidenceTile, version: int) -> None:
        """Take up a tile of an earlier run; it rests until it is needed."""
        known = self.tiles.get(key)
        self._lot_cells += tile.lot_cells - (0 if known is None else known.lot_cells)
        self.tiles[key] = tile
        self._used.pop(key, None)
        tile.rest()
        tile.version = version
        self._extend(key)
        self.recent.note(key, version)

    def note_change(self, key: TileKey, version: int) -> None:
        """Something in a tile changed with this version of the map."""
        self.tiles[key].changed(version)
        self.recent.note(key, version)

    def summarise(self, key: TileKey) -> None:
        """Bring a tile's coarse layers and the lot's area up to date."""
        tile = self.tiles[key]
        before = tile.lot_cells
        tile.summarise()
        self._lot_cells += tile.lot_cells - before

    def extent(self) -> NDArray[np.float64] | None:
        """Return two corners (2, 2) of (north, east) around all tiles, None when there are none."""
        if self._bounds is None:
            return None
        top, left, bottom, right = self._bounds
        return np.array([[-(bottom + 1) * TILE_M, left * TILE_M], [-top * TILE_M, (right + 1) * TILE_M]])

    def _extend(self, key: TileKey) -> None:
        top, left, bottom, right = self._bounds or (*key, *key)
        self._bounds = (min(top, key[0]), min(left, key[1]), max(bottom, key[0]), max(right, key[1]))

    def fuse(self, evidence: CellEvidence, weight: float, version: int) -> list[TileKey]:
        """Add one frame and return the tiles that it touched.

        ``weight`` (0..1) is how much of an independent look the frame is; a cell that was hardly seen takes it whole.
        """
        touched = []
        for key, in_tile, in_window in evidence.window.tiles():
            if not evidence.mask[in_window].any():
                continue
            if key not in self.tiles:
                self.tiles[key] = EvidenceTile()
                self._extend(key)
            tile = self.tile(key)
            assert tile is not None  # noqa: S101 - made above
            _fuse_tile(tile, in_tile, evidence, in_window, weight)
            self.note_change(key, version)
            touched.append(key)
        return touched

    def layer(self, window: Window, name: str) -> Grid32:
        """Return one layer of a window of evidence cells as float32, 0 where nothing was ever seen."""
        result = np.zeros(window.shape, np.float32)
        for key, in_tile, in_window in window.tiles():
            tile = self.tile(key)
            if tile is not None:
                result[in_window] = getattr(tile, name)[in_tile]
        return result

    def coarse(self, window: Window) -> CoarseLayers:
        """Return the coarse layers over a window of `COARSE_M` cells."""
        lot, seen, well, likely = (np.zeros(window.shape, np.float32) for _ in range(4))
        for key, in_tile, in_window in window.tiles():
            tile = self.tiles.get(key)
            if tile is not None:
                lot[in_window] = tile.coarse_lot[in_tile]
                seen[in_window] = tile.coarse_seen[in_tile]
                well[in_window] = tile.coarse_well[in_tile]
                likely[in_window] = tile.coarse_likely[in_tile]
        return CoarseLayers(window, lot, seen, well, likely)

    @property
    def lot_area_m2(self) -> float:
        """Area of all cells that are shown as lot, square metres."""
        return self._lot_cells * EVIDENCE_M**2


def log_odds(probability: Grid32) -> Grid32:
    """Return one frame's log-odds, limited to what one frame may claim."""
    edge = np.float32(1 / (1 + np.exp(_FRAME_LIMIT)))
    p = np.clip(probability, edge, 1 - edge)
    return np.asarray(np.log(p / (1 - p)), dtype=np.float32)


def _shares(layer: Grid32) -> Grid32:
    size = (_COARSE_CELLS, _COARSE_CELLS)
    return np.asarray(cv2.resize(layer, size, interpolation=cv2.INTER_AREA), dtype=np.float32)


def _fuse_tile(tile: EvidenceTile, part: Slices, evidence: CellEvidence, seen: Slices, weight: float) -> None:
    mask = evidence.mask[seen]
    looks = tile.looks[part]
    w = np.clip(1 - looks, np.float32(weight), 1) * (mask > 0)
    total = looks + w
    rate = w / np.clip(total, 1e-6, _MEAN_LOOKS)
    tile.lot[part] = np.clip(tile.lot[part] + w * evidence.lot[seen], -_CLAMP, _CLAMP)
    for layer, values in ((tile.core, evidence.core), (tile.car, evidence.car)):
        old = layer[part].astype(np.float32)
        layer[part] = old + (values[seen] - old) * rate
    tile.looks[part] = np.minimum(total, _LOOKS_LIMIT)
    tile.well[part] |= mask > 1
