"""Stalls and sections of a drawing: each outline's least rotated rectangle, in metres, where the outline fills it well.

An outline that leans, as those of angled rows do, becomes a rectangle of the same area between the lines beside it: as
wide as the least one, and shorter. Outlines that are no stalls are left out by name.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
import pymap3d
import shapely
from numpy.typing import NDArray

from hawk.formats.area_file import open_ring
from hawk.lots.plan import geometry
from hawk.lots.plan.checks import MOST_OVERLAP
from hawk.lots.plan.operations import FARTHEST_M, LENGTHS_M, WIDTHS_M
from hawk.lots.plan_files.crs import to_wgs_84
from hawk.lots.plan_files.dxf import UNITS
from hawk.lots.plan_files.geojson import FORMAT as GEOJSON
from hawk.lots.plan_files.geojson import WGS_84, crs_name
from hawk.lots.plan_files.section_shapes import sections_of
from hawk.lots.plan_files.values import (
    MOST_SECTIONS,
    MOST_STALLS,
    Asked,
    Drawing,
    Drawn,
    FileFeature,
    Floats,
    Notes,
    PlanFile,
)
from hawk.lots.values import LotInputError

USUAL_M2: Final = (7.0, 30.0)
"""Area of a stall for a car: 2 by 3.5 m to 3.7 by 8 m."""
LEAST_COVER: Final = 0.70
"""Share of its least rectangle that an outline fills: stalls that lean by 45° fill 0.75, a triangle fills 0.5."""
_SAME_M: Final = 1e-3
"""Metres within which two corners of an outline are one, as `hawk.formats.area_file` has it in degrees."""
_ROUNDING: Final = 1e-4
"""Stalls of a file may overlap by less than those of a plan by this: placing them rounds."""


def plan_of(drawing: Drawing, asked: Asked, notes: Notes) -> PlanFile:
    """Return the stalls and sections of a drawing.

    Raises LotInputError where it holds none, or its system is not known.
    """
    courses = [*(each.ring for each in drawing.drawn), *(each.places for each in drawing.sections)]
    _check_count(drawing, len(courses), notes)
    places = np.concatenate(courses)
    crs = crs_name(asked.crs) if asked.crs else drawing.crs or (WGS_84 if drawing.format == GEOJSON else "")
    datum, origin, accuracy, metres = None, (0.0, 0.0), None, drawing.metres
    if crs:
        degrees, accuracy = to_wgs_84(places * metres, crs)
        longitude, latitude = np.median(degrees, axis=0).tolist()
        datum = (latitude, longitude)
        north, east, _ = pymap3d.geodetic2ned(degrees[:, 1], degrees[:, 0], 0.0, latitude, longitude, 0.0)
        corners = np.column_stack([north, east])
        metres = 1.0
    else:
        x, y = np.median(places, axis=0).tolist()
        origin = (x, y)
        corners = (places - origin)[:, ::-1] * metres
    parts = np.split(corners, np.cumsum([len(each) for each in courses])[:-1])
    rings = parts[: len(drawing.drawn)]
    if not crs and not asked.units:
        _check_units(rings, metres)
    fits = _fitting(drawing.drawn, rings, notes)
    stalls = _without_overlaps(fits, notes)
    middles = np.array([(each.north, each.east) for each in stalls], np.float64).reshape(-1, 2)
    sections = sections_of(drawing.sections, parts[len(rings) :], middles, notes)
    if not stalls and not sections:
        if not crs:
            _check_units(rings, metres)
        raise LotInputError("file", _nothing(notes, "draw each stall as a closed outline of its own size"))
    return PlanFile(
        drawing.format, tuple(stalls), crs, datum, origin, metres, drawing.layers,
        tuple(notes.left_out), notes.count, accuracy, sections, tuple(notes.assumed),
    )  # fmt: skip


def _check_count(drawing: Drawing, count: int, notes: Notes) -> None:
    """Refuse a drawing without stalls and sections, and one with too many. Raises LotInputError."""
    if count == 0:
        raise LotInputError("file", _nothing(notes, "draw each stall as a closed outline"))
    for found, most, words in (
        (drawing.drawn, MOST_STALLS, "outlines"), (drawing.sections, MOST_SECTIONS, "sections"),
    ):  # fmt: skip
        if len(found) > most:
            raise LotInputError("file", f"has {len(found)} {words}, {most} are the most: import parts of it")


def _check_units(rings: Sequence[Floats], metres: float) -> None:
    """Refuse a drawing that says one unit and shows stalls in another: its template may have said it.

    Raises LotInputError with the units by which it would fit. Units that somebody named are believed where any stall
    fits.
    """
    areas = np.array([abs(_area(ring)) for ring in rings if len(ring) >= 3])
    counts = {unit: _usual(areas * (scale / metres) ** 2) for unit, scale in UNITS.items()}
    fitting = [unit for unit, count in counts.items() if count == max(counts.values())]
    if _usual(areas) == 0 and 2 * counts[fitting[0]] >= len(areas) > 0:
        raise LotInputError(
            "units",
            f"of the drawing do not fit: by what is said of them its outlines have {np.median(areas):.2g} m², "
            f"by {' or '.join(fitting)} they are stalls: write {fitting[0]}",
        )


def _usual(areas: Floats) -> int:
    return int(((areas >= USUAL_M2[0]) & (areas <= USUAL_M2[1])).sum())


def _area(ring: Floats) -> float:
    x, y = ring.T
    return float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2


def _nothing(notes: Notes, remedy: str) -> str:
    """Return the words that a file has neither stall nor section, with the first of its features that are none."""
    if not notes.left_out:
        return f"holds no stall and no section: {remedy}"
    first = notes.left_out[0]
    return f"holds no stall and no section, {notes.count} features are none. The first, {first.name}: {first.reason}"


def _fitting(drawn: Sequence[Drawn], rings: Sequence[Floats], notes: Notes) -> list[FileFeature]:
    """Return the outlines that are stalls; their ``rings`` are corners (north, east), metres."""
    if not rings:
        return []
    rings = [np.array(open_ring(ring.tolist(), _SAME_M), np.float64).reshape(-1, 2) for ring in rings]
    is_ring = np.array([len(ring) >= 3 for ring in rings])
    blank = np.zeros((4, 2))
    outlines = shapely.polygons(
        [shapely.linearrings(ring if ok else blank) for ring, ok in zip(rings, is_ring, strict=True)]
    )
    is_valid = is_ring & shapely.is_valid(outlines) & (shapely.area(outlines) > 0)
    shapes, cover, centres = _rectangles(outlines, is_valid)
    leans = cover < 1.0
    final = shapes.copy()
    final[leans, :2] = centres[leans]
    final[:, 4] *= cover
    final = geometry.normal(final)
    found = []
    for k, each in enumerate(drawn):
        reason = _reason(bool(is_valid[k]), rings[k], shapes[k], float(cover[k]))
        if reason:
            notes.add(each.name, reason)
            continue
        found.append(FileFeature(each.name, each.label, each.kind, *final[k].tolist()))
    return found


def _rectangles(outlines: Floats, is_valid: NDArray[np.bool_]) -> tuple[Floats, Floats, Floats]:
    """Return the least rectangles (N, 5), the share that each outline fills (N,), and the centroids (N, 2)."""
    shapes, cover, centres = np.zeros((len(outlines), 5)), np.zeros(len(outlines)), np.zeros((len(outlines), 2))
    at = np.flatnonzero(is_valid)
    if not len(at):
        return shapes, cover, centres
    least = shapely.minimum_rotated_rectangle(outlines[at])
    corners = shapely.get_coordinates(shapely.get_exterior_ring(least)).reshape(-1, 5, 2)
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 1]
    is_long = (np.hypot(*one.T) >= np.hypot(*other.T))[:, None]
    along, across = np.where(is_long, one, other), np.where(is_long, other, one)
    length, width = np.hypot(*along.T), np.hypot(*across.T)
    angle = np.arctan2(along[:, 1], along[:, 0]) % np.pi
    shapes[at] = np.column_stack([corners[:, :4].mean(axis=1), angle, width, length])
    cover[at] = np.minimum(shapely.area(outlines[at]) / (length * width), 1.0)
    centres[at] = shapely.get_coordinates(shapely.centroid(outlines[at]))
    cover[cover > 0.995] = 1.0
    return shapes, cover, centres


def _reason(is_valid: bool, ring: Floats, shape: Floats, cover: float) -> str:
    """Return the reason why an outline is no stall; "" for one."""
    if len(ring) < 3:
        return f"has {len(ring)} corners: draw the outline of the stall"
    if not is_valid:
        return "crosses itself or has no area: draw its corners in their order around the stall"
    if np.abs(shape[:2]).max() > FARTHEST_M:
        return f"is {np.hypot(*shape[:2]) / 1000:.0f} km from the others: import each lot by itself"
    width, length = float(shape[3]), float(shape[4])
    if not (WIDTHS_M[0] <= width <= WIDTHS_M[1] and LENGTHS_M[0] <= length * cover <= LENGTHS_M[1]):
        most = f"{WIDTHS_M[0]:g} to {WIDTHS_M[1]:g} m wide and up to {LENGTHS_M[1]:g} m long"
        return f"is {width:.2f} by {length:.2f} m: a stall is {most}, a section has a capacity"
    if cover < LEAST_COVER:
        return f"fills {cover:.0%} of the least rectangle about it, {LEAST_COVER:.0%} is the least: draw a rectangle"
    return ""


def _without_overlaps(stalls: Sequence[FileFeature], notes: Notes) -> list[FileFeature]:
    """Return the stalls without those that overlap an earlier one by more than stalls of a plan may."""
    shapes = np.array([(s.north, s.east, s.angle, s.width, s.length) for s in stalls], np.float64).reshape(-1, 5)
    pairs = geometry.overlaps(shapes, np.empty((0, 5)), MOST_OVERLAP - _ROUNDING)
    gone: set[int] = set()
    for first, second, share in sorted((min(a, b), max(a, b), share) for a, b, share in pairs):
        if first not in gone and second not in gone:
            gone.add(second)
            words = (
                f"overlaps {stalls[first].name} by {share:.0%}: {MOST_OVERLAP:.0%} is the most. Draw each stall once"
            )
            notes.add(stalls[second].name, words)
    return [stall for k, stall in enumerate(stalls) if k not in gone]
