"""Sections of a drawing as rings in metres: areas as they are drawn, lines as the strip beside them.

Sections that cannot be drawn are left out by name.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
import shapely

from hawk.formats.area_file import open_ring
from hawk.lots.plan import geometry
from hawk.lots.plan.operations import FARTHEST_M
from hawk.lots.plan.sections import axis_of, length_of, strip
from hawk.lots.plan_files.values import DrawnSection, FileSection, Floats, Notes, Strip
from hawk.model.poses import Ring
from hawk.model.sentences import words_of

MOST_CORNERS: Final = 1_000
"""Corners of one section."""
_SAME_M: Final = 1e-3
"""Metres within which two corners are one, as for stalls."""


def sections_of(
    drawn: Sequence[DrawnSection], courses: Sequence[Floats], stalls: Floats, notes: Notes
) -> tuple[FileSection, ...]:
    """Return the sections of a drawing.

    ``courses``: their rings and lines (N, 2), north and east, metres; ``stalls`` (S, 2): middles of the stalls of the
    same file. A car park with stalls is no section: they are counted.
    """
    found = []
    ids: set[str] = set()
    for each, course in zip(drawn, courses, strict=True):
        places = open_ring(course.tolist(), _SAME_M) if each.facts.strip is None else _line(course)
        try:
            ring, length = _ring(places, each.facts.strip)
        except geometry.ShapeError as error:
            notes.add(each.name, f"{error.field}: {words_of(error)}")
            continue
        if each.facts.is_lot and any(geometry.within(ring, stalls)):
            notes.add(each.name, "amenity: is a car park with stalls in this file, which are counted instead")
        elif each.facts.id and each.facts.id in ids:
            notes.add(each.name, f"id: {each.facts.id[:40]} is there twice: the first one is read")
        else:
            ids.add(each.facts.id)
            length = round(each.facts.metres or length, 2)
            found.append(FileSection(each.name, ring, length, replace(each.facts, strip=None)))
    return tuple(found)


def _ring(places: Sequence[geometry.Point], beside: Strip | None) -> tuple[Ring, float]:
    """Return the ring of a section, and its length along the kerb, metres. Raises ShapeError."""
    if len(places) > MOST_CORNERS:
        raise geometry.ShapeError("geometry", f"has {len(places)} corners, {MOST_CORNERS} are the most: simplify it")
    if np.abs(np.array(places)).max(initial=0.0) > FARTHEST_M:
        raise geometry.ShapeError("geometry", "is more than 20 km from the others: import each lot by itself")
    if beside is not None and len(places) < 2:
        raise geometry.ShapeError("geometry", "has no length: draw the line along the kerb")
    if beside is not None:
        return strip(_shifted(places, beside), beside.width, beside.side), length_of(places)
    if len(places) < 3:
        raise geometry.ShapeError("geometry", f"has {len(places)} corners: draw the outline of the section")
    ring = tuple((north, east) for north, east in geometry.checked_ring(list(places)))
    return ring, math.dist(*axis_of(ring))


def _shifted(line: Sequence[geometry.Point], beside: Strip) -> Sequence[geometry.Point]:
    """Return the near edge of a strip, whose line runs in the middle of the road. Raises ShapeError."""
    course = shapely.LineString([(east, north) for north, east in line])
    if not beside.near or not course.length:
        return line
    off = beside.near if beside.side == "left" else -beside.near
    moved = shapely.offset_curve(course, off, join_style="mitre")
    if moved.geom_type != "LineString" or moved.is_empty:
        raise geometry.ShapeError("geometry", "bends more than the road is wide: draw the section along the kerb")
    return [(north, east) for east, north in moved.coords]


def _line(course: Floats) -> Ring:
    """Return the places of a line, without those that repeat the one before."""
    places = [(north, east) for north, east in course.tolist()]
    return tuple(
        place for number, place in enumerate(places) if number == 0 or math.dist(place, places[number - 1]) > _SAME_M
    )
