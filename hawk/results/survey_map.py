"""The map of a survey as table (CSV), GeoJSON and picture: for exports and scoring, server and headless survey."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Any, Final

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
from hawk.results.row_labels import row_labels

_CELL_COLOURS = {Cell.UNKNOWN: (235, 231, 227), Cell.NON_LOT: (205, 205, 205), Cell.LOT: (150, 150, 150)}
_FREE = (255, 143, 47)
_FREE_LINE = (255, 241, 227)
_TAKEN = (26, 122, 255)
_TAKEN_LINE = (0, 90, 224)
_PLATE = (28, 22, 16)
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
        return cls(survey, datetime.now(UTC).isoformat(timespec="seconds"), f"hawk-drone {version('hawk-drone')}")

    def values(self) -> dict[str, str]:
        """Return the source by the names of its columns."""
        return {"survey": self.survey, "made_utc": self.utc, "software": self.software}


_UNKNOWN: Final = Made()


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


def map_picture(survey: SurveyMap) -> NDArray[np.uint8]:
    """Return the map as a BGR picture, north up, 10 cm a pixel: the mosaic where there is one, stalls drawn over it.

    Free is blue and plain, taken orange and hatched, unknown dark with a question mark, suggested only has corners: no
    state rests on colour alone.
    """
    mosaic, opacity, cells = survey.picture()
    colours = np.array([_CELL_COLOURS.get(cell, _CELL_COLOURS[Cell.LOT]) for cell in Cell], np.uint8)
    share = (opacity / np.float32(255)).astype(np.float32)
    picture = np.asarray(cv2.blendLinear(mosaic, colours[cells.values], share, 1 - share), np.uint8)
    for key in sorted(survey.stalls):
        draw_stall(picture, cells.to_pixels(survey.stalls[key].corners()), survey.stalls[key].state)
    return picture


def draw_stall(picture: NDArray[np.uint8], corners: NDArray[np.float64], state: StallState) -> None:
    """Draw a stall into a BGR picture by its corners (4, 2) as (column, row)."""
    pixels = corners.astype(np.int32)
    if state is StallState.SUGGESTED:
        _draw_corners(picture, pixels)
        return
    left, top = np.maximum(pixels.min(axis=0), 0)
    right, bottom = pixels.max(axis=0) + 1
    part = picture[top:bottom, left:right]
    if part.size == 0:
        return
    inside = np.zeros(part.shape[:2], np.uint8)
    cv2.fillPoly(inside, [pixels - (left, top)], 255)
    colour, line, share = {
        StallState.FREE: (_FREE, _FREE_LINE, 0.46),
        StallState.TAKEN: (_TAKEN, _TAKEN_LINE, 0.6),
        StallState.UNKNOWN: (_PLATE, (255, 255, 255), 0.45),
    }[state]
    tint = np.empty(part.shape, np.float32)
    tint[:] = colour
    if state is StallState.TAKEN:
        rows, columns = np.indices(inside.shape)
        tint[(rows + columns + left + top) % 9 > 4] = _PLATE
    tinted = part * (1 - share) + tint * share
    part[inside > 0] = tinted[inside > 0].astype(np.uint8)
    cv2.polylines(picture, [pixels], True, line, 1, cv2.LINE_AA)
    if state is StallState.UNKNOWN:
        centre = (int(pixels[:, 0].mean()) - 5, int(pixels[:, 1].mean()) + 5)
        cv2.putText(picture, "?", centre, cv2.FONT_HERSHEY_SIMPLEX, 0.5, (255, 255, 255), 1, cv2.LINE_AA)


def _draw_corners(picture: NDArray[np.uint8], pixels: NDArray[np.int32]) -> None:
    """Draw a quarter of each side from its ends: a suggested stall has no lines on the ground."""
    for start, end in zip(pixels, np.roll(pixels, -1, axis=0), strict=True):
        for near, far in ((start, end), (end, start)):
            cv2.line(picture, near.tolist(), (near + (far - near) // 4).tolist(), (255, 255, 255), 1, cv2.LINE_AA)


CSV_COLUMNS = (
    "id",
    "label",
    "state",
    "taken_probability",
    "latitude",
    "longitude",
    "north_m",
    "east_m",
    "direction_deg",
    "width_m",
    "length_m",
    "seen",
    "score",
    "survey",
    "made_utc",
    "software",
)
"""Columns of the table; the last three are the same in every line: two surveys' tables can be distinguished."""


def to_global(datum: GlobalPose, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (N, 2) of (north, east) metres in the map as (latitude, longitude) degrees."""
    latitude, longitude, _ = pymap3d.ned2geodetic(points[:, 0], points[:, 1], 0.0, datum.latitude, datum.longitude, 0.0)
    return np.column_stack((latitude, longitude))


def labels_of(stalls: Mapping[int, Stall]) -> dict[int, str]:
    """Return the labels for people, by id.

    On a known lot they are those of its plan; a stall that the plan has not gets one when it is taken over.
    """
    of_plan = {key: stall.label for key, stall in stalls.items() if stall.label}
    return of_plan or row_labels(stalls)


def stalls_csv(datum: GlobalPose, stalls: Mapping[int, Stall], made: Made = _UNKNOWN) -> str:
    """Return the table of stalls, one line each, in the order of their ids."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(CSV_COLUMNS)
    labels = labels_of(stalls)
    for key in sorted(stalls):
        row = {**_row(datum, stalls[key], labels.get(key, "")), **made.values()}
        writer.writerow(row.values())
    return out.getvalue()


def stalls_geojson(
    datum: GlobalPose, stalls: Mapping[int, Stall], made: Made = _UNKNOWN, labels: Mapping[int, str] | None = None
) -> str:
    """Return the stalls as a GeoJSON FeatureCollection (RFC 7946: longitude first, rings closed, counter-clockwise).

    Its source is the member "hawk". ``labels`` by id: those of `labels_of` where none are given, found by rows.
    """
    labels = labels_of(stalls) if labels is None else labels
    ordered = [stalls[key] for key in sorted(stalls)]
    corners = [stall.corners()[[0, 1, 2, 3, 0]] for stall in ordered]
    places = to_global(datum, np.concatenate([np.empty((0, 2)), *corners])).reshape(-1, 5, 2)
    rings = np.round(places[..., ::-1], 8).tolist()
    features = [_feature(stall, ring, labels.get(stall.id)) for stall, ring in zip(ordered, rings, strict=True)]
    return json.dumps({"type": "FeatureCollection", "hawk": made.values(), "features": features}, allow_nan=False)


def _row(datum: GlobalPose, stall: Stall, label: str) -> dict[str, object]:
    latitude, longitude = to_global(datum, np.array([[stall.north, stall.east]]))[0]
    return {
        "id": stall.id,
        "label": label,
        "state": stall.state.value,
        "taken_probability": f"{stall.taken:.3f}",
        "latitude": f"{latitude:.8f}",
        "longitude": f"{longitude:.8f}",
        "north_m": f"{stall.north:.2f}",
        "east_m": f"{stall.east:.2f}",
        "direction_deg": f"{math.degrees(stall.angle):.1f}",
        "width_m": f"{stall.width:.2f}",
        "length_m": f"{stall.length:.2f}",
        "seen": stall.seen,
        "score": f"{stall.score:.3f}",
    }


def _feature(stall: Stall, ring: list[list[float]], label: str | None) -> dict[str, Any]:
    return {
        "type": "Feature",
        "id": stall.id,
        "geometry": {"type": "Polygon", "coordinates": [ring]},
        "properties": {
            "id": stall.id,
            "label": label,
            "state": stall.state.value,
            "taken_probability": round(stall.taken, 3),
            "width_m": round(stall.width, 2),
            "length_m": round(stall.length, 2),
            "direction_deg": round(math.degrees(stall.angle), 1),
            "seen": stall.seen,
            "score": round(stall.score, 3),
        },
    }
