"""Pixels of an orthophoto on Earth.

Places in the picture are (column, row) of its corner-based pixel grid, seen as from above: the rows of a file that is
mirrored, as one whose first row is the south, are counted from its last row. A grid that is turned stays turned.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from hawk.picture.values import PictureError
from hawk.runtime.late import late

if TYPE_CHECKING:
    import pyproj
else:
    pyproj = late("pyproj")

FloatArray = NDArray[np.float64]
Box = tuple[int, int, int, int]
"""Left, top, right and bottom of a part of the picture, whole pixels."""
WGS_84: Final = "EPSG:4326"
_REACH: Final = 50.0
"""Pixels about a place over which the scale is measured."""
_DIGITS: Final = 5
"""Scales are rounded to .01 mm: the same ground in another CRS then gives the network the same picture."""
_SQUARE_DEG: Final = 2.0
"""Deviation from a right angle between columns and rows, on the ground, that is still read."""
_UNIT: Final = "{}: its grid is {:.1f}° off square on the ground; resample it: gdalwarp -t_srs EPSG:3857 {} square.tif"


@dataclass(frozen=True, slots=True)
class PixelGrid:
    """Georeference of a picture of ``columns`` by ``rows`` pixels.

    ``affine`` (a, b, c, d, e, f): x = a column + b row + c and y = d column + e row + f in the system ``crs``, which
    PROJ can read. ``metres``: of a pixel along a row and along a column, on the ellipsoid at the picture's middle.
    """

    columns: int
    rows: int
    crs: str = field(repr=False)
    affine: tuple[float, float, float, float, float, float]
    is_mirrored: bool = False
    metres: tuple[float, float] = (0.0, 0.0)

    def on_earth(self, places: FloatArray) -> FloatArray:
        """Return (latitude, longitude), degrees in WGS-84, of places (N, 2) of (column, row)."""
        a, b, c, d, e, f = self.affine
        column, row = places[:, 0], self._row_of_file(places[:, 1])
        x, y = a * column + b * row + c, d * column + e * row + f
        longitude, latitude = _transformer(self.crs).transform(x, y)
        return np.column_stack([latitude, longitude])

    def in_picture(self, places: FloatArray) -> FloatArray:
        """Return (column, row) of places (N, 2) of (latitude, longitude); infinite where the CRS does not have them."""
        a, b, c, d, e, f = self.affine
        x, y = _transformer(self.crs).transform(places[:, 1], places[:, 0], direction="INVERSE")
        x, y = np.asarray(x) - c, np.asarray(y) - f
        size = a * e - b * d
        return np.column_stack([(e * x - b * y) / size, self._row_of_file((a * y - d * x) / size)])

    def metres_at(self, column: float, row: float) -> tuple[float, float]:
        """Return the metres of a pixel along a row and along a column, on the ellipsoid about a place."""
        (across, _), (down, _) = self._axes(column, row)
        return round(float(across), _DIGITS), round(float(down), _DIGITS)

    def _axes(self, column: float, row: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return metres a pixel and azimuth (degrees) of the axis along a row and of that along a column."""
        reach_x, reach_y = min(_REACH, self.columns / 2), min(_REACH, self.rows / 2)
        ends = np.array([(-reach_x, 0), (reach_x, 0), (0, -reach_y), (0, reach_y)]) + np.array((column, row))
        at = self.on_earth(ends)
        turn, _, metres = pyproj.Geod(ellps="WGS84").inv(at[::2, 1], at[::2, 0], at[1::2, 1], at[1::2, 0])
        return (metres[0] / (2 * reach_x), turn[0]), (metres[1] / (2 * reach_y), turn[1])

    def _row_of_file(self, row: FloatArray) -> FloatArray:
        return self.rows - row if self.is_mirrored else row


def measure_grid(grid: PixelGrid, name: str) -> PixelGrid:
    """Return a grid with its scale and handedness by the ground.

    Args:
        grid: The grid as its file has it.
        name: Name of the file, for errors.

    Raises:
        PictureError: The grid is not on Earth, has no size, or is not square on the ground.
    """
    middle = (grid.columns / 2, grid.rows / 2)
    (across, turn_x), (down, turn_y) = grid._axes(*middle)
    if not np.isfinite([across, down, turn_x, turn_y]).all() or min(across, down) <= 0:
        raise PictureError(
            f"{name}: its coordinates are no place on Earth in its system; name the right one with --crs, as EPSG:25832"
        )
    off = (turn_y - turn_x + 180) % 360 - 180
    if abs(abs(off) - 90) > _SQUARE_DEG:
        raise PictureError(_UNIT.format(name, abs(abs(off) - 90), name))
    sized = replace(grid, is_mirrored=off < 0)
    return replace(sized, metres=sized.metres_at(*middle))


def system(text: str, name: str, option: str = "--crs") -> tuple[str, str]:
    """Return a system of coordinates as WKT, and its name: AUTHORITY:CODE where it has one, else WKT; "" for WGS-84.

    Args:
        text: Its name, WKT or PROJ string.
        name: Name of the file, for errors.
        option: The option that names another system, for errors.

    Raises:
        PictureError: PROJ does not know it, or it is on no place on Earth.
    """
    try:
        crs = pyproj.CRS.from_user_input(text)
        crs = (crs.sub_crs_list[0] if crs.is_compound else crs).to_2d()
        if crs.is_geocentric or not (crs.is_geographic or crs.is_projected):
            raise pyproj.exceptions.CRSError("it has no two coordinates on a map of the Earth")
    except pyproj.exceptions.CRSError as error:
        reason = str(error).splitlines()[0][:120]
        raise PictureError(
            f"{name}: its system of coordinates is not known ({reason}); name it with {option}, as EPSG:25832"
        ) from None
    authority = crs.to_authority(min_confidence=90)
    short = ":".join(authority) if authority else str(crs.to_wkt())
    return crs.to_wkt(), "" if short in (WGS_84, "OGC:CRS84") else short


@functools.lru_cache(maxsize=8)
def _transformer(crs: str) -> Any:
    return pyproj.Transformer.from_crs(pyproj.CRS.from_user_input(crs), WGS_84, always_xy=True)
