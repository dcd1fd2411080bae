"""Changes of the map that a heartbeat brings to one client."""

from __future__ import annotations

from typing import Literal

from hawk.comm.protocol.base import Finite, Outgoing


class TileUpdate(Outgoing):
    """A changed tile of the map. Its north-west corner lies -Row tiles north and Column tiles east of the datum."""

    row: int
    """Grows southwards."""
    column: int
    """Grows eastwards."""
    version: int
    data: str
    """Base64 of zlib of Tile Cells² bytes, one a cell, row by row from the north-west corner: 0 unknown, 1 not lot, 2
    lot, 3 free stall, 4 taken stall."""


class StallUpdate(Outgoing):
    """A changed stall. ``Removed``: it is gone. Angle in radians clockwise from north of the long side."""

    id: int
    version: int
    removed: bool = False
    north: Finite | None = None
    east: Finite | None = None
    angle: Finite | None = None
    width: Finite | None = None
    length: Finite | None = None
    state: Literal["free", "taken", "unknown", "suggested"] | None = None
    taken: Finite | None = None
    """Probability that it is taken."""
    seen: int | None = None
    """Frames that showed it; passes for a suggested one."""
    last_seen: Finite | None = None
    score: Finite | None = None


class MosaicVersion(Outgoing):
    """A changed mosaic tile; its picture is at /api/mosaic/{Row}/{Column}.jpg?v={Version}."""

    row: int
    column: int
    version: int


class MapUpdate(Outgoing):
    """The "Occupancy Map" of a heartbeat: map changes for this client, at most 64 kB, nearest first."""

    map_id: str
    tiles: list[TileUpdate]
    stalls: list[StallUpdate]
    mosaic: list[MosaicVersion]
    backlog: int
    """Tiles and stalls still to come in later heartbeats."""
