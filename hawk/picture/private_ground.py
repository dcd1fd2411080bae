"""Ground that nobody may look at, as far as it lies near a picture: none of it is passed over."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon
from shapely.affinity import translate

from hawk.lots.survey.private_ground import ERROR_M
from hawk.picture.orthophoto.grid import PixelGrid
from hawk.picture.orthophoto.outline_lots import polygons_of
from hawk.picture.orthophoto.source import Orthophoto, PixelRing
from hawk.picture.photographs.places import unwrap_longitudes
from hawk.picture.values import PictureError, Shot

_DEGREE_M: Final = 111_195.0
"""Metres of a degree of latitude on a sphere of 6,371 km."""
_NARROW_DEG: Final = 1.0
"""Wider ground over ±180° is no lot and no garden: it is what its corners say."""
_SIDE: Final = 9
"""Places along a side of a picture by which its bounds on Earth are known."""
_SHOT_REACH_M: Final = 1_000.0
"""Ground farther from a drone, which flies at 500 m at most, is in no shot that looks down."""
_MARGIN: Final = 0.2
"""Share of a picture's extent by which its surroundings go beyond it: sides between those places may be bent."""


def wider(area: Polygon) -> Polygon:
    """Return an area of a plan, (longitude, latitude), wider by the error of the receiver that placed its lot."""
    scale = np.array([np.cos(np.radians(area.centroid.y)), 1.0])
    flat = shapely.transform(continuous(area), lambda places: places * scale)
    return shapely.transform(flat.buffer(ERROR_M / _DEGREE_M, join_style="mitre"), lambda places: places / scale)


def continuous(area: Polygon) -> Polygon:
    """Return the ground within an area, holes too; narrow ground over ±180° goes on beyond it, not round the Earth."""
    places = np.array(area.exterior.coords)[:, :2]
    steps = np.diff(places[:, 0])
    turns = np.where((np.abs(steps) > 180) & (np.abs(steps) < 360), -np.sign(steps), 0).cumsum()
    beyond = places[:, 0] + 360 * np.concatenate([[0], turns])
    if np.ptp(beyond) < _NARROW_DEG:
        places[:, 0] = beyond
    return Polygon(places)


def parts_near(area: Polygon, near: Polygon) -> Iterator[Polygon]:
    """Yield the parts of an area within another one, (longitude, latitude), on whatever side of ±180° this lies."""
    whole = shapely.make_valid(continuous(area))
    for turn in (-360.0, 0.0, 360.0):
        yield from polygons_of(translate(whole, turn).intersection(near))


def rings_in(grid: PixelGrid, areas: Sequence[Polygon]) -> tuple[PixelRing, ...]:
    """Return what areas have near a picture in its pixels. Raises PictureError for one that its system cannot have."""
    near, rings = _surroundings(grid), []
    middle, reach = np.array([grid.columns, grid.rows]) / 2, 2 * (grid.columns + grid.rows)
    for number, area in enumerate(areas, 1):
        for part in parts_near(area, near):
            ring = grid.in_picture(np.array(part.exterior.coords)[:, 1::-1])
            if not (np.abs(ring - middle) < reach).all():  # infinite, or beyond the seam of the system
                raise PictureError(
                    f"private area {number} has no place in the picture's system of coordinates, so that the picture "
                    "would show it; store the picture in the UTM zone of its place: gdalwarp -t_srs EPSG:32631"
                )
            rings.append(tuple((float(x), float(y)) for x, y in ring))
    return tuple(rings)


def touches(picture: Orthophoto, area: Polygon) -> bool:
    """Return whether an area lies in a picture. Raises PictureError as `rings_in`."""
    own = replace(picture, private=rings_in(picture.grid, [area]))
    return bool(own.private_in((0, 0, picture.grid.columns, picture.grid.rows)))


def near_shots(areas: Iterable[Polygon], shots: Sequence[Shot]) -> Iterator[Polygon]:
    """Yield the areas that shots may show."""
    if not shots:
        return
    longitudes = unwrap_longitudes(np.array([shot.longitude for shot in shots]))
    places = np.column_stack([longitudes, [shot.latitude for shot in shots]])
    reach = _SHOT_REACH_M / _DEGREE_M / np.array([np.cos(np.radians(places[:, 1].mean())), 1.0])
    near = shapely.box(*(places.min(axis=0) - reach), *(places.max(axis=0) + reach))
    yield from (area for area in areas if any(parts_near(area, near)))


def _surroundings(grid: PixelGrid) -> Polygon:
    """Return the ground about a picture, (longitude, latitude)."""
    along = np.linspace(0.0, 1.0, _SIDE)
    x, y = (side.reshape(-1) for side in np.meshgrid(along * grid.columns, along * grid.rows))
    places: NDArray[np.float64] = grid.on_earth(np.column_stack([x, y]))[:, ::-1]
    places = places[np.isfinite(places).all(axis=1)]
    places[:, 0] = unwrap_longitudes(places[:, 0])
    low, high = places.min(axis=0), places.max(axis=0)
    margin = _MARGIN * (high - low)
    return shapely.box(*(low - margin), *(high + margin))
