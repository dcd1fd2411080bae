"""The map as a client holds it: kept by applying the updates of the heartbeats."""

from __future__ import annotations

import base64
import binascii
import zlib
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from hawk.comm.messages import MapUpdate, StallUpdate
from hawk.model import TILE_CELLS, Cell, Counts, GlobalPose, Stall, StallState, TileKey
from hawk.survey.survey_map import SurveyMap


class BadMapError(ValueError):
    """An update that cannot be applied; the remedy is to ask for the map again (Map Resync)."""


class ClientMap:
    """Tiles as (256, 256) arrays of `Cell`, stalls by id, versions of the mosaic's pictures."""

    def __init__(self) -> None:
        self.map_id: str | None = None
        self.backlog = 0
        """Changes that the drone has not sent yet."""
        self.tiles: dict[TileKey, NDArray[np.uint8]] = {}
        self.stalls: dict[int, Stall] = {}
        self.mosaic: dict[TileKey, int] = {}

    @property
    def counts(self) -> Counts:
        """Stalls by state."""
        states = [stall.state for stall in self.stalls.values()]
        return Counts(states.count(StallState.FREE), states.count(StallState.TAKEN), states.count(StallState.UNKNOWN))

    def clear(self) -> None:
        """Hold nothing: the connection is new, or the map began anew."""
        self.map_id = None
        self.backlog = 0
        self.tiles.clear()
        self.stalls.clear()
        self.mosaic.clear()

    def apply(self, update: MapUpdate) -> None:
        """Take one update. Raises BadMapError; what came before it in the update is kept."""
        if update.map_id != self.map_id:
            self.clear()
            self.map_id = update.map_id
        for tile in update.tiles:
            self.tiles[tile.row, tile.column] = _cells(tile.data)
        for stall in update.stalls:
            if stall.removed:
                self.stalls.pop(stall.id, None)
            else:
                self.stalls[stall.id] = _stall(stall)
        for picture in update.mosaic:
            self.mosaic[picture.row, picture.column] = picture.version
        self.backlog = update.backlog

    def survey_map(self, datum: GlobalPose, pictures: Mapping[TileKey, bytes]) -> SurveyMap:
        """Return it as the exports want it, with the mosaic's pictures (JPEG) that were fetched."""
        return SurveyMap(datum, dict(self.stalls), dict(self.tiles), dict(pictures))


def _cells(data: str) -> NDArray[np.uint8]:
    size = TILE_CELLS * TILE_CELLS
    try:
        inflater = zlib.decompressobj()
        raw = inflater.decompress(base64.b64decode(data, validate=True), size + 1)
    except (binascii.Error, zlib.error) as error:
        raise BadMapError(f"Tiles.Data: cannot be unpacked: {error}") from error
    if len(raw) != size:
        raise BadMapError(f"Tiles.Data: holds {len(raw)} cells, not {size}")
    cells = np.frombuffer(raw, np.uint8).reshape(TILE_CELLS, TILE_CELLS)
    if cells.max() > max(Cell):
        raise BadMapError(f"Tiles.Data: cell class {cells.max()} is not known")
    return cells


def _stall(update: StallUpdate) -> Stall:
    numbers = (update.north, update.east, update.angle, update.width, update.length)
    if update.state is None or any(number is None for number in numbers):
        raise BadMapError(f"Stalls: stall {update.id} is without place or state")
    north, east, angle, width, length = (float(number) for number in numbers if number is not None)
    return Stall(
        id=update.id,
        north=north,
        east=east,
        angle=angle,
        width=width,
        length=length,
        taken=0.5 if update.taken is None else update.taken,
        state=StallState(update.state),
        score=1.0 if update.score is None else update.score,
        seen=update.seen or 0,
        last_seen=update.last_seen or 0.0,
        version=update.version,
    )
