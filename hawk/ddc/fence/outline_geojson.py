"""An outline of a survey as a file (`hawk.formats.area_file` reads it): GeoJSON (RFC 7946; WGS-84), or KML.

Every polygon of the file belongs to the outline, their interior rings are holes. A polygon with the property
``"exclusion": true`` is a hole, as in a fence.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hawk.comm.protocol.outline_messages import outline_problem
from hawk.ddc.fence.geojson import checked_ring, read_area_file
from hawk.ddc.fence.outline import OutlineError, check_rings
from hawk.formats.area_file import Area, Ring
from hawk.model.limits import Outline
from hawk.model.sentences import say

_NONE = say("must hold Polygons or MultiPolygons (WGS-84, longitude before latitude)")


def read_survey_outline(path: Path) -> Outline:
    """Return the outline of a file, checked.

    Raises:
        OutlineError: Names the file, the ring and the fault.
    """
    return read_area_file(path, say("outline file"), outline_of, OutlineError)


def outline_of(areas: Sequence[Area]) -> Outline:
    """Return the outline that a file's areas make, checked. Raises OutlineError, FenceError."""
    polygons: list[Ring] = []
    holes: list[Ring] = []
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
