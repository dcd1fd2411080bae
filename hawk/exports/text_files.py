"""Surveys as text: a table (CSV) and GeoJSON with OpenStreetMap's keys."""

from __future__ import annotations

import csv
import io
import json
from typing import Any, Final

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from hawk.exports.shapes import lot_shape
from hawk.exports.values import ExportRecord, Observation
from hawk.lots.survey.source import SurveyKind
from hawk.lots.text import table_text
from hawk.lots.values import utc

CSV_COLUMNS: Final[tuple[str, ...]] = (
    "stall_id", "label", "kind", "state", "taken_probability", "looked_utc", "looks", "latitude", "longitude",
    "width_m", "length_m", "direction_deg", "confirmed", "lot", "lot_id", "survey_id", "survey_began_utc",
    "survey_ended_utc", "time_is_sure", "registered", "position_uncertainty_m", "stalls_blurred", "simulated",
    "software",
    "survey_kind", "survey_source", "survey_limits",
)  # fmt: skip
"""Columns of the table; those of the survey are the same in every line, so that tables can be joined."""
_DEGREES: Final = 8
"""Decimals: a millimetre."""


def survey_csv(survey: ExportRecord) -> bytes:
    """Return the table of stalls (RFC 4180, UTF-8), a line each."""
    out = io.StringIO()
    writer = csv.DictWriter(out, CSV_COLUMNS, lineterminator="\r\n")
    writer.writeheader()
    about = about_survey(survey)
    of_survey = {name: _text(value) for name, value in about.items() if name in CSV_COLUMNS}
    for stall in survey.stalls:
        line: dict[str, str] = {**_line(stall), **of_survey}
        writer.writerow(line)
    return out.getvalue().encode()


def survey_geojson(survey: ExportRecord) -> bytes:
    """Return lot and stalls as a FeatureCollection (RFC 7946) with OpenStreetMap's tags; the survey is under "hawk"."""
    features = [_lot(survey), *(_stall(stall) for stall in survey.stalls)]
    collection = {"type": "FeatureCollection", "hawk": about_survey(survey), "features": features}
    return json.dumps(collection, allow_nan=False, ensure_ascii=False).encode()


def about_survey(survey: ExportRecord) -> dict[str, Any]:
    """Return what a reader must know of a survey, by the names of the table's columns; None: not known."""
    pictures = survey.pictures
    return {
        "lot": survey.lot,
        "lot_id": survey.lot_id,
        "survey_id": survey.survey,
        "survey_began_utc": utc(survey.began),
        "survey_ended_utc": utc(survey.ended),
        "time_is_sure": survey.time_is_sure,
        "registered": not survey.doubt,
        "doubt": survey.doubt,
        "layout_version": survey.layout,
        "position_uncertainty_m": None if survey.accuracy is None else round(survey.accuracy, 2),
        "position_pinned": survey.is_pinned,
        "simulated": survey.is_simulated,
        "software": survey.software,
        "survey_kind": (SurveyKind.FLOWN if pictures is None else SurveyKind.PICTURE).value,
        "survey_source": "" if pictures is None else pictures.words,
        "survey_limits": "" if pictures is None else pictures.warning,
        "stalls": len(survey.stalls),
        "free": survey.count("free"),
        "taken": survey.count("taken"),
        "unknown": survey.count("unknown"),
        "stalls_blurred": survey.blurred,
    }


def _text(value: object) -> str:
    """Return a value as a table's text: "" for None, no formula of a spreadsheet."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return table_text(value)
    return "" if value is None else str(value)


def _line(stall: Observation) -> dict[str, str]:
    latitude, longitude = stall.place
    return {
        "stall_id": stall.id,
        "label": _text(stall.label),
        "kind": stall.kind or "normal",
        "state": stall.state,
        "taken_probability": "" if stall.taken is None else f"{stall.taken:.3f}",
        "looked_utc": "" if stall.looked is None else utc(stall.looked),
        "looks": str(stall.seen),
        "latitude": f"{latitude:.{_DEGREES}f}",
        "longitude": f"{longitude:.{_DEGREES}f}",
        "width_m": f"{stall.width:.2f}",
        "length_m": f"{stall.length:.2f}",
        "direction_deg": f"{stall.direction:.1f}",
        "confirmed": _text(stall.is_confirmed),
    }


def _lot(survey: ExportRecord) -> dict[str, Any]:
    kinds = sorted({stall.kind for stall in survey.stalls if stall.kind})
    capacity = {f"capacity:{kind}": sum(stall.kind == kind for stall in survey.stalls) for kind in kinds}
    return {
        "type": "Feature",
        "id": survey.lot_id,
        "geometry": _geometry(lot_shape(survey.outline)),
        "properties": {"amenity": "parking", "name": survey.lot, "capacity": len(survey.stalls), **capacity},
    }


def _stall(stall: Observation) -> dict[str, Any]:
    return {
        "type": "Feature",
        "id": stall.id,
        "geometry": {"type": "Polygon", "coordinates": [_ring(stall)]},
        "properties": {
            "amenity": "parking_space",
            "parking_space": stall.kind or "normal",
            "ref": stall.label,
            "state": stall.state,
            "taken_probability": None if stall.taken is None else round(stall.taken, 3),
            "looked_utc": None if stall.looked is None else utc(stall.looked),
            "looks": stall.seen,
            "width_m": round(stall.width, 2),
            "length_m": round(stall.length, 2),
            "direction_deg": round(stall.direction, 1),
            "confirmed": stall.is_confirmed,
        },
    }


def _ring(stall: Observation) -> list[tuple[float, float]]:
    """Return a stall's ring, closed, as `hawk.exports.shapes.stall_shape` has it: a thousand are listed at once."""
    corners = (*stall.corners, stall.corners[0])
    return [(round(longitude, _DEGREES), round(latitude, _DEGREES)) for latitude, longitude in corners]


def _geometry(shape: BaseGeometry) -> dict[str, Any]:
    rounded = shapely.transform(shape, lambda places: np.round(places, _DEGREES))
    return dict(shapely.geometry.mapping(rounded))
