"""The map as it is published: tiles of classes and the stalls, each encoded where it changed.

A class tile has `TILE_CELLS` x `TILE_CELLS` cells.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hawk.algo.ground import Window, shard_of_tile, tile_window
from hawk.algo.mapper.evidence import EVIDENCE_M
from hawk.algo.mapper.grid import EvidenceGrid
from hawk.algo.mapper.table import (
    FREE,
    STATES,
    TAKEN,
    Rows,
    probability,
    published_geometry,
    seen_blurred,
    shown_state,
    to_stall,
)
from hawk.algo.vision import quads
from hawk.model.lot_map import (
    CELL_M,
    TILE_M,
    Cell,
    Counts,
    EncodedTile,
    Stall,
    StallState,
    TileKey,
    free_variance,
)
from hawk.model.shards import Sharded

_FINER = round(EVIDENCE_M / CELL_M)
_REACH_M = 5.0  # half the diagonal of the longest stall
_SHIFT = 4  # bits of fraction in polygon corners
_CELLS = ((FREE, Cell.FREE), (TAKEN, Cell.TAKEN))
_MOVED_M = 0.05
_TURNED = 0.02
_PROBABILITY = 0.05
_SCORE = 0.02  # finer: the spread of the count rests on it
_AGED_S = 2.0
_SHARD = 128  # ids
_FINE = 1_000_000


class TileEncoder:
    """Keeps the encoded tiles and what waits to be encoded."""

    def __init__(self) -> None:
        self.encoded: Sharded[TileKey, EncodedTile] = Sharded(shard_of_tile)
        self._waiting: set[TileKey] = set()

    def mark(self, keys: set[TileKey]) -> None:
        """Mark tiles that may have changed."""
        self._waiting |= keys

    def mark_around(self, corners: NDArray[np.float64]) -> None:
        """Mark the tiles of stalls (corners (N, 4, 2)) that changed, came or went."""
        rows = np.floor(-corners[..., 0] / TILE_M).astype(int)
        columns = np.floor(corners[..., 1] / TILE_M).astype(int)
        self._waiting |= set(zip(rows.ravel().tolist(), columns.ravel().tolist(), strict=True))

    def next_tiles(self, most: int, near: tuple[float, float]) -> list[TileKey]:
        """Return the next ``most`` tiles to encode: those nearest to a place (north, east)."""
        return nearest_first(list(self._waiting), *near)[:most]

    def encode(self, grid: EvidenceGrid, stalls: Rows, most: int, version: int, near: tuple[float, float]) -> bool:
        """Encode the ``most`` waiting tiles nearest to a place; return True when one of them changed.

        ``stalls`` are all that may lie on them.
        """
        news: dict[TileKey, EncodedTile] = {}
        for key in self.next_tiles(most, near):
            self._waiting.discard(key)
            known = self.encoded.get(key)
            if known is None and key not in grid.tiles:
                continue
            data = zlib.compress(raster(grid, key, stalls).tobytes(), 1)
            if known is None or known.data != data:
                news[key] = EncodedTile(version, data)
        self.encoded = self.encoded.changed(news)
        return bool(news)


def raster(grid: EvidenceGrid, key: TileKey, stalls: Rows) -> NDArray[np.uint8]:
    """Return the `Cell` classes of one tile with its stalls drawn in."""
    tile = grid.tile(key)
    n = round(TILE_M / CELL_M)
    cells = (
        np.zeros((n, n), np.uint8) if tile is None else np.repeat(np.repeat(tile.layers.shown, _FINER, 0), _FINER, 1)
    )
    window = tile_window(key, CELL_M)
    near = stalls[_meets(stalls, key)]
    if len(near) == 0:
        return cells
    corners = quads.corners(*published_geometry(near))
    states = shown_state(near)
    for state, cell in _CELLS:
        _draw(cells, corners[states == state], window, cell)
    return cells


def _meets(stalls: Rows, key: TileKey) -> NDArray[np.bool_]:
    middle_north, middle_east = -(key[0] + 0.5) * TILE_M, (key[1] + 0.5) * TILE_M
    reach = TILE_M / 2 + _REACH_M
    return np.asarray((np.abs(stalls["north"] - middle_north) < reach) & (np.abs(stalls["east"] - middle_east) < reach))


def _draw(cells: NDArray[np.uint8], corners: NDArray[np.float64], window: Window, cell: Cell) -> None:
    if len(corners):
        points = window.cells_of(corners[..., 0], corners[..., 1])
        fixed = np.round(points * (1 << _SHIFT)).astype(np.int32)
        cv2.fillPoly(cells, list(fixed), [int(cell)], shift=_SHIFT)


def nearest_first(keys: list[TileKey], north: float, east: float) -> list[TileKey]:
    """Return tiles by the distance of their centres from a place."""
    return sorted(keys, key=lambda k: math.hypot(-(k[0] + 0.5) * TILE_M - north, (k[1] + 0.5) * TILE_M - east))


class StallIndex:
    """Valid stalls as they were last shown. A stall is updated only when it changed visibly."""

    def __init__(self) -> None:
        self.stalls: Sharded[int, Stall] = Sharded(lambda stall_id: stall_id // _SHARD)
        self.unclear: dict[int, Stall] = {}
        """Those whose state is not known."""
        self.plan: tuple[tuple[str, str], ...] = ()
        """Ids and labels of the stalls of the lot's plan, by their numbers from 1."""
        self._counts = dict.fromkeys(StallState, 0)
        self._variances = 0  # of the number of free ones, in parts of `_FINE`: whole numbers add up without drift

    def update(self, rows: Rows, index: NDArray[np.intp], gone: list[int], version: int) -> NDArray[np.float64]:
        """Bring rows ``index`` up to date and take out those that are gone; their versions are set in ``rows``.

        Returns the corners (N, 4, 2) of everything whose picture on the map changed, before and after.
        """
        lost = {i: self.stalls[i] for i in gone if i in self.stalls}
        news: dict[int, Stall] = {}
        redrawn = list(lost.values())
        index = index[rows["confirmed"][index]]
        table = rows[index]
        for position, stall_id, values in zip(index, table["id"].tolist(), _shown(table), strict=True):
            known = None if stall_id in lost else self.stalls.get(stall_id)
            of_plan, label = self._known(rows[position])
            if known is not None and known.known == of_plan and not _differs(known, values):
                continue
            rows["version"][position] = version
            news[stall_id] = fresh = to_stall(rows[position], of_plan, label)
            if known is None or _is_redrawn(known, values):
                redrawn += [fresh] if known is None else [fresh, known]
        self._count(lost, news)
        self.stalls = self.stalls.changed(news, lost)
        return np.array([stall.corners() for stall in redrawn]).reshape(-1, 4, 2)

    def suggest(self, those: Mapping[int, Stall | None]) -> None:
        """Bring suggested stalls up to date, by id; None: it is none, or none any more."""
        lost = {i: self.stalls[i] for i, stall in those.items() if stall is None and i in self.stalls}
        news = {i: stall for i, stall in those.items() if stall is not None and self._is_news(stall)}
        self._count(lost, news)
        self.stalls = self.stalls.changed(news, lost)

    def _known(self, row: Any) -> tuple[str, str]:
        """Return id and label of a row in the plan, empty for one that is not of it."""
        number = int(row["plan"])
        return self.plan[number - 1] if row["given"] and 0 < number <= len(self.plan) else ("", "")

    def _is_news(self, stall: Stall) -> bool:
        known = self.stalls.get(stall.id)
        return known is None or known.version != stall.version

    def counts(self) -> Counts:
        """Return how many there are of each state."""
        of_each = self._counts
        return Counts(
            of_each[StallState.FREE],
            of_each[StallState.TAKEN],
            of_each[StallState.UNKNOWN],
            self._variances / _FINE,
            of_each[StallState.SUGGESTED],
        )

    def _count(self, lost: dict[int, Stall], news: dict[int, Stall]) -> None:
        for stall_id in lost.keys() | news.keys():
            known = self.stalls.get(stall_id)
            if known is not None:
                self._counts[known.state] -= 1
                self._variances -= _variance(known)
                self.unclear.pop(stall_id, None)
        for stall_id, stall in news.items():
            self._counts[stall.state] += 1
            self._variances += _variance(stall)
            if stall.state is StallState.UNKNOWN:
                self.unclear[stall_id] = stall


def _variance(stall: Stall) -> int:
    return 0 if stall.state is StallState.SUGGESTED else round(free_variance(stall.existence, stall.taken) * _FINE)


def _shown(rows: Rows) -> list[tuple[float, ...]]:
    columns = (
        *published_geometry(rows),
        probability(rows["taken"]),
        shown_state(rows),
        rows["last_seen"],
        probability(rows["exists"]),
        seen_blurred(rows),
    )
    return list(zip(*(column.tolist() for column in columns), strict=True))


def _differs(known: Stall, values: tuple[float, ...]) -> bool:
    taken, _, last_seen, score, is_blurred = values[5:]
    return (
        _is_redrawn(known, values)
        or abs(taken - known.taken) > _PROBABILITY
        or abs(score - known.score) > _SCORE
        or last_seen - known.last_seen > _AGED_S
        or is_blurred != known.is_blurred
    )


def _is_redrawn(known: Stall, values: tuple[float, ...]) -> bool:
    """Return True when the stall's drawing on the map changed."""
    north, east, angle, width, length, _, state = values[:7]
    turned = abs((angle - known.angle + math.pi / 2) % math.pi - math.pi / 2)
    return (
        known.state is not STATES[int(state)]
        or max(abs(north - known.north), abs(east - known.east)) > _MOVED_M
        or max(abs(width - known.width), abs(length - known.length)) > _MOVED_M
        or turned > _TURNED
    )
