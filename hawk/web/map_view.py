"""The map as one client has received it, and what it receives next: at most `BUDGET_BYTES` a heartbeat.

No heartbeat compares whole maps: `MapBacklog` compares the newest map with the one compared last, a bounded number of
differences at a time, and sorts what the client lacks by its place.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import islice, takewhile
from typing import Final, Literal

from hawk.comm.protocol.heartbeat import MapUpdate, MosaicVersion, StallUpdate, TileUpdate
from hawk.model.lot_map import TILE_M, EncodedTile, OccupancyMap, Stall, TileKey
from hawk.model.poses import MapPoint
from hawk.model.shards import differing

BUDGET_BYTES: Final = 64 * 1024
"""JSON of one "Occupancy Map" (design, section 5)."""
STALL_SHARE: Final = 0.5
"""Share of the budget for stalls while tiles wait; the nearest tile always fits beside them."""
ENVELOPE_BYTES: Final = 256
TILE_BYTES: Final = 96
"""JSON of a tile without its data, at most."""
STALL_BYTES: Final = 320
"""JSON of a stall, at most: its numbers are rounded."""
MOSAIC_BYTES: Final = 72
INTAKE: Final = 2000
"""Differences between two maps that one update reads."""

_Kind = Literal["tile", "mosaic", "stall"]


class MapBacklog:
    """Keys of tiles, mosaic tiles and stalls that differ from those that the client has received."""

    def __init__(self) -> None:
        self.tiles: set[TileKey] = set()
        self.mosaic: set[TileKey] = set()
        self.gone: set[int] = set()
        """Stalls that the client holds and the map no longer has."""
        self._stalls: dict[TileKey, set[int]] = {}
        self._squares: dict[int, TileKey] = {}
        self._compared = OccupancyMap()
        self._differing: Iterator[tuple[_Kind, TileKey | int]] | None = None
        self._target = self._newest = self._compared

    def __len__(self) -> int:
        """Return the number of changes that wait; a comparison under way adds one, for changes not found yet."""
        unknown = 0 if self._compared is self._newest else 1
        return unknown + len(self.tiles) + len(self.mosaic) + len(self.gone) + len(self._squares)

    def take_in(
        self,
        current: OccupancyMap,
        held_tiles: Mapping[TileKey, int],
        held_mosaic: Mapping[TileKey, int],
        held_stalls: Mapping[int, int],
    ) -> None:
        """Compare with the newest map; ``held`` are the versions that the client has received."""
        self._newest = current
        if self._differing is None and current is not self._compared:
            self._differing, self._target = _differences(current, self._compared), current
        if self._differing is None:
            return
        news = list(islice(self._differing, INTAKE))
        if len(news) < INTAKE:
            self._differing, self._compared = None, self._target
        for kind, key in news:
            if kind == "stall":
                assert isinstance(key, int)  # noqa: S101 - narrows for the type checker
                self._note_stall(key, current, held_stalls.get(key))
            else:
                assert isinstance(key, tuple)  # noqa: S101 - narrows for the type checker
                layer, waiting, held = (
                    (current.tiles, self.tiles, held_tiles)
                    if kind == "tile"
                    else (current.mosaic, self.mosaic, held_mosaic)
                )
                tile = layer.get(key)
                if tile is not None and tile.version != held.get(key):
                    waiting.add(key)

    def next_stalls(self, current: OccupancyMap, near: MapPoint, most: int) -> list[int]:
        """Return stalls that wait, nearest first: those of the nearest squares, slightly more than ``most``."""
        found: list[int] = []
        for square in nearest(self._stalls, near):
            if len(found) >= most:
                break
            found += self._stalls[square]
        there = [stall for stall_id in found if (stall := current.stalls.get(stall_id)) is not None]
        there.sort(key=lambda stall: (math.hypot(stall.north - near.north, stall.east - near.east), stall.id))
        return [stall.id for stall in there]

    def sent_stall(self, stall_id: int) -> None:
        """Remove a stall that was sent."""
        square = self._squares.pop(stall_id, None)
        if square is not None:
            self._stalls[square].discard(stall_id)
            if not self._stalls[square]:
                del self._stalls[square]

    def _note_stall(self, stall_id: int, current: OccupancyMap, held: int | None) -> None:
        self.sent_stall(stall_id)
        self.gone.discard(stall_id)
        stall = current.stalls.get(stall_id)
        if stall is None:
            if held is not None:
                self.gone.add(stall_id)
        elif stall.version != held:
            square = (math.floor(-stall.north / TILE_M), math.floor(stall.east / TILE_M))
            self._squares[stall_id] = square
            self._stalls.setdefault(square, set()).add(stall_id)


def nearest(keys: Mapping[TileKey, object] | set[TileKey], near: MapPoint) -> list[TileKey]:
    """Return tiles, nearest first, by the distance of their centres from a place."""
    north, east = -near.north / TILE_M - 0.5, near.east / TILE_M - 0.5
    return sorted(keys, key=lambda key: (key[0] - north) ** 2 + (key[1] - east) ** 2)


def _differences(now: OccupancyMap, before: OccupancyMap) -> Iterator[tuple[_Kind, TileKey | int]]:
    for key in differing(now.tiles, before.tiles):
        yield "tile", key
    for key in differing(now.mosaic, before.mosaic):
        yield "mosaic", key
    for stall_id in differing(now.stalls, before.stalls):
        yield "stall", stall_id


@dataclass(slots=True)
class _Budget:
    left: int
    taken: int = 0

    def take(self, size: int, floor: int = 0) -> bool:
        """Take ``size`` unless less than ``floor`` would be left. The first of all is always granted."""
        if self.left - size < floor and self.taken:
            return False
        self.left -= size
        self.taken += 1
        return True


@dataclass(slots=True)
class MapView:
    """Versions that the client has received. A message on an open connection arrives or ends it, so sent means held."""

    budget_bytes: int = BUDGET_BYTES
    _map_id: str | None = None
    _tiles: dict[TileKey, int] = field(default_factory=dict)
    _mosaic: dict[TileKey, int] = field(default_factory=dict)
    _stalls: dict[int, int] = field(default_factory=dict)
    _backlog: MapBacklog = field(default_factory=MapBacklog)

    def forget(self) -> None:
        """Forget every version: the client holds nothing."""
        self._map_id = None
        self._backlog = MapBacklog()
        self._tiles.clear()
        self._mosaic.clear()
        self._stalls.clear()

    def update(self, current: OccupancyMap, drone: MapPoint | None) -> MapUpdate:
        """Return the next changes, nearest to the drone first, and mark them as sent."""
        if current.map_id != self._map_id:
            self.forget()
            self._map_id = current.map_id
        backlog = self._backlog
        backlog.take_in(current, self._tiles, self._mosaic, self._stalls)
        near = drone or MapPoint(0.0, 0.0)
        tiles = nearest(backlog.tiles, near)
        budget = _Budget(self.budget_bytes - ENVELOPE_BYTES)
        floor = max(round(budget.left * (1 - STALL_SHARE)), _size(current.tiles[tiles[0]])) if tiles else 0
        stalls = self._send_gone(budget, floor) + self._send_stalls(current, near, budget, floor)
        return MapUpdate(
            map_id=current.map_id,
            stalls=stalls,
            tiles=self._send_tiles(tiles, current, budget),
            mosaic=self._send_mosaic(nearest(backlog.mosaic, near), current, budget),
            backlog=len(backlog),
        )

    def _send_gone(self, budget: _Budget, floor: int) -> list[StallUpdate]:
        sent = []
        for number in takewhile(lambda _: budget.take(STALL_BYTES, floor), sorted(self._backlog.gone)):
            self._backlog.gone.discard(number)
            sent.append(StallUpdate(id=number, version=self._stalls.pop(number) + 1, removed=True))
        return sent

    def _send_stalls(self, current: OccupancyMap, near: MapPoint, budget: _Budget, floor: int) -> list[StallUpdate]:
        sent = []
        waiting = self._backlog.next_stalls(current, near, self.budget_bytes // STALL_BYTES)
        for number in takewhile(lambda _: budget.take(STALL_BYTES, floor), waiting):
            stall = current.stalls[number]
            sent.append(stall_update(stall))
            self._stalls[number] = stall.version
            self._backlog.sent_stall(number)
        return sent

    def _send_tiles(self, keys: list[TileKey], current: OccupancyMap, budget: _Budget) -> list[TileUpdate]:
        sent = []
        for key in takewhile(lambda key: budget.take(_size(current.tiles[key])), keys):
            tile = current.tiles[key]
            data = base64.b64encode(tile.data).decode("ascii")
            sent.append(TileUpdate(row=key[0], column=key[1], version=tile.version, data=data))
            self._tiles[key] = tile.version
            self._backlog.tiles.discard(key)
        return sent

    def _send_mosaic(self, keys: list[TileKey], current: OccupancyMap, budget: _Budget) -> list[MosaicVersion]:
        sent = []
        for key in takewhile(lambda _: budget.take(MOSAIC_BYTES), keys):
            version = current.mosaic[key].version
            sent.append(MosaicVersion(row=key[0], column=key[1], version=version))
            self._mosaic[key] = version
            self._backlog.mosaic.discard(key)
        return sent


def stall_update(stall: Stall) -> StallUpdate:
    """Return the message of a stall: lengths to the millimetre, probabilities to four digits."""
    return StallUpdate(
        id=stall.id,
        version=stall.version,
        north=round(stall.north, 3),
        east=round(stall.east, 3),
        angle=round(stall.angle, 5),
        width=round(stall.width, 3),
        length=round(stall.length, 3),
        state=stall.state.value,
        taken=round(stall.taken, 4),
        seen=stall.seen,
        last_seen=round(stall.last_seen, 2),
        score=round(stall.score, 4),
        label=stall.label or None,
    )


def _size(tile: EncodedTile) -> int:
    """Return the largest size of a tile in a message, bytes."""
    return TILE_BYTES + 4 * math.ceil(len(tile.data) / 3)
