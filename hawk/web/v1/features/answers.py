"""Answers of OGC API Features as pydantic models (OGC 17-069r4, with GeoJSON, RFC 7946)."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from hawk.lots.answers import BLURRED, Count, Feature, Geometry, Shown, State, Utc
from hawk.lots.plan.values import Id


def _is_none(value: object) -> bool:
    return value is None


class Link(Shown):
    """A link to another answer."""

    href: str
    rel: str
    type: str
    title: str = ""


class Landing(Shown):
    """Links to API definition, conformance and collections."""

    title: str
    description: str
    links: list[Link]


class Conformance(Shown):
    """Classes of the standard that are kept, by their addresses."""

    conforms_to: Annotated[list[str], Field(alias="conformsTo")]


class Spatial(Shown):
    """Boxes of the Earth: west, south, east, north, degrees."""

    bbox: list[Annotated[list[float], Field(min_length=4, max_length=4)]]
    crs: str


class Temporal(Shown):
    """Periods; null is an open end."""

    interval: list[Annotated[list[Utc | None], Field(min_length=2, max_length=2)]]
    trs: str


class CollectionExtent(Shown):
    """Ground and time of a collection's features."""

    spatial: Annotated[Spatial | None, Field(exclude_if=_is_none)] = None
    temporal: Temporal


class Collection(Shown):
    """A collection of features."""

    id: str
    title: str
    description: str
    extent: CollectionExtent
    item_type: Annotated[Literal["feature"], Field(alias="itemType")]
    crs: list[str]
    links: list[Link]


class Collections(Shown):
    """All collections."""

    links: list[Link]
    collections: list[Collection]


class LinkedFeature(Feature):
    """A feature with links to itself and its collection."""

    links: list[Link]


class FeatureCollection(Shown):
    """Part of a collection: `numberReturned` of `numberMatched` features."""

    type: Literal["FeatureCollection"]
    features: list[Feature]
    links: list[Link]
    time_stamp: Annotated[Utc, Field(alias="timeStamp")]
    number_matched: Annotated[Count, Field(alias="numberMatched")]
    number_returned: Annotated[Count, Field(alias="numberReturned")]


class AboutSurvey(Shown):
    """The survey that features show. `doubt`: why it is not registered."""

    lot_name: str
    lot_id: Id
    survey_id: Id
    survey_began_utc: Utc
    survey_ended_utc: Utc
    time_is_sure: bool
    registered: bool
    doubt: str
    layout_version: int | None
    position_uncertainty_m: float | None
    position_pinned: bool
    simulated: bool
    software: str
    survey_kind: Literal["flown", "picture"]
    survey_source: Annotated[str, Field(description="kind and name of the pictures")]
    survey_limits: Annotated[str, Field(description="what limits a survey by pictures, in sentences")]
    stalls: Count
    free: Count
    taken: Count
    unknown: Count
    stalls_blurred: Annotated[int | None, Field(ge=0, description=BLURRED)]


class SurveyFeature(Shown):
    """A lot or a stall; a stall that is not registered has the number that its survey gave it for an id."""

    type: Literal["Feature"]
    id: str
    geometry: Geometry
    properties: dict[str, Any]


class SurveyMap(Shown):
    """Stalls of a survey as the page draws them, a list for each value: a fifth of the GeoJSON.

    `corners`: of each stall four, counter-clockwise as seen from above; of each corner longitude and latitude, in
    0.00000001 degrees from `origin` (longitude, latitude). `taken`: probability; null without a look.
    """

    origin: tuple[float, float]
    ids: list[str]
    labels: list[str]
    states: list[State]
    taken: list[float | None]
    corners: list[int]


class LotPlaces(Shown):
    """All lots, the oldest first, a list for each value: a fifth of the list of lots.

    `surveys` to `drones` are about the newest survey of each, null without one; else as a listed lot has them.
    """

    ids: list[Id]
    names: list[str]
    latitudes: list[float]
    longitudes: list[float]
    time_zones: list[str]
    stalls: list[Count]
    survey_counts: list[Count]
    due: list[Utc | None]
    surveys: list[Id | None]
    ended: list[Utc | None]
    free: list[Count | None]
    taken: list[Count | None]
    unknown: list[Count | None]
    drones: list[str | None]


class SurveyStalls(Shown):
    """A survey with its stalls, as its GeoJSON file has them."""

    type: Literal["FeatureCollection"]
    hawk: AboutSurvey
    features: list[SurveyFeature]
