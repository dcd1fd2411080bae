"""The layers of one tile, and how they rest: as bytes, evidence rounded to what a look can tell.

Log-odds are rounded to a sixteenth, looks to a quarter, probabilities to 1/255. Rounding what is rounded already
changes nothing, so that a tile that rests and wakes again and again stays as it is.
"""

from __future__ import annotations

import io
import zipfile
import zlib
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hawk.model import TILE_M, Cell

EVIDENCE_M = 0.2
"""Side of an evidence cell, metres."""
TILE_SIDE = round(TILE_M / EVIDENCE_M)
"""Evidence cells along one side of a tile."""

_LOT_SCALE = 16.0
_LOOKS_SCALE = 4.0

Grid16 = NDArray[np.float16]
Grid32 = NDArray[np.float32]
GridU8 = NDArray[np.uint8]


def _zeros16() -> Grid16:
    return np.zeros((TILE_SIDE, TILE_SIDE), np.float16)


def _zeros32() -> Grid32:
    return np.zeros((TILE_SIDE, TILE_SIDE), np.float32)


def _zeros8() -> GridU8:
    return np.zeros((TILE_SIDE, TILE_SIDE), np.uint8)


@dataclass(slots=True)
class EvidenceLayers:
    """Layers (128, 128) from the tile's north-west corner.

    ``lot`` log-odds, ``core`` and ``car`` mean probabilities, ``looks`` independent looks so far, ``well`` 1 where the
    cell was seen in the good part of a picture, ``shown`` the `Cell` class without the stalls.
    """

    lot: Grid32 = field(default_factory=_zeros32)
    looks: Grid32 = field(default_factory=_zeros32)
    core: Grid16 = field(default_factory=_zeros16)
    car: Grid16 = field(default_factory=_zeros16)
    well: GridU8 = field(default_factory=_zeros8)
    shown: GridU8 = field(default_factory=_zeros8)

    def to_bytes(self) -> bytes:
        """Return the layers as bytes."""
        buffer = io.BytesIO()
        np.savez(
            buffer,
            lot=np.round(self.lot * _LOT_SCALE).astype(np.int8),
            looks=np.round(np.minimum(self.looks * _LOOKS_SCALE, 255)).astype(np.uint8),
            core=_to_byte(self.core),
            car=_to_byte(self.car),
            well=np.packbits(self.well),
            shown=self.shown,
        )
        return zlib.compress(buffer.getvalue(), 1)

    @classmethod
    def from_bytes(cls, data: bytes) -> EvidenceLayers:
        """Read the layers. Raises ValueError when the bytes are none."""
        try:
            with np.load(io.BytesIO(zlib.decompress(data)), allow_pickle=False) as arrays:
                layers = cls()
                layers.lot[:] = arrays["lot"] / np.float32(_LOT_SCALE)
                layers.looks[:] = arrays["looks"] / np.float32(_LOOKS_SCALE)
                layers.core[:] = arrays["core"] / np.float32(255)
                layers.car[:] = arrays["car"] / np.float32(255)
                layers.well[:] = np.unpackbits(arrays["well"]).reshape(layers.well.shape)
                layers.shown[:] = np.minimum(arrays["shown"], Cell.LOT)
        except (zlib.error, zipfile.BadZipFile, KeyError, ValueError, OSError, EOFError) as error:
            raise ValueError(f"not an evidence tile: {error}") from error
        return layers


def _to_byte(layer: Grid16) -> GridU8:
    return np.round(layer.astype(np.float32) * 255).astype(np.uint8)
