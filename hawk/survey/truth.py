"""Ground truth of a world: its stalls and lots, in metres of its picture."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, PositiveFloat, PositiveInt, ValidationError
from shapely.geometry import Polygon
from shapely.ops import unary_union

from hawk.formats.validation import first_wrong
from hawk.model.frames import offset_ned
from hawk.model.lot_map import StallState
from hawk.model.poses import GlobalPose
from hawk.results.survey_map import to_global


class TruthError(ValueError):
    """A truth file that cannot be used; the text names the field."""


class _TrueStall(BaseModel):
    model_config = ConfigDict(extra="ignore")
    corners_m: list[tuple[float, float]]
    state: str
    hidden: bool = False


class _Origin(BaseModel):
    latitude: float
    longitude: float


class _TruthFile(BaseModel):
    model_config = ConfigDict(extra="ignore")
    stalls: list[_TrueStall]
    lots_m: list[list[tuple[float, float]]]
    origin: _Origin | None = None
    metres_per_pixel: PositiveFloat | None = None
    size_px: tuple[PositiveInt, PositiveInt] | None = None


@dataclass(frozen=True, slots=True)
class GroundTruth:
    """Stalls and lots of a world. Places are (N, 2) metres of (x east, y south) of its picture's upper left corner.

    ``states`` holds None where the state is unclear (a cut or half covered stall). ``origin`` is the WGS-84 place of
    the corner, None when it is not known. ``size`` is the picture's (width, height) in metres, None when it is not
    known; nobody labelled what lies beyond.
    """

    stalls: tuple[NDArray[np.float64], ...]
    states: tuple[StallState | None, ...]
    hidden: tuple[bool, ...]
    lots: tuple[NDArray[np.float64], ...]
    origin: GlobalPose | None
    size: tuple[float, float] | None = None

    def in_picture(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return a mask (N,) of the world's places (N, 2) that its picture shows: all where its size is unknown."""
        return np.ones(len(points), np.bool_) if self.size is None else in_picture(points, self.size)

    def to_world(self, points: NDArray[np.float64], datum: GlobalPose) -> NDArray[np.float64]:
        """Return (N, 2) of map coordinates (north, east about ``datum``) as (x, y) of the world, metres.

        Raises TruthError when the truth has no origin.
        """
        north, east, _ = offset_ned(replace(datum, altitude=0.0), self._require_origin())
        return np.column_stack((points[:, 1] + east, -(points[:, 0] + north)))

    def fence(self, margin_m: float) -> dict[str, Any]:
        """Return a GeoJSON polygon (WGS-84) that runs ``margin_m`` metres around all lots together."""
        area = unary_union([Polygon(lot).buffer(0) for lot in self.lots]).buffer(margin_m, join_style="mitre")
        outer = area if area.geom_type == "Polygon" else area.convex_hull
        ring = np.asarray(outer.simplify(0.5).exterior.coords)
        origin = self._require_origin()
        places = to_global(origin, np.column_stack((-ring[:, 1], ring[:, 0])))
        coordinates = [[float(lon), float(lat)] for lat, lon in places]
        return {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [coordinates]}}

    def _require_origin(self) -> GlobalPose:
        if self.origin is None:
            raise TruthError("origin: the truth does not say where on Earth its picture lies")
        return self.origin


def in_picture(points: NDArray[np.float64], size: tuple[float, float]) -> NDArray[np.bool_]:
    """Return a mask (N,) of the places (N, 2) of a world that its picture of ``size`` (width, height) shows, metres."""
    return np.asarray(((points >= 0) & (points <= size)).all(axis=1))


def parse_truth(values: Mapping[str, Any]) -> GroundTruth:
    """Return the truth that a JSON object holds (``stalls`` with ``corners_m`` and ``state``, ``lots_m``, ``origin``).

    Raises TruthError naming the field.
    """
    try:
        found = _TruthFile.model_validate(values)
    except ValidationError as error:
        raise TruthError(first_wrong(error, _TruthFile)) from None
    for number, stall in enumerate(found.stalls):
        if len(stall.corners_m) != 4:
            raise TruthError(f"stalls.{number}.corners_m: a stall has 4 corners, not {len(stall.corners_m)}")
    place = GlobalPose(found.origin.latitude, found.origin.longitude, 0.0) if found.origin else None
    return GroundTruth(
        stalls=tuple(np.asarray(stall.corners_m, float) for stall in found.stalls),
        states=tuple(_state(stall.state) for stall in found.stalls),
        hidden=tuple(stall.hidden for stall in found.stalls),
        lots=tuple(np.asarray(lot, float) for lot in found.lots_m if len(lot) >= 3),
        origin=place,
        size=_size(found),
    )


def read_truth(path: Path) -> GroundTruth:
    """Return the truth in a file. Raises TruthError naming file and field."""
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise TruthError(f"{path}: {error}") from error
    if not isinstance(values, dict):
        raise TruthError(f"{path}: must hold one JSON object")
    try:
        return parse_truth(values)
    except TruthError as error:
        raise TruthError(f"{path}: {error}") from None


def _size(found: _TruthFile) -> tuple[float, float] | None:
    if found.metres_per_pixel is None or found.size_px is None:
        return None
    columns, rows = found.size_px
    return columns * found.metres_per_pixel, rows * found.metres_per_pixel


def _state(text: str) -> StallState | None:
    return {"free": StallState.FREE, "taken": StallState.TAKEN}.get(text)
