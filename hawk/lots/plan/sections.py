"""Sections of plans: the strip beside a line, the capacity that its length allows, and drafts of their changes.

Sections are given by persons or files. None is derived from vehicles or lanes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

import shapely

from hawk.lots.plan import geometry
from hawk.lots.plan.operations import MOST_PLACES, ChangeSection, DrawSection, RemoveSection
from hawk.lots.plan.values import Draft, LayoutSection, SectionKind
from hawk.lots.values import LotInputError
from hawk.model.poses import Ring
from hawk.model.sentences import say

PLACES_M: Final[Mapping[SectionKind, float]] = {"parallel": 5.5, "across": 2.5}
"""Metres of kerb for one vehicle where nobody says otherwise."""
_LEAST_LINE_M: Final = 1.0
_ROUNDING: Final = 1e-6


def capacity_of(kind: SectionKind, length_m: float, place_m: float | None = None) -> int | None:
    """Return the places along a kerb; None where neither ``place_m``, metres for one, nor the kind says them."""
    each = place_m or PLACES_M.get(kind)
    return None if each is None else min(max(math.floor(length_m / each + _ROUNDING), 1), MOST_PLACES)


def strip(line: Sequence[geometry.Point], width: float, side: str) -> Ring:
    """Return the ring of the strip on one side of a line of (north, east), as one goes along it.

    Corners of the line are mitred. Raises ShapeError for a line without length, and for one whose strip is no single
    area without holes.
    """
    course = shapely.LineString([(east, north) for north, east in line])
    if course.length < _LEAST_LINE_M:
        raise geometry.ShapeError(
            "line",
            say("is {length:.2f} m long: place its ends {least:g} m apart or more", length=course.length, least=1),
        )
    if not course.is_simple:
        raise geometry.ShapeError("line", say("crosses itself: place its corners in their order along the kerb"))
    off = width if side == "left" else -width  # left of the line where x is east and y north
    area = course.buffer(off, single_sided=True, join_style="mitre")
    if area.geom_type != "Polygon" or area.interiors or not area.area:
        raise geometry.ShapeError(
            "width", say("is too wide for the bends of the line: write less, or draw two sections")
        )
    ring = shapely.remove_repeated_points(area, 1e-4).exterior.coords[:-1]
    return _rounded([(north, east) for east, north in ring])


def length_of(line: Sequence[geometry.Point]) -> float:
    """Return the length of a line, metres."""
    return sum(math.dist(one, other) for one, other in pairwise(line))


def axis_of(ring: Sequence[geometry.Point]) -> tuple[geometry.Point, geometry.Point]:
    """Return the ends of the axis of an area: the line amid the long sides of the least rectangle around it."""
    around = shapely.Polygon(ring).minimum_rotated_rectangle
    a, b, c, d = list(around.exterior.coords)[:4]
    if math.dist(a, b) < math.dist(b, c):
        a, b, c, d = b, c, d, a
    return ((a[0] + d[0]) / 2, (a[1] + d[1]) / 2), ((b[0] + c[0]) / 2, (b[1] + c[1]) / 2)


def section_of(asked: DrawSection, new_id: str) -> LayoutSection:
    """Return the section that an operation draws. Raises ShapeError."""
    if asked.line is not None and asked.width is not None:
        ring = strip(asked.line, asked.width, asked.side or "left")
        length = length_of(asked.line)
    else:
        ring = _rounded(geometry.checked_ring([(north, east) for north, east in asked.outline or ()]))
        length = math.dist(*axis_of(ring))
    capacity = asked.capacity or capacity_of(asked.kind, length, asked.place_m)
    return LayoutSection(
        new_id, asked.name, ring, asked.kind, round(length, 2), capacity, asked.capacity is not None, asked.note
    )


def drawn(asked: DrawSection, present: Sequence[LayoutSection], new_id: Callable[[], str]) -> Draft:
    """Return the draft of a new section. Raises LotInputError, ShapeError."""
    _check_name(asked.name, present)
    return Draft(begun_sections=(section_of(asked, new_id()),), field="outline" if asked.line is None else "line")


def changed(asked: ChangeSection, present: Sequence[LayoutSection]) -> Draft:
    """Return the draft of a section that is said otherwise: the one ends, and one with the same id begins.

    Raises LotInputError.
    """
    old = _named(asked.section, present)
    new = replace(old, **{
        name: value for name in ("name", "kind", "note") if (value := getattr(asked, name)) is not None
    })  # fmt: skip
    if asked.capacity is not None:
        new = replace(new, capacity=asked.capacity, is_capacity_given=True)
    elif "capacity" in asked.model_fields_set or (new.kind != old.kind and not old.is_capacity_given):
        new = replace(new, capacity=capacity_of(new.kind, new.length_m), is_capacity_given=False)
    if new == old:
        return Draft()
    _check_name(new.name, [each for each in present if each.id != old.id])
    return Draft(ended_sections=(old,), begun_sections=(new,), field="section")


def removed(asked: RemoveSection, present: Sequence[LayoutSection]) -> Draft:
    """Return the draft that ends a section. Raises LotInputError."""
    return Draft(ended_sections=(_named(asked.section, present),), field="section")


def _named(section: str, present: Sequence[LayoutSection]) -> LayoutSection:
    found = next((each for each in present if each.id == section), None)
    if found is None:
        raise LotInputError("section", say("must be of this plan: read the plan again"))
    if not found.outline:
        raise LotInputError("section", say("is damaged on the disk. Restore a backup: hawk-drone restore FILE"))
    return found


def _check_name(name: str, present: Sequence[LayoutSection]) -> None:
    if any(each.name == name for each in present):
        raise LotInputError(
            "name", say("{name} is another section's: write another one, or remove that section first", name=name)
        )


def _rounded(ring: Sequence[geometry.Point]) -> Ring:
    return tuple((round(north, 6), round(east, 6)) for north, east in ring)
