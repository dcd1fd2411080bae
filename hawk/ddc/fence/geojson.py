"""A fence or an outline as a file: GeoJSON (RFC 7946; WGS-84, longitude before latitude), or KML.

`hawk.formats.area_file` reads it. The fence is a polygon, its interior rings are the exclusion zones. Further polygons
with the property ``"exclusion": true`` are zones, too.
"""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from shapely import Polygon

from hawk.comm.protocol.commands import LEAST_CORNERS, MOST_CORNERS, outline_problem, zones_problem
from hawk.ddc.fence.geometry import FenceError, Ring
from hawk.ddc.fence.outline import OutlineError, check_rings
from hawk.formats.area_file import LARGEST_BYTES, Area, AreaError, read_areas
from hawk.formats.area_file import Ring as FileRing
from hawk.model.plans import Outline
from hawk.model.sentences import say, series, words_of

T = TypeVar("T")
_ONE = say(
    'must hold exactly one Polygon (WGS-84, longitude before latitude); others need the property "exclusion": true'
)


@dataclass(frozen=True, slots=True)
class FenceFile:
    """Fence and zones, (latitude, longitude) corners; ``ceiling`` in metres above the arm place, None for none."""

    ring: Ring
    zones: tuple[Ring, ...]
    ceiling: float | None


def read_fence(path: Path) -> FenceFile:
    """Return the fence of a file, with its zones and its property ``ceiling_m``, if it has one.

    Raises:
        FenceError: Names the file, the ring and the fault.
    """
    return read_area_file(path, say("fence file"), fence_of, FenceError)


def read_area_file(path: Path, name: str, parse: Callable[[Sequence[Area]], T], kind: type[FenceError]) -> T:
    """Return what ``parse`` makes of the areas of a file; it raises FenceErrors without the file's name.

    Raises:
        FenceError: Of this ``kind``, with the ``name`` of such a file, its path and the fault.
    """
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_BYTES + 1)
    except OSError as error:
        raise kind(
            say("{name} {path}: cannot be read: {error}", name=name, path=str(path), error=str(error))
        ) from error
    try:
        return parsed_areas(data, parse)
    except FenceError as error:
        raise kind(say("{name} {path}: {error}", name=name, path=str(path), error=words_of(error))) from error


def parsed_areas(data: bytes, parse: Callable[[Sequence[Area]], T]) -> T:
    """Return what ``parse`` makes of the areas of a file. Raises FenceError without the file's name."""
    try:
        found = read_areas(data)
    except AreaError as error:
        raise FenceError(words_of(error)) from error
    try:
        return parse(found.areas)
    except FenceError as error:
        if found.areas or not found.others:
            raise
        raise FenceError(say("{error}; it holds {others}", error=words_of(error), others=found.others)) from error


def fence_of(areas: Sequence[Area]) -> FenceFile:
    """Return the fence among a file's areas: the one that is no exclusion zone. Raises FenceError."""
    fences = [area for area in areas if not area.is_exclusion]
    if len(fences) != 1:
        names = series(*(area.name for area in fences[:4]))
        raise FenceError(say("{one}; it holds {names}", one=_ONE, names=names) if fences else _ONE)
    (fence,) = fences
    inner = [checked_ring(ring, f"{fence.name}[{number}]") for number, ring in enumerate(fence.holes, start=1)]
    zones = [*inner, *(_zone(area) for area in areas if area.is_exclusion)]
    outer = checked_ring(fence.outer, f"{fence.name}[0]")
    problem = zones_problem(len(outer), [len(zone) for zone in zones])
    if problem:
        raise FenceError(problem)
    return FenceFile(outer, tuple(zones), _ceiling(fence.ceiling))


def _zone(area: Area) -> Ring:
    if area.holes:
        raise FenceError(say("{name}: an exclusion zone is one ring without holes: draw it so", name=area.name))
    return checked_ring(area.outer, f"{area.name}[0]")


def _ceiling(written: object) -> float | None:
    """Return metres above the arm place; tables write numbers as texts too. Raises FenceError."""
    if written is None or written == "":
        return None
    ceiling = math.nan
    if isinstance(written, int | float | str) and not isinstance(written, bool):
        with contextlib.suppress(ValueError):
            ceiling = float(written)
    if not (math.isfinite(ceiling) and ceiling > 0):
        raise FenceError(say("ceiling_m: must be metres above 0, not {written}", written=repr(written)))
    return ceiling


def checked_ring(ring: Ring, name: str) -> Ring:
    """Return corners that make a simple polygon of a size that the messages carry.

    Raises:
        FenceError: Names the ring and the fault.
    """
    if not LEAST_CORNERS <= len(ring) <= MOST_CORNERS:
        raise FenceError(
            say(
                "{name}: has {count} corners; draw {least} to {most}",
                name=name,
                count=len(ring),
                least=LEAST_CORNERS,
                most=MOST_CORNERS,
            )
        )
    if not Polygon(ring).is_valid:
        raise FenceError(say("{name}: its sides cross or touch each other; draw a simple polygon", name=name))
    return ring


def fence_feature(ring: Ring, zones: Sequence[Ring], ceiling: float | None) -> str:
    """Return (latitude, longitude) corners and a ceiling as a GeoJSON Feature.

    ``ceiling`` is in metres above the arm place, None for none.
    """
    rings = [_positions(ring, clockwise=False), *(_positions(zone, clockwise=True) for zone in zones)]
    feature = {
        "type": "Feature",
        "properties": {"name": "fence", "ceiling_m": ceiling},
        "geometry": {"type": "Polygon", "coordinates": rings},
    }
    return json.dumps(feature, indent=1) + "\n"


def _positions(ring: Ring, *, clockwise: bool) -> list[list[float]]:
    """Return a closed ring; RFC 7946: an outer ring runs counterclockwise, an inner one clockwise."""
    positions = [[longitude, latitude] for latitude, longitude in (*ring, ring[0])]
    return positions if _turns_clockwise(ring) == clockwise else positions[::-1]


def _turns_clockwise(ring: Ring) -> bool:
    pairs = zip(ring, (*ring[1:], ring[0]), strict=True)
    return sum((there[1] - here[1]) * (there[0] + here[0]) for here, there in pairs) > 0


FENCE = "fence"


def editable_area(data: bytes, kind: str) -> str:
    """Return the area of a file as a GeoJSON Feature of one Polygon, for the editor of a fence or of an outline.

    Raises:
        FenceError: The file holds no such area; the text is without its name.
    """
    if kind == FENCE:
        fence = parsed_areas(data, fence_of)
        return fence_feature(fence.ring, fence.zones, fence.ceiling)
    outline = parsed_areas(data, outline_of)
    first, *others = outline.polygons
    if others:
        raise FenceError(
            say("holds {count} polygons; the page draws one: set flight.outline_file for more", count=1 + len(others))
        )
    return fence_feature(first, outline.holes, None)


_NONE = say("must hold Polygons or MultiPolygons (WGS-84, longitude before latitude)")


def read_survey_outline(path: Path) -> Outline:
    """Return the outline of a file, checked.

    Raises:
        OutlineError: Names the file, the ring and the fault.
    """
    return read_area_file(path, say("outline file"), outline_of, OutlineError)


def outline_of(areas: Sequence[Area]) -> Outline:
    """Return the outline that a file's areas make, checked. Raises OutlineError, FenceError."""
    polygons: list[FileRing] = []
    holes: list[FileRing] = []
    for area in areas:
        (holes if area.is_exclusion else polygons).append(checked_ring(area.outer, f"{area.name}[0]"))
        inner = () if area.is_exclusion else area.holes
        holes += [checked_ring(ring, f"{area.name}[{number}]") for number, ring in enumerate(inner, start=1)]
    if not polygons:
        raise OutlineError(_NONE)
    problem = outline_problem([len(ring) for ring in polygons], [len(ring) for ring in holes])
    if problem:
        raise OutlineError(problem)
    outline = Outline(tuple(polygons), tuple(holes))
    check_rings(outline)
    return outline
