"""Reads a file with an area for the page's editor, as the settings' files are read."""

from __future__ import annotations

from hawk.ddc.fence.geojson import fence_of, outline_geojson, parsed_areas
from hawk.ddc.fence.geometry import FenceError
from hawk.ddc.fence.outline_geojson import outline_of
from hawk.model.sentences import say

FENCE = "fence"


def editable_area(data: bytes, kind: str) -> str:
    """Return the area of a file as a GeoJSON Feature of one Polygon, for the editor of a fence or of an outline.

    Raises:
        FenceError: The file holds no such area; the text is without its name.
    """
    if kind == FENCE:
        fence = parsed_areas(data, fence_of)
        return outline_geojson(fence.ring, fence.zones, fence.ceiling)
    outline = parsed_areas(data, outline_of)
    first, *others = outline.polygons
    if others:
        raise FenceError(
            say("holds {count} polygons; the page draws one: set flight.outline_file for more", count=1 + len(others))
        )
    return outline_geojson(first, outline.holes, None)
