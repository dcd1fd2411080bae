"""The scheme of XYZ map tiles: Web Mercator (EPSG:3857) in squares, y from the north."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from hawk.web.background import DEEPEST_ZOOM

HALF_M: Final = math.pi * 6_378_137.0
"""Half the width of the world in Web Mercator, metres of the projection (EPSG:3857: a sphere with WGS-84's radius)."""
TILE_PX: Final = 256
_COARSER: Final = 1.15
"""Tiles may be coarser than the picture by this factor: one zoom more takes four times the room."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """A rectangle in Web Mercator, metres of the projection."""

    west: float
    south: float
    east: float
    north: float


@dataclass(frozen=True, slots=True)
class Tile:
    """One tile by its number."""

    zoom: int
    x: int
    y: int

    @property
    def bounds(self) -> Bounds:
        """Its edges."""
        side = tile_side(self.zoom)
        west, north = self.x * side - HALF_M, HALF_M - self.y * side
        return Bounds(west, north - side, west + side, north)


def tile_side(zoom: int) -> float:
    """Return the side of a tile, metres of the projection."""
    return 2 * HALF_M / (1 << zoom)


def zooms_for(bounds: Bounds, metres_per_pixel: float) -> range:
    """Return the zooms of a picture: from the one at which it fits into a tile to that of its own pixels.

    ``metres_per_pixel`` is in metres of the projection.
    """
    deepest = math.ceil(math.log2(2 * HALF_M / TILE_PX / (metres_per_pixel * _COARSER)))
    deepest = min(max(deepest, 0), DEEPEST_ZOOM)
    widest = max(bounds.east - bounds.west, bounds.north - bounds.south)
    lowest = math.floor(math.log2(2 * HALF_M / widest))
    return range(min(max(lowest, 0), deepest), deepest + 1)


def tiles_of(bounds: Bounds, zooms: range) -> Iterator[Tile]:
    """Yield every tile that the rectangle touches."""
    for zoom in zooms:
        xs, ys = _span(bounds, zoom)
        for x in xs:
            for y in ys:
                yield Tile(zoom, x, y)


def count_tiles(bounds: Bounds, zooms: range) -> int:
    """Return the number of tiles that the rectangle touches."""
    return sum(len(xs) * len(ys) for xs, ys in (_span(bounds, zoom) for zoom in zooms))


def _span(bounds: Bounds, zoom: int) -> tuple[range, range]:
    side, last = tile_side(zoom), (1 << zoom) - 1
    first_x, last_x = math.floor((bounds.west + HALF_M) / side), math.ceil((bounds.east + HALF_M) / side) - 1
    first_y, last_y = math.floor((HALF_M - bounds.north) / side), math.ceil((HALF_M - bounds.south) / side) - 1
    return range(max(first_x, 0), min(last_x, last) + 1), range(max(first_y, 0), min(last_y, last) + 1)
