"""The map as bytes by key, for the flight journal: what changed since a version, and back again.

Every part stands for itself and the newest of a key wins, so that a journal only appends; empty bytes mean that the
part is no more. Evidence is rounded to a sixteenth in log-odds and 1/255 in probabilities.
"""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hawk.algo.mapper.grid import EvidenceTile
from hawk.model import Cell, TileKey

META = "meta"
GRID = "grid"
MOSAIC = "mosaic"
STALL = "stall"

_LOT_SCALE = 16.0
_LOOKS_SCALE = 4.0


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


def pack_tile(tile: EvidenceTile) -> bytes:
    """Return an evidence tile as bytes."""
    buffer = io.BytesIO()
    np.savez(
        buffer,
        lot=np.round(tile.lot.astype(np.float32) * _LOT_SCALE).astype(np.int8),
        looks=np.round(np.minimum(tile.looks.astype(np.float32) * _LOOKS_SCALE, 255)).astype(np.uint8),
        core=_to_byte(tile.core),
        car=_to_byte(tile.car),
        well=np.packbits(tile.well),
        shown=tile.shown,
    )
    return zlib.compress(buffer.getvalue(), 1)


def unpack_tile(data: bytes) -> EvidenceTile:
    """Return the tile of `pack_tile`. Raises ValueError when the bytes are not one."""
    try:
        with np.load(io.BytesIO(zlib.decompress(data)), allow_pickle=False) as arrays:
            tile = EvidenceTile()
            tile.lot[:] = arrays["lot"] / np.float32(_LOT_SCALE)
            tile.looks[:] = arrays["looks"] / np.float32(_LOOKS_SCALE)
            tile.core[:] = arrays["core"] / np.float32(255)
            tile.car[:] = arrays["car"] / np.float32(255)
            tile.well[:] = np.unpackbits(arrays["well"]).reshape(tile.well.shape)
            tile.shown[:] = np.minimum(arrays["shown"], Cell.LOT)
    except (zlib.error, zipfile.BadZipFile, KeyError, ValueError, OSError, EOFError) as error:
        raise ValueError(f"not an evidence tile: {error}") from error
    tile.summarise()
    return tile


def _to_byte(layer: NDArray[np.float16]) -> NDArray[np.uint8]:
    return np.round(layer.astype(np.float32) * 255).astype(np.uint8)
