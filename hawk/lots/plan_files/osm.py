"""Plans as XML of OpenStreetMap (https://wiki.openstreetmap.org/wiki/OSM_XML): stalls are ``amenity=parking_space``.

Sections are ``amenity=parking`` and roads with ``parking:left|right|both``. Stalls and car parks are closed outlines of
nodes. A relation, and a node with a ``capacity``, is none and is left out by its number.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final
from xml.etree.ElementTree import Element, ParseError

import numpy as np
from defusedxml import DefusedXmlException
from defusedxml.ElementTree import fromstring

from hawk.lots.plan_files.features import STALL, FeatureReader
from hawk.lots.plan_files.geojson import WGS_84
from hawk.lots.plan_files.section_facts import AREA, is_line
from hawk.lots.plan_files.values import MOST_FEATURES, Asked, Drawing, Facts, Floats, Notes, text_of
from hawk.lots.values import LotInputError

FORMAT: Final = "OpenStreetMap"
OUTLINE: Final = "way"
_PARTS: Final = ("node", OUTLINE, "relation")


def read(data: bytes, asked: Asked, notes: Notes) -> Drawing:
    """Return the outlines of a file. Raises LotInputError for one that is none, is cut, or defines entities."""
    root = root_of(text_of(data))
    if len(root) > 5 * MOST_FEATURES:
        raise LotInputError("file", f"has {len(root)} elements: export a smaller part of the map")
    there = parts_of(root)
    nodes = {each.get("id", ""): place_of(each) for each in there if each.tag == "node"}
    reader = FeatureReader(asked, notes)
    for element in there:
        facts: Facts = {tag.get("k", ""): tag.get("v", "") for tag in element.iter("tag")}
        is_outline = facts.get("amenity") in (STALL, AREA)
        if not is_outline and not (element.tag == OUTLINE and is_line(facts)):
            continue
        name = f"{element.tag} {element.get('id', '')[:20]}"
        reason, course = _course(element, nodes, is_closed=is_outline)
        if reason:
            notes.add(name, reason)
        else:
            reader.add(name, course, {**facts, "id": name}, is_line=not is_outline)
    return reader.drawing(FORMAT, WGS_84)


def root_of(text: str) -> Element:
    """Return the root of a file's XML. Raises LotInputError."""
    try:
        root: Element = fromstring(re.sub(r"^\s*<\?xml[^>]*\?>", "", text, count=1), forbid_dtd=True)
    except DefusedXmlException:
        words = "has definitions of its own (DOCTYPE, entities), which are not read: export it from OpenStreetMap again"
        raise LotInputError("file", words) from None
    except (ParseError, ValueError, RecursionError) as error:
        words = f"is no whole XML ({error}): export it again, and copy all of it"
        raise LotInputError("file", words) from None
    if root.tag != "osm":
        tag = str(root.tag).rpartition("}")[2][:30]
        words = "save it as GeoJSON" if tag == "kml" else "export OpenStreetMap's XML, or GeoJSON"
        raise LotInputError("file", f"is XML of another kind ({tag}): {words}")
    return root


def parts_of(root: Element) -> list[Element]:
    """Return the objects of a file that are there: an editor (JOSM) marks those that it deleted."""
    gone = ("delete", "false")
    return [e for e in root if e.tag in _PARTS and e.get("action") not in gone and e.get("visible") not in gone]


def place_of(node: Element) -> tuple[float, float]:
    """Return (longitude, latitude) of a node; NaN for what is no number."""
    try:
        return float(node.get("lon", "nan")), float(node.get("lat", "nan"))
    except ValueError:
        return float("nan"), float("nan")


def _course(
    element: Element, nodes: Mapping[str, tuple[float, float]], *, is_closed: bool
) -> tuple[str, Floats]:  # fmt: skip
    """Return the reason why an element is no outline, or no line, else "", and its corners."""
    none = np.empty((0, 2))
    if element.tag == "node":
        return "is a point: draw the outline of the stall", none
    if element.tag == "relation":
        return "is a relation: draw one closed outline for the stall", none
    ids = [each.get("ref", "") for each in element.iter("nd")]
    missing = [each for each in ids if each not in nodes]
    if missing:
        return f"nd: node {missing[0][:20]} is not in the file: export it with all nodes", none
    if is_closed and (len(ids) < 4 or ids[0] != ids[-1]):
        return "nd: is not closed: end it at its first node", none
    if len(ids) < 2:
        return "nd: has fewer than two nodes: draw the line of the road", none
    course = np.array([nodes[each] for each in ids], np.float64)
    if not np.isfinite(course).all():
        bad = ids[int(np.flatnonzero(~np.isfinite(course).all(axis=1))[0])]
        return f"nd: node {bad[:20]} must have lat and lon, two finite numbers", none
    return "", course
