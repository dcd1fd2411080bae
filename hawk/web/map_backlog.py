"""What a client does not hold of the map yet, by where it lies: no heartbeat looks at the rest of the map.

The secret is how it is kept up: the newest map is compared with the one compared last, and of what differs a bounded
number is taken in at a time, so that a page that is opened over a large map costs every heartbeat little and none much.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from typing import Final, Literal

from hawk.model import TILE_M, MapPoint, OccupancyMap, TileKey
from hawk.sharded import differing

INTAKE: Final = 2000
"""Differences between two maps that are taken in at a time."""

_Kind = Literal["tile", "mosaic", "stall"]


class MapBacklog:
    """Keys of tiles, mosaic tiles and stalls that differ from what the client was sent."""

    def __init__(self) -> None:
        self.tiles: set[TileKey] = set()
        self.mosaic: set[TileKey] = set()
        self.gone: set[int] = set()
        """Stalls that the client holds and the map has no more."""
        self._stalls: dict[TileKey, set[int]] = {}
        self._squares: dict[int, TileKey] = {}
        self._compared = OccupancyMap()
        self._differing: Iterator[tuple[_Kind, TileKey | int]] | None = None
        self._target = self._compared

    def __len__(self) -> int:
        """Return what waits; while a comparison is under way there is more of it than is known."""
        unknown = 0 if self._differing is None else 1
        return unknown + len(self.tiles) + len(self.mosaic) + len(self.gone) + len(self._squares)

    def take_in(
        self,
        current: OccupancyMap,
        held_tiles: Mapping[TileKey, int],
        held_mosaic: Mapping[TileKey, int],
        held_stalls: Mapping[int, int],
    ) -> None:
        """Look at what changed up to the newest map; ``held`` are the versions that the client was sent."""
        if self._differing is None and current is not self._compared:
            self._differing, self._target = _differences(current, self._compared), current
        if self._differing is None:
            return
        news = list(itertools.islice(self._differing, INTAKE))
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
        """Return stalls that wait, nearest first: those of the nearest squares, somewhat more than ``most``."""
        found: list[int] = []
        for square in nearest(self._stalls, near):
            if len(found) >= most:
                break
            found += self._stalls[square]
        there = [stall for stall_id in found if (stall := current.stalls.get(stall_id)) is not None]
        there.sort(key=lambda stall: (math.hypot(stall.north - near.north, stall.east - near.east), stall.id))
        return [stall.id for stall in there]

    def sent_stall(self, stall_id: int) -> None:
        """The stall waits no more."""
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
    """Return tiles by the distance of their middles from a place."""
    north, east = -near.north / TILE_M - 0.5, near.east / TILE_M - 0.5
    return sorted(keys, key=lambda key: (key[0] - north) ** 2 + (key[1] - east) ** 2)


def _differences(now: OccupancyMap, before: OccupancyMap) -> Iterator[tuple[_Kind, TileKey | int]]:
    for key in differing(now.tiles, before.tiles):
        yield "tile", key
    for key in differing(now.mosaic, before.mosaic):
        yield "mosaic", key
    for stall_id in differing(now.stalls, before.stalls):
        yield "stall", stall_id
