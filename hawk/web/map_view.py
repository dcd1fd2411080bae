"""What one client holds of the map, and what it must be told next: at most `BUDGET_BYTES` a heartbeat."""

from __future__ import annotations

import base64
import math
from dataclasses import dataclass, field
from typing import Final

from hawk.comm.messages import MapUpdate, MosaicVersion, StallUpdate, TileUpdate
from hawk.model import EncodedTile, MapPoint, OccupancyMap, Stall, TileKey
from hawk.web.map_backlog import MapBacklog, nearest

BUDGET_BYTES: Final = 64 * 1024
"""JSON of one "Occupancy Map" (design, section 5)."""
STALL_SHARE: Final = 0.5
"""Share of the budget that stalls may take while tiles wait; the nearest tile always fits beside them."""
ENVELOPE_BYTES: Final = 256
TILE_BYTES: Final = 96
"""JSON of a tile without its data, at most."""
STALL_BYTES: Final = 320
"""JSON of a stall, at most: its numbers are rounded."""
MOSAIC_BYTES: Final = 72


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
    """Versions that the client was sent. A message on an open connection arrives or ends it, so sent means held."""

    budget_bytes: int = BUDGET_BYTES
    _map_id: str | None = None
    _tiles: dict[TileKey, int] = field(default_factory=dict)
    _mosaic: dict[TileKey, int] = field(default_factory=dict)
    _stalls: dict[int, int] = field(default_factory=dict)
    _backlog: MapBacklog = field(default_factory=MapBacklog)

    def forget(self) -> None:
        """The client holds nothing."""
        self._map_id = None
        self._backlog = MapBacklog()
        self._tiles.clear()
        self._mosaic.clear()
        self._stalls.clear()

    def update(self, current: OccupancyMap, drone: MapPoint | None) -> MapUpdate:
        """Return what to send next, nearest to the drone first, and take it as sent."""
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
        for number in sorted(self._backlog.gone):
            if not budget.take(STALL_BYTES, floor):
                break
            self._backlog.gone.discard(number)
            sent.append(StallUpdate(id=number, version=self._stalls.pop(number) + 1, removed=True))
        return sent

    def _send_stalls(self, current: OccupancyMap, near: MapPoint, budget: _Budget, floor: int) -> list[StallUpdate]:
        sent = []
        for number in self._backlog.next_stalls(current, near, self.budget_bytes // STALL_BYTES):
            if not budget.take(STALL_BYTES, floor):
                break
            stall = current.stalls[number]
            sent.append(stall_update(stall))
            self._stalls[number] = stall.version
            self._backlog.sent_stall(number)
        return sent

    def _send_tiles(self, keys: list[TileKey], current: OccupancyMap, budget: _Budget) -> list[TileUpdate]:
        sent = []
        for key in keys:
            tile = current.tiles[key]
            if not budget.take(_size(tile)):
                break
            data = base64.b64encode(tile.data).decode("ascii")
            sent.append(TileUpdate(row=key[0], column=key[1], version=tile.version, data=data))
            self._tiles[key] = tile.version
            self._backlog.tiles.discard(key)
        return sent

    def _send_mosaic(self, keys: list[TileKey], current: OccupancyMap, budget: _Budget) -> list[MosaicVersion]:
        sent = []
        for key in keys:
            if not budget.take(MOSAIC_BYTES):
                break
            version = current.mosaic[key].version
            sent.append(MosaicVersion(row=key[0], column=key[1], version=version))
            self._mosaic[key] = version
            self._backlog.mosaic.discard(key)
        return sent


def stall_update(stall: Stall) -> StallUpdate:
    """Return a stall as it is sent: lengths to the millimetre, probabilities to four digits."""
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
    )


def _size(tile: EncodedTile) -> int:
    """Return the bytes that a tile takes in a message, at most."""
    return TILE_BYTES + 4 * math.ceil(len(tile.data) / 3)
