"""Sections of a lot without stalls whose outline, and number of places, a person gave in a file."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import shapely
from sqlalchemy import Connection, insert

from hawk.lots.plan.sections import axis_of
from hawk.lots.plan.steps import next_key, section_values
from hawk.lots.plan.values import LayoutSection
from hawk.lots.registration.georeference import about
from hawk.lots.storage.schema import SECTION
from hawk.lots.values import FinishedSurvey, new_id
from hawk.model.poses import Ring


def add_outline_sections(connection: Connection, lot: str, name: str, survey: FinishedSurvey) -> None:
    """Store the sections of a lot that a survey made, in its first layout."""
    first = next_key(connection, SECTION)
    for key, section in enumerate(outline_sections(survey, name), first):
        connection.execute(insert(SECTION).values(section_values(key, lot, section, 1, None)))


def outline_sections(survey: FinishedSurvey, name: str) -> tuple[LayoutSection, ...]:
    """Return a section for each part of a survey's outline, by their areas; none without a ``capacity``.

    ``name``: of the lot, and of its section; those of several parts have a number behind it. Each part has as many of
    the places as its area is of the whole. Holes count as ground.
    """
    if survey.capacity is None:
        return ()
    datum = (survey.datum.latitude, survey.datum.longitude)
    rings = [np.round(about(datum, np.array(ring, np.float64))[:, :2], 6).tolist() for ring in survey.outline.polygons]
    areas = sorted(((shapely.Polygon(ring).area, ring) for ring in rings), key=lambda each: -each[0])
    whole = sum(area for area, _ in areas)
    is_one = len(areas) == 1
    return tuple(
        _section(name if is_one else f"{name} {number}", ring, round(survey.capacity * area / whole), survey.capacity)
        for number, (area, ring) in enumerate(areas, 1)
    )


def _section(name: str, ring: Sequence[Sequence[float]], capacity: int, whole: int) -> LayoutSection:
    outline: Ring = tuple((north, east) for north, east in ring)
    note = "" if capacity == whole else f"{whole} places in all"
    length = round(math.dist(*axis_of(outline)), 2)
    return LayoutSection(new_id(), name, outline, "", length, capacity or None, capacity > 0, note)
