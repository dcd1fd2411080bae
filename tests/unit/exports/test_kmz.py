"""A survey as KMZ."""

from __future__ import annotations

import io
import zipfile
from dataclasses import replace

import defusedxml.ElementTree as ElementTree
import pytest

from hawk.exports.kmz import survey_kmz
from tests.unit.exports.stored import NAME, Stored

KML = "{http://www.opengis.net/kml/2.2}"


def document(data: bytes) -> object:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert archive.namelist() == ["doc.kml"]
        return ElementTree.fromstring(archive.read("doc.kml"))


@pytest.mark.slow
def test_each_stall_is_a_polygon_in_the_style_of_its_state(stored: Stored) -> None:
    survey = replace(stored.read(), lot=f"{NAME}\x00\x1b")
    root = document(survey_kmz(survey))
    places = root.findall(f".//{KML}Placemark")  # type: ignore[attr-defined]
    assert len(places) == 60
    styles = {style.get("id") for style in root.findall(f".//{KML}Style")}  # type: ignore[attr-defined]
    assert styles == {"free", "taken", "unknown"}
    assert [place.find(f"{KML}styleUrl").text for place in places] == [f"#{stall.state}" for stall in survey.stalls]
    corners = places[0].find(f".//{KML}coordinates").text.split()
    assert corners[0] == corners[-1]
    longitude, latitude = map(float, corners[0].split(","))
    assert abs(latitude - survey.stalls[0].corners[0][0]) < 1e-8
    assert abs(longitude - survey.stalls[0].corners[0][1]) < 1e-8
    title = root.find(f"{KML}Document/{KML}name").text  # type: ignore[attr-defined]
    assert title == f"{NAME}, 2026-02-03T02:55:00Z"


@pytest.mark.slow
def test_equal_surveys_are_equal_bytes(stored: Stored) -> None:
    assert survey_kmz(stored.read()) == survey_kmz(stored.read())
