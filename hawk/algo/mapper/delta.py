"""The map as bytes by key, for the flight journal: the changes since a version, and back again.

Every part stands for itself and the newest of a key wins, so that a journal only appends; empty bytes mean that the
part is no more. Tiles of evidence are bytes of `EvidenceTile.to_bytes`.
"""

from __future__ import annotations

import json
from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Generic, TypeVar

import numpy as np

from hawk.model.lot_map import TileKey

K = TypeVar("K", bound=Hashable)

META = "meta"
GRID = "grid"
MOSAIC = "mosaic"
STALL = "stall"
SUGGESTION = "suggestion"
VEHICLE = "vehicle"


@dataclass(frozen=True, slots=True)
class MapDelta:
    """Changes up to ``version``: bytes by key; empty bytes: gone."""

    version: int
    parts: Mapping[str, bytes] = field(repr=False)


@dataclass(frozen=True, slots=True)
class MapMeta:
    """Figures of the whole map; ``shift`` (north, east, turn) is the correction of the pose, metres and radians."""

    map_id: str
    version: int
    next_id: int
    shift: tuple[float, float, float]

    def to_bytes(self) -> bytes:
        """Return it as JSON."""
        return json.dumps([self.map_id, self.version, self.next_id, *self.shift]).encode()

    @classmethod
    def from_bytes(cls, data: bytes) -> MapMeta:
        """Return the figures. Raises ValueError when they cannot be read."""
        try:
            map_id, version, next_id, north, east, turn, *_ = json.loads(data)
            shift = (float(north), float(east), float(turn))
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


class Recent(Generic[K]):
    """Keys with the version of their last change; versions never fall."""

    def __init__(self) -> None:
        self._versions: dict[K, int] = {}

    def __contains__(self, key: K) -> bool:
        return key in self._versions

    def __len__(self) -> int:
        return len(self._versions)

    def note(self, key: K, version: int) -> None:
        """Note a change of the key."""
        self._versions.pop(key, None)
        self._versions[key] = version

    def forget(self, key: K) -> None:
        """Forget the key."""
        self._versions.pop(key, None)

    def since(self, version: int) -> Iterator[K]:
        """Yield the keys that changed after a version, the newest first."""
        for key, changed in reversed(self._versions.items()):
            if changed <= version:
                return
            yield key
