"""Files of a survey by pictures: they appear whole, in a folder."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final

import cv2

from hawk.exports.geopackage import surveys_gpkg
from hawk.exports.ground import lot_picture
from hawk.exports.kmz import survey_kmz
from hawk.exports.text_files import survey_csv, survey_geojson
from hawk.picture.report import report
from hawk.picture.values import PictureError, PictureSurvey, cannot_write
from hawk.picture.work_folder import REPORT
from hawk.runtime.files import replace_whole
from hawk.runtime.late import late

if TYPE_CHECKING:
    import pyproj
else:
    pyproj = late("pyproj")  # of the extra that read the source

IN_SYSTEM: Final = "stalls-source-crs.geojson"
"""The stalls in the source's own system of coordinates, where that is not WGS-84."""

_PICTURE: Final = "lot.png"
LOTS: Final = "lots"
"""Folder of the pictures of several lots."""
_LOTS_TABLE: Final = "lots.csv"
_SOMETIMES: Final = frozenset({IN_SYSTEM, _PICTURE, _LOTS_TABLE, "lots.geojson", "lots.png"})


def write_files(mapped: PictureSurvey, folder: Path, program: str) -> tuple[Path, ...]:
    """Write the files of a survey; return their paths. A file that is there is replaced as a whole, or removed.

    Args:
        mapped: The survey.
        folder: It is made where it is not there.
        program: Name of the program with its version.

    Raises:
        PictureError: A file cannot be written.
    """
    contents: dict[str, bytes] = {
        "stalls.csv": survey_csv(mapped.survey),
        "stalls.geojson": survey_geojson(mapped.survey),
        "survey.gpkg": surveys_gpkg([mapped.survey]),
        "survey.kmz": survey_kmz(mapped.survey),
        REPORT: json.dumps(report(mapped, program), indent=1, ensure_ascii=False).encode(),
    }
    if mapped.crs:
        contents[IN_SYSTEM] = stalls_in_system(mapped)
    if mapped.ground is not None:
        contents[_PICTURE] = cv2.imencode(".png", lot_picture(mapped.survey, mapped.ground))[1].tobytes()
    return write_contents(contents, folder)


def write_contents(contents: Mapping[str, bytes], folder: Path) -> tuple[Path, ...]:
    """Write files by their names, and remove those that another survey by the same folder has left; return the paths.

    Raises PictureError.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        written = tuple(replace_whole(folder / name, data) for name, data in contents.items())
        for name in _SOMETIMES - contents.keys():
            (folder / name).unlink(missing_ok=True)
        if _LOTS_TABLE not in contents and (folder / LOTS).is_dir():
            for picture in (folder / LOTS).glob("*.png"):
                picture.unlink()
            with contextlib.suppress(OSError):  # a person's file is in it
                (folder / LOTS).rmdir()
        return written
    except OSError as error:
        raise PictureError(f"--out: {cannot_write(Path(error.filename or folder), error)}") from error


def stalls_in_system(mapped: PictureSurvey) -> bytes:
    """Return the stalls as GeoJSON in the source's system, with GeoJSON 2008's member ``crs``, which GDAL reads."""
    system = pyproj.CRS.from_user_input(mapped.crs)
    onto = pyproj.Transformer.from_crs("EPSG:4326", system, always_xy=True)
    authority = system.to_authority()
    named = f"urn:ogc:def:crs:{authority[0]}::{authority[1]}" if authority else system.to_wkt()
    decimals = 9 if system.is_geographic else 3
    features = []
    for stall in mapped.survey.stalls:
        ring = [onto.transform(longitude, latitude) for latitude, longitude in (*stall.corners, stall.corners[0])]
        features.append(
            {
                "type": "Feature",
                "id": stall.id,
                "geometry": {
                    "type": "Polygon",
                    "coordinates": [[[round(x, decimals), round(y, decimals)] for x, y in ring]],
                },
                "properties": {
                    "stall_id": stall.id,
                    "state": stall.state,
                    "taken_probability": stall.taken_probability,
                },
            }
        )
    system_member = {"type": "name", "properties": {"name": named}}
    return json.dumps({"type": "FeatureCollection", "crs": system_member, "features": features}).encode()
