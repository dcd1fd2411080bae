"""Kinds of the files of a survey, by the ends of their names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

PICTURE: Final = ".png"
RASTER: Final = ".tif"
"""Mosaic and occupancy as Cloud Optimised GeoTIFF, with a STAC item: several files."""
ARCHIVE: Final = ".zip"
"""The files of `RASTER` in one."""
DATABASE: Final = ".gpkg"
"""It may hold many surveys."""
CONTENT_TYPES: Final[Mapping[str, str]] = {
    ".csv": "text/csv; charset=utf-8",
    ".geojson": "application/geo+json",
    DATABASE: "application/geopackage+sqlite3",
    ".kmz": "application/vnd.google-earth.kmz",
    PICTURE: "image/png",
    ARCHIVE: "application/zip",
}
"""Kinds that are one file each, with the type of their content."""
WRITTEN: Final = (*(each for each in CONTENT_TYPES if each != ARCHIVE), RASTER)
"""Kinds that the command writes."""
