"""Stalls as files: the one table (CSV) and the one GeoJSON, of the live map and of a survey of the store.

What is not known of a map in flight is empty in the table and null in GeoJSON, so that tables of both can be joined.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final
from unicodedata import category, normalize

import cv2
import numpy as np

from hawk.model.lot_map import Stall
from hawk.results.label_parts import reading_order
from hawk.results.map_picture import map_picture
from hawk.results.row_labels import row_labels
from hawk.results.survey_map import Made, SurveyMap, to_global

STALL_COLUMNS: Final = (
    "stall_id", "label", "kind", "state", "taken_probability", "score", "observed_utc", "picture_count", "latitude",
    "longitude", "width_m", "length_m", "direction_deg", "confirmed",
)  # fmt: skip
"""Columns of a stall. ``score``: probability of being a stall at all; ``picture_count``: pictures that showed it."""
SURVEY_COLUMNS: Final = (
    "lot_name", "lot_id", "survey_id", "survey_began_utc", "survey_ended_utc", "time_is_sure", "registered",
    "position_uncertainty_m", "stalls_blurred", "simulated", "software", "survey_kind", "survey_source",
    "survey_limits", "made_utc",
)  # fmt: skip
"""Columns of the survey, the same in every line. ``made_utc``: when the file of a live map was made."""
CSV_COLUMNS: Final = (*STALL_COLUMNS, *SURVEY_COLUMNS)
DEGREES: Final = 8
"""Decimals: a millimetre."""
_DECIMALS: Final = {
    "taken_probability": 3, "score": 3, "latitude": DEGREES, "longitude": DEGREES, "width_m": 2, "length_m": 2,
    "direction_deg": 1,
}  # fmt: skip
_OSM: Final = {"kind": "parking_space", "label": "ref"}
"""Columns that OpenStreetMap has a key for (https://wiki.openstreetmap.org/wiki/Tag:amenity=parking_space)."""
_LOT: Final = ("lot_id", "lot_name")
"""Columns of the survey that a stall says by itself where a file has several lots."""
_GEOMETRY: Final = ("stall_id", "latitude", "longitude")
_FORMULA: Final = ("=", "+", "-", "@", "\t", "\r", "\n")
"""A spreadsheet reads a text that begins so as a formula (OWASP, CSV injection)."""
_UNSEEN: Final = ("Cc", "Cf", "Zs")
"""Categories of characters that are not seen: some spreadsheets leave them out."""

Values = Mapping[str, Any]
Ring = Sequence[tuple[float, float]]
"""Corners of a stall as (longitude, latitude), counter-clockwise, closed (RFC 7946)."""


def stalls_csv(stalls: Iterable[Values], survey: Values) -> bytes:
    """Return a table (RFC 4180, UTF-8), a line a stall. ``stalls`` and ``survey`` are values by column."""
    of_survey = {name: survey[name] for name in SURVEY_COLUMNS if name in survey}
    return table_csv(CSV_COLUMNS, ({**stall, **of_survey} for stall in stalls))


def table_csv(columns: Sequence[str], rows: Iterable[Values]) -> bytes:
    """Return a table (RFC 4180, UTF-8) of rows by column; what a row does not say is empty, what is no column is not
    written.
    """
    out = io.StringIO()
    writer = csv.DictWriter(out, columns, restval="", extrasaction="ignore", lineterminator="\r\n")
    writer.writeheader()
    writer.writerows({name: _cell(name, value) for name, value in row.items()} for row in rows)
    return out.getvalue().encode()


def stalls_geojson(
    stalls: Iterable[Values], rings: Iterable[Ring], survey: Values, lot: Mapping[str, Any] | None = None
) -> bytes:
    """Return a FeatureCollection (RFC 7946) with OpenStreetMap's keys; the survey is its member "hawk".

    ``lot``: a feature that stands before the stalls. A stall may name its lot, where there are several.
    """
    features = [] if lot is None else [lot]
    features += [_feature(stall, ring) for stall, ring in zip(stalls, rings, strict=True)]
    collection = {"type": "FeatureCollection", "hawk": survey, "features": features}
    return json.dumps(collection, allow_nan=False, ensure_ascii=False).encode()


def table_text(text: str) -> str:
    """Return a text as the cell of a table that no spreadsheet takes for a formula: names are people's own."""
    first = next((each for each in text if category(each) not in _UNSEEN), "")
    plain = normalize("NFKC", first).replace("\N{MINUS SIGN}", "-")  # a full-width sign is a sign to some
    return f"'{text}" if text.startswith(_FORMULA) or plain.startswith(_FORMULA) else text


def _cell(name: str, value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return table_text(value)
    if isinstance(value, float) and name in _DECIMALS:
        return f"{value:.{_DECIMALS[name]}f}"
    return "" if value is None else str(value)


def _feature(stall: Values, ring: Ring) -> dict[str, Any]:
    properties: dict[str, Any] = {"amenity": "parking_space"}
    for name in (*STALL_COLUMNS, *(name for name in _LOT if name in stall)):
        if name not in _GEOMETRY:
            value = stall.get(name)
            if isinstance(value, float) and name in _DECIMALS:
                value = round(value, _DECIMALS[name])
            properties[_OSM.get(name, name)] = value
    geometry = {"type": "Polygon", "coordinates": [ring]}
    return {"type": "Feature", "id": stall["stall_id"], "geometry": geometry, "properties": properties}


# -- the live map -----------------------------------------------------------------------------------------------------


def map_csv(survey: SurveyMap, made: Made) -> bytes:
    """Return the table of a live map's stalls, in the order of their labels."""
    return stalls_csv([values for _, values in _listed(survey)], made.values())


def map_geojson(survey: SurveyMap, made: Made) -> bytes:
    """Return the stalls of a live map as GeoJSON, in the order of their labels."""
    listed = _listed(survey)
    corners = [stall.corners()[[0, 1, 2, 3, 0]] for stall, _ in listed]
    places = to_global(survey.datum, np.concatenate([np.empty((0, 2)), *corners])).reshape(-1, 5, 2)
    rings = np.round(places[..., ::-1], DEGREES).tolist()
    return stalls_geojson([values for _, values in listed], rings, made.values())


def write_map(folder: Path, survey: SurveyMap, made: Made) -> None:
    """Write ``stalls.csv``, ``stalls.geojson`` and ``map.png`` of a live map. Raises OSError."""
    picture = cv2.imencode(".png", map_picture(survey))[1].tobytes()
    for name, data in (
        ("stalls.csv", map_csv(survey, made)), ("stalls.geojson", map_geojson(survey, made)), ("map.png", picture),
    ):  # fmt: skip
        (folder / name).write_bytes(data)


def _listed(survey: SurveyMap) -> list[tuple[Stall, Values]]:
    """Return the stalls of a map with their columns, in the order of their labels, those without one behind.

    On a known lot they have the labels of its plan, else those of rows.

    A stall that the plan has not gets a label when it is taken over.
    """
    labels = {key: stall.label for key, stall in survey.stalls.items() if stall.label} or row_labels(survey.stalls)
    order = sorted(survey.stalls, key=lambda key: (key not in labels, reading_order(labels.get(key, "")), key))
    ordered = [survey.stalls[key] for key in order]
    places = to_global(survey.datum, np.array([(stall.north, stall.east) for stall in ordered]).reshape(-1, 2))
    return [
        (stall, _stall_values(stall, labels.get(stall.id, ""), *place))
        for stall, place in zip(ordered, places.tolist(), strict=True)
    ]


def _stall_values(stall: Stall, label: str, latitude: float, longitude: float) -> Values:
    return {
        "stall_id": str(stall.id),
        "label": label,
        "state": stall.state.value,
        "taken_probability": float(stall.taken),
        "score": float(stall.score),
        "picture_count": stall.seen,
        "latitude": latitude,
        "longitude": longitude,
        "width_m": float(stall.width),
        "length_m": float(stall.length),
        "direction_deg": math.degrees(stall.angle),
        "confirmed": bool(stall.known),
    }
