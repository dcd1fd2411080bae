"""OGC API Features, Part 1: Core (OGC 17-069r4), read only: lots, stalls, sections and surveys for QGIS, GDAL and
their like.

Kept are the classes Core and GeoJSON. The API definition is OpenAPI 3.1, for which the standard has no class yet.
A thread of the store loads this module, and SQLAlchemy with it (`hawk.runtime.late`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Final
from urllib.parse import urlencode

from sqlalchemy import Connection

from hawk.exports import features
from hawk.exports.features import Box, Choice, Extent, Found, extent
from hawk.lots.values import NotFoundError, moment
from hawk.web.v1.answers import GEOJSON, JSON, OPENAPI, Answer
from hawk.web.v1.features.answers import (
    Collection,
    CollectionExtent,
    Collections,
    Conformance,
    FeatureCollection,
    Landing,
    Link,
    LinkedFeature,
    Spatial,
    Temporal,
)
from hawk.web.v1.features.parameters import MOST_FEATURES, Items, box_of, period_of
from hawk.web.v1.features.parameters import ROOT as FEATURES
from hawk.web.v1.parameters import Query, Request
from hawk.web.v1.reads import within
from hawk.web.v1.unknown import ROOT

CRS84: Final = "http://www.opengis.net/def/crs/OGC/1.3/CRS84"
_GREGORIAN: Final = "http://www.opengis.net/def/uom/ISO-8601/0/Gregorian"
CLASSES: Final = tuple(f"http://www.opengis.net/spec/ogcapi-features-1/1.0/conf/{each}" for each in ("core", "geojson"))
_TEXTS: Final[Mapping[str, tuple[str, str]]] = {
    "lots": ("Parking lots", "Lots with the counts of their last survey"),
    "stalls": ("Stalls", "Stalls of the lots' plans, free, taken or unknown at the last look at each"),
    "sections": ("Sections", "Sections of the lots' plans with the count of the last look at each"),
    "surveys": ("Surveys", "Flights over lots: the ground that each mapped, and its counts"),
}
"""Collections: title and description."""
COLLECTIONS: Final = tuple(_TEXTS)
"""Names of the collections."""
_ALONE: Final = "sections"
"""Collection whose features the API shows within a list alone."""
_LISTS: Final = {"lots": "/lots", "surveys": "/surveys"}
"""Collections that are a list of the API, too."""


def landing(_: Connection, asked: Request[Query]) -> Answer:
    """Return the landing page."""
    here = f"{asked.base}{ROOT}"
    links = [
        _link(f"{here}{FEATURES}", "self", JSON, "This page"),
        _link(f"{here}/openapi.json", "service-desc", OPENAPI, "The API's definition"),
        _link(f"{asked.base}/docs/api.html", "service-doc", "text/html", "The API's description"),
        _link(f"{here}{FEATURES}/conformance", "conformance", JSON, "Classes of the standard"),
        _link(f"{here}{FEATURES}/collections", "data", JSON, "Lots, stalls, sections and surveys"),
    ]
    words = "Parking lots that drones have surveyed: lots, stalls, sections and surveys."
    return Answer(Landing(title="hawk", description=words, links=links))


def conformance(_: Connection, __: Request[Query]) -> Answer:
    """Return the classes of the standard that are kept."""
    return Answer(Conformance(conforms_to=list(CLASSES)))


def collections(connection: Connection, asked: Request[Query]) -> Answer:
    """Return all collections."""
    around = extent(connection, within(connection, asked))
    found = [_collection(asked, name, around) for name in _TEXTS]
    return Answer(Collections(links=[_link(_address(asked), "self", JSON, "This list")], collections=found))


def collection(connection: Connection, asked: Request[Query]) -> Answer:
    """Return a collection."""
    return Answer(_collection(asked, asked.path["collection"], extent(connection, within(connection, asked))))


def _collection(asked: Request[Any], name: str, around: Extent) -> Collection:
    title, words = _TEXTS[name]
    box = around.box
    ground = None if box is None else Spatial(bbox=[[box.west, box.south, box.east, box.north]], crs=CRS84)
    ends = [None if each is None else moment(each) for each in (around.begin, around.end)]
    links = [
        _link(_address(asked, name), "self", JSON, title),
        _link(f"{_address(asked, name)}/items", "items", GEOJSON, f"{title}, as features"),
    ]
    if name in _LISTS:
        links.append(_link(f"{asked.base}{ROOT}{_LISTS[name]}", "alternate", JSON, f"{title}, as a list"))
    reach = CollectionExtent(spatial=ground, temporal=Temporal(interval=[ends], trs=_GREGORIAN))
    return Collection(
        id=name, title=title, description=words, item_type="feature", crs=[CRS84], extent=reach, links=links
    )  # fmt: skip


def items(connection: Connection, asked: Request[Items]) -> Answer:
    """Return the features of a collection that are asked for."""
    name, query, address = asked.path["collection"], asked.query, f"{_address(asked, asked.path['collection'])}/items"
    limit = min(query.limit, MOST_FEATURES)
    choice = replace(_choice(query, limit), lots=within(connection, asked))
    found = _finder(name)(connection, choice)
    given = {key: value for key, value in (("bbox", query.bbox), ("datetime", query.datetime)) if value is not None}

    def at(offset: int, count: int = limit) -> str:
        return f"{address}?{urlencode({**given, 'limit': count, 'offset': offset}, safe=',/:')}"

    links = [_link(at(query.offset), "self", GEOJSON, "This part")]
    if query.offset + limit < found.matched:
        links.append(_link(at(query.offset + limit), "next", GEOJSON, "The next part"))
    if query.offset > 0:
        links.append(
            _link(at(max(query.offset - limit, 0), min(limit, query.offset)), "prev", GEOJSON, "The part before")
        )
    links.append(_link(_address(asked, name), "collection", JSON, _TEXTS[name][0]))
    if name in _LISTS:
        links.append(_link(f"{asked.base}{ROOT}{_LISTS[name]}", "alternate", JSON, "As a list of the API"))
    content = FeatureCollection(
        type="FeatureCollection", links=links, time_stamp=moment(asked.now), number_matched=found.matched,
        number_returned=len(found.features), features=found.features,
    )  # fmt: skip
    return Answer(content, content_type=GEOJSON)


def item(connection: Connection, asked: Request[Query]) -> Answer:
    """Return a feature. Raises NotFoundError."""
    name = asked.path["collection"]
    found = _finder(name)(connection, Choice(ids=[asked.id], lots=within(connection, asked)))
    if not found.features:
        raise NotFoundError("feature: there is no feature with this id; read the collection again")
    links = [
        _link(f"{_address(asked, name)}/items/{asked.id}", "self", GEOJSON, "This feature"),
        _link(_address(asked, name), "collection", JSON, _TEXTS[name][0]),
    ]
    if name != _ALONE:
        links.append(_link(f"{asked.base}{ROOT}/{name}/{asked.id}", "alternate", JSON, "As the API shows it"))
    return Answer(LinkedFeature(**dict(found.features[0]), links=links), content_type=GEOJSON)


def _finder(name: str) -> Callable[[Connection, Choice], Found]:
    found: Callable[[Connection, Choice], Found] = getattr(features, name)
    return found


def _choice(query: Items, limit: int) -> Choice:
    box = None if query.bbox is None else Box(*box_of(query.bbox))
    begin, end = (None, None) if query.datetime is None else period_of(query.datetime)
    return Choice(limit, query.offset, box, begin, end)


def _address(asked: Request[Any], name: str = "") -> str:
    return f"{asked.base}{ROOT}{FEATURES}/collections{f'/{name}' if name else ''}"


def _link(href: str, rel: str, content_type: str, title: str) -> Link:
    return Link(href=href, rel=rel, type=content_type, title=title)
