"""Surveys as KMZ (OGC KML 2.3) for Google Earth and its like: a polygon a stall, coloured by its state."""

from __future__ import annotations

import io
import zipfile
from typing import Final
from xml.etree.ElementTree import Element, SubElement, tostring

from hawk.exports.shapes import stall_shape
from hawk.exports.text_files import about_survey
from hawk.exports.values import ExportRecord, Observation
from hawk.lots.values import utc

_COLOURS: Final = {"free": "ffff8f2f", "taken": "ff1a7aff", "unknown": "ff1c1610"}
"""Line of each state as the page draws it, KML's aabbggrr; the area is the same at `_AREA`."""
_AREA: Final = "99"
_MADE: Final = (1980, 1, 1, 0, 0, 0)
"""Time of the file in the archive: equal surveys are equal bytes."""


def survey_kmz(survey: ExportRecord) -> bytes:
    """Return a survey as a KMZ with one document."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        info = zipfile.ZipInfo("doc.kml", _MADE)
        archive.writestr(info, _document(survey), zipfile.ZIP_DEFLATED)
    return out.getvalue()


def _document(survey: ExportRecord) -> bytes:
    root = Element("kml", xmlns="http://www.opengis.net/kml/2.2")
    document = SubElement(root, "Document")
    _text(document, "name", f"{survey.lot}, {utc(survey.ended)}")
    about = about_survey(survey)
    _text(document, "description", "\n".join(f"{name}: {value}" for name, value in about.items() if value is not None))
    span = SubElement(document, "TimeSpan")
    _text(span, "begin", utc(survey.began))
    _text(span, "end", utc(survey.ended))
    for state, colour in _COLOURS.items():
        style = SubElement(document, "Style", id=state)
        _text(SubElement(style, "LineStyle"), "color", colour)
        _text(SubElement(style, "PolyStyle"), "color", _AREA + colour[2:])
    for stall in survey.stalls:
        _place(document, stall)
    return bytes(tostring(root, encoding="utf-8", xml_declaration=True))


def _place(document: Element, stall: Observation) -> None:
    place = SubElement(document, "Placemark", id=f"stall-{stall.id}")
    _text(place, "name", stall.label or stall.id)
    _text(place, "styleUrl", f"#{stall.state}")
    values = {
        "stall_id": stall.id,
        "state": stall.state,
        "kind": stall.kind or "normal",
        "picture_count": str(stall.picture_count),
    }
    if stall.taken_probability is not None:
        values["taken_probability"] = f"{stall.taken_probability:.3f}"
    if stall.looked_at is not None:
        values["observed_utc"] = utc(stall.looked_at)
    data = SubElement(place, "ExtendedData")
    for name, value in values.items():
        _text(SubElement(data, "Data", name=name), "value", value)
    ring = SubElement(SubElement(SubElement(place, "Polygon"), "outerBoundaryIs"), "LinearRing")
    corners = stall_shape(stall).exterior.coords
    _text(ring, "coordinates", " ".join(f"{longitude:.8f},{latitude:.8f}" for longitude, latitude in corners))


def _text(parent: Element, name: str, text: str) -> None:
    SubElement(parent, name).text = "".join(c for c in text if c.isprintable() or c in "\n\t")
