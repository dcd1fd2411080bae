"""Plans as XML of OpenStreetMap."""

from __future__ import annotations

import pytest

from hawk.lots.values import LotInputError
from tests.unit.lots.plan_files.files import labels, left_out, osm, outline, plan, row

A_ROW = row(4)
STALL = {"amenity": "parking_space"}


def test_closed_outlines_with_their_ref_name_and_kind_are_stalls() -> None:
    found = plan(
        osm(
            outline(1, A_ROW[0], **STALL, ref="12"),
            outline(2, A_ROW[1], **STALL, name="Chief", parking_space="private"),
            outline(3, A_ROW[2], **STALL, capacity__disabled="yes"),
            outline(4, A_ROW[3], amenity="bench"),
        )
    )
    assert [(each.name, each.label, each.kind) for each in found.stalls] == [
        ("way 1", "12", None), ("way 2", "Chief", "private"), ("way 3", "", "disabled"),
    ]  # fmt: skip
    assert found.left_out_count == 0


@pytest.mark.parametrize(
    ("element", "name", "words"),
    [
        (outline(2, A_ROW[1], **STALL).replace('<nd ref="20"/>', ""), "way 2", "is not closed"),
        ('<way id="2"><nd ref="99"/><tag k="amenity" v="parking_space"/></way>', "way 2", "node 99 is not in the file"),
        ('<node id="2" lat="52" lon="5"><tag k="amenity" v="parking_space"/></node>', "node 2", "is a point"),
        ('<relation id="2"><tag k="amenity" v="parking_space"/></relation>', "relation 2", "is a relation"),
        (outline(2, A_ROW[1], **STALL).replace('lat="52', 'lat="nan', 1), "way 2", "two finite numbers"),
        (outline(2, A_ROW[1], **STALL).replace('lat="52', 'lat="x', 1), "way 2", "two finite numbers"),
    ],
)
def test_what_is_no_outline_is_left_out_by_its_number(element: str, name: str, words: str) -> None:
    found = plan(osm(outline(1, A_ROW[0], **STALL), element))
    assert len(found.stalls) == 1
    assert left_out(found)[0].startswith(f"{name}: ")
    assert words in left_out(found)[0]


def test_what_was_deleted_in_josm_is_left_out() -> None:
    deleted = outline(2, A_ROW[1], **STALL).replace("<way ", '<way action="delete" ')
    assert len(plan(osm(outline(1, A_ROW[0], **STALL), deleted)).stalls) == 1


BOMB = b"""<?xml version="1.0"?><!DOCTYPE osm [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>
<osm><node id="1" lat="52" lon="5"><tag k="name" v="&b;"/></node></osm>"""


@pytest.mark.fault("a small file with a plan grows without end: an archive, entities of XML, blocks within blocks")
@pytest.mark.parametrize(
    ("data", "words"),
    [
        (BOMB, "has definitions of its own"),
        (osm(outline(1, A_ROW[0], **STALL))[:-30], "is no whole XML"),
        (b"<kml><Document/></kml>", "has no layer of polygons"),
        (osm(), "holds no stall and no section: draw each stall"),
    ],
)
def test_what_cannot_be_read_is_refused_with_the_remedy(data: bytes, words: str) -> None:
    with pytest.raises(LotInputError, match=words):
        plan(data)


@pytest.mark.fault("a label in a file with a plan holds HTML", "it is text, in the store and on the page")
def test_html_in_a_name_is_text() -> None:
    found = plan(osm(outline(1, A_ROW[0], **STALL, ref="&lt;i&gt;7&lt;/i&gt;")))
    assert labels(found) == ["<i>7</i>"]
