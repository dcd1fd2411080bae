"""Files of a survey of several lots: a row, a shape and a picture a lot, and the stalls of all with their lot."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
import shapely

from hawk.exports.geopackage import surveys_gpkg
from hawk.exports.ground import lot_picture
from hawk.exports.kmz import survey_kmz
from hawk.exports.shapes import lot_shape
from hawk.exports.text_files import surveys_csv, surveys_geojson
from hawk.picture.files import IN_SYSTEM, LOTS, stalls_in_system, write_contents
from hawk.picture.lot_report import LotCount, lots_report
from hawk.picture.lots_picture import lots_picture
from hawk.picture.orthophoto.lots import without_pictures
from hawk.picture.values import LotSurvey, LotSurveys, PictureError, PictureSurvey, cannot_write
from hawk.picture.work_folder import REPORT
from hawk.results.stall_files import DEGREES, table_csv
from hawk.runtime.files import replace_whole

LOT_COLUMNS: Final = (
    "lot_id", "lot_name", "stalls", "free", "taken", "unknown", "free_least", "free_most", "vehicles", "vehicles_least",
    "vehicles_most", "capacity", "occupancy", "area_seen_m2", "unseen_share", "unsure", "doubts", "tags",
    "latitude", "longitude", "survey_id", "picture", "stored",
)  # fmt: skip
"""Columns of ``lots.csv``."""
_NO_NAME: Final = re.compile(r"[^\w.-]+", re.ASCII)
_LONGEST: Final = 60
Keep = Callable[[LotSurvey], tuple[LotSurvey, str]]
"""Stores the survey of a lot; returns it as its files say it, and how the store has it."""


def count_lots(lots: LotSurveys, folder: Path, keep: Keep | None) -> list[LotCount]:
    """Make the surveys of lots one after the other: write their pictures, store them; return what stays of them.

    Raises PictureError where a picture cannot be written, and as ``keep`` does.
    """
    counts: list[LotCount] = []
    used: set[str] = set()
    try:
        (folder / LOTS).mkdir(parents=True, exist_ok=True)
        for survey in lots:
            kept, stored = (survey, "") if keep is None else keep(survey)
            name = ""
            if survey.mapped.ground is not None:
                name = _file_name(kept.facts.id, used)
                picture = lot_picture(kept.mapped.survey, survey.mapped.ground)
                replace_whole(folder / LOTS / name, cv2.imencode(".png", picture)[1].tobytes())
            counts.append(LotCount.of(without_pictures(kept), name and f"{LOTS}/{name}", stored))
        for path in (folder / LOTS).glob("*.png"):  # of other outlines by the same folder
            if path.name.casefold() not in used:
                path.unlink()
    except OSError as error:
        raise PictureError(f"--out: {cannot_write(Path(error.filename or folder), error)}") from error
    return counts


def _file_name(lot: str, used: set[str]) -> str:
    """Return the name of a lot's picture, which no other one has on any disk, and note it."""
    plain = _NO_NAME.sub("-", lot)[:_LONGEST].strip(".-")
    name = f"{plain}.png"
    if not plain or name.casefold() in used:
        name = f"{plain}-{hashlib.sha256(lot.encode()).hexdigest()[:8]}.png".lstrip("-")
    used.add(name.casefold())
    return name


def write_lots(whole: PictureSurvey, counts: Sequence[LotCount], folder: Path, program: str) -> tuple[Path, ...]:
    """Write the files of all lots but their pictures; return their paths.

    Args:
        whole: The survey of all.
        counts: The lots.
        folder: It is made where it is not there.
        program: Name of the program with its version.

    Raises:
        PictureError: A file cannot be written.
    """
    records = [each.survey.mapped.survey for each in counts]
    every = replace(whole, survey=replace(whole.survey, stalls=tuple(s for each in records for s in each.stalls)))
    contents = {
        "lots.csv": lots_csv(counts),
        "lots.geojson": lots_geojson(counts),
        "stalls.csv": surveys_csv(records),
        "stalls.geojson": surveys_geojson(whole.survey, records),
        "survey.gpkg": surveys_gpkg(records),
        "survey.kmz": survey_kmz(every.survey),
        "lots.png": cv2.imencode(".png", lots_picture(whole.survey, counts))[1].tobytes(),
        REPORT: json.dumps(lots_report(whole, counts, program), indent=1, ensure_ascii=False).encode(),
    }
    if whole.crs:
        contents[IN_SYSTEM] = stalls_in_system(every)
    return write_contents(contents, folder)


def lots_csv(counts: Sequence[LotCount]) -> bytes:
    """Return the table of lots, a line each."""
    return table_csv(LOT_COLUMNS, map(_cells, counts))


def _cells(count: LotCount) -> dict[str, Any]:
    values = count.values()
    tags = "; ".join(f"{key}={value}" for key, value in values["tags"].items())
    return {**values, "doubts": " ".join(values["doubts"]), "tags": tags}


def lots_geojson(counts: Sequence[LotCount]) -> bytes:
    """Return the outlines of lots with their counts as a FeatureCollection (RFC 7946)."""
    features = [
        {
            "type": "Feature",
            "id": each.facts.id,
            "geometry": _geometry(each),
            "properties": {"amenity": "parking", "name": each.facts.name, **each.values()},
        }
        for each in counts
    ]
    return json.dumps({"type": "FeatureCollection", "features": features}, ensure_ascii=False).encode()


def _geometry(count: LotCount) -> dict[str, Any]:
    shape = lot_shape(count.survey.mapped.survey.outline)
    return dict(shapely.geometry.mapping(shapely.transform(shape, lambda at: np.round(at, DEGREES))))
