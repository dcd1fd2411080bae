"""The map of the lot: cells in tiles, stalls and their counts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum, StrEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hawk.model.plans import ExploreStatus
from hawk.model.vehicles import MapVehicle

TILE_CELLS = 256
"""Cells along one side of a map tile."""
CELL_M = 0.10
"""Side of a map cell, metres."""
TILE_M = TILE_CELLS * CELL_M
"""Side of a map tile, metres."""


class StallState(StrEnum):
    """State of a stall. SUGGESTED: no stall is marked, but a car stood there in several passes; it counts as none."""

    FREE = "free"
    TAKEN = "taken"
    UNKNOWN = "unknown"
    SUGGESTED = "suggested"


@dataclass(frozen=True, slots=True)
class Stall:
    """A stall on the map: an oriented rectangle with a permanent id.

    ``angle`` is the direction of the long side in [0, pi); ``taken`` the probability of being taken; ``score`` the
    probability of being a stall at all; ``seen`` the number of frames that showed it, of passes for a suggested one;
    ``version`` rises when its shown content changes. ``known`` is the UUID of that stall in the lot's plan, where a
    person has confirmed it, ``label`` its name there: then ``score`` is only what the flight saw of it. ``extra`` is
    the state of a stall found beside confirmed ones, where the plan has none: ``state`` is SUGGESTED then, as for a
    car that stood there. ``is_blurred``: only blurred pictures showed it; None: not
    measured.
    """

    id: int
    north: float
    east: float
    angle: float
    width: float
    length: float
    taken: float
    state: StallState
    score: float
    seen: int
    last_seen: float
    version: int
    known: str = ""
    extra: StallState | None = None
    label: str = ""
    is_blurred: bool | None = None

    @property
    def existence(self) -> float:
        """Probability of being a stall at all: a confirmed one is."""
        return 1.0 if self.known else self.score

    def corners(self) -> NDArray[np.float64]:
        """Return the four corners, (4, 2) of (north, east) metres: two ends of the near short side, then the far."""
        along = np.array([math.cos(self.angle), math.sin(self.angle)]) * self.length / 2
        across = np.array([-math.sin(self.angle), math.cos(self.angle)]) * self.width / 2
        centre = np.array([self.north, self.east])
        return np.array(
            [centre - along - across, centre - along + across, centre + along + across, centre + along - across]
        )


class Cell(IntEnum):
    """Class of a map cell."""

    UNKNOWN = 0
    NON_LOT = 1
    LOT = 2
    FREE = 3
    TAKEN = 4


TileKey = tuple[int, int]
"""(row, column) of a tile: it covers north in [-(row + 1), -row) * TILE_M and east in [column, column + 1) * TILE_M, so
that rows grow southwards and columns eastwards, as in a picture; cell (0, 0) of a tile is its north-west corner."""


@dataclass(frozen=True, slots=True)
class EncodedTile:
    """An encoded tile: ``version`` rises only when its shown content changes."""

    version: int
    data: bytes = field(repr=False)


@dataclass(frozen=True, slots=True)
class Counts:
    """Stalls by state. ``free_variance`` is the variance of the number of free ones (`hawk.model.lot_map`)."""

    free: int = 0
    taken: int = 0
    unknown: int = 0
    free_variance: float = 0.0
    suggested: int = 0

    @property
    def total(self) -> int:
        """All stalls, without the suggested ones."""
        return self.free + self.taken + self.unknown


@dataclass(frozen=True, slots=True)
class OccupancyMap:
    """An immutable index of the map: nothing in it is copied when a cell changes.

    ``tiles`` hold TILE_CELLS x TILE_CELLS bytes of `Cell`, row-major from the north-west corner, zlib-compressed.
    ``mosaic`` holds pictures of the same tiles (`hawk.model.tile_picture`), TILE_CELLS pixels a side. ``stalls`` and
    ``vehicles`` by id.
    """

    tiles: Mapping[TileKey, EncodedTile] = field(default_factory=dict)
    mosaic: Mapping[TileKey, EncodedTile] = field(default_factory=dict)
    stalls: Mapping[int, Stall] = field(default_factory=dict)
    vehicles: Mapping[int, MapVehicle] = field(default_factory=dict, kw_only=True)
    counts: Counts = Counts()
    lot_area_m2: float = 0.0
    version: int = 0
    map_id: str = ""
    """Changes when the map starts again: a client drops its copy of another map."""


SPREADS: Final = 2.7
"""Standard deviations, of stalls that err each for itself, about the count. Stalls err by the row as well, and some are
not found at all: this many held the true number in 29 of the drawn worlds 101 to 132, 90 %."""
HELD_SHARE: Final = 0.9
"""Share of surveys in which the interval must hold the true number."""


def free_variance(score: float, taken: float) -> float:
    """Return the variance of a stall's part in the number of free ones, 0 to 0.25.

    ``score`` is the probability of being a stall, ``taken`` that of being taken.
    """
    free = score * (1 - taken)
    return free * (1 - free)


def variance_of(stalls: Iterable[Stall]) -> float:
    """Return the variance of the number of free stalls among these."""
    return sum(free_variance(stall.existence, stall.taken) for stall in stalls)


def free_interval(counts: Counts, explore: ExploreStatus | None) -> tuple[int, int] | None:
    """Return the least and the greatest number of free stalls of the lot found; None until it is seen whole.

    As many stalls as the lot has by area are expected on the few patches that were left out; each may be free or not.

    Args:
        counts: The stalls found, with their variance.
        explore: Progress of the exploration; None before the first plan.
    """
    if explore is None or not explore.is_whole:
        return None
    unseen = counts.total * (1 / min(explore.seen_share, 1.0) - 1)
    return interval_of(counts.free, counts.free_variance, unseen)


def interval_of(free: int, variance: float, unseen: float = 0.0) -> tuple[int, int]:
    """Return the least and the greatest number of free stalls about a count; `HELD_SHARE` of these hold the truth.

    ``unseen``: stalls that are expected on ground that was not seen; each may be free or not.
    """
    off = SPREADS * math.sqrt(variance)
    return max(math.floor(free - off), 0), math.ceil(free + off + unseen)
