"""The map of a survey: its stalls, cells and pictures with their place on Earth, for exports, scoring, recordings."""

from __future__ import annotations

import contextlib
import json
import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Any

import cv2
import numpy as np
import pymap3d
from numpy.typing import NDArray

from hawk.model.lot_map import (
    CELL_M,
    TILE_CELLS,
    TILE_M,
    Cell,
    Counts,
    OccupancyMap,
    Stall,
    StallState,
    TileKey,
    variance_of,
)
from hawk.model.poses import GlobalPose
from hawk.model.tile_picture import decode_picture

_OUTLINE_M = 0.5
_OUTLINE_AT, _OUTLINE_RISES = 96, 4  # of 255 seen about a place: at half of it the picture is half there


@dataclass(frozen=True, slots=True)
class Raster:
    """Cells of a rectangle of the map: row 0 is its north edge, column 0 its west edge.

    ``north`` and ``east`` are the map coordinates (metres) of the north-west corner, ``cell_m`` the side of a cell.
    """

    values: NDArray[np.uint8]
    north: float
    east: float
    cell_m: float

    def to_pixels(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (N, 2) of (north, east) as (column, row), pixel centres at whole numbers plus a half."""
        return np.column_stack(((points[:, 1] - self.east) / self.cell_m, (self.north - points[:, 0]) / self.cell_m))


@dataclass(frozen=True, slots=True)
class Made:
    """Source of a file: the ``survey``'s name (that of its journal, with its date), when the file was made (ISO 8601,
    UTC), and the ``software``.
    """

    survey: str = ""
    utc: str = ""
    software: str = ""

    @classmethod
    def now(cls, survey: str) -> Made:
        """Return the source of a file that this program makes now."""
        moment = datetime.now(UTC).isoformat(timespec="seconds").replace("+00:00", "Z")
        return cls(survey, moment, f"hawk-drone {version('hawk-drone')}")

    def values(self) -> dict[str, str]:
        """Return the source by the names of its columns."""
        return {"survey_id": self.survey, "made_utc": self.utc, "software": self.software}


@dataclass(frozen=True, slots=True)
class SurveyMap:
    """Stalls and cells of a survey in the map frame, and the WGS-84 place of its origin. ``survey`` is its name."""

    datum: GlobalPose
    stalls: Mapping[int, Stall]
    tiles: Mapping[TileKey, NDArray[np.uint8]]
    mosaic: Mapping[TileKey, bytes] = field(default_factory=dict, repr=False)
    survey: str = ""

    @classmethod
    def of(cls, datum: GlobalPose, current: OccupancyMap) -> SurveyMap:
        """Return the mapper's present map, its tiles unpacked."""
        tiles = {
            key: np.frombuffer(zlib.decompress(tile.data), np.uint8).reshape(TILE_CELLS, TILE_CELLS)
            for key, tile in current.tiles.items()
        }
        mosaic = {key: tile.data for key, tile in current.mosaic.items()}
        return cls(datum, dict(current.stalls), tiles, mosaic, current.map_id)

    @property
    def counts(self) -> Counts:
        """Stalls by state."""
        states = [stall.state for stall in self.stalls.values()]
        return Counts(
            states.count(StallState.FREE),
            states.count(StallState.TAKEN),
            states.count(StallState.UNKNOWN),
            variance_of(self.marked),
            states.count(StallState.SUGGESTED),
        )

    @property
    def marked(self) -> list[Stall]:
        """The stalls by rising id, without the suggested ones."""
        return [self.stalls[key] for key in sorted(self.stalls) if self.stalls[key].state is not StallState.SUGGESTED]

    def cells(self) -> Raster:
        """Return all tiles as one picture of `Cell` values; a single unknown cell when nothing was seen."""
        if not self.tiles:
            return Raster(np.zeros((1, 1), np.uint8), 0.0, 0.0, CELL_M)
        keys = np.array(list(self.tiles))
        north, east = -keys[:, 0].min() * TILE_M, keys[:, 1].min() * TILE_M
        values = np.full((np.ptp(keys, axis=0) + 1) * TILE_CELLS, Cell.UNKNOWN, np.uint8)
        for key, tile in self.tiles.items():
            values[self._window(key, north, east)] = tile
        return Raster(values, north, east, CELL_M)

    def picture(self) -> tuple[NDArray[np.uint8], NDArray[np.uint8], Raster]:
        """Return the mosaic over the extent of `cells`, its opacity (0..255), and those cells.

        The picture is BGR. Nothing is seen of it where the opacity is 0; it rises over the half metre about the outline
        of what was seen, which is smooth.
        """
        cells = self.cells()
        picture = np.zeros((*cells.values.shape, 3), np.uint8)
        seen, filled = np.zeros(cells.values.shape, np.uint8), np.zeros(cells.values.shape, np.uint8)
        for key, data in self.mosaic.items():
            if key in self.tiles:
                with contextlib.suppress(ValueError):
                    part = self._window(key, cells.north, cells.east)
                    picture[part], seen[part] = decode_picture(data)
                    filled[part] = 255
        return picture, np.minimum(_smooth(seen), filled), cells

    @staticmethod
    def _window(key: TileKey, north: float, east: float) -> tuple[slice, slice]:
        top = (key[0] + round(north / TILE_M)) * TILE_CELLS
        left = (key[1] - round(east / TILE_M)) * TILE_CELLS
        return slice(top, top + TILE_CELLS), slice(left, left + TILE_CELLS)


def _smooth(seen: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the mask with a soft outline that has no corner sharper than half a metre."""
    wide = cv2.GaussianBlur(seen, (0, 0), _OUTLINE_M / CELL_M, borderType=cv2.BORDER_CONSTANT)
    return np.clip((np.asarray(wide, np.int16) - _OUTLINE_AT) * _OUTLINE_RISES, 0, 255).astype(np.uint8)


def to_global(datum: GlobalPose, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (N, 2) of (north, east) metres in the map as (latitude, longitude) degrees."""
    latitude, longitude, _ = pymap3d.ned2geodetic(points[:, 0], points[:, 1], 0.0, datum.latitude, datum.longitude, 0.0)
    return np.column_stack((latitude, longitude))


def recorded_geojson(datum: GlobalPose, stalls: Mapping[int, Stall]) -> str:
    """Return the stalls as a recording has them: GeoJSON (RFC 7946) whose keys stay, since maps are compared by it.

    Only stalls of a plan have labels: those of rows cost too much in flight.
    """
    ordered = [stalls[key] for key in sorted(stalls)]
    corners = [stall.corners()[[0, 1, 2, 3, 0]] for stall in ordered]
    places = to_global(datum, np.concatenate([np.empty((0, 2)), *corners])).reshape(-1, 5, 2)
    rings = np.round(places[..., ::-1], 8).tolist()
    features = [_recorded_feature(stall, ring) for stall, ring in zip(ordered, rings, strict=True)]
    source = {"survey": "", "made_utc": "", "software": ""}
    return json.dumps({"type": "FeatureCollection", "hawk": source, "features": features}, allow_nan=False)


def _recorded_feature(stall: Stall, ring: list[list[float]]) -> dict[str, Any]:
    return {
        "type": "Feature",
        "id": stall.id,
        "geometry": {"type": "Polygon", "coordinates": [ring]},
        "properties": {
            "id": stall.id,
            "label": stall.label or None,
            "state": stall.state.value,
            "taken_probability": round(stall.taken, 3),
            "width_m": round(stall.width, 2),
            "length_m": round(stall.length, 2),
            "direction_deg": round(math.degrees(stall.angle), 1),
            "seen": stall.seen,
            "score": round(stall.score, 3),
        },
    }
