"""The share of one lot in the map of a round: what lies nearer to it than to the other lots of the round."""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, TypeVar

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from hawk.lots.registration.georeference import ground_about
from hawk.lots.survey.landing import LandingFacts
from hawk.lots.values import SHARE
from hawk.model.lot_map import TILE_CELLS, TILE_M, Cell, EncodedTile, OccupancyMap, Stall, TileKey
from hawk.model.vehicles import MapVehicle

T = TypeVar("T", Stall, MapVehicle)
_CELLS: Final = 16
"""Cells of the map on a side of a cell of the partition: 1.6 m."""
_PER_TILE: Final = TILE_CELLS // _CELLS
_SIDE_M: Final = TILE_M / _PER_TILE


def share_of(landed: LandingFacts, lot: str, lot_of: Mapping[str, str]) -> LandingFacts | None:
    """Return the survey of one lot of a round, by its id; None where no stall of it was seen, and it is not over.

    Takes some 10 ms for each hectare of the map.

    Args:
        landed: The survey of the round.
        lot: The lot.
        lot_of: Lot of each stall, by their ids, that the flight knew: a receiver that errs puts it nearer to another.
    """
    grounds = () if landed.outline is None else landed.outline.grounds()
    number = next((number for number, (each, _) in enumerate(grounds) if each.id == lot), None)
    if number is None or not landed.current.tiles:
        return None
    datum = (landed.datum.latitude, landed.datum.longitude)
    partition = LotPartition.of([ground_about(datum, ground) for _, ground in grounds], landed.current.tiles)
    current = _part(landed.current, partition, number)
    current = replace(current, stalls=_known_first(landed.current.stalls, current.stalls, lot, lot_of))
    is_over = grounds[number][0].is_over and bool(current.tiles)  # sections alone have no stalls
    if not is_over and not any(stall.seen for stall in current.stalls.values()):
        return None
    return replace(
        landed,
        name=f"{landed.name}{SHARE}{lot}",
        current=current,
        outline=grounds[number][1],
        beside=tuple(ground for each, ground in grounds if each.id != lot),
    )


@dataclass(frozen=True, slots=True)
class LotPartition:
    """The map divided among lots: ``nearest`` (rows, columns) is the number of the lot nearest to each cell of 1.6 m.

    Cell (0, 0) is the north-west corner, at ``north`` and ``east``, metres.
    """

    nearest: NDArray[np.intp] = field(repr=False)
    north: float
    east: float

    @classmethod
    def of(cls, grounds: Sequence[BaseGeometry], tiles: Mapping[TileKey, object]) -> LotPartition:
        """Divide the extent of tiles among the ground of lots, in metres (north, east)."""
        keys = np.array(list(tiles))
        north, east = -keys[:, 0].min() * TILE_M, keys[:, 1].min() * TILE_M
        rows, columns = ((np.ptp(keys, axis=0) + 1) * _PER_TILE).tolist()
        middles = np.meshgrid(
            north - (np.arange(rows) + 0.5) * _SIDE_M, east + (np.arange(columns) + 0.5) * _SIDE_M, indexing="ij"
        )
        away = np.stack([_away(ground, *middles) for ground in grounds])
        return cls(away.argmin(axis=0), float(north), float(east))

    def at(self, north: NDArray[np.float64], east: NDArray[np.float64]) -> NDArray[np.intp]:
        """Return the number of the lot nearest to places (N,), metres; beyond the map those at its edge."""
        rows = np.floor((self.north - north) / _SIDE_M).astype(np.intp).clip(0, self.nearest.shape[0] - 1)
        columns = np.floor((east - self.east) / _SIDE_M).astype(np.intp).clip(0, self.nearest.shape[1] - 1)
        return np.asarray(self.nearest[rows, columns])

    def of_tile(self, key: TileKey) -> NDArray[np.intp]:
        """Return the number of the nearest lot for each cell (256, 256) of a tile of the map."""
        row = round(self.north / TILE_M + key[0]) * _PER_TILE
        column = round(key[1] - self.east / TILE_M) * _PER_TILE
        part = self.nearest[row : row + _PER_TILE, column : column + _PER_TILE]
        cells: NDArray[np.intp] = part.repeat(_CELLS, axis=0).repeat(_CELLS, axis=1)
        return cells


def _away(ground: BaseGeometry, north: NDArray[np.float64], east: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distances (rows, columns) of places from some ground, metres, to a cell."""
    mask = shapely.contains_xy(ground, north, east) if not ground.is_empty else np.zeros(north.shape, np.bool_)
    if not mask.any():  # smaller than a cell, or beyond the map
        return np.asarray(shapely.distance(ground, shapely.points(north, east)), np.float64)
    return cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE).astype(np.float64)


def _part(current: OccupancyMap, partition: LotPartition, number: int) -> OccupancyMap:
    """Return what of a map is nearest to one lot."""
    tiles = {}
    for key, tile in current.tiles.items():
        mine = partition.of_tile(key) == number
        if mine.all():
            tiles[key] = tile
        elif mine.any():
            cells = np.frombuffer(zlib.decompress(tile.data), np.uint8).reshape(TILE_CELLS, TILE_CELLS)
            tiles[key] = EncodedTile(
                tile.version, zlib.compress(np.where(mine, cells, Cell.UNKNOWN).astype(np.uint8).tobytes())
            )
    return replace(
        current,
        tiles=tiles,
        mosaic={key: tile for key, tile in current.mosaic.items() if key in tiles},
        stalls=_nearest(current.stalls, partition, number),
        vehicles=None if current.vehicles is None else _nearest(current.vehicles, partition, number),
    )


def _known_first(
    stalls: Mapping[int, Stall], nearest: Mapping[int, Stall], lot: str, lot_of: Mapping[str, str]
) -> dict[int, Stall]:
    """Return the stalls of a lot by their known ids, and the nearest ones of those without."""
    unknown = {key: stall for key, stall in nearest.items() if stall.known not in lot_of}
    return unknown | {key: stall for key, stall in stalls.items() if lot_of.get(stall.known) == lot}


def _nearest(found: Mapping[int, T], partition: LotPartition, number: int) -> dict[int, T]:
    """Return those of stalls or vehicles, by id, that are nearest to one lot."""
    places = np.array([(one.north, one.east) for one in found.values()], np.float64).reshape(-1, 2)
    mine = partition.at(*places.T) == number
    return {key: one for (key, one), yes in zip(found.items(), mine.tolist(), strict=True) if yes}
