"""Evidence per cell: lot, stall core and cars by all frames together, and how well each place was seen.

Fusion: log-odds of lot / not lot added frame by frame and clamped, running means of the network's
other layers, everything in tiles that are made as the drone gets there. Cells have `EVIDENCE_M`, the network's own
resolution: finer ones would only repeat it.
"""

from __future__ import annotations

import itertools

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import COARSE_M, CoarseLayers, Slices, Window
from hawk.algo.mapper.delta import Recent
from hawk.algo.mapper.evidence import EVIDENCE_M, CellEvidence, EvidenceLayers, Grid32
from hawk.model.lot_map import TILE_M, Cell, TileKey

_COARSE_CELLS = round(TILE_M / COARSE_M)
_CLAMP = 4.0  # log-odds, .982: two dozen frames of the opposite can still turn a cell
_MEAN_LOOKS = 8.0  # running means forget looks older than about this number
_LOOKS_LIMIT = 60.0
LOADED = 64
"""Tiles (4 ha) whose layers are kept as arrays; the others are kept as bytes, which the flight journal shares."""


class EvidenceTile:
    """One tile: its layers (`hawk.algo.mapper.evidence`), loaded or evicted, and shares of them in coarse cells.

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
        """The layers; an evicted tile is loaded again."""
        if self._layers is None:
            assert self._packed is not None  # noqa: S101 - set by evict()
            self._layers = EvidenceLayers.from_bytes(self._packed)
        return self._layers

    def to_bytes(self) -> bytes:
        """Return the layers as bytes; made once for each change."""
        if self._packed is None:
            self._packed = self.layers.to_bytes()
        return self._packed

    def changed(self, version: int) -> None:
        """Note a change of a layer: the bytes are void."""
        self.version = version
        self._packed = None

    def evict(self) -> None:
        """Keep the bytes only, until a layer is asked for."""
        self.to_bytes()
        self._layers = None

    def summarise(self) -> None:
        """Bring the coarse layers up to date: shares of lot, of what looks like it, of seen and of well seen cells."""
        layers = self.layers
        known = (layers.shown != Cell.UNKNOWN).astype(np.float32)
        lot = (layers.shown == Cell.LOT).astype(np.float32)
        self.coarse_lot = _shares(lot)
        self.coarse_likely = _shares((layers.lot > 0).astype(np.float32) * known)
        self.coarse_seen = _shares(known)
        self.coarse_well = _shares(layers.well.astype(np.float32))
        self.lot_cells = int(np.count_nonzero(lot))


class EvidenceGrid:
    """The tiles."""

    def __init__(self) -> None:
        self.tiles: dict[TileKey, EvidenceTile] = {}
        self.recent: Recent[TileKey] = Recent()
        self._lot_cells = 0
        self._bounds: tuple[int, int, int, int] | None = None
        self._used: dict[TileKey, None] = {}
        """Loaded tiles, the least recently used first."""

    def tile(self, key: TileKey) -> EvidenceTile | None:
        """Return a tile to be read or written, None where nothing was ever seen."""
        tile = self.tiles.get(key)
        if tile is not None:
            self._used.pop(key, None)
            self._used[key] = None
        return tile

    def evict(self, most: int = 1) -> int:
        """Evict the least recently used tiles beyond `LOADED`, at most ``most``; return their number."""
        beyond = list(itertools.islice(self._used, min(most, max(len(self._used) - LOADED, 0))))
        for key in beyond:
            del self._used[key]
            self.tiles[key].evict()
        return len(beyond)

    def put(self, key: TileKey, tile: EvidenceTile, version: int) -> None:
        """Restore a tile of an earlier run; it is evicted until it is needed."""
        known = self.tiles.get(key)
        self._lot_cells += tile.lot_cells - (0 if known is None else known.lot_cells)
        self.tiles[key] = tile
        self._used.pop(key, None)
        tile.evict()
        tile.version = version
        self._extend(key)
        self.recent.note(key, version)

    def note_change(self, key: TileKey, version: int) -> None:
        """Note a change of a tile with this version of the map."""
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

        ``weight`` (0..1) is the frame's share of an independent look; a cell that was hardly seen takes a whole one.
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
            _fuse_layers(tile.layers, in_tile, evidence, in_window, weight)
            self.note_change(key, version)
            touched.append(key)
        return touched

    def layer(self, window: Window, name: str) -> Grid32:
        """Return one layer of a window of evidence cells as float32, 0 where nothing was ever seen."""
        result = np.zeros(window.shape, np.float32)
        for key, in_tile, in_window in window.tiles():
            tile = self.tile(key)
            if tile is not None:
                result[in_window] = getattr(tile.layers, name)[in_tile]
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


def _shares(layer: Grid32) -> Grid32:
    size = (_COARSE_CELLS, _COARSE_CELLS)
    return np.asarray(cv2.resize(layer, size, interpolation=cv2.INTER_AREA), dtype=np.float32)


def _fuse_layers(tile: EvidenceLayers, part: Slices, evidence: CellEvidence, seen: Slices, weight: float) -> None:
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
