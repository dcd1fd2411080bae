"""The map as bytes by key, for the flight journal: what changed since a version, and back again.

Every part stands for itself and the newest of a key wins, so that a journal only appends; empty bytes mean that the
part is no more. Tiles of evidence are bytes of `EvidenceTile.to_bytes`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from hawk.model import TileKey

META = "meta"
GRID = "grid"
MOSAIC = "mosaic"
STALL = "stall"


@dataclass(frozen=True, slots=True)
class MapDelta:
    """What changed up to ``version``: bytes by key; empty bytes: gone."""

    version: int
    parts: Mapping[str, bytes] = field(repr=False)


@dataclass(frozen=True, slots=True)
class MapMeta:
    """What belongs to the map as a whole; the shift is the pose error that the map is laid in."""

    map_id: str
    version: int
    next_id: int
    shift: tuple[float, float, float, float]

    def to_bytes(self) -> bytes:
        """Return it as JSON."""
        return json.dumps([self.map_id, self.version, self.next_id, *self.shift]).encode()

    @classmethod
    def from_bytes(cls, data: bytes) -> MapMeta:
        """Read it. Raises ValueError when it cannot be."""
        try:
            map_id, version, next_id, north, east, turn, scale = json.loads(data)
            shift = (float(north), float(east), float(turn), float(scale))
            if not np.isfinite(shift).all():
                raise ValueError("the shift is not finite")
            return cls(str(map_id), int(version), int(next_id), shift)
        except (TypeError, ValueError) as error:
            raise ValueError(f"{META}: cannot be read: {error}") from error


def tile_name(kind: str, key: TileKey) -> str:
    """Return the key of a tile in a delta."""
    return f"{kind}/{key[0]},{key[1]}"


def tile_key(name: str) -> TileKey:
    """Return the tile of a key. Raises ValueError when it names none."""
    row, _, column = name.partition("/")[2].partition(",")
    return int(row), int(column)
