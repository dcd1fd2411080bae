"""Features of map programs: GeoJSON (RFC 7946) of lots, stalls and surveys."""

from __future__ import annotations

from typing import Any, Literal

from hawk.lots.answers import Shown
from hawk.lots.plan.values import Id


class Geometry(Shown):
    """Polygon or MultiPolygon of [longitude, latitude], degrees."""

    type: Literal["Polygon", "MultiPolygon"]
    coordinates: list[Any]


class Feature(Shown):
    """A lot, a stall or a survey with its ground; null where none is known."""

    type: Literal["Feature"]
    id: Id
    geometry: Geometry | None
    properties: dict[str, Any]
