"""Surveys as Cloud Optimised GeoTIFF: the mosaic and the occupancy, with a STAC item that describes both.

They need rasterio, which the extra ``background`` brings. Their plane is the lot's own: an azimuthal equidistant
projection about its datum, so that a pixel is where the map has it, to the millimetre, and nothing is resampled.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

import numpy as np
import shapely
from numpy.typing import NDArray

from hawk.exports.ground import OCCUPANCY, Ground, occupancy, thinned
from hawk.exports.shapes import lot_shape
from hawk.exports.text_files import about_survey
from hawk.exports.values import ExportRecord
from hawk.formats import gdal
from hawk.lots.values import LotStoreError, utc
from hawk.runtime.programs import remedy

_COLOURS: Final = {0: (0, 0, 0, 0), 1: (47, 143, 255, 255), 2: (255, 122, 26, 255), 3: (22, 22, 28, 255)}
"""Colours of the occupancy, RGBA."""
_BLOCK: Final = 512
STAC_VERSION: Final = "1.0.0"


def write_rasters(survey: ExportRecord, ground: Ground, mosaic: Path) -> tuple[Path, ...]:
    """Write ``NAME.tif``, ``NAME-occupancy.tif`` and the STAC item ``NAME.json``; return their paths.

    Raises LotStoreError without rasterio, and OSError.
    """
    rasterio = _rasterio()
    states, item = mosaic.with_name(f"{mosaic.stem}-occupancy.tif"), mosaic.with_suffix(".json")
    shown = thinned(ground)
    colours = np.concatenate([np.moveaxis(shown.image[..., ::-1], -1, 0), ground.seen[None]])
    tags = {name.upper(): str(value) for name, value in about_survey(survey).items() if value is not None}
    profile = _profile(rasterio, survey, ground)
    _write(rasterio, mosaic, colours, profile, tags)
    _write(rasterio, states, occupancy(survey, ground)[None], {**profile, "nodata": 0}, tags)
    item.write_text(json.dumps(stac_item(survey, ground, mosaic.name, states.name), indent=1), encoding="utf-8")
    return mosaic, states, item


def _rasterio() -> Any:
    try:
        return gdal.rasterio()  # only this export needs it
    except ImportError as error:
        words = f"rasterio is not installed, which writes GeoTIFF files: {remedy('background')}"
        raise LotStoreError(words) from error


def plane_of(survey: ExportRecord) -> str:
    """Return the plane of a survey's rasters as PROJ writes it."""
    latitude, longitude = survey.origin
    return f"+proj=aeqd +lat_0={latitude:.9f} +lon_0={longitude:.9f} +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs"


def _profile(rasterio: Any, survey: ExportRecord, ground: Ground) -> dict[str, Any]:
    return {
        "driver": "COG",
        "dtype": "uint8",
        "crs": rasterio.crs.CRS.from_proj4(plane_of(survey)),
        "transform": rasterio.transform.from_origin(ground.east, ground.north, ground.metres, ground.metres),
        "compress": "DEFLATE",
        "predictor": "YES",
        "blocksize": _BLOCK,
    }


def _write(rasterio: Any, path: Path, bands: NDArray[np.uint8], profile: dict[str, Any], tags: dict[str, str]) -> None:
    count, height, width = bands.shape
    colours = rasterio.enums.ColorInterp
    resampling = "AVERAGE" if count > 1 else "NEAREST"
    options = {**profile, "overview_resampling": resampling, "count": count, "height": height, "width": width}
    with rasterio.open(path, "w", **options) as file:
        file.write(bands)
        file.update_tags(**tags)
        if count > 1:
            file.colorinterp = (colours.red, colours.green, colours.blue, colours.alpha)
        else:
            file.write_colormap(1, _COLOURS)


def stac_item(survey: ExportRecord, ground: Ground, mosaic: str, states: str) -> dict[str, Any]:
    """Return the STAC item (with the extension "projection") of a survey's two rasters."""
    shape = lot_shape(survey.outline)
    if shape.is_empty:
        shape = shapely.MultiPoint([stall.place[::-1] for stall in survey.stalls]).convex_hull
    rows, columns = ground.seen.shape
    transform = [ground.metres, 0.0, ground.east, 0.0, -ground.metres, ground.north]
    plane = {"proj:epsg": None, "proj:shape": [rows, columns], "proj:transform": transform}
    media = "image/tiff; application=geotiff; profile=cloud-optimized"
    return {
        "type": "Feature",
        "stac_version": STAC_VERSION,
        "stac_extensions": [
            "https://stac-extensions.github.io/projection/v1.1.0/schema.json",
            "https://stac-extensions.github.io/classification/v2.0.0/schema.json",
        ],
        "id": survey.survey,
        "geometry": shapely.geometry.mapping(shape),
        "bbox": list(shape.bounds),
        "properties": {
            "datetime": utc(survey.ended),
            "start_datetime": utc(survey.began),
            "end_datetime": utc(survey.ended),
            "gsd": round(ground.metres, 3),
            **plane,
            **{f"hawk:{name}": value for name, value in about_survey(survey).items()},
        },
        "links": [],
        "assets": {
            "mosaic": {"href": f"./{mosaic}", "type": media, "roles": ["data", "visual"], "title": "Mosaic"},
            "occupancy": {
                "href": f"./{states}", "type": media, "roles": ["data"], "title": "Free and taken stalls",
                "classification:classes": [{"value": value, "name": name} for name, value in OCCUPANCY.items()],
            },
        },
    }  # fmt: skip
