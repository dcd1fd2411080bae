"""Plans as XML of OpenStreetMap (https://wiki.openstreetmap.org/wiki/OSM_XML): ``amenity=parking_space``.

Stalls are closed outlines of nodes. A relation, and a node with a ``capacity``, is none and is left out by its number.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final
from xml.etree.ElementTree import Element, ParseError

import numpy as np
from defusedxml import DefusedXmlException
from defusedxml.ElementTree import fromstring

from hawk.lots.plan_files.facts import kind_of, label_of
from hawk.lots.plan_files.geojson import STALL, WGS_84
from hawk.lots.plan_files.values import MOST_FEATURES, Asked, Drawing, Drawn, Floats, Notes, text_of
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
    drawn = []
    for element in there:
        facts = {tag.get("k", ""): tag.get("v", "") for tag in element.iter("tag")}
        if facts.get("amenity") != STALL:
            continue
        name = f"{element.tag} {element.get('id', '')[:20]}"
        reason, ring = _ring(element, nodes)
        if reason:
            notes.add(name, reason)
        else:
            drawn.append(Drawn(name, ring, label_of(facts, asked.label, name, notes), kind_of(facts, name, notes)))
    return Drawing(FORMAT, tuple(drawn), crs=WGS_84)


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


def _ring(element: Element, nodes: Mapping[str, tuple[float, float]]) -> tuple[str, Floats]:
    """Return the reason why an element is no stall, else "", and its corners."""
    none = np.empty((0, 2))
    if element.tag == "node":
        return "is a point: draw the outline of the stall", none
    if element.tag == "relation":
        return "is a relation: draw one closed outline for the stall", none
    ids = [each.get("ref", "") for each in element.iter("nd")]
    missing = [each for each in ids if each not in nodes]
    if missing:
        return f"nd: node {missing[0][:20]} is not in the file: export it with all nodes", none
    if len(ids) < 4 or ids[0] != ids[-1]:
        return "nd: is not closed: end it at its first node", none
    ring = np.array([nodes[each] for each in ids], np.float64)
    if not np.isfinite(ring).all():
        bad = ids[int(np.flatnonzero(~np.isfinite(ring).all(axis=1))[0])]
        return f"nd: node {bad[:20]} must have lat and lon, two finite numbers", none
    return "", ring
