"""Surveys as text: the table (CSV) and GeoJSON of `hawk.results.stall_files`, with the ground of the lot."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import shapely

from hawk.exports.shapes import lot_shape
from hawk.exports.values import ExportRecord, Observation
from hawk.lots.survey.source import SurveyKind
from hawk.lots.values import utc
from hawk.results.stall_files import CSV_COLUMNS, DEGREES, Ring, stalls_csv, stalls_geojson, table_csv


def survey_csv(survey: ExportRecord) -> bytes:
    """Return the table of stalls (RFC 4180, UTF-8), a line each."""
    return stalls_csv(map(_values, survey.stalls), about_survey(survey))


def survey_geojson(survey: ExportRecord) -> bytes:
    """Return lot and stalls as a FeatureCollection (RFC 7946) with OpenStreetMap's tags; the survey is under "hawk"."""
    rings = map(_ring, survey.stalls)
    return stalls_geojson(map(_values, survey.stalls), rings, about_survey(survey), _lot(survey))


def survey_map(survey: ExportRecord) -> dict[str, Any]:
    """Return the stalls of a survey, a list for each value, as `hawk.web.v1.features.answers.SurveyMap` says."""
    stalls = survey.stalls
    latitude, longitude = stalls[0].corners[0] if stalls else (0.0, 0.0)
    scale, origin = 10**DEGREES, (round(longitude, DEGREES), round(latitude, DEGREES))
    places = np.array([stall.corners for stall in stalls], dtype=np.float64).reshape(-1, 2)[:, ::-1]
    return {
        "origin": origin,
        "ids": [stall.id for stall in stalls],
        "labels": [stall.label for stall in stalls],
        "states": [stall.state for stall in stalls],
        "taken": [None if stall.taken_probability is None else round(stall.taken_probability, 3) for stall in stalls],
        "corners": np.rint((places - origin) * scale).astype(np.int64).ravel().tolist(),
    }


def surveys_csv(surveys: Sequence[ExportRecord]) -> bytes:
    """Return the table of stalls of several lots, a line each, as `survey_csv` has one."""
    return table_csv(CSV_COLUMNS, ({**about, **_values(stall)} for about, stall in _of_each(surveys)))


def surveys_geojson(whole: ExportRecord, surveys: Sequence[ExportRecord]) -> bytes:
    """Return the stalls of several lots as a FeatureCollection, each with its lot; ``whole`` is under "hawk"."""
    named = ("lot_id", "lot_name")
    stalls = [{**_values(stall), **{name: about[name] for name in named}} for about, stall in _of_each(surveys)]
    rings = [_ring(stall) for survey in surveys for stall in survey.stalls]
    return stalls_geojson(stalls, rings, about_survey(whole))


def _of_each(surveys: Sequence[ExportRecord]) -> Iterator[tuple[dict[str, Any], Observation]]:
    for survey in surveys:
        about = about_survey(survey)
        yield from ((about, stall) for stall in survey.stalls)


def about_survey(survey: ExportRecord) -> dict[str, Any]:
    """Return what a reader must know of a survey, by the names of the table's columns; None: not known."""
    pictures = survey.pictures
    return {
        "lot_name": survey.lot,
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


def _values(stall: Observation) -> dict[str, Any]:
    latitude, longitude = stall.place
    return {
        "stall_id": stall.id,
        "label": stall.label,
        "kind": stall.kind or "normal",
        "state": stall.state,
        "taken_probability": stall.taken_probability,
        "score": stall.score,
        "observed_utc": None if stall.looked_at is None else utc(stall.looked_at),
        "picture_count": stall.picture_count,
        "latitude": latitude,
        "longitude": longitude,
        "width_m": stall.width,
        "length_m": stall.length,
        "direction_deg": stall.direction,
        "confirmed": stall.is_confirmed,
    }


def _ring(stall: Observation) -> Ring:
    """Return a stall's ring, closed, as `hawk.exports.shapes.stall_shape` has it: a thousand are listed at once."""
    corners = (*stall.corners, stall.corners[0])
    return [(round(longitude, DEGREES), round(latitude, DEGREES)) for latitude, longitude in corners]


def _lot(survey: ExportRecord) -> dict[str, Any]:
    kinds = sorted({stall.kind for stall in survey.stalls if stall.kind})
    capacity = {f"capacity:{kind}": sum(stall.kind == kind for stall in survey.stalls) for kind in kinds}
    ground = shapely.transform(lot_shape(survey.outline), lambda places: np.round(places, DEGREES))
    return {
        "type": "Feature",
        "id": survey.lot_id,
        "geometry": dict(shapely.geometry.mapping(ground)),
        "properties": {"amenity": "parking", "name": survey.lot, "capacity": len(survey.stalls), **capacity},
    }
