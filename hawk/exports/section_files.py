"""Sections of a survey with their counts as files: one set of columns for CSV, GeoJSON and GeoPackage."""

from __future__ import annotations

import json
from typing import Any, Final

from hawk.exports.values import ExportRecord, SeenSection
from hawk.lots.values import utc
from hawk.results.stall_files import DEGREES, table_csv

COLUMNS: Final = {
    "section_id": "TEXT", "lot_id": "TEXT", "survey_id": "TEXT", "name": "TEXT", "kind": "TEXT", "note": "TEXT",
    "length_m": "REAL", "capacity": "INTEGER", "capacity_given": "BOOLEAN", "source": "TEXT", "parked": "INTEGER",
    "least": "INTEGER", "most": "INTEGER", "occupancy": "REAL", "room": "INTEGER", "hidden_share": "REAL",
    "seen_share": "REAL", "observed": "DATETIME",
}  # fmt: skip
"""Columns with their types in a GeoPackage."""


def section_values(survey: ExportRecord, seen: SeenSection) -> dict[str, Any]:
    """Return a section with a survey's look by the columns; None: not known."""
    section, look = seen.section, seen.look
    return {
        "section_id": section.id, "lot_id": survey.lot_id, "survey_id": survey.survey, "name": section.name,
        "kind": section.kind, "note": section.note, "length_m": section.length_m, "capacity": section.capacity,
        "capacity_given": section.is_capacity_given, "source": look.source, "parked": look.parked, "least": look.least,
        "most": look.most, "occupancy": look.occupancy, "room": look.room, "hidden_share": look.hidden_share,
        "seen_share": look.seen_share, "observed": utc(look.observed.timestamp()),
    }  # fmt: skip


def sections_csv(survey: ExportRecord) -> bytes:
    """Return the table of sections that a survey looked at (RFC 4180, UTF-8), a line each."""
    return table_csv([*COLUMNS], (section_values(survey, each) for each in survey.sections))


def sections_geojson(survey: ExportRecord) -> bytes:
    """Return the sections that a survey looked at as a FeatureCollection (RFC 7946)."""
    features = [
        {"type": "Feature", "id": each.section.id, "geometry": geometry_of(each),
         "properties": section_values(survey, each)}
        for each in survey.sections
    ]  # fmt: skip
    return json.dumps({"type": "FeatureCollection", "features": features}, allow_nan=False).encode()


def geometry_of(seen: SeenSection) -> dict[str, Any]:
    """Return the ground of a section as GeoJSON; rings run counter-clockwise."""
    ring = [[round(longitude, DEGREES), round(latitude, DEGREES)] for latitude, longitude in seen.ring]
    if _area(ring) < 0:
        ring.reverse()
    return {"type": "Polygon", "coordinates": [[*ring, ring[0]]]}


def _area(ring: list[list[float]]) -> float:
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(ring, [*ring[1:], ring[0]], strict=True))
